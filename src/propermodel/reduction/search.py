"""The smallest model whose outputs stay within tolerances: prediction proposes, simulation decides.

Beginning with the largest sets of removals that are predicted to be within the tolerances, models are reformulated and
simulated on every scenario, the best of a size first. A success leads to larger sets; what then remains is refined one
removal at a time. Nothing is simulated twice, and what no simulation has confirmed is not offered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from propermodel.analysis.tolerances import Tolerance
from propermodel.codegen.machine import Method
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import Path, ReductionError
from propermodel.expressions.core import Expr
from propermodel.modelling.files import FileName
from propermodel.modelling.model import Model, Scenario
from propermodel.reduction.candidates import Candidate, ProperModelSearch
from propermodel.reduction.strategy import Strategy
from propermodel.reduction.trials import Trials, period_of
from propermodel.simulation.choosing import Choice as MethodChoice
from propermodel.simulation.simulate import simulate
from propermodel.simulation.stepping import DEFAULT_TOLERANCE
from propermodel.simulation.trajectory import observable_path

Allowed = float | Tolerance  # of an output; a number is a root mean square


def find_proper_model(
    model: Model,
    scenarios: Scenario | Iterable[Scenario],
    tolerances: Mapping[Path, Allowed] | Mapping[str, Allowed] | Mapping[Expr, Allowed],
    *,
    method: MethodChoice = Method.SEMI_IMPLICIT,
    step: float | None = None,
    jacobian_every: int = 1,
    step_tolerance: float = DEFAULT_TOLERANCE,
    record_every: float | None = None,
    most_simulations: int = 200,
    results: FileName | None = None,
    progress: Callable[[Candidate, int], None] | None = None,
) -> ProperModelSearch:
    """Find the smallest model whose outputs stay within tolerances on all scenarios.

    Args:
        model: The full model.
        scenarios: What it is for. Those that matter most first; scenarios for verification count like all others.
        tolerances: Of each output that matters: the largest root mean square of its change, as a share of its range in
            the full model's run; or a `Tolerance` for other features. Predictions know root mean squares alone and are
            judged by the smallest share of a tolerance; simulation judges every feature.
        method: How a step is taken; with "auto" a short trial of the full model decides for all.
        step: Largest step, s.
        jacobian_every: How many steps of an implicit method may share one Jacobian.
        step_tolerance: The error of one step, where the method controls it.
        record_every: Period of recording, s; by default a two-thousandth of each scenario.
        most_simulations: After so many runs of candidates no further one begins.
        results: A file in which runs of candidates are kept as they are done. A search that was stopped goes on from
            it, and searches of the same model, scenarios, outputs and steps with other tolerances share them.
        progress: Called with every candidate, and the number of simulations so far.

    Returns:
        Every model that was tried; `recommended`, `best` and `front` choose among them.

    Raises:
        ReductionError: there is no scenario or tolerance, an output lacks a feature that its tolerance names, a run of
            the full model did not reach its end, or the file of results belongs to something else.
        SimulationError: a scenario does not fit the model.
    """
    every = (scenarios,) if isinstance(scenarios, Scenario) else tuple(scenarios)
    wanted = {observable_path(output): Tolerance.of(allowed) for output, allowed in tolerances.items()}
    if not every or not wanted:
        raise ReductionError.of(
            "reduction/tolerances",
            "a search needs a scenario, and outputs with tolerances",
            help='for 1 % of its range: find_proper_model(model, scenario, {"body.flange.flow": 0.01})',
        )
    full = compile_quietly(model)
    first = simulate(
        full,
        every[0],
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        tolerance=step_tolerance,
        record_every=period_of(every[0], record_every),
        integrals_every=every[0].stop - every[0].start,
    )
    trials = Trials(full, every, wanted, first, record_every, results)
    search = Strategy(trials, most_simulations, progress)
    search.run()
    return ProperModelSearch(
        model=model,
        tolerances=wanted,
        scenarios=tuple(scenario.name for scenario in every),
        rows=len(trials.full.system.rows),
        states=len(trials.full.system.states),
        candidates=tuple(search.tried.values()),
        simulations=search.simulations,
        notes=trials.predictions[0].notes,
        alone=trials.predictions[0].rows(),
        conditions=trials.conditions,
        stepping=first.stepping,
    )
