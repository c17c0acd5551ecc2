"""The energy balance of a run: what sources did, what storage kept, what resistances took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from propermodel.bondgraph.pseudo import is_pseudo
from propermodel.diagnostics import Path
from propermodel.equations.at_places import sign_at
from propermodel.modelling.model import ElementKind
from propermodel.presentation import notebook_html
from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True, kw_only=True)
class EnergyBalance:
    """Energies over a run, J.

    The change of stored energy comes from the energy functions at both ends, never from an integral of power, so that
    `integration_residual` shows what the step and the laws are worth. `wiring_residual` is the sum of all element
    powers, which the junction structure makes vanish. Pseudo bonds have a balance of their own for each domain, of the
    product of effort and flow, which is no energy.

    Activated bonds take no power where they begin; what they give where they end is no work of a source that was
    written, so each is named with it. So is storage whose law changes from outside, through a signal or with time (the
    gap of a capacitor that somebody opens), with the work of whatever changes it.
    """

    supplied: float  # work of all sources, counted into the system; without activated bonds and modulation
    throughput: float  # sum over sources and activated bonds of the integral of |power|
    exchanged: float  # sum over storage of the integral of |power|
    stored: float
    dissipated: float
    wiring_residual: float
    sources: tuple[tuple[Path, float], ...]
    activated: tuple[tuple[Path, float], ...] = ()  # what each activated bond gave
    modulated: tuple[tuple[Path, float], ...] = ()  # what changes of its law have brought into each storage
    converted: float = 0.0  # what converters have taken to pseudo bonds
    lost_in_events: float = 0.0
    pseudo: Mapping[str, EnergyBalance] = field(default_factory=dict[str, "EnergyBalance"])

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def integration_residual(self) -> float:
        """What is missing between supplied energy and that stored, dissipated, converted and lost in events."""
        given = self.supplied + sum(energy for _, energy in (*self.activated, *self.modulated))
        return given - self.stored - self.dissipated - self.converted - self.lost_in_events

    @property
    def relative_residual(self) -> float:
        """The integration residual as a share of the source work, without sources of what storage exchanged."""
        brought = (energy for _, energy in self.modulated)
        gone = (self.stored, self.dissipated, self.converted, self.lost_in_events, *brought)
        scale = max(self.throughput or self.exchanged, *map(abs, gone))
        return abs(self.integration_residual) / scale if scale else 0.0

    def __str__(self) -> str:
        lines = [f"energy balance: {self._text('J')}"]
        lines += [f"balance of pseudo bonds ({name}): {own._text('')}" for name, own in self.pseudo.items()]
        return "\n".join(lines)

    def _text(self, unit: str) -> str:
        scale = "the source work" if self.throughput else "what storage exchanged"
        end = f" {unit}" if unit else ""
        kept = f"stored {self.stored:.6g}{end} + dissipated {self.dissipated:.6g}{end}"
        converted = f" + converted {self.converted:.6g}{end}" if self.converted else ""
        events = f" + lost in events {self.lost_in_events:.6g}{end}" if self.lost_in_events else ""
        residual = f"residual {self.relative_residual:.2e} of {scale}, wiring {abs(self.wiring_residual):.2e}{end}"
        given = "".join(f" + activated bond {path} {energy:.6g}{end}" for path, energy in self.activated)
        given += "".join(f" + modulation of {path} {energy:.6g}{end}" for path, energy in self.modulated)
        return f"sources {self.supplied:.6g}{end}{given} = {kept}{converted}{events}; {residual}"


def energy_balance(trajectory: Trajectory) -> EnergyBalance:
    """The energy balance of a run; constant replacements and cuts count as sources, converters on pseudo bonds too."""
    graph = trajectory.compiled.graph
    kinds = {bond.name: bond.domain if is_pseudo(graph, bond) else "" for bond in graph.normal.bonds.values()}
    found = {kind: _balance(trajectory, {b for b, k in kinds.items() if k == kind}) for kind in {"", *kinds.values()}}
    lost = sum(event.lost for event in trajectory.events)
    return replace(found.pop(""), lost_in_events=lost, pseudo=dict(sorted(found.items())))


def _balance(trajectory: Trajectory, bonds: set[Path]) -> EnergyBalance:
    """The balance of the bonds of one kind."""
    graph = trajectory.compiled.graph
    supplied = throughput = exchanged = dissipated = converted = wiring = 0.0
    sources: list[tuple[Path, float]] = []
    activated: list[tuple[Path, float]] = []
    members: set[Path] = set()
    for path, ends in graph.normal.at().items():
        element = graph.normal.elements.get(path)
        own = [bond for bond in ends if bond.name in bonds]
        if element is None or not own:
            continue
        members.add(path)
        inward = sum(trajectory.work(bond.name) * (1.0 if sign_at(bond, path) else -1.0) for bond in own)
        passed = sum(trajectory.activity(bond.name) for bond in own)
        wiring += inward
        converts = len(own) < len(ends)
        if converts and not is_pseudo(graph, own[0]):
            converted += inward
        elif path in graph.activated_probes:
            continue
        elif (bond := graph.activated_sources.get(path)) is not None:
            throughput += passed
            activated.append((bond.path, -inward))
        elif converts or element.kind in (ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE):
            supplied -= inward
            throughput += passed
            sources.append((path, -inward))
        elif element.kind is ElementKind.RESISTANCE:
            dissipated += inward
        elif element.kind.is_storage:
            exchanged += passed
    modulated = tuple(
        (item.element, trajectory.work(item.element / "modulation"))
        for item in trajectory.compiled.system.modulations
        if item.element in members
    )
    stored = sum(
        trajectory.at_end(item.element / "energy") - trajectory.at_start(item.element / "energy")
        for item in trajectory.compiled.system.energies
        if item.element in members
    )
    return EnergyBalance(
        supplied=supplied,
        throughput=throughput,
        exchanged=exchanged,
        stored=stored,
        dissipated=dissipated,
        wiring_residual=wiring,
        sources=tuple(sources),
        activated=tuple(activated),
        modulated=modulated,
        converted=converted,
    )
