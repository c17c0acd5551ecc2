"""Figures of a study: mission, activity, outputs of the full and the reduced model.

Colours are those of Okabe and Ito, which readers with any colour vision can tell apart.
"""
# pyright: basic

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.reduction.plan import Verdict
from propermodel.report.panels import Panel
from propermodel.report.study import ReductionStudy
from propermodel.report.timeline import column_of
from propermodel.simulation.display_units import Display, display_for, display_of
from propermodel.simulation.trajectory import Trajectory

BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, GREY, DARK = "#E69F00", "#56B4E9", "#B4B4B4", "#303030"
LINES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
VERDICTS = {Verdict.KEPT: BLUE, Verdict.REMOVED: GREY, Verdict.REFUSED: ORANGE}
SMALLEST_INDEX = 1e-6  # per cent; smaller bars are cut off

_STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#606060",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E2E2E2",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.2,
    "figure.constrained_layout.use": True,
    "savefig.dpi": 150,
    "savefig.facecolor": "white",
    "path.simplify_threshold": 0.3,
}


@dataclass(frozen=True, slots=True)
class Figure:
    """A written figure."""

    name: str
    meaning: str


def write_figures(study: ReductionStudy, folder: FilePath) -> tuple[Figure, ...]:
    """Draw the figures of a study into a folder."""
    found: list[Figure] = []
    if study.options.panels:
        draw_mission(study.full, study.options.panels, folder / "mission.png")
        found.append(Figure("mission.png", "what the full model did"))
    draw_activity(study, folder / "activity.png")
    found.append(Figure("activity.png", "activity of every element, and what became of it"))
    if study.compared:
        draw_outputs(study, folder / "outputs.png")
        found.append(Figure("outputs.png", "outputs of the reduced model against the full one"))
    return tuple(found)


@contextmanager
def drawn(width: float, height: float, file: FilePath) -> Iterator[Any]:
    """A figure that is written at the end; nothing of Matplotlib's global state is touched."""
    import matplotlib
    from matplotlib.figure import Figure as Canvas

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        for name, value in _STYLE.items():
            matplotlib.rcParams[name] = value  # pyright: ignore[reportArgumentType]
        figure = Canvas(figsize=(width, height))
        yield figure
        figure.savefig(file, metadata={"Software": None})


# -- activity -------------------------------------------------------------------------------------------


def draw_activity(study: ReductionStudy, file: FilePath) -> None:
    """Sorted activity with the decisions, and its cumulative share with the threshold."""
    reduction = study.reduction
    decisions = reduction.decisions
    places = np.arange(len(decisions))
    height = 1.7 + 0.19 * len(decisions)
    with drawn(10.5, height, file) as figure:
        bars, shares = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        indices = np.array([max(d.row.index * 100.0, SMALLEST_INDEX) for d in decisions])
        for verdict, colour in VERDICTS.items():
            here = np.array([d.verdict is verdict for d in decisions])
            if here.any():
                label = f"{verdict.value} ({int(here.sum())})"
                hatch = "////" if verdict is Verdict.REFUSED else None
                bars.barh(
                    places[here],
                    indices[here],
                    height=0.72,
                    color=colour,
                    hatch=hatch,
                    edgecolor="white",
                    linewidth=0.0,
                    label=label,
                )
        bars.set_xscale("log")
        least = max(SMALLEST_INDEX, 10.0 ** np.floor(np.log10(indices.min()) - 0.2))
        bars.set_xlim(least, 100.0)
        for place in places[indices <= least]:
            bars.text(least * 1.3, place, f"at most {least:.0e} %", va="center", color=DARK, fontsize=7.5)
        bars.set_yticks(places, [f"{d.row.path}  ({d.row.kind})" for d in decisions])
        bars.tick_params(axis="y", length=0)
        bars.set_ylim(len(decisions) - 0.4, -0.6)
        bars.grid(False, axis="y")
        bars.set_xlabel("activity index, % of the total (logarithmic)")
        bars.set_title(f"Activity in scenario {study.full.scenario.name}")

        cumulative = np.array([d.row.cumulative * 100.0 for d in decisions])
        colours = [VERDICTS[d.verdict] for d in decisions]
        shares.plot(cumulative, places, color=DARK, linewidth=0.9, zorder=2)
        shares.scatter(cumulative, places, c=colours, s=22, zorder=3, edgecolors=DARK, linewidths=0.5)
        threshold = reduction.threshold * 100.0
        shares.axvline(threshold, color=VERMILION, linewidth=1.1, linestyle="--", zorder=1)
        shares.axhline(reduction.kept_by_threshold - 0.5, color=VERMILION, linewidth=0.8, linestyle=":", zorder=1)
        shares.annotate(
            f"threshold {threshold:g} % keeps {reduction.kept_by_threshold}",
            (threshold, len(decisions) - 0.6),
            xytext=(-9, 2),
            textcoords="offset points",
            ha="right",
            color=VERMILION,
        )
        shares.set_xlim(0.0, 102.0)
        shares.grid(False, axis="y")
        shares.tick_params(axis="y", length=0)
        shares.set_xlabel("cumulative activity, %")
        shares.set_title(f"{len(reduction.kept)} stay, with {reduction.kept_activity:.2%}")
        bars.legend(loc="lower right")


