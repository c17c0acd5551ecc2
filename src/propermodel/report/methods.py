"""The figure and tables of a comparison of methods."""
# pyright: basic

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.reduction.methods.compare import MethodComparison
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.workbench import SizedModel
from propermodel.report.figures import DARK, GREY, LINES, Figure, drawn
from propermodel.report.summary import removal_text

FORMAT_VERSION = 1
_MARKS = ("o", "s", "^", "v", "D", "P", "X", "<", ">")
_LEAST = 1e-6  # smaller errors are drawn here


def write_comparison(found: MethodComparison, folder: FilePath) -> tuple[Figure, ...]:
    """Write a comparison into a folder: figure, CSV, JSON."""
    folder.mkdir(parents=True, exist_ok=True)
    draw_comparison(found, folder / "methods.png")
    (folder / "methods.json").write_text(json.dumps(as_data(found), indent=2) + "\n", encoding="utf-8")
    with (folder / "methods.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("method", "rows", "states", "error_rms_over_range", "is_chosen", "why_no_error"))
        for curve in found.curves:
            for model in curve.models:
                error = f"{model.error:.9g}" if np.isfinite(model.error) else ""
                rows = "" if model.rows is None else model.rows
                writer.writerow((curve.method, rows, model.states, error, int(model == curve.chosen), model.why))
    return (
        Figure("methods.png", "size against error, all methods"),
        Figure("methods.csv", "the same as a table"),
        Figure("methods.json", "the same with removals, rules and what does not apply"),
    )


def as_data(found: MethodComparison) -> dict[str, object]:
    """A comparison as plain data; an error that could not be measured is null."""
    return {
        "format": "propermodel-method-comparison",
        "version": FORMAT_VERSION,
        "model": found.model,
        "scenario": found.scenario,
        "outputs": [str(path) for path in found.outputs],
        "tolerance_rms_over_range": found.tolerance,
        "rows": found.rows,
        "states": found.states,
        "methods": [
            {
                "method": curve.method,
                "source": curve.source,
                "rule": curve.rule,
                "simulations": curve.simulations,
                "not_applied": curve.not_applied,
                "notes": list(curve.notes),
                "models": [_model(model) for model in curve.models],
                "chosen": None if curve.chosen is None else _model(curve.chosen),
                "smallest_within": None if (best := curve.smallest_within(found.tolerance)) is None else _model(best),
            }
            for curve in found.curves
        ],
    }


def _model(model: SizedModel) -> dict[str, object]:
    return {
        "rows": model.rows,
        "states": model.states,
        "error": model.error if np.isfinite(model.error) else None,
        "why": model.why,
        "removals": [removal_text(removal) for removal in model.removals],
    }


def draw_comparison(found: MethodComparison, file: FilePath) -> None:
    """Error against the number of energy elements, and against the number of states."""
    with drawn(10.5, 4.6, file) as figure:
        by_rows, by_states = figure.subplots(1, 2, sharey=True)
        for number, curve in enumerate(found.curves):
            style = {
                "color": (*LINES, DARK, GREY, "#8C6D31")[number % 9],
                "marker": _MARKS[number % len(_MARKS)],
                "markersize": 3.5,
                "linewidth": 1.8 if number == 0 else 1.0,
                "zorder": 3 if number == 0 else 2,
            }
            for axes, sizes in (
                (by_rows, [model.rows for model in curve.models]),
                (by_states, [model.states for model in curve.models]),
            ):
                _line(axes, sizes, curve, style)
        for axes, label in ((by_rows, "energy elements kept"), (by_states, "states kept")):
            axes.set_yscale("log")
            axes.axhline(found.tolerance, color=DARK, linewidth=0.8, linestyle=(0, (4, 3)))
            axes.set_xlabel(label)
            axes.xaxis.get_major_locator().set_params(integer=True)
        by_rows.set_ylabel("error, root mean square over range")
        by_rows.set_title(f"{found.model}: {found.rows} elements, {found.states} states")
        by_states.set_title("projections have states only")
        handles, labels = by_states.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5)


def _line(axes: Any, sizes: Sequence[int | None], curve: Curve, style: dict[str, object]) -> None:
    points = [
        (size, max(model.error, _LEAST))
        for size, model in zip(sizes, curve.models, strict=True)
        if size is not None and np.isfinite(model.error)
    ]
    if points:
        axes.plot(*zip(*points, strict=True), label=curve.method, **style)
