"""From a compiled model to its picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace

from propermodel.analysis.ranking import ActivityRanking
from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.graph import Bond, BondGraph, Element
from propermodel.causality.causal import CausalGraph, Why
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Diagnostic, Path, parse_path
from propermodel.drawing.picture import (
    Gone,
    Picture,
    PictureActivity,
    PictureBond,
    PictureNode,
    PictureSignal,
    Strokes,
)
from propermodel.drawing.signals import SignalPaths, expressions_in, is_foreign
from propermodel.expressions.core import leaves
from propermodel.modelling.model import (
    BondRemoval,
    ConstantEffort,
    ConstantFlow,
    Cut,
    ElementKind,
    Merge,
    Model,
    Prescribe,
    ZeroEffort,
    ZeroFlow,
)

_MODULATED = (
    ElementKind.TRANSFORMER,
    ElementKind.GYRATOR,
    ElementKind.EFFORT_SOURCE,
    ElementKind.FLOW_SOURCE,
    ElementKind.RESISTANCE,
)
NO_ROOT = Path()
CONFLICT = "causality/conflict"


def depict(
    compiled: CompiledModel,
    ranking: ActivityRanking | None = None,
    bonds: Mapping[Path, float] | None = None,
) -> Picture:
    """The picture of a model: a reduced one is drawn as the full model, with a sign at everything that is gone.

    Args:
        compiled: The model.
        ranking: Activities of the elements of the full model, to be shown as fills.
        bonds: Activities of single bonds, J, to be shown as widths (`bond_activities`).
    """
    if not compiled.model.removals:
        picture = depict_graph(compiled.graph, compiled.system.causal)
    else:
        whole = compile_quietly(replace(compiled.model, removals=()))
        picture = depict_graph(whole.graph, whole.system.causal, _gone(whole.graph, compiled.graph))
    if ranking is None:
        return picture
    total = ranking.total or 1.0
    return replace(
        picture,
        activity=PictureActivity(
            total=ranking.total,
            rows={row.path: row.index for row in ranking.rows},
            bonds={path: value / total for path, value in (bonds or {}).items()},
        ),
    )


def depict_model(model: Model, faults: Iterable[Diagnostic] = ()) -> Picture:
    """The picture of a model that need not have causality, for what cannot be compiled.

    Args:
        model: The model.
        faults: Why it cannot be: the bonds of elements that contradict each other are marked.

    Raises:
        ModelError: there is no graph either.
    """
    picture = depict_graph(flatten(replace(model, removals=())))
    at_odds = {parse_path(item.path) for fault in faults if fault.code == CONFLICT for item in fault.involved}
    marked = (
        replace(bond, strokes=Strokes.CONFLICT) if at_odds & {bond.tail, bond.head} else bond for bond in picture.bonds
    )
    return replace(picture, bonds=tuple(marked))


def depict_graph(
    graph: BondGraph, causal: CausalGraph | None = None, gone: Mapping[Path, Gone] | None = None
) -> Picture:
    """The picture of a graph in normal form, with strokes where its causality is known."""
    gone = gone or {}
    levels = _Levels(graph)
    signals = SignalPaths(graph)
    nodes = [
        *(
            PictureNode(path=junction.path, kind=junction.kind.value, group=levels.of_junction(junction.path))
            for junction in graph.normal.junctions.values()
        ),
        *(_element(element, levels, gone) for element in graph.normal.elements.values()),
    ]
    links: list[PictureSignal] = []
    for element in graph.normal.elements.values():
        links.extend(PictureSignal(giver, element.path) for giver in signals.into_element(element))
    for path in signals.controllers:
        nodes.append(PictureNode(path=path, kind="controller", group=levels.around(path)))
        links.extend(PictureSignal(giver, path) for giver in signals.into_controller(path))
    for path in signals.blocks:
        nodes.append(PictureNode(path=path, kind="signal", group=levels.around(path)))
        links.extend(PictureSignal(giver, path) for giver in signals.into_block(path))
    used = {link.giver for link in links}
    nodes.extend(
        PictureNode(path=path, kind="input", group=levels.around(path)) for path in signals.inputs if path in used
    )
    known = {node.path for node in nodes}
    nodes.extend(
        PictureNode(path=path, kind="signal", group=levels.around(path))
        for path in signals.generators
        if path not in known
    )
    known.update(signals.generators)
    return Picture(
        name=graph.model.name,
        groups=levels.needed(nodes),
        nodes=tuple(nodes),
        bonds=tuple(_bond(bond, causal, gone) for bond in graph.normal.bonds.values()),
        signals=tuple(link for link in links if link.giver in known and link.giver != link.user),
    )


class _Levels:
    """Which group of the hierarchy each thing is drawn in."""

    def __init__(self, graph: BondGraph) -> None:
        self._graph = graph
        self._elements = graph.normal.elements
        self._at = graph.normal.at()

    def around(self, path: Path) -> Path:
        """The group around an element: what is inside an element is no level of its own."""
        group = path.parent
        while group and group in self._elements:
            group = group.parent
        return group

    def of_junction(self, path: Path) -> Path:
        """The group of most elements that hang on a junction alone; failing that, the one it is named in."""
        named = self.around(path)
        others = [bond.other(path).owner for bond in self._at[path]]
        hanging = Counter(
            self.around(other) for other in others if other in self._elements and len(self._at[other]) == 1
        )
        if not hanging:
            return named
        most = max(hanging.values())
        return named if hanging[named] == most else next(group for group, n in hanging.items() if n == most)

    def needed(self, nodes: list[PictureNode]) -> tuple[Path, ...]:
        """All groups that hold something, each after the one around it."""
        found: dict[Path, None] = {NO_ROOT: None}
        for node in nodes:
            for length in range(1, len(node.group) + 1):
                found.setdefault(Path(node.group[:length]), None)
        return tuple(found)


def _element(element: Element, levels: _Levels, gone: Mapping[Path, Gone]) -> PictureNode:
    is_modulated = element.kind in _MODULATED and any(
        is_foreign(leaf, element) for expr in expressions_in(element.behaviour) for leaf in leaves(expr)
    )
    return PictureNode(
        path=element.path,
        kind=f"M{element.kind.value}" if is_modulated else element.kind.value,
        group=levels.around(element.path),
        row=element.row if element.kind.is_energetic else None,
        gone=gone.get(element.path),
    )


def _bond(bond: Bond, causal: CausalGraph | None, gone: Mapping[Path, Gone]) -> PictureBond:
    is_gone = bond.tail.owner in gone or bond.head.owner in gone
    if causal is None:
        return PictureBond(
            name=bond.name,
            tail=bond.tail.owner,
            head=bond.head.owner,
            domain=bond.domain,
            effort_into=None,
            strokes=Strokes.NONE,
            is_gone=is_gone,
        )
    stroke = causal.strokes[bond.name]
    ends = {bond.tail.owner, bond.head.owner}
    strokes = (
        Strokes.DEPENDENT
        if ends & set(causal.derivative)
        else Strokes.FIXED
        if stroke.why is Why.PREFERENCE and stroke.cause in ends
        else Strokes.PREFERRED
    )
    return PictureBond(
        name=bond.name,
        tail=bond.tail.owner,
        head=bond.head.owner,
        domain=bond.domain,
        effort_into=stroke.effort_into,
        strokes=strokes,
        is_gone=is_gone,
    )


def _gone(whole: BondGraph, left: BondGraph) -> dict[Path, Gone]:
    """What is gone of a graph, and what stands in its place."""
    signs: dict[Path, Gone] = {}
    for removal in left.removals:
        if isinstance(removal, BondRemoval):
            path, sign = _sign(whole, removal)
            known = signs.get(path)
            signs[path] = sign if known is None else _both(known, sign)
    missing = [path for path in whole.normal.elements if path not in left.normal.elements]
    idle = Gone("idle", "nothing acts on it any more")
    return {path: signs.get(path, idle) for path in missing} | {
        path: sign for path, sign in signs.items() if path in whole.normal.elements
    }


def _both(one: Gone, other: Gone) -> Gone:
    """The sign of an element with several ports."""
    sign = one.sign if one.sign == other.sign else f"{one.sign}, {other.sign}"
    return Gone(sign, f"{one.meaning}; {other.meaning}")


def _sign(whole: BondGraph, removal: BondRemoval) -> tuple[Path, Gone]:
    match removal:
        case ZeroEffort(bond):
            gone = Gone("e = 0", "carries no effort")
        case ZeroFlow(bond):
            gone = Gone("f = 0", "carries no flow")
        case ConstantEffort(bond, value):
            gone = Gone("e = const", f"its effort is constant, {value:.6g}")
        case ConstantFlow(bond, value):
            gone = Gone("f = const", f"its flow is constant, {value:.6g}")
        case Cut(bond, driven):
            gone = Gone("one way", f"driven by the {driven}, without acting back")
        case Merge(bond, into):
            gone = Gone("merged", f"part of {into.parent}")
        case Prescribe(bond, driven):
            gone = Gone("input", f"driven by an input, its {driven}")
    found = whole.normal.bonds.get(bond) or whole.original.bonds[bond]
    owner = next((end.owner for end in (found.head, found.tail) if end.port), found.head.owner)
    return owner, gone
