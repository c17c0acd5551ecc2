"""What of a set of removals it is that leaves no model, so that no other set with it is tried."""

from __future__ import annotations

from collections.abc import Callable

from propermodel.diagnostics import Path
from propermodel.reduction.prediction import Replacement
from propermodel.reduction.proposals import Choice


def fewest_refused(choice: Choice, is_refused: Callable[[Choice], bool]) -> Choice:
    """A smallest part of a refused choice that is refused itself (Junker 2004, QuickXplain).

    Each round finds, by halving, one more row that it cannot do without.

    Args:
        choice: A choice that is refused.
        is_refused: Whether a part of it is.
    """
    needed: dict[Path, tuple[Replacement, ...]] = {}
    rest = list(choice.items())
    while rest and not (needed and is_refused(needed)):
        low, high = 0, len(rest)
        while high - low > 1:
            middle = (low + high) // 2
            if is_refused({**needed, **dict(rest[:middle])}):
                high = middle
            else:
                low = middle
        row, way = rest[high - 1]
        needed[row] = way
        rest = rest[: high - 1]
    return needed
