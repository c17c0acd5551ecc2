"""What the page of a reduction shows, as plain data: from a study, or from a certificate whose models are run again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from propermodel.analysis.activity import bond_activities, rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.analysis.comparison import OutputError, compare
from propermodel.analysis.ranking import ActivityRanking, Discretisation
from propermodel.codegen.machine import FloatArray
from propermodel.codegen.versions import versions
from propermodel.diagnostics import Path, parse_path
from propermodel.drawing.depict import depict
from propermodel.modelling.model import Removal
from propermodel.reduction.candidates import ProperModelSearch
from propermodel.reduction.certificate import Certificate
from propermodel.reduction.certify import CertifiedModel
from propermodel.report.buckets import Intervals, extremes, packed
from propermodel.report.panels import Panel, Series
from propermodel.report.run_data import (
    USUAL_THRESHOLD,
    Fate,
    balance_data,
    history_data,
    instants,
    ranking_data,
    windows_data,
)
from propermodel.report.study import ReductionStudy
from propermodel.report.summary import removal_text
from propermodel.report.timeline import column_of
from propermodel.simulation.display_units import Display, display_for
from propermodel.simulation.trajectory import Trajectory

FORMAT = "propermodel report"
VERSION = 1
INTERVALS = 1000  # of each signal
SHORT_INTERVALS = 200  # of the histories of single elements

Json = Any


@dataclass(frozen=True, kw_only=True)
class PageSubject:
    """A reduction with the runs of both models on one scenario, and what else is known of it."""

    certificate: Certificate
    full: Trajectory
    reduced: Trajectory
    ranking: ActivityRanking
    fates: Mapping[Path, Fate]
    threshold: float
    outputs: tuple[Path, ...]
    totals: Mapping[str, Path] = field(default_factory=dict[str, Path])
    panels: tuple[Panel, ...] = ()
    facts: tuple[tuple[str, str, str], ...] = ()  # more of them: name, value, note
    notes: tuple[str, ...] = ()
    removals: tuple[Removal, ...] = ()
    search: ProperModelSearch | None = None


def subject_of_study(study: ReductionStudy, certificate: Certificate) -> PageSubject:
    """What the page of a study of activity shows."""
    facts: list[tuple[str, str, str]] = []
    if study.speed is not None:
        facts.append(("faster", f"{study.speed.ratio:.2f} times", "same method and step"))
    if study.best_steps is not None and study.best_steps.speed is not None:
        facts.append(("faster at best steps", f"{study.best_steps.speed.ratio:.2f} times", "same error of the outputs"))
    reduction = study.reduction
    return PageSubject(
        certificate=certificate,
        full=study.full,
        reduced=study.reduced,
        ranking=study.ranking,
        fates={d.row.path: Fate(d.verdict.value, d.meaning, d.reason) for d in reduction.decisions},
        threshold=reduction.threshold,
        outputs=study.compared,
        totals=study.options.totals,
        panels=study.options.panels,
        facts=tuple(facts),
        notes=reduction.notes,
        removals=reduction.removals,
    )


def subject_of_certified(
    certified: CertifiedModel,
    *,
    search: ProperModelSearch | None = None,
    totals: Mapping[str, Path] | None = None,
    panels: Iterable[Panel] = (),
) -> PageSubject:
    """What the page of a certified model shows, after running both models on the first scenario.

    Raises:
        ReductionError: a run does not reach its end.
        SimulationError: the scenario does not fit the full model.
    """
    claim, certificate = certified.claim, certified.certificate
    full, reduced = claim.recorded_pair()
    gone = {row.row: row for row in certificate.removed}
    fates = {
        row.path: Fate("removed", "", gone[row.path].why) if row.path in gone else Fate("kept", "", "")
        for row in full.compiled.system.rows
    }
    return PageSubject(
        certificate=certificate,
        full=full,
        reduced=reduced,
        ranking=rank_activity(full),
        fates=fates,
        threshold=USUAL_THRESHOLD,
        outputs=claim.outputs,
        totals=totals or {},
        panels=tuple(panels),
        removals=claim.removals,
        search=search,
    )


def page_data(subject: PageSubject) -> Json:
    """All that a page shows, as plain data."""
    full, ranking = subject.full, subject.ranking
    return {
        "format": FORMAT,
        "version": VERSION,
        "model": full.compiled.model.name,
        "scenario": full.scenario.name,
        "window": [float(full.time[0]), float(full.time[-1])],
        "threshold": subject.threshold,
        "facts": [{"name": name, "value": value, "note": note} for name, value, note in _facts(subject)],
        "picture": depict(subject.reduced.compiled, ranking, bond_activities(full)).document(),
        "rows": ranking_data(ranking, subject.fates),
        "totalActivity": ranking.total,
        "notes": [*subject.certificate.warnings, *subject.notes],
        "outputs": [output_data(error) for error in compare(full, subject.reduced, subject.outputs).outputs],
        "balances": {
            "full": balance_data(energy_balance(full)),
            "reduced": balance_data(energy_balance(subject.reduced)),
        },
        "signals": _signals(subject),
        "windows": windows_data(full),
        "histories": _histories(subject),
        "tried": None if subject.search is None else _tried(subject.search),
        "made": _made(subject),
        "certificate": str(subject.certificate).splitlines(),
    }


def _facts(subject: PageSubject) -> list[tuple[str, str, str]]:
    full, reduced, certificate = subject.full, subject.reduced, subject.certificate
    kept = [row for row in subject.ranking.rows if subject.fates[row.path].verdict != "removed"]
    facts = [
        ("energy elements", f"{certificate.full.rows} → {certificate.reduced.rows}", "that store or dissipate"),
        ("states", f"{certificate.full.states} → {certificate.reduced.states}", "of the equations"),
        ("activity kept", f"{sum(row.index for row in kept):.2%}", "of all elements"),
    ]
    for name, path in subject.totals.items():
        before, after = (run.at_end(path) - run.at_start(path) for run in (full, reduced))
        change = f"{after / before - 1.0:+.2%}" if before else ""
        unit = full.unit(path)
        facts.append((name.removesuffix(f"_{unit}"), f"{before:.4g} → {after:.4g} {unit}", change))
    outputs = compare(full, reduced, subject.outputs).outputs
    if outputs:
        worst = max(outputs, key=lambda error: error.rms)
        facts.append(("largest error", f"{worst.rms:.2%}", f"rms / range, {worst.path}"))
    if certificate.score is not None:
        facts.append(("of the tolerance", f"{certificate.score:.0%}", "used by the worst output"))
    facts.extend(subject.facts)
    residual = max(energy_balance(run).relative_residual for run in (full, reduced))
    facts.append(("energy unaccounted", f"{residual:.0e}", "of the work of sources"))
    return facts


def output_data(error: OutputError) -> Json:
    """The differences of an output, as shares of its range."""
    return {
        "path": str(error.path),
        "unit": error.unit,
        "rms": error.rms,
        "maximum": error.largest,
        "at": error.at,
        "full": error.reference.final,
        "reduced": error.other.final,
        "final": error.final_error,
    }


def _signals(subject: PageSubject) -> Json:
    """What panels show, and the compared outputs that they do not show."""
    full, reduced = subject.full, subject.reduced
    edges, times = instants(float(full.time[0]), float(full.time[-1]), INTERVALS)
    lanes = [(panel.title, panel.unit, panel.series) for panel in subject.panels]
    seen = {series.path for _, _, shown in lanes for series in shown}
    lanes += [(str(path), "", (Series(str(path)),)) for path in subject.outputs if str(path) not in seen]
    items: list[Json] = []
    for title, unit, shown in lanes:
        columns = [column_of(full, series) for series in shown]
        size = max((float(np.max(np.abs(values), initial=0.0)) for _, values, _ in columns), default=0.0)
        display = Display(unit, 1.0) if unit else display_for(columns[0][2], size)
        for series, (time, values, _) in zip(shown, columns, strict=True):
            factor = series.scale * display.factor
            items.append(
                {
                    "path": series.path,
                    "label": series.label or series.path,
                    "unit": display.unit,
                    "panel": title,
                    "full": packed(extremes(time, values * factor, edges)),
                    "reduced": _reduced(reduced, parse_path(series.path), factor, edges),
                    "difference": _difference(reduced, parse_path(series.path), factor, (time, values), edges),
                }
            )
    return {"times": packed(times), "items": items}


def _reduced(run: Trajectory, path: Path, factor: float, edges: FloatArray) -> str | None:
    return packed(extremes(run.time, run[path] * factor, edges)) if path in run else None


def _difference(
    reduced: Trajectory, path: Path, factor: float, full: tuple[FloatArray, FloatArray], edges: FloatArray
) -> str | None:
    """The reduced model less the full one, at the instants of the full one."""
    if path not in reduced:
        return None
    time, values = full
    return packed(extremes(time, (np.interp(time, reduced.time, reduced[path]) - values) * factor, edges))


def _histories(subject: PageSubject) -> Json:
    """Effort and flow at the ports of every row, in few intervals."""
    full = subject.full
    edges, times = instants(float(full.time[0]), float(full.time[-1]), SHORT_INTERVALS)
    intervals = Intervals(full.time, edges)
    rows: dict[str, list[Json]] = {}
    for row in full.compiled.system.rows:
        bonds = [bond for bond in row.bonds if bond / "effort" in full and bond / "flow" in full]
        if bonds:
            rows[str(row.path)] = history_data(full, bonds, intervals)
    return {"times": packed(times), "rows": rows}


def _made(subject: PageSubject) -> list[Json]:
    full, ranking = subject.full, subject.ranking
    check = ranking.discretisation
    rows = [
        ("method", f"{full.method.value}, step {full.step:g} s"),
        ("found by", subject.certificate.method),
        ("steps", f"{full.statistics.steps} full, {subject.reduced.statistics.steps} reduced"),
        ("discretisation", "" if check is None else _discretisation(check)),
        ("datums", "; ".join(ranking.datums)),
        ("removals", "; ".join(removal_text(removal) for removal in subject.removals)),
        *((name, str(value)) for name, value in versions().items()),
    ]
    return [{"name": name, "value": value} for name, value in rows if value]


def _discretisation(check: Discretisation) -> str:
    return f"indices change by at most {check.largest_change_points:.2g} points {check.comparison}"


def _tried(search: ProperModelSearch) -> Json:
    recommended, best = search.recommended, search.best
    return [
        {
            "rows": search.rows - len(candidate.rows),
            "states": candidate.states,
            "score": candidate.score,
            "predicted": candidate.predicted,
            "verdict": candidate.verdict.value,
            "mark": "recommended" if candidate is recommended else "smallest" if candidate is best else "",
        }
        for candidate in search.candidates
    ]
