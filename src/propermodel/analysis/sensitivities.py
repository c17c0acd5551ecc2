"""Sensitivities: how outputs, energies and activity indices change with parameters, from one run that carries them."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from propermodel.analysis.sensitivity_question import Name, Question
from propermodel.analysis.sensitivity_table import sensitivity_table
from propermodel.codegen.machine import FloatArray, Method, Request
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError, one_of
from propermodel.expressions.units import si_text
from propermodel.modelling.model import Scenario
from propermodel.presentation import notebook_html
from propermodel.simulation.choosing import AUTO, Choice
from propermodel.simulation.equilibrium import equilibrium_start
from propermodel.simulation.stability import note_on_step
from propermodel.simulation.start import Start, parameter_values, start_of
from propermodel.simulation.start_tangents import StartTangents, start_tangents
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.table_store import TableStore
from propermodel.simulation.tangent_run import Along, TangentJob, TangentRun
from propermodel.simulation.trajectory import Ending, Statistics, observable_path

TICKS_AT_ONCE = 1000  # so that an interrupt (Ctrl-C) is heard


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivities:
    """Derivatives of outputs with respect to parameters, in SI: `sensitivities[output, parameter]` over `time`.

    Outputs are observables, among them `power`, `work` and `activity` of ports and bonds. For every row of a ranking
    there are also the derivatives of its work, activity and activity index over the whole run. With `relative=True`
    all are relative: by how many percent something changes with one percent of the parameter.
    """

    compiled: CompiledModel
    scenario: Scenario
    method: Method
    step: float
    parameters: tuple[Path, ...]
    parameter_values: FloatArray
    parameter_units: tuple[str, ...]
    outputs: tuple[Path, ...]
    output_units: tuple[str, ...]
    time: FloatArray
    along: Along  # rows x outputs (x parameters)
    final: Along  # outputs (x parameters)
    rows: tuple[Path, ...]  # of a ranking, in the order of the model
    row_work: Along  # rows (x parameters), J
    row_activity: Along
    ending: Ending
    statistics: Statistics
    notes: tuple[str, ...]

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    def __getitem__(self, key: tuple[Name, Name]) -> FloatArray:
        """The derivative of an output with respect to a parameter, over `time`."""
        output, parameter = key
        return self.along.slopes[:, self._output(output), self._parameter(parameter)]

    def values(self, output: Name) -> FloatArray:
        """An output itself, over `time`."""
        return self.along.values[:, self._output(output)]

    def at_end(self, output: Name, parameter: Name, *, relative: bool = False) -> float:
        """The derivative of an output at the end."""
        return self._chosen(self.final, self._output(output), self._parameter(parameter), relative)

    def value_at_end(self, output: Name) -> float:
        """An output itself at the end."""
        return float(self.final.values[self._output(output)])

    def gradient(self, output: Name) -> FloatArray:
        """The derivatives of an output at the end with respect to all parameters, in their order."""
        return self.final.slopes[self._output(output)]

    def work(self, row: Name, parameter: Name, *, relative: bool = False) -> float:
        """The derivative of the energy that has gone into an element or group, J."""
        return self._chosen(self.row_work, self._row(row), self._parameter(parameter), relative)

    def activity(self, row: Name, parameter: Name, *, relative: bool = False) -> float:
        """The derivative of the activity of an element or group, J."""
        return self._chosen(self.row_activity, self._row(row), self._parameter(parameter), relative)

    def index(self, row: Name, parameter: Name, *, relative: bool = False) -> float:
        """The derivative of the activity index of an element or group."""
        return self._chosen(self.indices, self._row(row), self._parameter(parameter), relative)

    @property
    def indices(self) -> Along:
        """The activity indices, shares of the activity of all rows, with their derivatives by the quotient rule."""
        values, slopes = self.row_activity.values, self.row_activity.slopes
        total = values.sum()
        with np.errstate(invalid="ignore", divide="ignore"):
            shares = values / total
            return Along(shares, (slopes - shares[:, np.newaxis] * slopes.sum(axis=0)) / total)

    def relative(self, quantity: Along) -> FloatArray:
        """The derivatives of a quantity in relative form, p/y dy/dp; no numbers where the quantity is zero."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return quantity.slopes * self.parameter_values / quantity.values[..., np.newaxis]

    def to_xarray(self) -> Any:
        """Everything as an xarray Dataset over `time`, `output`, `row` and `parameter`; needs the extra `data`."""
        import xarray as xr

        over = {"time": ("time", "output"), "end": ("output",), "row": ("row",)}
        data: dict[str, Any] = {}
        for name, quantity, kind in (
            ("output", self.along, "time"),
            ("output at end", self.final, "end"),
            ("work", self.row_work, "row"),
            ("activity", self.row_activity, "row"),
            ("index", self.indices, "row"),
        ):
            data[f"{name} value" if name == "output" else name] = (over[kind], quantity.values)
            data[f"d {name}"] = ((*over[kind], "parameter"), quantity.slopes)
            data[f"relative {name}"] = ((*over[kind], "parameter"), self.relative(quantity))
        return xr.Dataset(
            data,
            coords={
                "time": ("time", self.time, {"units": "s"}),
                "output": [str(path) for path in self.outputs],
                "output_unit": ("output", list(self.output_units)),
                "row": [str(path) for path in self.rows],
                "parameter": [str(path) for path in self.parameters],
                "parameter_unit": ("parameter", list(self.parameter_units)),
                "parameter_value": ("parameter", self.parameter_values),
            },
            attrs={"status": self.ending.status.value, "scenario": self.scenario.name},
        )

    def __str__(self) -> str:
        return sensitivity_table(self)

    def _chosen(self, quantity: Along, place: int, parameter: int, relative: bool) -> float:
        slopes = self.relative(quantity) if relative else quantity.slopes
        return float(slopes[place, parameter])

    def _output(self, name: Name) -> int:
        return _place(name, self.outputs, "simulation/not-recorded", "output of these sensitivities")

    def _parameter(self, name: Name) -> int:
        return _place(name, self.parameters, "simulation/not-recorded", "parameter of these sensitivities")

    def _row(self, name: Name) -> int:
        return _place(name, self.rows, "simulation/unknown-bond", "row of the ranking")


