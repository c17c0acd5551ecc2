"""All methods on one model: how large it has to be for an error, by each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from propermodel.codegen.machine import Method
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import Path, ReductionError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Model, Scenario
from propermodel.reduction.methods.activity import by_activity
from propermodel.reduction.methods.backward import by_measured_error
from propermodel.reduction.methods.correlation import by_energy_correlation
from propermodel.reduction.methods.curve import Curve, MethodOfOthers
from propermodel.reduction.methods.deduction import by_frequency_response, by_spectral_radius
from propermodel.reduction.methods.projection import by_balanced_truncation, by_modal_truncation
from propermodel.reduction.methods.proposed import by_prediction
from propermodel.reduction.methods.relative import by_relative_activity
from propermodel.reduction.methods.workbench import Workbench
from propermodel.reduction.trials import period_of
from propermodel.simulation.choosing import Choice
from propermodel.simulation.simulate import simulate
from propermodel.simulation.stepping import DEFAULT_TOLERANCE
from propermodel.simulation.trajectory import observable_path

METHODS: tuple[MethodOfOthers, ...] = (
    by_prediction,
    by_measured_error,
    by_activity,
    by_relative_activity,
    by_energy_correlation,
    by_spectral_radius,
    by_frequency_response,
    by_balanced_truncation,
    by_modal_truncation,
)


@dataclass(frozen=True, kw_only=True)
class MethodComparison:
    """The curves of all methods for one model and scenario."""

    model: str
    scenario: str
    outputs: tuple[Path, ...]
    tolerance: float  # root mean square over range
    rows: int
    states: int
    curves: tuple[Curve, ...]

    def __str__(self) -> str:
        head = (
            f"{self.model}: {self.rows} rows, {self.states} states, on {self.scenario}; errors are root mean squares "
            f"over range, the largest of {', '.join(map(str, self.outputs))}"
        )
        width = max(len(curve.method) for curve in self.curves)
        lines = [
            head,
            f"{'':<{width}}  smallest within {self.tolerance:<8.3g} by its own rule",
            f"{'method':<{width}}{'rows':>6}{'states':>8}{'error':>10}{'rows':>8}{'states':>8}{'error':>10}{'runs':>6}",
        ]
        for curve in self.curves:
            if curve.not_applied:
                lines.append(f"{curve.method:<{width}}  does not apply: {curve.not_applied}")
                continue
            cells: list[str] = []
            for model, size in ((curve.smallest_within(self.tolerance), 6), (curve.chosen, 8)):
                if model is None:
                    cells.append(f"{'-':>{size}}{'-':>8}{'-':>10}")
                    continue
                rows = "-" if model.rows is None else str(model.rows)
                error = f"{model.error:.3%}" if model.error < 10.0 else "no run" if model.why else "large"
                cells.append(f"{rows:>{size}}{model.states:>8}{error:>10}")
            lines.append(f"{curve.method:<{width}}{''.join(cells)}{curve.simulations:>6}")
        notes = dict.fromkeys(f"{curve.method}: {note}" for curve in self.curves for note in curve.notes)
        return "\n".join([*lines, *(f"note: {note}" for note in notes)])


def compare_methods(
    model: Model,
    scenario: Scenario,
    outputs: Iterable[Expr | Path | str],
    *,
    tolerance: float = 0.02,
    threshold: float = 0.99,
    method: Choice = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    step_tolerance: float = DEFAULT_TOLERANCE,
    record_every: float | None = None,
    methods: Iterable[MethodOfOthers] = METHODS,
    progress: Callable[[Curve], None] | None = None,
) -> MethodComparison:
    """Reduce a model by this package's method and those of others, and measure every model on the way.

    Args:
        model: The full model.
        scenario: What it is for.
        outputs: The observables that matter.
        tolerance: Root mean square over range at which the methods are compared.
        threshold: The share of activity, or importance, that a ranking keeps by its own rule.
        method: How a step is taken; with "auto" a short trial of the full model decides for all.
        step: Largest step, s.
        jacobian_every: How many steps of an implicit method may share one Jacobian.
        step_tolerance: The error of one step, where the method controls it.
        record_every: Period of recording, s; by default a two-thousandth of the scenario.
        methods: Which of them.
        progress: Called with every curve.

    Raises:
        ReductionError: an output does not exist, or the run of the full model did not reach its end.
        SimulationError: the scenario does not fit the model.
    """
    paths = tuple(map(observable_path, outputs))
    period = period_of(scenario, record_every)
    full = compile_quietly(model)
    for path in paths:
        if path not in full.lowered.observables:
            raise ReductionError.of(
                "reduction/unknown-output",
                f"the output '{path}' does not exist",
                help=one_of(str(path), map(str, full.lowered.observables)),
            )
    if not paths:
        raise ReductionError.of(
            "reduction/unknown-output", "no outputs were given", help="name the observables that matter"
        )
    run = simulate(
        full,
        scenario,
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=step_tolerance,
        record_every=period,
        integrals_every=scenario.stop - scenario.start,
    )
    if not run.ending.is_complete:
        raise ReductionError.of(
            "activity/incomplete",
            f"the run did not reach its end: {run.ending.message}",
            where=str(run.ending.path),
            help="compare on a run that is complete: cure the failure (a smaller step?), or let it stop earlier",
        )
    bench = Workbench(run, paths, record_every=period, tolerance=tolerance, threshold=threshold)
    curves: list[Curve] = []
    for reduce in methods:
        bench.begin()
        curves.append(reduce(bench))
        if progress is not None:
            progress(curves[-1])
    return MethodComparison(
        model=model.name,
        scenario=scenario.name,
        outputs=paths,
        tolerance=tolerance,
        rows=len(full.system.rows),
        states=len(full.system.states),
        curves=tuple(curves),
    )
