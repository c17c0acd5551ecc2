"""Parameters of exactly zero, as the reason why equations have no answer."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from propermodel.expressions.core import Expr, SymbolKind, leaves

MOST_NAMED = 6


def zero_parameters(exprs: Iterable[Expr], value: Callable[[Expr], float]) -> str:
    """The parameters among these expressions that are exactly zero, with the verb; empty if there are none."""
    found = [
        str(leaf.data.path) for leaf in leaves(*exprs) if leaf.data.kind is SymbolKind.PARAMETER and value(leaf) == 0.0
    ]
    if not found:
        return ""
    return f"{listed(found)} {'is' if len(found) == 1 else 'are'} 0"


def listed(names: Iterable[str]) -> str:
    """Names in a row, the first few of many."""
    every = list(names)
    shown = ", ".join(every[:MOST_NAMED])
    return shown if len(every) <= MOST_NAMED else f"{shown} and {len(every) - MOST_NAMED} more"
