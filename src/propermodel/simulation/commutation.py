"""What switches do to the states at the instant at which they move: currents that have no way any more end at once."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.bondgraph.graph import Element
from propermodel.codegen.machine import FloatArray, Machine, Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError
from propermodel.modelling.model import ElementKind, PowerSource, Variable
from propermodel.simulation.switches import AGREEMENT, URGENCY, Switches

_MOST_ITERATIONS = 20
_WORK = 1e-9  # of a source in an impulse, as a share of the energies, that is rounding


@dataclass(frozen=True, slots=True)
class Commutation:
    """That the states have changed, by an impulse of these switches; `is_small` where only rounding was taken away."""

    element: Path
    members: tuple[Path, ...]
    is_small: bool


def commutate(compiled: CompiledModel, machine: Machine, switches: Switches, memory: Memory) -> Commutation | None:
    """Bring the states where the switches ask them to be, by impulses of their efforts and flows.

    The rates with and without a pull towards the constraints differ by what an impulse does.

    Raises:
        SimulationError: no impulse does it, or it would pass through a source.
    """
    first = now = switches.violation(memory)
    if first.size == 0.0:
        return None
    is_small = first.size <= AGREEMENT
    for _ in range(_MOST_ITERATIONS):
        switches.pull(memory, 0.0)
        free, before = machine.rates(memory)[0], machine.observe(memory)
        switches.pull(memory, URGENCY)
        pulled, after = machine.rates(memory)[0], machine.observe(memory)
        if not is_small:
            _refuse_sources(compiled, (after - before) / URGENCY, before, first.members)
        memory.state += (pulled - free) / URGENCY
        previous, now = now, switches.violation(memory)
        if now.size == 0.0 or now.size >= previous.size:
            break
    if not now.size <= AGREEMENT:
        names = ", ".join(str(path) for path in first.members)
        raise SimulationError.of(
            "simulation/not-converged",
            f"no impulse brings the states to what {names} ask of them: {now.size:g} is left",
            help="put a resistance beside the open switch, or in series with the closed one",
        )
    return Commutation(first.element, first.members, is_small)


def _refuse_sources(
    compiled: CompiledModel, impulses: FloatArray, signals: FloatArray, members: tuple[Path, ...]
) -> None:
    """Refuse an impulse in which a source would do work."""
    energies = sum(
        abs(float(signals[compiled.lowered.observables[stored.element / "energy"].index]))
        for stored in compiled.system.energies
    )
    for element in compiled.graph.normal.elements.values():
        work = _work(compiled, element, impulses, signals)
        if not abs(work) <= _WORK * energies:
            names = ", ".join(str(path) for path in members)
            raise SimulationError.of(
                "simulation/not-converged",
                f"an impulse of {names} would pass through the source {element.path}, which does {work:g} J at once",
                help="put a resistance in series with the switch, or a storage between it and the source",
            )


def _work(compiled: CompiledModel, element: Element, impulses: FloatArray, signals: FloatArray) -> float:
    if not isinstance(element.behaviour, PowerSource):
        return 0.0
    (port,) = element.ports
    given = Variable.EFFORT if element.behaviour.kind is ElementKind.EFFORT_SOURCE else Variable.FLOW
    found = [compiled.lowered.observables.get(element.path / port / v.value) for v in (given, given.other)]
    if found[0] is None or found[1] is None:
        return 0.0
    return float(signals[found[0].index] * impulses[found[1].index])
