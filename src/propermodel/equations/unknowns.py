"""Unknowns of the implicit part with what determines them."""

from __future__ import annotations

from dataclasses import dataclass

from propermodel.diagnostics import Path
from propermodel.equations.system import BlockKind
from propermodel.expressions.core import ZERO, Expr


@dataclass(frozen=True, slots=True)
class Unknown:
    """One unknown of the implicit part with its residual.

    `other` is what the residual of a switch would be if it were the other way.
    """

    symbol: Expr
    residual: Expr
    element: Path
    kind: BlockKind
    other: Expr = ZERO
