"""Windows on the command line, and how often a run keeps integrals for them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from propermodel.diagnostics import ReductionError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from propermodel.analysis.windows import Window, Windows
    from propermodel.modelling.model import Scenario
    from propermodel.report.options import StudyOptions


def parse_windows(text: str) -> Windows:
    """How many windows, their length with its unit, or pairs of instants: `8`, `10 s`, `0:5,20:22`.

    Raises:
        ReductionError: it is none of these.
    """
    if ":" in text:
        try:
            return [_pair(part) for part in text.split(",")]
        except ValueError:
            raise ReductionError.of(
                "activity/window", f"'{text}' are no windows", help="write pairs of instants in seconds: 0:5,20:22"
            ) from None
    return int(text) if text.strip().isdecimal() else text


def _pair(text: str) -> Window:
    begin, end = text.split(":")
    return float(begin), float(end)


def period_of_windows(
    options: StudyOptions, scenarios: Iterable[Scenario], window: Window | None, windows: Windows | None
) -> float | None:
    """The period at which runs keep integrals so that windows are exact; None where the usual one will do.

    Raises:
        ReductionError: the windows are none of these runs, or their edges have no common period.
    """
    from propermodel.analysis.windows import period_for, windows_of

    if window is None and windows is None:
        return None
    period = float("inf")
    for scenario in scenarios:
        start, stop = scenario.start, scenario.stop
        begin, end = (start, stop) if window is None else windows_of([window], start, stop)[0]
        edges = [(begin, end), *(() if windows is None else windows_of(windows, begin, end))]
        found = period_for(edges, start, stop, min(period, options.integrals_every(scenario)))
        if found is None:
            raise ReductionError.of(
                "activity/window",
                f"the edges of the windows have no common period in a run from {start:g} to {stop:g} s",
                help="choose edges that are multiples of a period, such as 0.1 s",
            )
        period = min(period, found)
    return period
