"""Driving and driven parts: where one side of a bond does not feel the other, the model falls apart one way.

At a 1-junction a small effort, at a 0-junction a small flow is left out of the sum; what lies behind the bond is then
driven by the flow or effort of that junction, and does not act back (Rideout, Stein and Louca 2004, 2007). Parts that
influence each other all the same, by another bond or by signals, are one part.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from propermodel.analysis.comparison import Comparison, compare
from propermodel.bondgraph.graph import Bond
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError, ReductionError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Cut, Model, Removal
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.groups import is_small, joined, links_of
from propermodel.reduction.reading import elements_of_laws, elements_of_outputs
from propermodel.simulation.observables import observable_path
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory

MOST_MEASURED = 24  # cuts whose error is measured one by one


class Role(StrEnum):
    """What a part is to the others."""

    DRIVING = "driving"
    DRIVEN = "driven"
    BETWEEN = "driven and driving"
    ALONE = "alone"


@dataclass(frozen=True, slots=True)
class OneWayCut:
    """A bond that only one side feels.

    `share` is what the driving junction would miss of its greatest activity, `share_behind` what the bond is on the
    other side. `error` is the largest error over all outputs with this cut alone, as a share of their ranges.
    """

    removal: Cut
    driving: int  # parts
    driven: int
    junction: Path
    share: float
    share_behind: float
    error: float | None = None


@dataclass(frozen=True, slots=True)
class ModelPart:
    """Elements and junctions that feel each other."""

    number: int
    role: Role
    rows: tuple[Path, ...]
    elements: tuple[Path, ...]  # sources and two-ports too
    junctions: tuple[Path, ...]
    activity: float  # share of the whole
    outputs: tuple[Path, ...]
    parameters: int  # on which its laws depend: its design variables
    stage: int  # parts of one stage need nothing of each other


@dataclass(frozen=True, kw_only=True)
class Partition:
    """The parts of a model in the order in which they drive each other, and the cuts between them."""

    model: Model
    scenario: str
    tolerance: float
    parts: tuple[ModelPart, ...]
    cuts: tuple[OneWayCut, ...]
    comparison: Comparison | None  # of all cuts together with the full model
    notes: tuple[str, ...]

    @property
    def removals(self) -> tuple[Removal, ...]:
        """All cuts: driven parts stay, and follow."""
        return tuple(cut.removal for cut in self.cuts)

    @property
    def needed(self) -> tuple[ModelPart, ...]:
        """The parts with outputs, and those that drive them; the others can go."""
        wanted = {part.number for part in self.parts if part.outputs}
        while True:
            drivers = {cut.driving for cut in self.cuts if cut.driven in wanted} - wanted
            if not drivers:
                return tuple(part for part in self.parts if part.number in wanted)
            wanted |= drivers

    def document(self) -> dict[str, Any]:
        """The partition as plain data."""
        return {
            "format": "propermodel-partition",
            "version": 1,
            "model": self.model.name,
            "scenario": self.scenario,
            "tolerance": self.tolerance,
            "parts": [
                {
                    "number": part.number,
                    "role": part.role.value,
                    "stage": part.stage,
                    "rows": list(map(str, part.rows)),
                    "elements": list(map(str, part.elements)),
                    "activity": part.activity,
                    "outputs": list(map(str, part.outputs)),
                    "parameters": part.parameters,
                }
                for part in self.parts
            ],
            "cuts": [
                {
                    "bond": str(cut.removal.bond),
                    "passes_on": cut.removal.driven.value,
                    "driving": cut.driving,
                    "driven": cut.driven,
                    "junction": str(cut.junction),
                    "share": cut.share,
                    "share_behind": cut.share_behind,
                    "error": cut.error,
                }
                for cut in self.cuts
            ],
            "errors": {str(o.path): o.rms for o in self.comparison.outputs} if self.comparison else {},
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        lines = [f"{self.model.name}, scenario {self.scenario}: {len(self.parts)} parts, {len(self.cuts)} one-way cuts"]
        for part in self.parts:
            names = ", ".join(map(str, part.rows)) or "no energy elements"
            holds = f"; holds {', '.join(map(str, part.outputs))}" if part.outputs else ""
            count = f"{part.parameters} parameter{'' if part.parameters == 1 else 's'}"
            lines.append(
                f"  part {part.number}, {part.role}, {part.activity:.2%} of the activity, {count}: {names}{holds}"
            )
        for cut in self.cuts:
            error = "" if cut.error is None else f"; alone it changes outputs by {cut.error:.3%} of their range"
            lines.append(
                f"  {cut.removal.bond} passes the {cut.removal.driven} of {cut.junction} from part {cut.driving} to "
                f"part {cut.driven}, but not back: {cut.share:.2%} of the greatest activity there, "
                f"{cut.share_behind:.0%} behind{error}"
            )
        if self.comparison is not None:
            lines.extend(f"  with all cuts, {output}" for output in self.comparison.outputs)
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])


def partition(
    trajectory: Trajectory, *, tolerance: float = 0.1, outputs: Iterable[Expr | Path | str] = ()
) -> Partition:
    """Find the parts of a model that drive others without feeling them.

    Args:
        trajectory: A run of the full model, with the observables of all ports recorded.
        tolerance: The largest share of a junction's greatest activity that a term may have to be left out there.
        outputs: Observables; what all cuts together do to them, and each alone, is measured by simulation.

    Raises:
        ReductionError: the run did not reach its end, or an output does not exist.
    """
    compiled = trajectory.compiled
    paths = tuple(observable_path(output) for output in outputs)
    if not trajectory.ending.is_complete:
        raise ReductionError.of(
            "activity/incomplete",
            f"the run did not reach its end: {trajectory.ending.message}",
            where=str(trajectory.ending.path),
            help="take a run that is complete",
        )
    for path in paths:
        if path not in compiled.lowered.observables:
            raise ReductionError.of(
                "reduction/unknown-output",
                f"the output '{path}' does not exist",
                help=one_of(str(path), map(str, compiled.lowered.observables)),
            )
    finder = _Finder(RunEvidence.of(compiled, trajectory), tolerance)
    cuts, notes = finder.cuts()
    cuts, comparison = _measured(trajectory, cuts, paths)
    return Partition(
        model=compiled.model,
        scenario=trajectory.scenario.name,
        tolerance=tolerance,
        parts=finder.model_parts(cuts, paths),
        cuts=cuts,
        comparison=comparison,
        notes=notes,
    )


@dataclass(frozen=True, slots=True)
class _Way:
    """A bond at which one side does not feel the other."""

    bond: Bond
    junction: Path  # of the driving side
    behind: Path  # a junction of the driven side, or an element alone
    share: float
    share_behind: float


class _Finder:
    """Cuts in thought what is small, and puts together again what feels each other all the same."""

    def __init__(self, evidence: RunEvidence, tolerance: float) -> None:
        self._evidence = evidence
        self._structure = evidence.structure
        self._tolerance = tolerance
        self._ways = [*self._between(), *self._single()]
        graph = evidence.compiled.graph
        elements = graph.normal.elements
        self._reads = {path: elements_of_laws(graph, element) for path, element in elements.items()}

    def cuts(self) -> tuple[tuple[OneWayCut, ...], tuple[str, ...]]:
        """The cuts that leave a model with equations."""
        refused: list[Bond] = []
        notes: list[str] = []
        while True:
            found = self._cuts(refused)
            try:
                compile_quietly(self._evidence.compiled.model.without(cut.removal for cut in found))
            except ProperModelError as error:
                worst = max(found, key=lambda cut: (cut.share, cut.removal.bond))
                refused.append(self._structure.bonds[worst.removal.bond])
                notes.append(f"{worst.removal.bond} is not cut: {error.diagnostics[0].message}")
                continue
            return found, tuple(notes)

    def _between(self) -> list[_Way]:
        found: list[_Way] = []
        for link in links_of(self._evidence, self._tolerance):
            shares = [self._evidence.share(b, j) for b, j in zip(link.bonds, link.ends, strict=True)]
            sides = [side for side in (0, 1) if link.small[side]]
            if sides:
                side = min(sides, key=lambda s: (shares[s], s))
                found.append(
                    _Way(link.bonds[side], link.ends[side], link.ends[1 - side], shares[side], shares[1 - side])
                )
        return found

    def _single(self) -> list[_Way]:
        """One-ports that their junction does not feel."""
        found: list[_Way] = []
        for path, element in self._structure.elements.items():
            if not element.kind.is_energetic or len(element.ports) > 1:
                continue
            (bond,) = self._evidence.at[path]
            junction = bond.other(path).owner
            if len(self._evidence.at[junction]) > 2 and is_small(self._evidence, bond, junction, self._tolerance):
                found.append(_Way(bond, junction, path, self._evidence.share(bond, junction), 1.0))
        return found

    def _cuts(self, refused: list[Bond]) -> tuple[OneWayCut, ...]:
        place = self._places(refused)
        cuts = [
            OneWayCut(
                Cut(way.bond.name, self._structure.junctions[way.junction].kind.common),
                place[way.junction],
                place[way.behind],
                way.junction,
                way.share,
                way.share_behind,
            )
            for way in self._ways
            if way.bond not in refused and place[way.junction] != place[way.behind]
        ]
        self._place = place
        return tuple(cuts)

    def _places(self, refused: list[Bond]) -> dict[Path, int]:
        """The part of every junction and element; parts are numbered so that the driving come before the driven."""
        links = list(links_of(self._evidence, self._tolerance))
        strong = [link for link in links if not any(link.small) or any(bond in refused for bond in link.bonds)]
        parts = joined(self._evidence, strong)
        place = {junction: number for number, part in enumerate(parts) for junction in part}
        count = len(parts)
        ways = [way for way in self._ways if way.bond not in refused]
        single = {way.behind for way in ways if way.behind in self._structure.elements}
        for path in self._structure.elements:
            if path in single:
                place[path], count = count, count + 1
            else:
                place[path] = min(place[bond.other(path).owner] for bond in self._evidence.at[path])
        edges = [(place[way.junction], place[way.behind]) for way in ways]
        edges += [(place[read], place[path]) for path, reads in self._reads.items() for read in reads]
        rows, columns = np.array(edges, dtype=np.intp).reshape(-1, 2).T
        matrix = csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
        _, component = connected_components(matrix, directed=True, connection="strong")
        order = _driving_first([int(c) for c in component], [(int(component[a]), int(component[b])) for a, b in edges])
        return {path: order[int(component[number])] for path, number in place.items()}

    def model_parts(self, cuts: tuple[OneWayCut, ...], outputs: tuple[Path, ...]) -> tuple[ModelPart, ...]:
        """The parts with all that is told of them."""
        graph = self._evidence.compiled.graph
        activities = self._evidence.activities
        energetic = [path for path, e in self._structure.elements.items() if e.kind.is_energetic]
        own = {path: sum(activities[bond.name] for bond in self._evidence.at[path]) for path in energetic}
        whole = sum(own.values()) or 1.0
        holders = {output: {self._place[e] for e in elements_of_outputs(graph, [output])} for output in outputs}
        stages = _stages(cuts, len(set(self._place.values())))
        found: list[ModelPart] = []
        for number in sorted(set(self._place.values())):
            elements = tuple(p for p in self._structure.elements if self._place[p] == number)
            drives = any(cut.driving == number for cut in cuts)
            driven = any(cut.driven == number for cut in cuts)
            role = {
                (True, False): Role.DRIVING,
                (False, True): Role.DRIVEN,
                (True, True): Role.BETWEEN,
            }.get((drives, driven), Role.ALONE)
            rows = [r.path for r in self._evidence.compiled.system.rows if any(e in elements for e in r.elements)]
            found.append(
                ModelPart(
                    number=number,
                    role=role,
                    rows=tuple(rows),
                    elements=elements,
                    junctions=tuple(p for p in self._structure.junctions if self._place[p] == number),
                    activity=sum(own.get(path, 0.0) for path in elements) / whole,
                    outputs=tuple(output for output, parts in holders.items() if number in parts),
                    parameters=_parameters(self._evidence.compiled, elements),
                    stage=stages.get(number, 0),
                )
            )
        return tuple(found)


def _driving_first(components: list[int], edges: list[tuple[int, int]]) -> dict[int, int]:
    """Numbers from 1 on, such that what drives comes before what it drives."""
    before: dict[int, set[int]] = {c: set() for c in sorted(set(components))}
    for a, b in edges:
        if a != b:
            before[b].add(a)
    order: dict[int, int] = {}
    while len(order) < len(before):
        following = next(c for c, drivers in before.items() if c not in order and drivers <= order.keys())
        order[following] = len(order) + 1
    return order


def _stages(cuts: Iterable[OneWayCut], count: int) -> Mapping[int, int]:
    """For each part, how many parts in a row must have run before it."""
    stages = dict.fromkeys(range(1, count + 1), 0)
    for number in range(1, count + 1):
        for cut in cuts:
            if cut.driven == number:
                stages[number] = max(stages[number], stages[cut.driving] + 1)
    return stages


def _parameters(compiled: CompiledModel, elements: tuple[Path, ...]) -> int:
    """How many parameters the laws of some elements have of their own."""
    inside = set(elements)
    return sum(path.parent in inside for path in compiled.graph.parameters)


def _measured(
    trajectory: Trajectory, cuts: tuple[OneWayCut, ...], outputs: tuple[Path, ...]
) -> tuple[tuple[OneWayCut, ...], Comparison | None]:
    """What cuts do to outputs, one by one and together."""
    if not outputs or not cuts:
        return cuts, None
    if len(cuts) <= MOST_MEASURED:
        alone = [_compared(trajectory, [cut], outputs) for cut in cuts]
        cuts = tuple(
            OneWayCut(
                c.removal,
                c.driving,
                c.driven,
                c.junction,
                c.share,
                c.share_behind,
                None if found is None else max(output.rms for output in found.outputs),
            )
            for c, found in zip(cuts, alone, strict=True)
        )
    return cuts, _compared(trajectory, cuts, outputs)


def _compared(trajectory: Trajectory, cuts: Iterable[OneWayCut], outputs: tuple[Path, ...]) -> Comparison | None:
    """The outputs with cuts against those of the full model; None where the run with them does not reach its end."""
    compiled = compile_quietly(trajectory.compiled.model.without(cut.removal for cut in cuts))
    stepping = trajectory.stepping
    times = trajectory.time
    run = simulate(
        compiled,
        trajectory.scenario,
        method=stepping.method,
        step=stepping.step,
        jacobian_every=stepping.jacobian_every,
        tolerance=stepping.tolerance,
        record=outputs,
        record_every=float(np.median(np.diff(times))),
        integrals_every=float(times[-1] - times[0]),
    )
    return compare(trajectory, run, outputs) if run.ending.is_complete else None
