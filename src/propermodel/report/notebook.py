"""What models, runs, rankings and reductions look like in a notebook."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from functools import singledispatch
from importlib.util import find_spec

import numpy as np

from propermodel.analysis.balance import EnergyBalance
from propermodel.analysis.comparison import Comparison
from propermodel.analysis.ranking import ActivityRanking
from propermodel.analysis.sensitivities import Sensitivities
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import Path, ProperModelError
from propermodel.drawing.depict import depict, depict_model
from propermodel.drawing.svg import to_svg
from propermodel.modelling.model import Model
from propermodel.reduction.candidates import Candidate, ProperModelSearch
from propermodel.reduction.certify import CertifiedModel
from propermodel.reduction.plan import Reduction, Verdict
from propermodel.report.buckets import extremes
from propermodel.simulation.display_units import display_of
from propermodel.simulation.trajectory import Trajectory

MOST_LINES = 12  # of a run
_SPARK = (240, 28)  # px
_LINE = "#0b5cad"
_CELL = "text-align:left;padding:2px 12px 2px 0"


@singledispatch
def html_of(_thing: object) -> str | None:
    """The HTML of a thing, complete in itself and without scripts; None for types that have none."""
    return None


@html_of.register
def _(model: Model) -> str | None:
    if find_spec("quickjs") is None:  # the extra `draw`: the text says as much as can be said
        return None
    try:
        picture = depict(compile_quietly(model))
    except ProperModelError as error:  # no equations: a graph without strokes, where there is one
        try:
            picture = depict_model(model, error.diagnostics)
        except ProperModelError:
            return None
    return _framed(to_svg(picture))


@html_of.register
def _(compiled: CompiledModel) -> str | None:
    return None if find_spec("quickjs") is None else _framed(to_svg(depict(compiled)))


@html_of.register
def _(run: Trajectory) -> str:
    paths = _telling(run)[:MOST_LINES] if len(run.signals) else ()
    rows: list[Sequence[str]] = []
    for path in paths:
        values = run[path]
        finite = values[np.isfinite(values)]
        shown = display_of(run.unit(path), finite)
        ends = (
            f"{float(np.min(finite)) * shown.factor:.4g} to {float(np.max(finite)) * shown.factor:.4g}"
            if len(finite)
            else ""
        )
        rows.append((_text(path), _spark(run.time, values), _text(ends), _text(shown.unit)))
    more = len(run.paths) - len(paths) if len(run.signals) else 0
    foot = f"<p>and {more} more: run.paths</p>" if more else ""
    head = f"<p><b>{_text(run.compiled.model.name)}</b>, {_text(run.scenario.name)}: {_text(run.ending.message)}</p>"
    return head + _table(("", "", "from, to", "unit"), rows) + foot


def _telling(run: Trajectory) -> Sequence[Path]:
    """What was recorded: states, efforts and flows of elements, and only then what lies between them."""
    system = run.compiled.system
    ports = [bond / variable for row in system.rows for bond in row.bonds for variable in ("effort", "flow")]
    wanted = dict.fromkeys([*(state.path for state in system.states), *ports])
    recorded = set(run.paths)
    first = [path for path in wanted if path in recorded]
    return [*first, *(path for path in run.paths if path not in wanted)]


@html_of.register
def _(balance: EnergyBalance) -> str:
    rows = [(f"work of {_text(path)}", f"{work:.6g} J") for path, work in balance.sources]
    rows += [(f"activated bond {_text(path)}", f"{energy:.6g} J") for path, energy in balance.activated]
    rows += [(f"modulation of {_text(path)}", f"{energy:.6g} J") for path, energy in balance.modulated]
    rows += [("stored", f"{balance.stored:.6g} J"), ("dissipated", f"{balance.dissipated:.6g} J")]
    if balance.converted:
        rows.append(("converted to pseudo bonds", f"{balance.converted:.6g} J"))
    if balance.lost_in_events:
        rows.append(("lost in events", f"{balance.lost_in_events:.6g} J"))
    rows.append(("unaccounted", f"{balance.integration_residual:.2g} J, {balance.relative_residual:.1e} of the whole"))
    rows += [
        (f"pseudo bonds, {_text(name)}: unaccounted", f"{own.relative_residual:.1e}")
        for name, own in balance.pseudo.items()
    ]
    return _table(("energy", ""), rows)


@html_of.register(Sensitivities)
@html_of.register(CertifiedModel)
def _(thing: object) -> str:
    """What is laid out as text already."""
    return f"<pre>{_text(thing)}</pre>"


@html_of.register
def _(ranking: ActivityRanking) -> str:
    greatest = max((row.index for row in ranking.rows), default=0.0) or 1.0
    rows = [
        (
            str(number),
            _text(row.path),
            _text(row.kind),
            _bar(row.index / greatest),
            f"{row.index:.3%}",
            f"{row.cumulative:.3%}",
        )
        for number, row in enumerate(ranking.rows, 1)
    ]
    head = f"<p>activity {ranking.total:.4g} J on {_text(ranking.scenario)}</p>"
    return head + _table(("", "element", "kind", "", "index", "sum"), rows)


@html_of.register
def _(reduction: Reduction) -> str:
    rows = [
        (
            _text(decision.row.path),
            f"{decision.row.index:.3%}",
            f"<b>{decision.verdict.value}</b>" if decision.verdict is not Verdict.KEPT else decision.verdict.value,
            _text(decision.explanation),
        )
        for decision in reduction.decisions
    ]
    head = f"<p>{_text(str(reduction).partition(chr(10))[0])}</p>"
    return head + _table(("element", "index", "", "because"), rows)


@html_of.register
def _(comparison: Comparison) -> str:
    rows = [
        (
            _text(error.path),
            f"{error.rms:.3%}",
            f"{error.largest:.3%} at {error.at:.4g} s",
            f"{error.reference.final:.6g} → {error.other.final:.6g} {_text(error.unit)}",
        )
        for error in comparison.outputs
    ]
    return _table(("output", "rms / range", "largest / range", "at the end"), rows)


@html_of.register
def _(search: ProperModelSearch) -> str:
    marks = {_worth(search.best): "smallest", _worth(search.recommended): "<b>recommended</b>"}
    rows = [
        (
            str(search.rows - len(candidate.rows)),
            str(candidate.states),
            f"{candidate.score:.3f}",
            f"{candidate.predicted:.3f}",
            marks.get(_worth(candidate), ""),
        )
        for candidate in search.front
    ]
    head = f"<p>{_text(str(search).partition(chr(10))[0])}</p>"
    return head + _table(("elements", "states", "error / tolerance", "predicted", ""), rows)


def _worth(candidate: Candidate | None) -> tuple[float, ...]:
    """What candidates are told apart by: one size can be reached in ways that are worth the same."""
    return () if candidate is None else (len(candidate.rows), candidate.states, candidate.score)


def _text(value: object) -> str:
    return html.escape(str(value))


def _framed(svg: str) -> str:
    return f'<div style="overflow-x:auto">{svg}</div>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are HTML already."""
    head = "".join(f'<th style="{_CELL}">{cell}</th>' for cell in heads)
    body = "".join("<tr>" + "".join(f'<td style="{_CELL}">{cell}</td>' for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _bar(share: float) -> str:
    return f'<div style="width:{120.0 * share:.1f}px;height:10px;background:{_LINE}"></div>'


def _spark(time: FloatArray, values: FloatArray) -> str:
    """A line of 120 intervals, none of whose peaks is lost."""
    width, height = _SPARK
    if len(time) < 2 or not np.all(np.isfinite(values)):
        return ""
    line = extremes(time, values, np.linspace(time[0], time[-1], 121))
    span = float(np.ptp(line)) or 1.0
    x = np.linspace(1.0, width - 1.0, len(line))
    y = height - 2.0 - (line - float(np.min(line))) * ((height - 4.0) / span)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    return (
        f'<svg width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
        f'<polyline points="{points}" fill="none" stroke="{_LINE}"/></svg>'
    )
