"""Rows of a ranking: one for each energy element, or for each group that a component declares as one."""

from __future__ import annotations

from propermodel.causality.causal import CausalGraph
from propermodel.diagnostics import Path
from propermodel.equations.system import Row


def rows_of(causal: CausalGraph) -> tuple[Row, ...]:
    """The rows of a model, in the order of its elements."""
    normal = causal.graph.normal
    at = normal.at()
    members: dict[Path, list[Path]] = {}
    for element in normal.elements.values():
        if element.kind.is_energetic:
            members.setdefault(element.row, []).append(element.path)
    rows: list[Row] = []
    for path, elements in members.items():
        kinds = sorted({normal.elements[e].kind.value for e in elements})
        bonds = tuple(bond.name for e in elements for bond in at[e])
        rows.append(Row(path=path, kind="+".join(kinds), elements=tuple(elements), bonds=bonds))
    return tuple(rows)
