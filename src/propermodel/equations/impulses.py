"""What an impulse of an effort does to the states: the slopes of their rates with respect to it.

An effort that is very large for a very short time leaves displacements where they are and changes the states by the
slope of their rates, times its integral over that time. Every jump of the states follows from these slopes: merging
storage, an impact, the projection onto a kinematic constraint.
"""

from __future__ import annotations

from collections.abc import Sequence

from propermodel.equations.system import StateKind, StateVariable
from propermodel.expressions.core import Expr
from propermodel.expressions.derivatives import partial_derivatives

Slopes = tuple[tuple[Expr, Expr], ...]  # symbol of a state, slope of its rate with respect to the effort


def impulse_slopes(states: Sequence[StateVariable], unknowns: Sequence[Expr]) -> tuple[Slopes, ...]:
    """For each unknown effort, by how much an impulse of it changes each stored quantity.

    The rates of the states must be in terms of the unknowns, before any of them is eliminated.
    """
    slopes = partial_derivatives([state.derivative for state in states], unknowns)
    return tuple(
        tuple(
            (state.symbol, slope[unknown])
            for state, slope in zip(states, slopes, strict=True)
            if unknown in slope and state.kind is not StateKind.SIGNAL
        )
        for unknown in unknowns
    )
