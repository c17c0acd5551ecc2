"""Tables for the terminal; wide and plain where the output is read by a program."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from propermodel.analysis.comparison import Comparison
from propermodel.analysis.ranking import ActivityRanking
from propermodel.modelling.removal_words import removal_text
from propermodel.reduction.plan import Reduction, Verdict
from propermodel.reduction.prediction import Prediction
from propermodel.report.study import ReductionStudy

PLAIN_WIDTH = 220
_STYLES = {Verdict.KEPT: "", Verdict.REMOVED: "green", Verdict.REFUSED: "yellow"}


class Screen:
    """Where results are printed: as wide as the terminal, or wide enough for all columns where a program reads it."""

    def __init__(self) -> None:
        self._is_terminal = sys.stdout.isatty()
        self._console = Console(width=None if self._is_terminal else PLAIN_WIDTH, highlight=False)

    def print(self, *items: RenderableType) -> None:
        """Print each item on its own line; text as it stands."""
        for item in items:
            shown = Text(item, no_wrap=True, overflow="ignore") if isinstance(item, str) else item
            if self._is_terminal:
                self._console.print(shown)
                continue
            with self._console.capture() as captured:
                self._console.print(shown, crop=False)
            sys.stdout.write("".join(f"{line.rstrip()}\n" for line in captured.get().splitlines()))


def table(title: str, *columns: str, right: Iterable[str] = ()) -> Table:
    """An empty table; the first column is never wrapped."""
    made = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for index, name in enumerate(columns):
        made.add_column(name, justify="right" if name in right else "left", no_wrap=index == 0 or name in right)
    return made


def plain(text: object) -> Text:
    """Text in which square brackets are no markup."""
    return Text(str(text))


def ranking_table(ranking: ActivityRanking) -> Table:
    """The ranking of activity; with parts also the largest index and where, with a check what it changes."""
    start, stop = ranking.window
    plural = "s" if ", " in ranking.scenario else ""
    is_checked = ranking.discretisation is not None
    optional = ["+- points"] * is_checked + ["largest", "in"] * bool(ranking.parts)
    made = table(
        f"Activity in scenario{plural} {ranking.scenario}, {start:g} to {stop:g} s",
        "element",
        "rank",
        "kind",
        "activity J",
        "index",
        "cumulative",
        *optional,
        right=("rank", "activity J", "index", "cumulative", "+- points", "largest"),
    )
    for number, row in enumerate(ranking.rows, 1):
        more = ["-" if row.change_points is None else f"{row.change_points:.2g}"] * is_checked
        more += [f"{row.largest_index:.3%}", row.largest_in or "the whole"] * bool(ranking.parts)
        made.add_row(
            plain(row.path),
            str(number),
            row.kind,
            f"{row.activity:.5g}",
            f"{row.index:.3%}",
            f"{row.cumulative:.3%}",
            *map(plain, more),
        )
    return made


def prediction_table(prediction: Prediction, ranking: ActivityRanking) -> Table:
    """What the best way to remove each row would change, with its activity beside."""
    outputs = [str(path) for path in prediction.outputs]
    made = table(
        "Predicted change of outputs if one element is removed, rms over the range of the output",
        "element",
        "replaced by",
        "index",
        *outputs,
        right=("index", *outputs),
    )
    indices = {row.path: row.index for row in ranking.rows}
    for row in prediction.rows():
        errors = ["-" for _ in outputs] if row.best is None else [f"{e:.3%}" for e in row.best.errors.values()]
        index = f"{indices[row.row]:.3%}" if row.row in indices else "-"
        made.add_row(plain(row.row), "nothing can" if row.best is None else row.best.meaning, index, *errors)
    return made


def ranking_notes(ranking: ActivityRanking) -> list[str]:
    """What a reader of a ranking has to know."""
    notes = [f"total activity {ranking.total:.6g} J"]
    check = ranking.discretisation
    if check is None:
        notes.append("not checked with a smaller step")
    else:
        notes.append(
            f"{check.comparison} indices change by at most "
            f"{check.largest_change_points:.3f} points ({check.largest_change_at})"
        )
    notes.extend(f"datum of {datum}" for datum in ranking.datums)
    notes.extend(ranking.notes)
    return notes


def decisions_table(reduction: Reduction) -> Table:
    """The decision on every element."""
    made = table(
        f"Decisions at a threshold of {reduction.threshold:.4g}",
        "element",
        "rank",
        "kind",
        "index",
        "cumulative",
        "decision",
        "replacement",
        "reason",
        right=("rank", "index", "cumulative"),
    )
    for number, decision in enumerate(reduction.decisions, 1):
        row = decision.row
        made.add_row(
            plain(row.path),
            str(number),
            row.kind,
            f"{row.index:.3%}",
            f"{row.cumulative:.3%}",
            decision.verdict.value,
            plain(decision.meaning),
            plain(decision.reason),
            style=_STYLES[decision.verdict],
        )
    return made


def comparison_table(comparison: Comparison) -> Table:
    """The errors of the outputs."""
    made = table(
        "Reduced against full; errors as shares of the range of the full run",
        "output",
        "rms",
        "largest",
        "at s",
        "final full",
        "final reduced",
        "unit",
        right=("rms", "largest", "at s", "final full", "final reduced"),
    )
    for error in comparison.outputs:
        made.add_row(
            plain(error.path),
            f"{error.rms:.3%}",
            f"{error.largest:.3%}",
            f"{error.at:.1f}",
            f"{error.reference.final:.6g}",
            f"{error.other.final:.6g}",
            error.unit,
        )
    return made


def study_lines(study: ReductionStudy) -> list[str]:
    """The result of a study in sentences."""
    full, reduced, reduction = study.full, study.reduced, study.reduction
    kept, removed = len(reduction.kept), len(reduction.removed)
    lines = [
        f"{kept + removed} energy elements; the threshold keeps {reduction.kept_by_threshold}",
        f"{removed} removed, {kept} kept with {reduction.kept_activity:.2%} of the activity",
        f"{len(full.compiled.system.states)} states become {len(reduced.compiled.system.states)}",
    ]
    lines.extend(f"could be one, exactly: {merge}" for merge in reduction.merges)
    for name, path in study.options.totals.items():
        before, after = (run.at_end(path) - run.at_start(path) for run in (full, reduced))
        change = f" ({after / before - 1.0:+.3%})" if before else ""
        lines.append(f"{name}: {before:.6g} {full.unit(path)} full, {after:.6g} reduced{change}")
    lines.append(
        f"energy balance: residual {study.full_balance.relative_residual:.1e} full, "
        f"{study.reduced_balance.relative_residual:.1e} reduced"
    )
    lines.append(f"{full.stepping}: {full.statistics.wall_s:.3g} s full, {reduced.statistics.wall_s:.3g} s reduced")
    if study.speed is not None:
        start, stop = study.speed.window
        lines.append(
            f"runs {study.speed.ratio:.2f} times as fast at the same step (median of {len(study.speed.full.runs)}, "
            f"{start:g} to {stop:.4g} s)"
        )
    best = study.best_steps
    if best is not None and best.speed is not None:
        lines.append(
            f"runs {best.speed.ratio:.2f} times as fast at the largest good steps: {best.full_step:g} s full, "
            f"{best.reduced_step:g} s reduced"
        )
    elif best is not None:
        lines.append("no step of the ladder was good for both models, so their largest steps are not compared")
    lines.extend(f"note: {note}" for note in reduction.notes)
    lines.extend(removal_text(removal) for removal in reduction.frozen)
    lines.extend(f"outside the table {use.path} for {use.seconds:.3g} s" for use in full.outside_tables)
    return lines
