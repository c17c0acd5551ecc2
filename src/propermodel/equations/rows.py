"""Rows of a ranking: one for each energy element, or for each group that a component declares as one."""

from __future__ import annotations

from propermodel.bondgraph.pseudo import is_pseudo
from propermodel.causality.causal import CausalGraph
from propermodel.diagnostics import Path
from propermodel.equations.system import Row


def rows_of(causal: CausalGraph) -> tuple[Row, ...]:
    """The rows of a model, in the order of its elements; where a row has true bonds, its pseudo bonds do not count."""
    normal = causal.graph.normal
    at = normal.at()
    members: dict[Path, list[Path]] = {}
    for element in normal.elements.values():
        if element.kind.is_energetic:
            members.setdefault(element.row, []).append(element.path)
    rows: list[Row] = []
    for path, elements in members.items():
        kinds = sorted({normal.elements[e].kind.value for e in elements})
        all_bonds = [bond for e in elements for bond in at[e]]
        true = [bond for bond in all_bonds if not is_pseudo(causal.graph, bond)]
        bonds = tuple(bond.name for bond in true or all_bonds)
        rows.append(Row(path=path, kind="+".join(kinds), elements=tuple(elements), bonds=bonds))
    return tuple(rows)
