"""The energy balance of a run: what sources did, what storage kept, what resistances took."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.diagnostics import Path
from propermodel.equations.definitions import sign_at
from propermodel.modelling.model import ElementKind
from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class EnergyBalance:
    """Energies over a run, J.

    The change of stored energy comes from the energy functions at both ends, never from an integral of power, so that
    `integration_residual` shows what the step and the laws are worth. `wiring_residual` is the sum of all element
    powers, which the junction structure makes vanish.
    """

    supplied: float  # work of all sources, counted into the system
    throughput: float  # sum over sources of the integral of |power|
    exchanged: float  # sum over storage of the integral of |power|
    stored: float
    dissipated: float
    lost_in_events: float
    wiring_residual: float
    sources: tuple[tuple[Path, float], ...]

    @property
    def integration_residual(self) -> float:
        """What is missing between supplied, stored and dissipated energy and that lost in events."""
        return self.supplied - self.stored - self.dissipated - self.lost_in_events

    @property
    def relative_residual(self) -> float:
        """The integration residual as a share of the source work, without sources of what storage exchanged."""
        scale = max(self.throughput or self.exchanged, abs(self.stored), abs(self.dissipated), abs(self.lost_in_events))
        return abs(self.integration_residual) / scale if scale else 0.0

    def __str__(self) -> str:
        events = f" + lost in events {self.lost_in_events:.6g} J" if self.lost_in_events else ""
        scale = "the source work" if self.throughput else "what storage exchanged"
        return (
            f"energy balance: sources {self.supplied:.6g} J = stored {self.stored:.6g} J + dissipated "
            f"{self.dissipated:.6g} J{events}; residual {self.relative_residual:.2e} of {scale}, "
            f"wiring {abs(self.wiring_residual):.2e} J"
        )


def energy_balance(trajectory: Trajectory) -> EnergyBalance:
    """The energy balance of a run; constant replacements and cuts count as sources."""
    graph = trajectory.compiled.graph
    at = graph.normal.at()
    supplied = throughput = exchanged = dissipated = wiring = 0.0
    sources: list[tuple[Path, float]] = []
    for element in graph.normal.elements.values():
        inward = sum(
            trajectory.work(bond.name) * (1.0 if sign_at(bond, element.path) else -1.0) for bond in at[element.path]
        )
        wiring += inward
        if element.kind is ElementKind.RESISTANCE:
            dissipated += inward
        elif element.kind in (ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE):
            supplied -= inward
            throughput += sum(trajectory.activity(bond.name) for bond in at[element.path])
            sources.append((element.path, -inward))
        elif element.kind in (ElementKind.COMPLIANCE, ElementKind.INERTIA):
            exchanged += sum(trajectory.activity(bond.name) for bond in at[element.path])
    stored = sum(
        trajectory.at_end(item.element / "energy") - trajectory.at_start(item.element / "energy")
        for item in trajectory.compiled.system.energies
    )
    return EnergyBalance(
        supplied=supplied,
        throughput=throughput,
        exchanged=exchanged,
        stored=stored,
        dissipated=dissipated,
        lost_in_events=sum(event.lost for event in trajectory.events),
        wiring_residual=wiring,
        sources=tuple(sources),
    )
