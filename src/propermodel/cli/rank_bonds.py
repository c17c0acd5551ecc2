"""`propermodel rank MODEL --bonds`: the activity of every bond, and which junctions are inactive."""

from __future__ import annotations

import csv
import json
import sys
from typing import TYPE_CHECKING

import typer

from propermodel.cli.tables import Screen, plain, table

if TYPE_CHECKING:
    from rich.table import Table

    from propermodel.analysis.bond_ranking import BondRanking
    from propermodel.analysis.windows import Window
    from propermodel.cli.rank_runs import RankedRuns


def show_bonds(found: RankedRuns, window: Window | None, as_json: bool, as_csv: bool) -> None:
    """Print the ranking of bonds in the form that is asked for."""
    from propermodel.analysis.bond_ranking import rank_bonds

    ranking = rank_bonds(found.runs, refined=found.refined, window=window)
    if as_csv:
        _write_csv(ranking)
        return
    if as_json:
        model = found.runs[0].compiled.model.name
        typer.echo(json.dumps({"model": model, **_report(ranking)}, indent=2))
        return
    Screen().print(_bonds(ranking), *_notes(ranking))


def _bonds(ranking: BondRanking) -> Table:
    start, stop = ranking.window
    columns = ("bond", "rank", "kind", "activity J", "of the greatest", "at its junctions")
    made = table(
        f"Activity of bonds in scenario {ranking.scenario}, {start:g} to {stop:g} s",
        *columns,
        right=("rank", "activity J", "of the greatest"),
    )
    for number, row in enumerate(ranking.rows, 1):
        ends = ", ".join(f"{end.relative:.3%} at {end.junction}" for end in row.at)
        made.add_row(plain(row.path), str(number), row.kind, f"{row.activity:.5g}", f"{row.share:.3%}", plain(ends))
    return made


def _notes(ranking: BondRanking) -> list[str]:
    notes = [
        f"{junction.kind}-junction {junction.path} is inactive: its bonds have at most {junction.share:.2g} of the "
        "most active one"
        for junction in ranking.inactive
    ]
    changes = [(row.change_points, str(row.path)) for row in ranking.rows if row.change_points is not None]
    if changes:
        largest, path = max(changes)
        notes.append(f"{ranking.comparison} shares change by at most {largest:.3f} points ({path})")
    else:
        notes.append("not checked with a smaller step")
    return [*notes, *(f"datum of {datum}" for datum in ranking.datums)]


def _report(ranking: BondRanking) -> dict[str, object]:
    return {
        "scenario": ranking.scenario,
        "window_s": list(ranking.window),
        "datums": list(ranking.datums),
        "discretisation_check": ranking.comparison or None,
        "inactive_below": ranking.inactive_below,
        "bonds": [
            {
                "path": str(row.path),
                "kind": row.kind,
                "domain": row.domain,
                "tail": str(row.tail),
                "head": str(row.head),
                "activity_J": row.activity,
                "share": row.share,
                "change_points": row.change_points,
                "relative": {str(end.junction): end.relative for end in row.at},
            }
            for row in ranking.rows
        ],
        "junctions": [
            {
                "path": str(junction.path),
                "kind": junction.kind,
                "activity_J": junction.activity,
                "share": junction.share,
                "is_inactive": junction.is_inactive,
                "bonds": {str(bond): relative for bond, relative in junction.bonds},
            }
            for junction in ranking.junctions
        ],
    }


def _write_csv(ranking: BondRanking) -> None:
    """A line for each bond."""
    writer = csv.writer(sys.stdout, lineterminator="\n")
    head = ["rank", "path", "kind", "domain", "tail", "head", "activity_J", "share", "change_points", "relative"]
    writer.writerow(head)
    for number, row in enumerate(ranking.rows, 1):
        change = "" if row.change_points is None else row.change_points
        ends = [row.domain, row.tail, row.head]
        writer.writerow([number, row.path, row.kind, *ends, row.activity, row.share, change, row.relative])
