"""The guard of a condition is positive exactly where it holds; events of what is not there do not happen."""

from __future__ import annotations

import itertools

import pytest

from propermodel import Path, ZeroFlow, compile_model, elaborate, equals
from propermodel.equations.events import guard_of
from propermodel.expressions.core import Expr, SymbolKind, symbol
from propermodel.expressions.interpret import interpret
from tests.event_parts import BouncingBall, SlowingMass

X, Y, Z = (symbol(SymbolKind.STATE, Path((name,))) for name in "xyz")
VALUES = (-1.0, 0.0, 0.5, 1.0)


@pytest.mark.parametrize(
    "condition",
    [
        X < Y,
        X <= Y,
        X > Y,
        X >= Y,
        equals(X, Y),
        ~(X < Y),
        ~(X <= Y),
        ~equals(X, Y),
        (X < Y) & (Y < Z),
        (X < Y) | (Y <= Z),
        ~((X < Y) & ~(Y < Z)),
        ~((X <= Y) | ((Y < Z) & equals(X, Z))),
    ],
)
def test_a_guard_is_positive_exactly_where_its_condition_holds(condition: Expr):
    for values in itertools.product(VALUES, repeat=3):
        given = dict(zip((X, Y, Z), values, strict=True))
        holds = bool(interpret(condition, given))
        assert (interpret(guard_of(condition), given) > 0.0) is holds, (condition, values)


def test_the_events_of_a_system_change_its_states_and_held_values():
    (bounce,) = compile_model(elaborate(BouncingBall())).system.events
    assert [str(target.data.path) for target, _ in bounce.changes] == ["ball.momentum"]
    (stage,) = compile_model(elaborate(SlowingMass())).system.events
    assert [str(target.data.path) for target, _ in stage.changes] == ["damper.stage"]


def test_an_element_that_a_removal_takes_away_has_no_events():
    model = elaborate(SlowingMass())
    reduced = compile_model(model.without([ZeroFlow(Path(("damper", "flange")))]))
    assert reduced.system.events == ()
    assert len(compile_model(model).system.events) == 1
