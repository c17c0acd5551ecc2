"""The certificate of a reduction by activity, from the runs of its study."""

from __future__ import annotations

from propermodel.diagnostics import Path
from propermodel.reduction.certificate import RemovedRow
from propermodel.reduction.certify import CertifiedModel, make_certificate
from propermodel.reduction.claim import Claim, Condition
from propermodel.reduction.plan import Reduction
from propermodel.report.study import ReductionStudy
from propermodel.simulation.trajectory import Trajectory


def certify_study(study: ReductionStudy) -> CertifiedModel:
    """Certify the reduced model of a study; its errors are stated, as a threshold of activity promises none."""
    full, options = study.full, study.options
    condition = Condition(
        scenario=full.scenario,
        record_every=options.record_every(full.scenario),
        integrals_every=options.integrals_every(full.scenario),
    )
    return certify_reduction(study.reduction, full, study.reduced, condition, study.compared)


def certify_reduction(
    reduction: Reduction,
    full: Trajectory,
    reduced: Trajectory,
    condition: Condition,
    outputs: tuple[Path, ...],
    window: tuple[float, float] | None = None,
) -> CertifiedModel:
    """Certify the reduced model of a plan from the runs of both models on one scenario.

    Args:
        reduction: The plan.
        full: The run of the full model.
        reduced: That of the reduced model.
        condition: The scenario of the full model, and how it is recorded.
        outputs: What is compared.
        window: The part of the run that was ranked, s, where it was not all of it.
    """
    claim = Claim(
        model=full.compiled.model,
        removals=reduction.removals,
        conditions=(condition,),
        outputs=outputs,
        tolerances={},
        stepping=full.stepping,
    )
    ranked = "" if window is None else f" between {window[0]:g} and {window[1]:g} s"
    return make_certificate(
        claim,
        [(full, reduced)],
        method=(
            f"activity{ranked}: the threshold {reduction.threshold:.1%} keeps {reduction.kept_by_threshold} of "
            f"{len(reduction.decisions)} rows, local tests with {reduction.tolerance:g} decide about the others"
        ),
        removed=[
            RemovedRow(
                row=decision.row.path,
                kind=decision.row.kind,
                removals=decision.removals,
                why=f"{decision.explanation} (activity {decision.row.index:.3%})",
                alone={},
                is_fragile=False,
            )
            for decision in reduction.removed
        ],
    )
