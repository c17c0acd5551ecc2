"""How observables are named: as expressions of a component, as paths, as text."""

from __future__ import annotations

from propermodel.diagnostics import Path, parse_path
from propermodel.expressions.core import Expr


def observable_path(observable: Expr | Path | str) -> Path:
    """The path of an observable given as an expression of a component, a path or text."""
    if isinstance(observable, Expr):
        return observable.data.path
    if isinstance(observable, Path):
        return observable
    return parse_path(observable)