def _place(name: Name, known: Sequence[Path], code: str, what: str) -> int:
    path = observable_path(name)
    if path not in known:
        raise SimulationError.of(code, f"'{path}' is no {what}", help=one_of(str(path), map(str, known)))
    return known.index(path)


def sensitivities(
    compiled: CompiledModel,
    scenario: Scenario,
    *,
    parameters: Iterable[Name],
    outputs: Iterable[Name] = (),
    method: Choice = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    record_every: float = 0.1,
    start: Literal["declared", "equilibrium"] = "declared",
) -> Sensitivities:
    """The derivatives of outputs, energies and activity indices with respect to parameters, along one run.

    They are those of the run with its steps, as exact as its numbers: not approximated by differences. Kinks of laws
    and edges of table cells have one-sided derivatives, and instants at which a condition of a law changes stay.

    Args:
        compiled: The model.
        scenario: The scenario.
        parameters: With respect to which; parameters that the model computes from them follow.
        outputs: Observables, and `power`, `work` or `activity` of ports, bonds and groups.
        method: How a step is taken.
        step: Largest step, s, by default 0.2 ms.
        jacobian_every: How many steps of an implicit method may share one Jacobian.
        record_every: Period of recording, s.
        start: Whether the run begins with the declared values or at the equilibrium near them.

    Returns:
        The derivatives, also when the run failed; `ending` says how it ended.

    Raises:
        SimulationError: a name is unknown, the scenario does not fit, or the model has jumps that have no derivative.
    """
    stepping = Stepping(Method.RODAS if method == AUTO else Method(method), step, jacobian_every)
    question = Question.asked(compiled, scenario, parameters, outputs, stepping, record_every)
    store = TableStore()

    def begin(other: Scenario) -> Start:
        return start_of(compiled, other, store) if start == "declared" else equilibrium_start(compiled, other)

    begun = begin(scenario)
    note = note_on_step(compiled, begun.memory, stepping.method, stepping.longest(), scenario.stop - scenario.start)
    rates = start_tangents(compiled, scenario, question.parameters, begin, is_declared=start == "declared")
    before = time.perf_counter()
    job = TangentJob(
        compiled=compiled,
        prepared=compiled.tangents(stepping.method, question.directions, question.signals, question.powers),
        names=question.parameters,
        request=Request(
            until=scenario.stop,
            step=stepping.longest(),
            row_period=record_every,
            most_ticks=TICKS_AT_ONCE,
            jacobian_every=jacobian_every,
        ),
        signals=question.signals,
        powers=question.powers,
        kept=question.kept,
    )
    job.prepared.machine(job.lanes)
    build_s = time.perf_counter() - before
    before = time.perf_counter()
    run = job.run(begun.memory, rates)
    wall_s = time.perf_counter() - before
    flat = compiled.graph.parameters
    values = parameter_values(compiled, scenario.parameters)
    final = question.at_end(run)
    return Sensitivities(
        compiled=compiled,
        scenario=scenario,
        method=stepping.method,
        step=stepping.longest(),
        parameters=question.parameters,
        parameter_values=np.array([values[flat[path].symbol] for path in question.parameters]),
        parameter_units=tuple(si_text(flat[path].unit) for path in question.parameters),
        outputs=tuple(output.path for output in question.outputs),
        output_units=tuple(si_text(output.unit) for output in question.outputs),
        time=run.time,
        along=question.along(run),
        final=final,
        rows=question.rows,
        row_work=run.final_work.of(question.row_places),
        row_activity=run.final_activity.of(question.row_places),
        ending=run.ending,
        statistics=Statistics(steps=run.steps, wall_s=wall_s, build_s=build_s),
        notes=(*begun.notes, *([note] if note else []), *_notes(compiled, question, rates, run)),
    )


def _notes(compiled: CompiledModel, question: Question, rates: StartTangents, run: TangentRun) -> list[str]:
    """What a reader has to know: parameters without effect, and starts that were differentiated by differences."""
    notes: list[str] = []
    for k, path in enumerate(question.parameters):
        effects = (run.signals, run.final_signals, run.final_work, run.final_activity)
        has_start = rates.state[k].any() or rates.discrete[k].any()
        direction = question.own_directions[k]
        if not (direction.at_one or direction.at_given or has_start):
            notes.append(f"{path} has no effect: nothing that is simulated depends on it")
        elif not any(effect.slopes[..., k].any() for effect in effects):
            notes.append(f"{path} has no effect on these outputs and energies in this scenario")
        else:
            moved = [s.path for s, rate in zip(compiled.system.states, rates.state[k], strict=True) if rate]
            computed = [str(state) for state in rates.by_differences if state in moved]
            if computed:
                notes.append(f"by differences of the start, with respect to {path}: {', '.join(computed)}")
    return notes
