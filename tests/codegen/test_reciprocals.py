"""Which divisions become multiplications."""

from __future__ import annotations

import pytest

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Method
from propermodel.codegen.program import Assign
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.expressions import sqrt
from propermodel.expressions.core import Expr, Op, postorder
from tests.codegen.programs import Draft


def divisions(draft: Draft) -> list[Expr]:
    program = with_reciprocals(draft.program())
    roots = [step.value for step in program.rates.steps if isinstance(step, Assign)]
    return [node for node in postorder(roots) if node.op is Op.DIVIDE]


def test_a_parameter_divides_once_a_run() -> None:
    draft = Draft()
    x, mass = draft.state("x", 3.0), draft.parameter("mass", 7.0)
    draft.rate(x, x / mass)
    (division,) = divisions(draft)
    assert division.args[1] is mass
    assert division.args[0].data == (1.0, "")


def test_a_divisor_that_serves_twice_is_inverted_once() -> None:
    draft = Draft()
    x, y = draft.state("x", 3.0), draft.state("y", 2.0)
    draft.rate(x, x / y)
    draft.rate(y, (x * x) / y)
    assert len(divisions(draft)) == 1


def test_a_divisor_known_after_what_it_divides_stays() -> None:
    draft = Draft()
    x, y = draft.state("x", 3.0), draft.state("y", 2.0)
    late = x / sqrt(y * y + 1.0)
    draft.rate(x, late)
    assert divisions(draft) == [late]


@pytest.mark.parametrize("backend", Backend)
def test_quotients_keep_their_value(backend: Backend) -> None:
    draft = Draft()
    x, y = draft.state("x", 3.0), draft.state("y", -0.7)
    mass, nothing = draft.parameter("mass", 7.0), draft.parameter("nothing", 0.0)
    for value in (x / mass, x / y, (x * x) / y, mass / x, x / 3.0, 1.0 / mass, x / nothing):
        draft.power(value)
    draft.rate(x, y)
    _, found = build_machine(draft.program(), Method.EULER, backend=backend).rates(draft.memory())
    expected = [3.0 / 7.0, 3.0 / -0.7, 9.0 / -0.7, 7.0 / 3.0, 1.0, 1.0 / 7.0, float("inf")]
    assert found.tolist() == pytest.approx(expected, rel=4e-16)
