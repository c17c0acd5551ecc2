"""Many runs of one compiled model: designs side by side in the lanes of a vector register, groups of them in threads.

The machine code is the same for all designs; parameters, initial values and tables are its arguments. A design that
fails leaves the others alone. With a fixed step a design has the same bits alone, in any lane, thread and process.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from propermodel.codegen.build import best_lanes
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Faults, Path, SimulationError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Scenario
from propermodel.simulation.finite import faults_of_settings
from propermodel.simulation.groups import NO_ROWS, Settings, groups
from propermodel.simulation.observables import observable_path
from propermodel.simulation.overview import Overview
from propermodel.simulation.recovery import integral_of, start_of
from propermodel.simulation.side_by_side import LaneResults
from propermodel.simulation.simulate import selected_entries
from propermodel.simulation.stepping import DEFAULT_TOLERANCE, Stepping
from propermodel.simulation.trajectory import Ending, Statistics


@dataclass(frozen=True, eq=False, kw_only=True)
class Ensemble:
    """The answers of many designs: `ensemble[observable]` has one row of recorded values for each design.

    `final` are the values at the end, `integrals` and `activities` those of power and of its absolute value over the
    whole run, J. The numbers of a design that failed are not a number from then on; `endings` say why and when.
    """

    compiled: CompiledModel
    scenarios: tuple[Scenario, ...]
    method: Method
    step: float
    lanes: int
    time: FloatArray  # instants of the recorded rows
    rows: FloatArray  # designs x instants x recorded
    begins: FloatArray  # of the intervals between rows, the last one to the end; none where extremes are not asked for
    least: FloatArray  # designs x intervals x recorded
    greatest: FloatArray
    final: FloatArray  # designs x recorded
    recorded: Mapping[int, int]  # entry of the program's signals: column
    integrals: FloatArray  # designs x powers
    activities: FloatArray
    endings: tuple[Ending, ...]
    statistics: Statistics

    def __len__(self) -> int:
        return len(self.scenarios)

    def __getitem__(self, observable: Expr | Path | str) -> FloatArray:
        """The recorded values of an observable, designs x instants.

        Raises:
            SimulationError: the model has no such observable, or it was not recorded.
        """
        path = observable_path(observable)
        integral = integral_of(self.compiled, path)
        if integral is None:
            return self.rows[:, :, self._column(path)]
        starts = (start_of(self.compiled, scenario, path, integral) for scenario in self.scenarios)
        rates = self.rows[:, :, self._column(integral.rate)]
        return np.array([integral.values(self.time, rate, begin) for rate, begin in zip(rates, starts, strict=True)])

    def at_end(self, observable: Expr | Path | str) -> FloatArray:
        """The value of a recorded observable at the end, one for each design."""
        if integral_of(self.compiled, observable_path(observable)) is not None:
            return self[observable][:, -1]
        return self.final[:, self._column(observable)]

    def extremes(self, observable: Expr | Path | str) -> Overview:
        """The least and greatest values of a recorded observable, designs x intervals between rows.

        Without `record_every` there is one interval, the whole run. They are not a number where a design has failed.

        Raises:
            SimulationError: the model has no such observable, or its extremes were not recorded.
        """
        column = self._column(observable)
        if not self.begins.size:
            raise SimulationError.of(
                "simulation/not-recorded",
                f"the extremes of '{observable_path(observable)}' were not recorded in these runs",
                help="ask for them: simulate_many(..., record_extremes=True)",
            )
        return Overview(self.begins, self.least[:, :, column], self.greatest[:, :, column])

    def activity(self, entry: Path | str) -> FloatArray:
        """The integral of |power| of a bond or row, J, one for each design."""
        return self.activities[:, self._power(entry)]

    def work(self, entry: Path | str) -> FloatArray:
        """The integral of power of a bond (along its half arrow) or row (into it), J, one for each design."""
        return self.integrals[:, self._power(entry)]

    @property
    def failed(self) -> tuple[int, ...]:
        """The designs that did not reach their end."""
        return tuple(i for i, ending in enumerate(self.endings) if not ending.is_complete)

    @property
    def paths(self) -> tuple[Path, ...]:
        """Every recorded observable."""
        known = self.compiled.lowered.observables
        return tuple(path for path, observable in known.items() if observable.index in self.recorded)

    @property
    def parameters(self) -> Mapping[Path, FloatArray]:
        """The parameters that scenarios give, one value for each design; not a number where a scenario gives none."""
        names = dict.fromkeys(path for scenario in self.scenarios for path in scenario.parameters)
        return {
            name: np.array([scenario.parameters.get(name, np.nan) for scenario in self.scenarios]) for name in names
        }

    def to_xarray(self) -> Any:
        """Everything as an xarray Dataset over `design` (and `time`, `bond`), with units; needs the extra `data`."""
        import xarray as xr

        known = self.compiled.lowered.observables
        data: dict[str, Any] = {}
        for path in self.paths:
            units = {"units": known[path].unit}
            if self.time.size:
                data[str(path)] = (("design", "time"), self[path], units)
            data[f"{path} at end"] = ("design", self.at_end(path), units)
            if self.begins.size:
                seen = self.extremes(path)
                data[f"least {path}"] = (("design", "interval"), seen.least, units)
                data[f"greatest {path}"] = (("design", "interval"), seen.greatest, units)
        powers = [index for index, power in enumerate(self.compiled.lowered.powers) if power.kind != "outside"]
        for name, values in (("work", self.integrals), ("activity", self.activities)):
            data[name] = (("design", "bond"), values[:, powers], {"units": "J"})
        coordinates: dict[str, Any] = {
            "design": np.arange(len(self)),
            "scenario": ("design", [scenario.name for scenario in self.scenarios]),
            "status": ("design", [ending.status.value for ending in self.endings]),
            "bond": [str(self.compiled.lowered.powers[index].path) for index in powers],
        }
        if self.time.size:
            coordinates["time"] = ("time", self.time, {"units": "s"})
        if self.begins.size:
            coordinates["interval"] = ("interval", self.begins, {"units": "s"})
        units = {p.path: p.unit for p in self.compiled.graph.parameters.values()}
        for path, values in self.parameters.items():
            coordinates[f"parameter {path}"] = ("design", values, {"units": units[path]})
        return xr.Dataset(data, coords=coordinates)

    def __str__(self) -> str:
        per_minute = 60.0 * len(self) / max(self.statistics.wall_s, 1e-9)
        head = (
            f"{self.compiled.model.name}: {len(self)} designs in {self.statistics.wall_s:.2f} s "
            f"({per_minute:.0f} a minute), {self.lanes} side by side; {len(self.failed)} failed"
        )
        return "\n".join([head, *(f"  design {i}: {self.endings[i].message}" for i in self.failed)])

    def _column(self, observable: Expr | Path | str) -> int:
        path = observable_path(observable)
        (entry,) = selected_entries(self.compiled, [path])
        if int(entry) not in self.recorded:
            raise SimulationError.of(
                "simulation/not-recorded",
                f"'{path}' was not recorded in these runs",
                help="name it in simulate_many(..., record=[...])",
            )
        return self.recorded[int(entry)]

    def _power(self, entry: Path | str) -> int:
        path = observable_path(entry)
        powers = {power.path: i for i, power in enumerate(self.compiled.lowered.powers) if power.kind != "outside"}
        if path not in powers:
            raise SimulationError.of(
                "simulation/unknown-bond",
                f"the model has no bond or row '{path}'",
                help=one_of(str(path), map(str, powers)),
            )
        return powers[path]


def designs(scenario: Scenario, parameters: Mapping[Expr | Path | str, ArrayLike]) -> tuple[Scenario, ...]:
    """One scenario for each set of parameter values, SI: `designs(mission, {"body.mass": [900.0, 1000.0]})`.

    Args:
        scenario: What all have in common.
        parameters: Values by path, as many for each; a single number is the same for all.

    Raises:
        SimulationError: the numbers of values differ.
    """
    columns = {observable_path(path): np.asarray(values, dtype=np.float64) for path, values in parameters.items()}
    counts = {str(path): values.size for path, values in columns.items() if values.ndim > 0}
    if len(set(counts.values())) > 1 or any(values.ndim > 1 for values in columns.values()):
        raise SimulationError.of(
            "simulation/designs",
            f"the parameters have different numbers of values: {', '.join(f'{n} of {p}' for p, n in counts.items())}",
            help="give one value for each design, or a single number for all; repeat values for a full grid",
        )
    count = next(iter(counts.values()), 1)
    full = {path: np.broadcast_to(values, count) for path, values in columns.items()}
    return tuple(
        replace(
            scenario,
            name=f"{scenario.name} {i}",
            parameters={**scenario.parameters, **{path: float(values[i]) for path, values in full.items()}},
        )
        for i in range(count)
    )


def simulate_many(
    compiled: CompiledModel,
    scenarios: Iterable[Scenario],
    *,
    method: Method = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    tolerance: float = DEFAULT_TOLERANCE,
    record: Iterable[Expr | Path | str] | None = None,
    record_every: float = NO_ROWS,
    record_extremes: bool = False,
    lanes: int | None = None,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Ensemble:
    """Run a model once for each scenario; nothing is compiled between them.

    Scenarios that start and stop together and share their tables run side by side. Those whose inputs or tables differ
    run in turn; so does every scenario of a model with events, which happen at instants of its own, and with a method
    that controls its steps, which are each design's own.

    Args:
        compiled: The model.
        scenarios: One for each design, as from `designs(scenario, {"body.mass": masses})`.
        method: How a step is taken.
        step: Largest step, s; by default as for `simulate`.
        jacobian_every: How many steps of the method ros2 may share one Jacobian.
        tolerance: The error in one step as a share of each state, where the method controls its steps.
        record: Observables whose values are kept; by default all.
        record_every: Period of recording, s; by default only the values at the end are kept.
        record_extremes: Whether the least and greatest values between two rows are kept, too, or those of the whole
            run; they are looked for after every step: `ensemble.extremes(observable)`.
        lanes: How many designs run side by side; by default as many as a vector register of this machine holds.
        threads: How many groups run at once; by default one for each core.
        executor: Where groups run instead of in threads of this call, such as a `ProcessPoolExecutor`; `threads` then
            says how many workers it has. Each process compiles the model once, from its document.
        progress: Called with the number of designs that are done and of all.

    Returns:
        The answers of all designs; those that failed say why in `endings`.

    Raises:
        SimulationError: there is no scenario, or one does not fit the model; windows differ where rows are recorded.
    """
    every = tuple(scenarios)
    if not every:
        raise SimulationError.of(
            "simulation/designs", "there are no designs to simulate", help="give at least one scenario"
        )
    stepping = Stepping(method, step, jacobian_every, tolerance)
    faults = Faults(SimulationError)
    for scenario in every:
        faults.found.extend(faults_of_settings(scenario, stepping, record_every, NO_ROWS))
    faults.raise_if_any()
    windows = {(scenario.start, scenario.stop) for scenario in every}
    if len(windows) > 1 and record_every < NO_ROWS:
        raise SimulationError.of(
            "simulation/window",
            f"designs that are recorded need one window; these have {len(windows)}",
            help="give all scenarios the same start and stop, or record the end only: leave out record_every",
        )
    selected = selected_entries(compiled, record)
    before = time.perf_counter()
    wide = 1 if compiled.system.events or method.is_adaptive else (lanes or best_lanes(compiled.backend))
    # Machines are made before threads ask for them.
    compiled.machine(method, 1 if len(every) == 1 else wide)
    build_s = time.perf_counter() - before
    settings = Settings(compiled, stepping, record_every, selected, wide, record_extremes)
    before = time.perf_counter()
    answers = _Answers(len(every))
    workers = threads or os.cpu_count() or 1
    with ExitStack() as stack:
        pool = executor or stack.enter_context(ThreadPoolExecutor(workers))
        waiting: dict[Future[LaneResults], tuple[int, ...]] = {}
        stack.callback(_cancel, waiting)
        for group in groups(compiled, every, wide):
            # Few groups wait at a time, so that memory does not grow with the number of designs.
            while len(waiting) >= 2 * workers:
                answers.take(waiting, progress)
            waiting[pool.submit(group.job(settings))] = group.numbers
        while waiting:
            answers.take(waiting, progress)
    wall_s = time.perf_counter() - before
    return Ensemble(
        compiled=compiled,
        scenarios=every,
        method=method,
        step=max(stepping.longest(record_every, scenario.stop - scenario.start) for scenario in every),
        lanes=wide,
        recorded={int(entry): column for column, entry in enumerate(selected)},
        statistics=Statistics(steps=answers.steps, wall_s=wall_s, build_s=build_s),
        **answers.arrays(),
    )


def _cancel(waiting: Mapping[Future[LaneResults], object]) -> None:
    """Give up what has not begun, after an error."""
    for future in waiting:
        future.cancel()


class _Answers:
    """The answers of all designs, filled in as their groups come to an end."""

    def __init__(self, count: int) -> None:
        self.steps = 0
        self._count = count
        self._done = 0
        self._endings: dict[int, Ending] = {}
        self._arrays: dict[str, FloatArray] = {}
        self._time: FloatArray = np.zeros(0)
        self._begins: FloatArray = np.zeros(0)

    def take(
        self, waiting: dict[Future[LaneResults], tuple[int, ...]], progress: Callable[[int, int], None] | None
    ) -> None:
        """Wait for a group, and keep what it gave."""
        done, _ = wait(waiting, return_when=FIRST_COMPLETED)
        for future in done:
            numbers = waiting.pop(future)
            self._keep(numbers, future.result())
            if progress is not None:
                progress(self._done, self._count)

    def _keep(self, numbers: Sequence[int], result: LaneResults) -> None:
        for name in ("rows", "least", "greatest", "final", "integrals", "activities"):
            given: FloatArray = getattr(result, name)
            kept = self._arrays.get(name, np.empty((self._count, 0, *given.shape[2:])))
            # A group that has failed as a whole has fewer rows.
            if given.shape[1] > kept.shape[1]:
                more = np.full((self._count, given.shape[1] - kept.shape[1], *given.shape[2:]), np.nan)
                kept = np.concatenate((kept, more), axis=1)
            kept[list(numbers), : given.shape[1]] = given
            self._arrays[name] = kept
        if result.time.size > self._time.size:
            self._time = result.time
        if result.begins.size > self._begins.size:
            self._begins = result.begins
        self._endings.update(zip(numbers, result.endings, strict=True))
        self._done += len(numbers)
        self.steps += result.steps * len(numbers)

    def arrays(self) -> dict[str, Any]:
        """Everything by name."""
        endings = tuple(self._endings[number] for number in range(self._count))
        return {**self._arrays, "time": self._time, "begins": self._begins, "endings": endings}
