"""The study of a reduction: full model, ranking, reduction, reduced model, and what was lost and gained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import EnergyBalance, energy_balance
from propermodel.analysis.comparison import Comparison, compare
from propermodel.analysis.ranking import ActivityRanking
from propermodel.compiler import CompiledModel, compile_model, compile_quietly
from propermodel.diagnostics import Diagnostic, Path, ProperModelError, SimulationError, parse_path
from propermodel.modelling.model import ElementKind, Model, Scenario
from propermodel.reduction.fitting import fitting_scenario
from propermodel.reduction.plan import Reduction, plan_reduction
from propermodel.report.options import StudyOptions, check_outputs
from propermodel.report.panels import Panel
from propermodel.report.speed import BestSteps, Speed, measure_best_steps, measure_speed
from propermodel.simulation.simulate import Progress, simulate
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.trajectory import RunStatus, Trajectory

StudyProgress = Callable[[str, Progress | None], None]


@dataclass(frozen=True, kw_only=True)
class ReductionStudy:
    """All that a reduction rests on, and what it is worth."""

    options: StudyOptions
    full: Trajectory
    refined: Trajectory  # the full model at half the step, or a tenth of the tolerance
    ranking: ActivityRanking
    reduction: Reduction
    reduced: Trajectory
    compared: tuple[Path, ...]
    comparison: Comparison
    full_balance: EnergyBalance
    reduced_balance: EnergyBalance
    speed: Speed | None
    best_steps: BestSteps | None

    @property
    def reduced_model(self) -> CompiledModel:
        """The reduced model."""
        return self.reduced.compiled


@dataclass
class StudySoFar:
    """What a study has made until it stopped."""

    runs: dict[str, Trajectory] = field(default_factory=dict[str, Trajectory])
    ranking: ActivityRanking | None = None
    reduction: Reduction | None = None

    def run(
        self,
        name: str,
        compiled: CompiledModel,
        scenario: Scenario,
        options: StudyOptions,
        say: StudyProgress,
        stepping: Stepping | None = None,
    ) -> Trajectory:
        """Make a run and keep it, also when it does not reach its end; without a stepping, with that of the options.

        Raises:
            SimulationError: it did not.
        """
        run = simulate(
            compiled,
            scenario,
            method=options.method if stepping is None else stepping.method,
            step=options.step if stepping is None else stepping.step,
            jacobian_every=options.jacobian_every,
            tolerance=options.step_tolerance if stepping is None else stepping.tolerance,
            record=() if name == "refined" else None,
            record_every=options.record_every(scenario),
            integrals_every=options.integrals_every(scenario),
            progress=lambda progress: say(name, progress),
        )
        self.runs[name] = run
        if not run.ending.is_complete:
            raise SimulationError.of(
                "study/incomplete",
                f"{name} run: {run.ending.message}",
                where=str(run.ending.path),
                help="cure the failure first (a smaller step, other values), or let the scenario stop earlier",
            )
        return run

    def refine(self, full: Trajectory, options: StudyOptions, say: StudyProgress) -> Trajectory:
        """The same run with finer steps.

        Raises:
            SimulationError: it did not reach its end.
        """
        return self.run("refined", full.compiled, full.scenario, options, say, full.stepping.refined())

    @property
    def was_interrupted(self) -> bool:
        """Whether the last run was interrupted."""
        return bool(self.runs) and list(self.runs.values())[-1].ending.status is RunStatus.INTERRUPTED


class IncompleteStudy(SimulationError):
    """A study was interrupted, or one of its stages failed; `so_far` holds what was made."""

    so_far: StudySoFar
    was_interrupted: bool

    @classmethod
    def because(cls, cause: ProperModelError | KeyboardInterrupt, so_far: StudySoFar) -> IncompleteStudy:
        """The error for what stopped a study."""
        if isinstance(cause, ProperModelError):
            error = cls(cause.diagnostics)
            error.was_interrupted = so_far.was_interrupted
        else:
            error = cls(
                [
                    Diagnostic(
                        "study/incomplete", "interrupted; what was computed is kept", help="run it again to the end"
                    )
                ]
            )
            error.was_interrupted = True
        error.so_far = so_far
        return error


def run_study(
    model: Model,
    scenario: Scenario,
    options: StudyOptions | None = None,
    progress: StudyProgress | None = None,
) -> ReductionStudy:
    """Reduce a model for a scenario, and compare the reduced model with it.

    Args:
        model: The full model.
        scenario: What it is driven through.
        options: How.
        progress: Called with the name of each stage, and about ten times a second during a run.

    Raises:
        IncompleteStudy: it stopped after the first run had begun.
        ProperModelError: the model, scenario or options are wrong.
    """
    so_far = StudySoFar()
    try:
        return _stages(model, scenario, options or StudyOptions(), progress or _say_nothing, so_far)
    except (ProperModelError, KeyboardInterrupt) as cause:
        if not so_far.runs:
            raise
        raise IncompleteStudy.because(cause, so_far) from cause


def _stages(
    model: Model, scenario: Scenario, options: StudyOptions, say: StudyProgress, so_far: StudySoFar
) -> ReductionStudy:
    say("compiling", None)
    compiled = compile_model(model)
    check_outputs(compiled, (*options.outputs, *options.totals.values(), *_shown(options.panels, compiled)))
    full = so_far.run("full", compiled, scenario, options, say)
    refined = so_far.refine(full, options, say)
    ranking = so_far.ranking = rank_activity(full, refined=refined)
    say("reducing", None)
    reduction = so_far.reduction = plan_reduction(
        compiled,
        full,
        ranking,
        threshold=options.threshold,
        protected=tuple(dict.fromkeys((*options.outputs, *options.totals.values()))),
        tolerance=options.tolerance,
        drop_driven=options.drop_driven,
    )
    reduced_model = compile_quietly(model.without(reduction.removals))
    fitting = fitting_scenario(reduced_model, scenario)
    reduced = so_far.run("reduced", reduced_model, fitting, options, say, full.stepping)
    compared = options.outputs or most_active(ranking, full, reduced)
    speed, best = _speeds(full, reduced, compared, options, say)
    return ReductionStudy(
        options=options,
        full=full,
        refined=refined,
        ranking=ranking,
        reduction=reduction,
        reduced=reduced,
        compared=compared,
        comparison=compare(full, reduced, compared),
        full_balance=energy_balance(full),
        reduced_balance=energy_balance(reduced),
        speed=speed,
        best_steps=best,
    )


def _speeds(
    full: Trajectory, reduced: Trajectory, compared: tuple[Path, ...], options: StudyOptions, say: StudyProgress
) -> tuple[Speed | None, BestSteps | None]:
    """What is asked for of the speeds; an interruption leaves out what was not measured, not the study."""
    speed = best = None
    try:
        if options.speed_repeats > 0:
            say("measuring speed", None)
            speed = measure_speed(full, reduced, compared, options.speed_repeats)
            if options.best_steps and not full.method.is_adaptive:
                say("searching steps", None)
                best = measure_best_steps(full, reduced, compared, options.speed_repeats)
    except KeyboardInterrupt:
        say("interrupted", None)
    return speed, best


def _say_nothing(stage: str, progress: Progress | None) -> None:
    pass


def _shown(panels: tuple[Panel, ...], compiled: CompiledModel) -> tuple[Path, ...]:
    """The observables that panels show; a table of the scenario can be shown as well."""
    paths = [parse_path(series.path) for panel in panels for series in panel.series]
    return tuple(path for path in paths if path not in compiled.graph.tables)


def most_active(ranking: ActivityRanking, full: Trajectory, reduced: Trajectory) -> tuple[Path, ...]:
    """What the most active storage gives: the effort of a compliance, the flow of an inertia."""
    found: list[Path] = []
    for row in ranking.rows:
        variable = "effort" if row.kind == ElementKind.COMPLIANCE else "flow"
        path = row.ports[0][0] / variable
        if row.kind in (ElementKind.COMPLIANCE, ElementKind.INERTIA) and path in full and path in reduced:
            found.append(path)
    return tuple(found[:4])
