"""The report of a reduction: one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import gzip
import html
import json
from importlib import resources
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.analysis.activity import Discretisation, bond_activities
from propermodel.analysis.balance import EnergyBalance
from propermodel.analysis.comparison import OutputError
from propermodel.codegen.versions import versions
from propermodel.diagnostics import Path, parse_path
from propermodel.drawing.depict import depict
from propermodel.reduction.certificate import Certificate
from propermodel.report.buckets import extremes, packed
from propermodel.report.panels import Display, Series, display_for
from propermodel.report.study import ReductionStudy
from propermodel.report.summary import finite, removal_text
from propermodel.report.timeline import column_of
from propermodel.simulation.trajectory import Trajectory

FORMAT = "propermodel report"
VERSION = 1
INTERVALS = 1000  # of each signal

Json = Any

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<noscript>This report draws itself, and needs scripts; it loads nothing from elsewhere.</noscript>
<div id="app"></div>
<script type="application/json" id="data">{data}</script>
<!-- The layout engine ELK (elkjs, EPL-2.0, https://github.com/kieler/elkjs), unmodified and compressed. -->
<script type="text/plain" id="engine">{engine}</script>
<script>{script}</script>
</body>
</html>
"""
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' blob:; worker-src blob:; style-src 'unsafe-inline'; img-src data:"
)


def write_page(study: ReductionStudy, certificate: Certificate, file: FilePath) -> None:
    """Write the report of a study as one HTML file."""
    file.write_text(page_text(page_data(study, certificate)), encoding="utf-8")


def page_text(data: Json) -> str:
    """The HTML of a page with this data, as the front end reads it."""
    report = resources.files("propermodel.report") / "assets"
    engine = (resources.files("propermodel.drawing") / "assets" / "elk-worker.min.js").read_bytes()
    # A "<" could end the element that holds the data.
    text = json.dumps(finite(data), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return _PAGE.format(
        policy=_POLICY,
        title=html.escape(f"{data['model']}: {data['scenario']}"),
        style=(report / "report.css").read_text(encoding="utf-8"),
        data=text,
        engine=base64.b64encode(gzip.compress(engine, mtime=0)).decode("ascii"),
        script=(report / "report.js").read_text(encoding="utf-8"),
    )


def page_data(study: ReductionStudy, certificate: Certificate) -> Json:
    """All that the page of a study shows, as plain data."""
    full = study.full
    return {
        "format": FORMAT,
        "version": VERSION,
        "model": full.compiled.model.name,
        "scenario": full.scenario.name,
        "window": [float(full.time[0]), float(full.time[-1])],
        "threshold": study.reduction.threshold,
        "facts": _facts(study),
        "picture": depict(study.reduced_model, study.ranking, bond_activities(full)).document(),
        "rows": [
            {
                "path": str(decision.row.path),
                "kind": decision.row.kind,
                "activity": decision.row.activity,
                "index": decision.row.index,
                "cumulative": decision.row.cumulative,
                "verdict": decision.verdict.value,
                "meaning": decision.meaning,
                "reason": decision.reason,
            }
            for decision in study.reduction.decisions
        ],
        "totalActivity": study.ranking.total,
        "notes": [*certificate.warnings, *study.reduction.notes],
        "outputs": [_output(error) for error in study.comparison.outputs],
        "balances": {"full": _balance(study.full_balance), "reduced": _balance(study.reduced_balance)},
        "signals": _signals(study),
        "made": _made(study),
        "certificate": _certified(certificate),
    }


def _facts(study: ReductionStudy) -> list[Json]:
    reduction, full, reduced = study.reduction, study.full, study.reduced
    states = len(full.compiled.system.states), len(reduced.compiled.system.states)
    facts = [
        ("energy elements", f"{len(reduction.decisions)} → {len(reduction.kept)}", "stored or dissipated in"),
        ("states", f"{states[0]} → {states[1]}", "of the equations"),
        ("activity kept", f"{reduction.kept_activity:.2%}", f"threshold {reduction.threshold:.1%}"),
    ]
    for name, path in study.options.totals.items():
        before, after = (run.at_end(path) - run.at_start(path) for run in (full, reduced))
        change = f"{after / before - 1.0:+.2%}" if before else "–"
        facts.append((name, f"{before:.4g} → {after:.4g} {full.unit(path)}", change))
    if study.comparison.outputs:
        worst = max(study.comparison.outputs, key=lambda error: error.rms)
        facts.append(("largest error", f"{worst.rms:.2%}", f"rms / range, {worst.path}"))
    if study.speed is not None:
        facts.append(("faster", f"{study.speed.ratio:.2f} times", "same method and step"))
    if study.best_steps is not None and study.best_steps.speed is not None:
        facts.append(("faster at best steps", f"{study.best_steps.speed.ratio:.2f} times", "same error of the outputs"))
    residual = max(study.full_balance.relative_residual, study.reduced_balance.relative_residual)
    facts.append(("energy unaccounted", f"{residual:.0e}", "of the work of sources"))
    return [{"name": name, "value": value, "note": note} for name, value, note in facts]


def _output(error: OutputError) -> Json:
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


def _balance(balance: EnergyBalance) -> Json:
    return {
        "supplied": balance.supplied,
        "stored": balance.stored,
        "dissipated": balance.dissipated,
        "residual": balance.relative_residual,
        "sources": [{"path": str(path), "work": work} for path, work in balance.sources],
    }


def _signals(study: ReductionStudy) -> Json:
    """What panels show, and the compared outputs that they do not show."""
    full, reduced = study.full, study.reduced
    edges = np.linspace(float(full.time[0]), float(full.time[-1]), INTERVALS + 1)
    middles = 0.5 * (edges[:-1] + edges[1:])
    lanes = [(panel.title, panel.unit, panel.series) for panel in study.options.panels]
    seen = {series.path for _, _, shown in lanes for series in shown}
    lanes += [(str(path), "", (Series(str(path)),)) for path in study.compared if str(path) not in seen]
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
                }
            )
    return {"times": packed(np.column_stack([edges[:-1], middles]).ravel()), "items": items}


def _reduced(run: Trajectory, path: Path, factor: float, edges: Any) -> str | None:
    return packed(extremes(run.time, run[path] * factor, edges)) if path in run else None


def _made(study: ReductionStudy) -> list[Json]:
    full = study.full
    check = study.ranking.discretisation
    rows = [
        ("method", f"{full.method.value}, step {full.step:g} s"),
        ("steps", f"{full.statistics.steps} full, {study.reduced.statistics.steps} reduced"),
        ("discretisation", "" if check is None else _discretisation(check)),
        ("datums", "; ".join(study.ranking.datums)),
        ("removals", "; ".join(removal_text(removal) for removal in study.reduction.removals)),
        *((name, str(value)) for name, value in versions().items()),
    ]
    return [{"name": name, "value": value} for name, value in rows if value]


def _discretisation(check: Discretisation) -> str:
    return f"indices change by at most {check.largest_change_points:.2g} points {check.comparison}"


def _certified(certificate: Certificate) -> Json:
    return {
        "text": str(certificate).splitlines(),
        "not checked": list(certificate.not_checked),
        "recheck": certificate.recheck,
    }