# -- outputs --------------------------------------------------------------------------------------------


def draw_outputs(study: ReductionStudy, file: FilePath) -> None:
    """Every compared output of both models, with the difference below it."""
    errors = {error.path: error for error in study.comparison.outputs}
    full, reduced = study.full, study.reduced
    count = len(study.compared)
    with drawn(9.0, 2.75 * count + 0.4, file) as figure:
        rows = figure.subplots(2 * count, 1, sharex=True, height_ratios=(2.1, 1.0) * count)
        for index, path in enumerate(study.compared):
            above, below = rows[2 * index], rows[2 * index + 1]
            expected = full[path]
            found = np.interp(full.time, reduced.time, reduced[path])
            shown = display_of(full.unit(path), expected)
            above.plot(full.time, expected * shown.factor, color=BLUE, linewidth=1.5, label="full")
            above.plot(
                full.time, found * shown.factor, color=ORANGE, linewidth=1.1, linestyle=(0, (4, 2)), label="reduced"
            )
            above.set_ylabel(_unit_text(shown))
            above.set_title(f"{path}   rms difference {errors[path].rms:.2%} of the range")
            below.plot(full.time, (found - expected) * shown.factor, color=DARK, linewidth=0.9)
            below.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
            below.set_ylabel(f"difference\n{_unit_text(shown)}")
            if index == 0:
                above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
        rows[-1].set_xlabel("time, s")
        rows[-1].set_xlim(float(full.time[0]), float(full.time[-1]))
        figure.align_ylabels(list(rows))


# -- mission --------------------------------------------------------------------------------------------


def draw_mission(run: Trajectory, panels: tuple[Panel, ...], file: FilePath) -> None:
    """What a run did, one panel above the other."""
    with drawn(9.0, 1.75 * len(panels) + 0.5, file) as figure:
        rows = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
        for axes, panel in zip(rows, panels, strict=True):
            columns = [column_of(run, series) for series in panel.series]
            size = max(float(np.max(np.abs(values), initial=0.0)) for _, values, _ in columns)
            unit = columns[0][2]
            shown = Display(panel.unit, 1.0) if panel.unit else display_for(unit, size)
            for colour, series, (time, values, _) in zip(LINES, panel.series, columns, strict=False):
                factor = series.scale if panel.unit else series.scale * shown.factor
                style = (0, (4, 2)) if series.dashed else "-"
                axes.plot(time, values * factor, color=colour, linestyle=style, label=series.label or series.path)
            if all(bool(np.all(values == np.round(values))) for _, values, _ in columns):
                axes.yaxis.get_major_locator().set_params(integer=True)
            axes.set_ylabel(_unit_text(shown))
            axes.set_title(panel.title)
            if len(panel.series) > 1:
                axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(panel.series), borderaxespad=0.1)
        rows[-1].set_xlabel("time, s")
        rows[-1].set_xlim(float(run.time[0]), float(run.time[-1]))
        figure.align_ylabels(list(rows))


def _unit_text(shown: Display) -> str:
    return shown.unit or "–"
