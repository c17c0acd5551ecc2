"""Why every causal stroke is where it is: a table, the paths that matter, and an account step by step."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from propermodel.bondgraph.graph import Bond
from propermodel.causality.causal import CausalGraph, Stroke, Why
from propermodel.causality.paths import CausalLoop, CausalPath, DependentPath, Signals
from propermodel.diagnostics import Path, shortest_endings
from propermodel.modelling.model import ElementKind, Variable

WIDTH = 100
# Reports name as many paths or loops of a kind, and count the others.
MOST_LISTED = 20

_FOLLOWED = frozenset({Why.REMAINING, Why.JUNCTION, Why.TWO_PORT})


_REASONS = {
    Why.SOURCE: "source",
    Why.ACTIVATED: "activated bond",
    Why.CONSTRAINT: "closes a loop",
    Why.LAW: "only law",
    Why.PREFERENCE: "preferred by its author",
    Why.INTEGRAL: "integral causality",
    Why.DERIVATIVE: "derivative causality",
    Why.MODULUS: "modulus may be 0",
    Why.CHOICE: "chosen, either fits",
    Why.REMAINING: "only law left",
    Why.JUNCTION: "junction",
    Why.TWO_PORT: "two-port",
}


@dataclass(frozen=True, slots=True)
class CausalRow:
    """One bond: who sets its effort and its flow, why, and as which in the order of assignment."""

    number: int  # of the bond, in the order of the graph
    bond: Path
    sets_effort: Path
    sets_flow: Path
    why: Why
    cause: Path  # the element whose assignment led to it
    order: int  # 1 for the stroke that was assigned first


@dataclass(frozen=True, slots=True)
class CausalStep:
    """One decision of the assignment, and the strokes that follow from it: each with the place where it follows."""

    element: Path
    why: Why
    decided: tuple[Path, ...]  # bonds
    followed: tuple[tuple[Path, Path], ...]  # place, bond


@dataclass(frozen=True)
class CausalReport:
    """The causality of a model, explained."""

    causal: CausalGraph
    rows: tuple[CausalRow, ...]
    steps: tuple[CausalStep, ...]
    dependent: tuple[DependentPath, ...]
    zero_order: tuple[CausalPath, ...]
    loops: tuple[CausalLoop, ...]

    def table(self) -> str:
        """The causality table."""
        places = [self._short(row.sets_effort) for row in self.rows]
        others = [self._short(row.sets_flow) for row in self.rows]
        widths = [max(map(len, column), default=0) for column in (places, others)]
        lines = [f"{'bond':>4}  {'effort set by':<{widths[0]}}  {'flow set by':<{widths[1]}}  order  because"]
        reasons = [self._because(row) for row in self.rows]
        # Where names are long the reason stands below.
        is_wide = 17 + sum(widths) + max(map(len, reasons), default=0) > WIDTH
        for row, effort, flow, reason in zip(self.rows, places, others, reasons, strict=True):
            line = f"{row.number:>4}  {effort:<{widths[0]}}  {flow:<{widths[1]}}  {row.order:>5}"
            lines += [line, f"{'':6}{reason}"] if is_wide else [f"{line}  {reason}"]
        return "\n".join(lines)

    def explanation(self) -> str:
        """The assignment step by step, in at most `WIDTH` columns where names allow it."""
        lines = [f"causality of {self.causal.graph.model.name}, assigned step by step", ""]
        for number, step in enumerate(self.steps, 1):
            lines += _paragraph(f"{number}. ", self._decision(step))
            for place, bonds in self._by_place(step).items():
                lines += _paragraph("   - ", self._consequence(place, bonds))
        lines += ["", *self._findings()]
        return "\n".join(lines)

    def text(self) -> str:
        """The table and what was found."""
        return "\n".join([f"causality of {self.causal.graph.model.name}", self.table(), "", *self._findings()])

    def __str__(self) -> str:
        return self.text()

    # -- sentences -----------------------------------------------------------------------------------------

    @cached_property
    def _numbers(self) -> Mapping[Path, int]:
        return {row.bond: row.number for row in self.rows}

    def _place(self, path: Path) -> str:
        junction = self.causal.graph.normal.junctions.get(path)
        if junction is not None:
            return f"{junction.kind}-junction {self._endings[path]}"
        return self._short(path)

    def _short(self, path: Path) -> str:
        graph = self.causal.graph.normal
        junction = graph.junctions.get(path)
        kind = graph.elements[path].kind if junction is None else junction.kind
        return f"{kind} {self._endings[path]}"

    @cached_property
    def _endings(self) -> Mapping[Path, Path]:
        """Short names of elements and junctions; a junction is called after a port, which its owner goes with."""
        graph = self.causal.graph.normal
        short = shortest_endings([*graph.elements, *graph.junctions])
        return {path: Path(path[-max(len(short[path]), 1 + (path in graph.junctions)) :]) for path in short}

    def _because(self, row: CausalRow) -> str:
        after = "" if row.cause in (row.sets_effort, row.sets_flow) else f", after {self._endings[row.cause]}"
        return f"{_REASONS[row.why]}{after}"

    def _bonds(self, bonds: tuple[Path, ...] | list[Path]) -> str:
        numbers = ", ".join(str(self._numbers[bond]) for bond in bonds)
        return f"bond {numbers}" if len(bonds) == 1 else f"bonds {numbers}"

    def _variable(self, bond: Path, variable: Variable) -> str:
        """An effort or flow in the word of its domain."""
        domain = self.causal.graph.domains.get(self.causal.graph.normal.bonds[bond].domain)
        if domain is None:
            return variable.value
        return f"{domain.effort if variable is Variable.EFFORT else domain.flow} ({variable})"

    def _given(self, place: Path, bond: Path) -> Variable:
        return Variable.FLOW if self.causal.strokes[bond].effort_into == place else Variable.EFFORT

    def _decision(self, step: CausalStep) -> str:
        who = self._place(step.element)
        bond = step.decided[0]
        given = self._variable(bond, self._given(step.element, bond))
        where = self._bonds(step.decided)
        match step.why:
            case Why.SOURCE:
                return f"{who} prescribes the {given} of {where}."
            case Why.ACTIVATED:
                if step.element in self.causal.graph.activated_probes:
                    return f"{who} begins an activated bond: it takes no {given} from {where}."
                return f"{who} is the end of an activated bond, which gives the {given} of {where} and feels nothing."
            case Why.CONSTRAINT:
                return f"{who} closes a kinematic loop: the {given} of {where} keeps its flow."
            case Why.LAW:
                return f"{who} has a law for one causality only: it sets the {given} of {where}."
            case Why.PREFERENCE:
                return f"{who} has either causality, and its author prefers this one: it sets the {given} of {where}."
            case Why.INTEGRAL:
                return f"{who} takes integral causality: what it stores sets the {given} of {where}."
            case Why.DERIVATIVE:
                return f"{who} cannot have integral causality: it is left to set the {given} of {where}."
            case _:
                return f"{who} may have either causality; chosen: it sets the {given} of {where}."

    def _by_place(self, step: CausalStep) -> dict[Path, list[Path]]:
        found: dict[Path, list[Path]] = {}
        for place, bond in step.followed:
            found.setdefault(place, []).append(bond)
        return found

    def _consequence(self, place: Path, bonds: list[Path]) -> str:
        graph = self.causal.graph.normal
        junction = graph.junctions.get(place)
        where = self._bonds(bonds)
        if junction is None:
            element = graph.elements[place]
            if element.kind is ElementKind.TRANSFORMER:
                how = f"lets the stroke pass to {where}"
            elif element.kind is ElementKind.GYRATOR:
                how = f"turns the stroke over to {where}"
            else:
                how = f"has one law left that fits, and sets the strokes of {where}"
            return f"{self._place(place)} {how}." + self._ends(bonds)
        common = junction.kind.common
        gives = [bond for bond in bonds if self._given(place, bond) is common]
        name = self._place(place)
        if gives:
            strong = next(b.name for b in self._at[place] if self._given(place, b.name) is not common)
            word = self._variable(strong, common)
            return f"{name} has its {word} from bond {self._numbers[strong]} and gives it to {where}." + self._ends(
                bonds
            )
        word = self._variable(bonds[0], common)
        return f"{name} still needs its {word}, and only {where} is left to bring it." + self._ends(bonds)

    def _ends(self, bonds: list[Path]) -> str:
        """What the new strokes mean for one-port elements at their other ends."""
        graph = self.causal.graph.normal
        found: list[str] = []
        for bond in bonds:
            for end in (graph.bonds[bond].tail.owner, graph.bonds[bond].head.owner):
                element = graph.elements.get(end)
                if element is None or len(self._at[end]) != 1:
                    continue
                given = self._variable(bond, self._given(end, bond))
                if end in self.causal.derivative:
                    found.append(f"{self._place(end)} must set the {given}: derivative causality, dependent storage.")
                elif end in self.causal.integral:
                    found.append(f"{self._place(end)} gets integral causality and sets the {given}.")
                else:
                    found.append(f"{self._place(end)} answers with the {given}.")
        return " " + " ".join(found) if found else ""

    @cached_property
    def _at(self) -> Mapping[Path, list[Bond]]:
        return self.causal.graph.normal.at()

    def _findings(self) -> list[str]:
        states, dependent = len(self.causal.integral), len(self.causal.derivative)
        lines = [f"storage: {states} integral (state{'' if states == 1 else 's'}), {dependent} derivative (dependent)"]
        for item in self.dependent:
            lines.append(f"dependent storage {self._place(item.storage)} follows from")
            lines += _listed([self._arrows(path) for path in item.paths])
        graph = self.causal.graph
        if graph.activated:
            lines.append(f"activated bonds: {len(graph.activated)}")
            lines += _listed([f"{bond.path}: {graph.activation_text(bond)}" for bond in graph.activated])
        if self.causal.constraints:
            lines.append(f"kinematic loops: {len(self.causal.constraints)}, closed by")
            lines += _listed([self._place(path) for path in self.causal.constraints])
        if self.loops:
            lines.append(f"algebraic loops: {len(self.loops)}")
            lines += _listed(
                [
                    f"{self._arrows(loop.path)}; gain of {', '.join(self._place(e) for e in loop.elements)}"
                    for loop in self.loops
                ]
            )
        else:
            lines.append("algebraic loops: none")
        if self.zero_order:
            lines.append(f"zero-order causal paths (no state on them): {len(self.zero_order)}")
            lines += _listed([self._arrows(path) for path in self.zero_order])
        else:
            lines.append("zero-order causal paths: none")
        if self.dependent or self.loops or self.zero_order:
            lines.append("(-e1-> and -f1-> are the effort and the flow of bond 1)")
        return lines

    def _arrows(self, path: CausalPath) -> str:
        parts = [self._place(path.places[0])]
        for (bond, variable), place in zip(path.signals, path.places[1:], strict=True):
            parts.append(f"-{variable.value[0]}{self._numbers[bond]}-> {self._place(place)}")
        return " ".join(parts)


class HasCausality(Protocol):
    """What has an equation system with its causal graph, as a compiled model has."""

    @property
    def system(self) -> _System:
        """The equations."""
        ...


class _System(Protocol):
    @property
    def causal(self) -> CausalGraph: ...


def explain_causality(of: CausalGraph | HasCausality) -> CausalReport:
    """The causality of a compiled model: who decided every stroke, dependent storage, loops, and zero-order paths."""
    causal = of if isinstance(of, CausalGraph) else of.system.causal
    bonds = causal.graph.normal.bonds
    order = {name: position for position, name in enumerate(causal.strokes, 1)}
    signals = Signals(causal)
    rows = tuple(
        CausalRow(
            number,
            name,
            signals.setter((name, Variable.EFFORT)),
            signals.setter((name, Variable.FLOW)),
            causal.strokes[name].why,
            causal.strokes[name].cause,
            order[name],
        )
        for number, name in enumerate(bonds, 1)
    )
    return CausalReport(
        causal=causal,
        rows=rows,
        steps=tuple(_steps(causal)),
        dependent=tuple(signals.dependent_storage()),
        zero_order=tuple(signals.zero_order_paths()),
        loops=tuple(signals.loops()),
    )


def _steps(causal: CausalGraph) -> Iterator[CausalStep]:
    """The strokes in their order, gathered by the decision that they follow from."""
    groups: list[list[tuple[Path, Stroke]]] = []
    for name, stroke in causal.strokes.items():
        is_new = not groups or groups[-1][0][1].cause != stroke.cause
        if is_new or (_is_decision(stroke) and not _is_decision(groups[-1][-1][1])):
            groups.append([])
        groups[-1].append((name, stroke))
    known: set[Path] = set()
    bonds = causal.graph.normal.bonds
    at = causal.graph.normal.at()
    for group in groups:
        decided = tuple(name for name, stroke in group if _is_decision(stroke))
        followed: list[tuple[Path, Path]] = []
        known.update(decided)
        for name, stroke in group:
            if not _is_decision(stroke):
                followed.append((_place_of(causal, bonds[name], at, known), name))
                known.add(name)
        first = group[0][1]
        yield CausalStep(first.cause, first.why, decided or (group[0][0],), tuple(followed))


def _is_decision(stroke: Stroke) -> bool:
    return stroke.why not in _FOLLOWED


def _place_of(causal: CausalGraph, bond: Bond, at: Mapping[Path, list[Bond]], known: set[Path]) -> Path:
    """Where a stroke follows from those known before."""
    stroke, structure = causal.strokes[bond.name], causal.graph.normal
    ends = (bond.tail.owner, bond.head.owner)
    if stroke.why is not Why.JUNCTION:
        candidates = [end for end in ends if end in structure.elements]
        return next((end for end in candidates if any(b.name in known for b in at[end])), candidates[0])
    for end in ends:
        junction = structure.junctions.get(end)
        if junction is None:
            continue
        wants = junction.kind.common is Variable.EFFORT
        others = [other for other in at[end] if other.name != bond.name and other.name in known]
        if (stroke.effort_into == end) is wants:
            implied = len(others) == len(at[end]) - 1
        else:
            implied = any((causal.strokes[other.name].effort_into == end) is wants for other in others)
        if implied:
            return end
    return next(end for end in ends if end in structure.junctions)


def _listed(items: list[str]) -> list[str]:
    lines = [line for item in items[:MOST_LISTED] for line in _paragraph("  ", item)]
    if len(items) > MOST_LISTED:
        lines.append(f"  and {len(items) - MOST_LISTED} more")
    return lines


def _paragraph(mark: str, sentence: str) -> list[str]:
    return textwrap.wrap(
        sentence,
        WIDTH,
        initial_indent=mark,
        subsequent_indent=" " * (len(mark) + (2 if not mark.strip() else 0)),
        break_long_words=False,
        break_on_hyphens=False,
    )
