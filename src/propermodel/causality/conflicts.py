"""What contradictions of strokes mean to the author of a model."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import TYPE_CHECKING

from propermodel.bondgraph.graph import Bond, Element
from propermodel.causality.invertible import Inversion
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Involved, Path, in_words
from propermodel.modelling.model import ElementKind, JunctionKind, PowerSource, Resistive, Variable

if TYPE_CHECKING:
    from propermodel.causality.assign import Assignment

# The sources that set the common variable of a junction.
_SETS = {JunctionKind.ZERO: ElementKind.EFFORT_SOURCE, JunctionKind.ONE: ElementKind.FLOW_SOURCE}


class Conflict(Exception):
    """A stroke contradicts another; carries the junction or element where, and the strokes involved."""

    def __init__(self, place: Path, bonds: list[Bond]) -> None:
        super().__init__(str(place))
        self.place = place
        self.bonds = bonds


class Shape(Enum):
    """What is wrong where strokes contradict each other."""

    TOO_MANY = auto()  # several sources set the common variable of a junction
    NONE = auto()  # nothing sets it
    FORCED = auto()  # an element cannot have a causality that it has a law for


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Elements that contradict each other at a junction or an element; `last` is the one that met it."""

    shape: Shape
    place: Path
    elements: tuple[Element, ...]
    last: Element


def contradiction(work: Assignment, element: Element, conflict: Conflict) -> Contradiction:
    """What a conflict means that was met while fixing an element."""
    causes = {conflict.place, element.path}
    causes.update(work.strokes[b.name].cause for b in conflict.bonds if b.name in work.strokes)
    elements = tuple(e for e in work.structure.elements.values() if e.path in causes)
    place = conflict.place
    if place in work.structure.elements and len(work.at[place]) == 1:
        # A one-port that meets a stroke already there: what they contradict each other about is the junction.
        other = work.at[place][0].other(place).owner
        place = other if other in work.structure.junctions else place
    junction = work.structure.junctions.get(place)
    shape = Shape.FORCED
    if junction is not None:
        given = {_gives(work, e) for e in elements}
        if {e.kind for e in elements} == {_SETS[junction.kind]} and len(elements) > 1:
            shape = Shape.TOO_MANY
        elif given == {junction.kind.common.other} or work.strong_bond(place, junction.kind) is None:
            shape = Shape.NONE
    return Contradiction(shape, place, elements, element)


def merged(found: Iterable[Contradiction]) -> list[Contradiction]:
    """One contradiction for each place: a third source at a junction joins the first two."""
    places: dict[tuple[Shape, Path], Contradiction] = {}
    for item in found:
        key = (item.shape, item.place)
        known = places.get(key)
        places[key] = (
            item if known is None else replace(known, elements=tuple(dict.fromkeys((*known.elements, *item.elements))))
        )
    return list(places.values())


def explain(work: Assignment, found: Contradiction, inversion: Inversion | None = None) -> Diagnostic:
    """A contradiction in words; with `inversion`, also why laws have no inverse."""
    place, elements = found.place, found.elements
    junction = work.structure.junctions.get(place)
    if junction is not None and found.shape is Shape.TOO_MANY:
        variable = work.graph.word(work.at[place][0], junction.kind.common)
        what = "flow" if junction.kind is JunctionKind.ONE else "effort"
        message = f"{in_words(len(elements))} {what} sources set the {variable} of one junction"
        cure = (
            "put a compliance between them, or make one of them an effort source"
            if junction.kind is JunctionKind.ONE
            else "put a resistance or inertia between them, or make one of them a flow source"
        )
    elif junction is not None and found.shape is Shape.NONE:
        variable = work.graph.word(work.at[place][0], junction.kind.common)
        message = f"nothing sets the {variable} of one junction: every bond prescribes its other variable"
        what = "an inertia" if junction.kind is JunctionKind.ONE else "a compliance"
        cure = f"connect {what}, or a resistance, whose law gives the {variable}"
    else:
        forced = work.structure.elements.get(place, found.last)
        others = ", ".join(str(e.path) for e in elements if e is not forced) or "the rest of the model"
        message = f"{forced.path} cannot have the causality it needs: {others} forces the other one"
        cure = "give the element a law for the other causality, or put storage between it and the cause"
    where = f"{place} ({junction.kind}-junction)" if junction else str(place)
    source = junction.source if junction and junction.source.line else found.last.source
    involved = tuple(Involved(str(e.path), _role(work, inversion, e), e.source) for e in elements)
    return Diagnostic("causality/conflict", message, where, source, involved, cure)


