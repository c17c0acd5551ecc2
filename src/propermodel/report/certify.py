"""The certificate of a reduction by activity, from the runs of its study."""

from __future__ import annotations

from propermodel.reduction.certificate import RemovedRow
from propermodel.reduction.certify import CertifiedModel, make_certificate
from propermodel.reduction.claim import Claim, Condition
from propermodel.report.study import ReductionStudy


def certify_study(study: ReductionStudy) -> CertifiedModel:
    """Certify the reduced model of a study; its errors are stated, as a threshold of activity promises none."""
    full, reduction, options = study.full, study.reduction, study.options
    claim = Claim(
        model=full.compiled.model,
        removals=reduction.removals,
        conditions=(
            Condition(
                scenario=full.scenario,
                record_every=options.record_every(full.scenario),
                integrals_every=options.integrals_every(full.scenario),
            ),
        ),
        outputs=study.compared,
        tolerances={},
        stepping=full.stepping,
    )
    return make_certificate(
        claim,
        [(full, study.reduced)],
        method=(
            f"activity: the threshold {reduction.threshold:.1%} keeps {reduction.kept_by_threshold} of "
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
