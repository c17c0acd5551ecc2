"""The expressions that plain data hold."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import cast

from propermodel.expressions.core import Expr


def expressions_in(value: object) -> list[Expr]:
    """All expressions in the fields of plain data."""
    found: list[Expr] = []
    pending = [value]
    while pending:
        current = pending.pop()
        if isinstance(current, Expr):
            found.append(current)
        elif isinstance(current, tuple):
            pending.extend(cast("tuple[object, ...]", current))
        elif is_dataclass(current) and not isinstance(current, type):
            pending.extend(getattr(current, part.name) for part in fields(current))
    return found
