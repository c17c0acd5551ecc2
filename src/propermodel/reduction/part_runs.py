"""The parts of a partition as models of their own: what drives runs first, its recorded signals drive the rest.

Parts that need nothing of each other run at the same time.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from propermodel.analysis.comparison import OutputError, compare
from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.graph import Structure
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ReductionError
from propermodel.modelling.model import (
    BondRemoval,
    ElementKind,
    JunctionKind,
    Model,
    Prescribe,
    Scenario,
    TableValues,
    ZeroEffort,
    ZeroFlow,
)
from propermodel.reduction.partition import ModelPart, OneWayCut, Partition
from propermodel.reduction.reading import elements_of_laws
from propermodel.simulation.simulate import simulate
from propermodel.simulation.trajectory import Trajectory

SAMPLES = 20000  # of a signal that one part passes on to another, where nothing else is asked for


@dataclass(frozen=True, kw_only=True)
class PartRuns:
    """The runs of all parts, and how their outputs differ from the full model's."""

    partition: Partition
    runs: Mapping[int, Trajectory]  # by part
    errors: tuple[OutputError, ...]

    def __str__(self) -> str:
        lines = [
            f"part {number}: {len(run.compiled.system.states)} states, {run.statistics.steps} steps of {run.step:g} s"
            for number, run in self.runs.items()
        ]
        return "\n".join([*lines, *map(str, self.errors)])


def part_model(partition: Partition, number: int) -> Model:
    """One part as a model: what drives it are inputs of its scenarios, and what it drives is gone.

    Raises:
        ReductionError: it reads signals of other parts.
    """
    graph = flatten(partition.model)
    structure = graph.normal
    part = partition.parts[number - 1]
    inside = set(part.elements)
    reads = (read for path in part.elements for read in elements_of_laws(graph, structure.elements[path]))
    foreign = {read for read in reads if read not in inside}
    if foreign:
        raise ReductionError.of(
            "reduction/part-signals",
            f"part {number} reads signals of other parts, at {', '.join(sorted(map(str, foreign)))}",
            help="run the model with all cuts: model.without(partition.removals)",
        )
    removals: dict[Path, BondRemoval] = {}
    for cut in partition.cuts:
        if cut.driven == number:
            removals[cut.removal.bond] = Prescribe(cut.removal.bond, cut.removal.driven)
        elif cut.driving == number:
            is_one = structure.junctions[cut.junction].kind is JunctionKind.ONE
            removals[cut.removal.bond] = ZeroEffort(cut.removal.bond) if is_one else ZeroFlow(cut.removal.bond)
    for removal in _without_others(structure, inside):
        removals.setdefault(removal.bond, removal)
    return partition.model.without(removals.values())


def _without_others(structure: Structure, inside: set[Path]) -> list[BondRemoval]:
    """Every element of other parts is deleted by the rule of its junction, a source by what it does not prescribe."""
    found: list[BondRemoval] = []
    at = structure.at()
    for path, element in structure.elements.items():
        if path in inside or element.kind in (ElementKind.TRANSFORMER, ElementKind.GYRATOR):
            continue
        for bond in at[path]:
            end = bond.other(path)
            is_one = not end.port and structure.junctions[end.owner].kind is JunctionKind.ONE
            if element.kind is ElementKind.FLOW_SOURCE or (element.kind.is_energetic and is_one):
                found.append(ZeroEffort(bond.name))
            else:
                found.append(ZeroFlow(bond.name))
    return found


def simulate_parts(partition: Partition, reference: Trajectory, *, record_every: float | None = None) -> PartRuns:
    """Run the parts one after the other, each driven by what was recorded of those before it, and compare outputs.

    Args:
        partition: The parts, of the model of `reference`.
        reference: A run of the full model; the parts run its scenario with its method and step.
        record_every: Period of the signals that are passed on, s.

    Raises:
        ReductionError: a part reads signals of others, or its run does not reach its end.
    """
    scenario = reference.scenario
    finest = max((scenario.stop - scenario.start) / SAMPLES, 0.0 if reference.method.is_adaptive else reference.step)
    period = finest if record_every is None else record_every
    compiled = {part.number: compile_quietly(part_model(partition, part.number)) for part in partition.parts}
    structure = reference.compiled.graph.normal
    runs: dict[int, Trajectory] = {}
    for stage in range(max(part.stage for part in partition.parts) + 1):
        here = [part for part in partition.parts if part.stage == stage]
        scenarios = [_driven_scenario(partition, part, structure, runs, scenario) for part in here]

        def run(part: ModelPart, given: Scenario) -> Trajectory:
            passed = [
                _passed_on(structure, cut, compiled[part.number])
                for cut in partition.cuts
                if cut.driving == part.number
            ]
            wanted = [path for path in part.outputs if path in compiled[part.number].lowered.observables]
            return _run(compiled[part.number], given, reference, [*passed, *wanted], period)

        with ThreadPoolExecutor(min(os.cpu_count() or 1, len(here))) as pool:
            for part, found in zip(here, pool.map(run, here, scenarios), strict=True):
                if not found.ending.is_complete:
                    raise ReductionError.of(
                        "activity/incomplete",
                        f"the run of part {part.number} did not reach its end: {found.ending.message}",
                        help="take fewer cuts (a smaller tolerance), or a smaller step",
                    )
                runs[part.number] = found
    errors = [compare(reference, runs[p.number], p.outputs).outputs for p in partition.parts if p.outputs]
    return PartRuns(partition=partition, runs=runs, errors=tuple(error for some in errors for error in some))


def _run(
    compiled: CompiledModel, scenario: Scenario, reference: Trajectory, record: list[Path], period: float
) -> Trajectory:
    stepping = reference.stepping
    return simulate(
        compiled,
        scenario,
        method=stepping.method,
        step=stepping.step,
        jacobian_every=stepping.jacobian_every,
        tolerance=stepping.tolerance,
        record=list(dict.fromkeys(record)),
        record_every=period,
        integrals_every=scenario.stop - scenario.start,
    )


def _driven_scenario(
    partition: Partition, part: ModelPart, structure: Structure, runs: Mapping[int, Trajectory], scenario: Scenario
) -> Scenario:
    """The scenario with the recorded signals that drive a part as its inputs."""
    inputs: dict[Path, float | TableValues] = dict(scenario.inputs)
    for cut in partition.cuts:
        if cut.driven == part.number:
            run = runs[cut.driving]
            column = run[_passed_on(structure, cut, run.compiled)]
            times = run.time
            rises = [True, *(times[1:] > times[:-1])]
            values = TableValues((tuple(times[rises].tolist()),), tuple(column[rises].tolist()))
            inputs[cut.removal.bond / cut.removal.driven.value] = values
    return replace(scenario, inputs=inputs)


def _passed_on(structure: Structure, cut: OneWayCut, driving: CompiledModel) -> Path:
    """The observable that a cut passes on: the common variable of its junction, at a bond that the driving part knows.

    Raises:
        ReductionError: there is none.
    """
    at = structure.at()[cut.junction]
    others = sorted(
        (bond for bond in at if bond.name != cut.removal.bond), key=lambda b: not b.other(cut.junction).port
    )
    for name in (cut.removal.bond, *(bond.name for bond in others)):
        if (path := name / cut.removal.driven.value) in driving.lowered.observables:
            return path
    raise ReductionError.of(
        "reduction/part-signals",
        f"nothing in part {cut.driving} tells the {cut.removal.driven} of {cut.junction}, for {cut.removal.bond}",
        help="run the model with all cuts: model.without(partition.removals)",
    )
