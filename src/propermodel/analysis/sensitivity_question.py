"""What sensitivities are asked for, in terms of a compiled model: directions, signals and powers."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from propermodel.bondgraph.parameters import followers
from propermodel.bondgraph.pseudo import is_pseudo, is_pseudo_port
from propermodel.codegen.tangents import Direction
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Path, SimulationError, one_of
from propermodel.expressions.core import Expr, leaves
from propermodel.modelling.model import Scenario
from propermodel.simulation.finite import faults_of_settings
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.tangent_run import Along, TangentRun
from propermodel.simulation.trajectory import observable_path

Name = Expr | Path | str
_MOST_NAMED = 6


class OutputKind(StrEnum):
    """What an output is."""

    OBSERVABLE = "observable"
    POWER = "power"  # effort times flow
    WORK = "work"  # the integral of a power since the start
    ACTIVITY = "activity"  # the integral of its absolute value


@dataclass(frozen=True, slots=True)
class Output:
    """One output, and where what it is made of stands: among the chosen signals, or among the chosen powers."""

    path: Path
    unit: str
    kind: OutputKind
    places: tuple[int, ...]

    @property
    def is_integral(self) -> bool:
        """Whether it is an integral of a chosen power."""
        return self.kind in (OutputKind.WORK, OutputKind.ACTIVITY)


@dataclass(frozen=True, kw_only=True)
class Question:
    """Parameters and outputs that exist, of a model and scenario that have derivatives.

    Without events all parameters share one direction of the program, whose rates a run tells, lane by lane.
    """

    parameters: tuple[Path, ...]
    own_directions: tuple[Direction, ...]  # of each parameter
    has_events: bool
    outputs: tuple[Output, ...]
    signals: tuple[int, ...]  # entries of SIGNAL that the outputs need
    powers: tuple[int, ...]  # entries of POWER that the outputs and rows need
    rows: tuple[Path, ...]  # of a ranking
    row_places: tuple[int, ...]  # where their powers are among the chosen ones

    @staticmethod
    def asked(
        compiled: CompiledModel,
        scenario: Scenario,
        parameters: Iterable[Name],
        outputs: Iterable[Name],
        stepping: Stepping,
        record_every: float,
    ) -> Question:
        """The question, checked.

        Raises:
            SimulationError: a name is unknown, a number cannot be, or the model has no derivatives.
        """
        names = tuple(dict.fromkeys(map(observable_path, parameters)))
        faults = Faults(SimulationError)
        faults.found.extend(faults_of_settings(scenario, stepping, record_every, record_every))
        faults.found.extend(_faults_of_stepping(stepping))
        faults.found.extend(_faults_of_model(compiled))
        faults.found.extend(_faults_of_parameters(compiled, names))
        entries = _Entries(compiled)
        found: list[Output] = []
        for path in dict.fromkeys(map(observable_path, outputs)):
            with faults.collecting():
                found.append(entries.output(path))
        entries.add_energies()
        rows = _ranked_rows(compiled)
        row_places = tuple(entries.power(entry) for entry in rows.values())
        faults.raise_if_any()
        return Question(
            parameters=names,
            own_directions=tuple(_direction(compiled, path, scenario.parameters) for path in names),
            has_events=bool(compiled.system.events),
            outputs=tuple(found),
            signals=tuple(entries.signals),
            powers=tuple(entries.powers),
            rows=tuple(rows),
            row_places=row_places,
        )

    @property
    def directions(self) -> tuple[Direction, ...]:
        """The directions of the program."""
        if self.has_events or len(self.own_directions) == 1:
            return self.own_directions
        moved = (leaf for own in self.own_directions for leaf in (*own.at_one, *own.at_given))
        return (Direction((), tuple(dict.fromkeys(moved))),)

    @property
    def kept(self) -> tuple[int, ...]:
        """Where the powers whose integrals are outputs are among the chosen ones."""
        return tuple(dict.fromkeys(output.places[0] for output in self.outputs if output.is_integral))

    def along(self, run: TangentRun) -> Along:
        """The outputs over time."""
        return self._outputs(run.signals, run.work, run.activity, {entry: i for i, entry in enumerate(self.kept)})

    def at_end(self, run: TangentRun) -> Along:
        """The outputs at the end."""
        kept = {entry: entry for entry in self.kept}
        return self._outputs(run.final_signals, run.final_work, run.final_activity, kept)

    def _outputs(self, signals: Along, work: Along, activity: Along, kept: Mapping[int, int]) -> Along:
        parts: list[Along] = []
        for output in self.outputs:
            match output.kind:
                case OutputKind.OBSERVABLE:
                    parts.append(signals.of(output.places))
                case OutputKind.POWER:
                    effort, flow = (signals.of([place]) for place in output.places)
                    parts.append(effort.times(flow))
                case OutputKind.WORK:
                    parts.append(work.of([kept[output.places[0]]]))
                case OutputKind.ACTIVITY:
                    parts.append(activity.of([kept[output.places[0]]]))
        parts = parts or [signals.of([])]
        return Along(
            np.concatenate([part.values for part in parts], axis=-1),
            np.concatenate([part.slopes for part in parts], axis=-2),
        )


class _Entries:
    """The entries of SIGNAL and POWER that are needed, in the order in which they are first asked for."""

    def __init__(self, compiled: CompiledModel) -> None:
        self._compiled = compiled
        self.signals: dict[int, int] = {}  # entry: place
        self.powers: dict[int, int] = {}
        self._power_entries = {
            power.path: entry for entry, power in enumerate(compiled.lowered.powers) if power.kind != "outside"
        }

    def output(self, path: Path) -> Output:
        """An output with what it needs.

        Raises:
            SimulationError: the model has no such observable.
        """
        known = self._compiled.lowered.observables
        is_pseudo = is_pseudo_port(self._compiled.graph, path.parent)
        if path in known:
            return Output(path, known[path].unit, OutputKind.OBSERVABLE, (self._signal(path),))
        if path.name == "power":
            places = (self._signal(path.parent / "effort"), self._signal(path.parent / "flow"))
            return Output(path, "" if is_pseudo else "W", OutputKind.POWER, places)
        if path.name in ("work", "activity") and path.parent in self._power_entries:
            return Output(path, "" if is_pseudo else "J", OutputKind(path.name), (self.power(path.parent),))
        raise SimulationError.of(
            "simulation/unknown-observable",
            f"the model has no observable '{path}'",
            help=one_of(str(path), map(str, (*known, *(entry / "activity" for entry in self._power_entries)))),
        )

    def add_energies(self) -> None:
        """What the records of events need."""
        if self._compiled.system.events:
            for stored in self._compiled.system.energies:
                self._signal(stored.element / "energy")

    def _signal(self, path: Path) -> int:
        known = self._compiled.lowered.observables
        if path not in known:
            raise SimulationError.of(
                "simulation/unknown-observable",
                f"the model has no observable '{path}'",
                help=one_of(str(path), map(str, known)),
            )
        return self.signals.setdefault(known[path].index, len(self.signals))

    def power(self, entry: Path) -> int:
        """The place of the power of a bond or row."""
        return self.powers.setdefault(self._power_entries[entry], len(self.powers))


def _ranked_rows(compiled: CompiledModel) -> dict[Path, Path]:
    """The rows of a ranking with the entry of their power; pseudo bonds have none beside true ones."""
    graph = compiled.graph
    rows = compiled.system.rows
    true = [row for row in rows if not any(is_pseudo(graph, graph.normal.bonds[name]) for name in row.bonds)]
    return {row.path: row.path if len(row.bonds) > 1 else next(iter(row.bonds)) for row in true or rows}


def _direction(compiled: CompiledModel, path: Path, given: Container[Path]) -> Direction:
    """The direction of a parameter, among the parameters that the program reads."""
    read = set(compiled.lowered.parameters)
    flat = compiled.graph.parameters
    equal = {flat[path].symbol: path}
    others: list[Expr] = []
    for follower in followers(flat, path):
        if follower.path in given:
            continue
        if follower.value in equal:
            equal[follower.symbol] = follower.path
        elif follower.path in read:
            others.append(follower.symbol)
    return Direction(tuple(symbol for symbol, name in equal.items() if name in read), tuple(others))


def _faults_of_parameters(compiled: CompiledModel, names: Sequence[Path]) -> Iterator[Diagnostic]:
    flat = compiled.graph.parameters
    if not names:
        yield Diagnostic(
            "simulation/sensitivities",
            "no parameter is given with respect to which there could be sensitivities",
            help=f"name at least one, for example {next(map(str, flat), 'body.mass')}",
        )
    for path in names:
        if path not in flat:
            yield Diagnostic(
                "simulation/unknown-parameter",
                f"the model has no parameter '{path}'",
                help=one_of(str(path), map(str, flat), "this model has no parameters"),
            )
            continue
        moved = {flat[path].symbol, *(parameter.symbol for parameter in followers(flat, path))}
        for controller in compiled.graph.controllers:
            if moved.intersection(leaves(controller.period)):
                yield Diagnostic(
                    "simulation/sensitivities",
                    f"there is no sensitivity to {path}: it sets the sample period of {controller.path}, and a run "
                    "changes by steps where an instant of sampling moves",
                    source=controller.source,
                    help="compare runs with different periods, or leave this parameter out",
                )


def _faults_of_stepping(stepping: Stepping) -> Iterator[Diagnostic]:
    if stepping.method.is_adaptive:
        yield Diagnostic(
            "simulation/sensitivities",
            f"{stepping.method} chooses its steps by their error; sensitivities are derivatives of steps that stay",
            help="use a method with steps of one length: ros2 for stiff models, rk4 for others",
        )


def _faults_of_model(compiled: CompiledModel) -> Iterator[Diagnostic]:
    if compiled.system.switching:
        names = list(dict.fromkeys(str(path) for switching in compiled.system.switching for path in switching.paths))
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        yield Diagnostic(
            "simulation/sensitivities",
            f"the model has ideal switches, which change its equations: {', '.join(names[:_MOST_NAMED])}{more}",
            help="take differences of two runs with slightly different parameters, or switches with a resistance that "
            "is small or large",
        )