def _gives(work: Assignment, element: Element) -> Variable | None:
    """The variable that a one-port can only give, not take."""
    behaviour = element.behaviour
    if isinstance(behaviour, PowerSource):
        return Variable.EFFORT if behaviour.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
    if isinstance(behaviour, Resistive) and len(patterns := work.law_patterns(element)) == 1 == len(element.ports):
        return Variable.FLOW if next(iter(patterns[0].values())) else Variable.EFFORT
    return None


def _role(work: Assignment, inversion: Inversion | None, element: Element) -> str:
    """What an element does in a conflict."""
    if (bond := work.activated.get(element.path)) is not None:
        word = work.graph.word(work.at[element.path][0], bond.carries)
        return f"is the end of an activated bond, which carries its {word} and gives it here"
    if element.kind is ElementKind.FLOW_SOURCE:
        return f"prescribes its {work.graph.word(work.at[element.path][0], Variable.FLOW)}"
    if element.kind is ElementKind.EFFORT_SOURCE:
        return f"prescribes its {work.graph.word(work.at[element.path][0], Variable.EFFORT)}"
    if isinstance(element.behaviour, Resistive) and element.behaviour.laws and len(work.law_patterns(element)) == 1:
        given = (f"{result.port}.{result.variable}" for result in element.behaviour.laws[0].results)
        return f"offers a law for {' and '.join(given)} only{_why(inversion, element, ', which ')}"
    return f"is a {element.kind} element that forces a stroke"


def _why(inversion: Inversion | None, element: Element, before: str) -> str:
    """What keeps the law of an element from being inverted."""
    obstacle = "" if inversion is None else inversion.obstacle(element)
    return before + obstacle if obstacle else ""


def no_inverse(work: Assignment, element: Element, inversion: Inversion | None = None) -> Diagnostic:
    """Dependent storage whose law cannot be inverted."""
    cause = next(work.strokes[b.name].cause for b in work.at[element.path])
    decides = work.structure.elements.get(cause)
    law = "displacement(effort)" if element.kind is ElementKind.COMPLIANCE else "momentum(flow)"
    variable = Variable.EFFORT if element.kind is ElementKind.COMPLIANCE else Variable.FLOW
    word = work.graph.word(work.at[element.path][0], variable)
    return Diagnostic(
        "causality/no-inverse",
        f"the {word} of the storage {element.path} is decided elsewhere, and its law cannot be inverted"
        + _why(inversion, element, ": it "),
        source=element.source,
        involved=(Involved(str(cause), f"decides its {word}", decides.source if decides else NO_SOURCE),),
        help=f"offer the inverse law {law}, or put a part between that lets it have its own {word}",
    )


def undetermined(work: Assignment, bond: Bond, conflict: Conflict) -> Diagnostic:
    """A junction whose common variable nothing determines."""
    junction = work.structure.junctions.get(conflict.place)
    kind = f" ({junction.kind}-junction)" if junction else ""
    around = [b.other(conflict.place) for b in conflict.bonds if conflict.place in (b.tail.owner, b.head.owner)]
    return Diagnostic(
        "causality/undetermined",
        f"nothing determines the common variable at {conflict.place}{kind}",
        where=str(bond.name),
        source=junction.source if junction else work.structure.elements[conflict.place].source,
        involved=tuple(Involved(str(end.path), "meets it") for end in around),
        help="connect a storage, a source or a resistance whose law gives it",
    )
