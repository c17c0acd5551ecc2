"""The native machine against the interpreted one, and against expressions evaluated one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.codegen.arrangement import Printing
from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.interpreted import InterpretedMachine
from propermodel.codegen.llvm_compiler import Effort
from propermodel.codegen.machine import Memory, Method, Outcome, Request
from propermodel.codegen.native import NativeMachine
from propermodel.codegen.program import Extrapolation
from propermodel.expressions import (
    absolute,
    atan2,
    cos,
    equals,
    exp,
    floor,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tanh,
    where,
)
from propermodel.expressions.core import Expr
from propermodel.expressions.derivatives import derivative
from propermodel.expressions.interpret import interpret_all
from tests.codegen.programs import Draft, chain, implicit, oscillator, tables
from tests.expressions.strategies import SYMBOLS, X, Y, Z, expressions, points

PROGRAMS: Mapping[str, Callable[[], Draft]] = {
    "oscillator": oscillator,
    "held tables": tables,
    "continued tables": lambda: tables(Extrapolation.LINEAR),
    "held uniform tables": lambda: tables(Extrapolation.HOLD, is_uniform=True),
    "continued uniform tables": lambda: tables(Extrapolation.LINEAR, is_uniform=True),
    "one implicit equation": lambda: implicit(1),
    "two implicit equations": lambda: implicit(2),
    "three implicit equations": lambda: implicit(3),
    "fourteen implicit equations": lambda: implicit(14),
    "chain": lambda: chain(5),
}


def run(draft: Draft, machine: NativeMachine | InterpretedMachine, steps: int = 1000) -> tuple[Memory, Outcome]:
    memory = draft.memory(machine.lanes)
    request = Request(
        until=steps * 1e-3,
        step=1e-3,
        row_period=0.0123,
        integral_period=0.1,
        selected=np.arange(draft.signals),
    )
    return memory, machine.run(memory, request)


def assert_close(actual: np.ndarray, expected: np.ndarray) -> None:
    """Equal to 1e-12 of the range of each column."""
    scale = np.maximum(np.abs(expected).max(axis=0, initial=0.0), 1e-3)
    np.testing.assert_array_less(np.abs(actual - expected) / scale, 1e-12)


@pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
@pytest.mark.parametrize("name", PROGRAMS)
def test_both_backends_agree(name: str, method: Method) -> None:
    draft = PROGRAMS[name]()
    program = draft.program()
    steps = 12 if name == "fourteen implicit equations" else 200 if "implicit" in name else 500
    native, outcome = run(draft, NativeMachine(program, method), steps)
    interpreted, expected = run(draft, InterpretedMachine(program, method), steps)
    assert outcome.status is expected.status
    np.testing.assert_array_equal(outcome.row_times, expected.row_times)
    np.testing.assert_array_equal(outcome.integral_times, expected.integral_times)
    assert_close(outcome.rows, expected.rows)
    assert_close(outcome.integrals, expected.integrals)
    assert_close(outcome.activities, expected.activities)
    assert_close(native.state, interpreted.state)
    assert_close(native.discrete, interpreted.discrete)
    assert (native.steps_taken, native.rows_taken) == (interpreted.steps_taken, interpreted.rows_taken)
    assert native.samples_taken.tolist() == interpreted.samples_taken.tolist()


@pytest.mark.parametrize("name", PROGRAMS)
def test_single_evaluations_agree_and_change_nothing(name: str) -> None:
    draft = PROGRAMS[name]()
    program = draft.program()
    memory = draft.memory()
    before = memory.copy()
    machines = [build_machine(program, Method.EULER, backend=backend) for backend in Backend]
    first, second = ((*machine.rates(memory), machine.observe(memory)) for machine in machines)
    for actual, expected in zip(first, second, strict=True):
        np.testing.assert_allclose(actual, expected, rtol=1e-13, atol=1e-13)
    np.testing.assert_array_equal(memory.state, before.state)
    np.testing.assert_array_equal(memory.unknown, before.unknown)


@pytest.mark.parametrize("backend", Backend)
def test_sampling_for_a_start_reads_before_it_writes_and_counts_nothing(backend: Backend) -> None:
    draft = oscillator()
    memory = draft.memory()
    memory.discrete[:] = [0.0, 4.0]
    build_machine(draft.program(), Method.EULER, backend=backend).sample(memory)
    assert memory.discrete.tolist() == [-2.0, 5.0]
    assert memory.samples_taken.tolist() == [0]


def observed(exprs: list[Expr], at: Mapping[Expr, float], lanes: int = 1) -> np.ndarray:
    """The values of expressions of three parameters in native code."""
    draft = Draft()
    state = {leaf: draft.state(str(leaf.data.path)) for leaf in SYMBOLS}
    # The symbols of the strategies are read from states here.
    draft.slots = {leaf: draft.slots[state[leaf]] for leaf in SYMBOLS}
    for expr in exprs:
        draft.signal(expr)
    machine = NativeMachine(draft.program(), Method.EULER, lanes)
    memory = draft.memory(lanes)
    memory.state.reshape(3, lanes)[:] = np.array([at[leaf] for leaf in SYMBOLS])[:, np.newaxis]
    return machine.observe(memory)


EVERY = [
    X + Y,
    X - Y,
    X * Y,
    X / Y,
    -X,
    *(X**n for n in (2, 3, 7, -1, -2, 0.5, -0.5, 1.5, 40)),
    absolute(X) ** 1.4,
    absolute(X) ** -2.2,
    absolute(X),
    sign(X),
    sqrt(absolute(X)),
    exp(X),
    log(absolute(X)),
    sin(X),
    cos(X),
    tanh(X),
    atan2(X, Y),
    floor(X),
    minimum(X, Y),
    maximum(X, Y),
    where((X < Y) & (X <= Z), X, Y),
    where((X < Y) | equals(X, Z), X, Y),
    where(~(X < Y), X, Y),
    (X < Y) * 3.0,
    1.0 * (X <= Y) + equals(X, Y),
]
PLACES = [(0.7, -1.3, 2.0), (-0.7, -0.7, -0.7), (0.0, 0.0, 0.0), (2.0, 2.0, -3.0), (-1e-9, 1e9, 0.5), (0.0, -1.0, 0.0)]


@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("place", PLACES)
def test_every_operation_and_its_derivatives_at_kinks_too(place: tuple[float, float, float], lanes: int) -> None:
    at = dict(zip(SYMBOLS, place, strict=True))
    exprs = EVERY + [derivative(expr, leaf) for expr in EVERY for leaf in (X, Y)]
    expected = np.array(interpret_all(exprs, at))
    actual = observed(exprs, at, lanes).reshape(len(exprs), lanes)
    for lane in range(lanes):
        np.testing.assert_allclose(actual[:, lane], expected, rtol=1e-14, atol=1e-300)


@settings(max_examples=30)
@given(exprs=st.lists(expressions(), min_size=1, max_size=8), at=points, lanes=st.sampled_from([1, 2, 4]))
def test_random_expressions_have_their_value(exprs: list[Expr], at: Mapping[Expr, float], lanes: int) -> None:
    expected = interpret_all(exprs, at)
    for values in observed(exprs, at, lanes).reshape(len(exprs), lanes).T:
        np.testing.assert_allclose(values, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("lanes", [2, 3, 4, 8])
@pytest.mark.parametrize("name", PROGRAMS)
def test_each_lane_has_the_bits_of_a_run_alone(name: str, lanes: int) -> None:
    draft = PROGRAMS[name]()
    program = draft.program()
    wide, alone = NativeMachine(program, Method.SEMI_IMPLICIT, lanes), NativeMachine(program, Method.SEMI_IMPLICIT)
    memory = draft.memory(lanes)
    # Every lane is another run.
    memory.state *= 1.0 + 0.1 * np.arange(lanes)
    singles = [draft.memory() for _ in range(lanes)]
    request = Request(until=0.2, step=1e-3, row_period=0.01, integral_period=0.1, selected=np.arange(draft.signals))
    for lane, single in enumerate(singles):
        single.state *= 1.0 + 0.1 * lane
    outcome = wide.run(memory, request)
    for lane, single in enumerate(singles):
        expected = alone.run(single, request)
        np.testing.assert_array_equal(outcome.rows[..., lane], expected.rows)
        np.testing.assert_array_equal(outcome.activities[..., lane], expected.activities)
        np.testing.assert_array_equal(memory.state[:, lane], single.state)


@pytest.mark.parametrize("method", [method for method in Method if method.is_generated])
@pytest.mark.parametrize("name", PROGRAMS)
def test_cutting_functions_does_not_change_a_bit(name: str, method: Method) -> None:
    draft = PROGRAMS[name]()
    program = draft.program()
    whole, outcome = run(draft, NativeMachine(program, method), 200)
    cut, same = run(draft, NativeMachine(program, method, printing=Printing(most_instructions=7)), 200)
    np.testing.assert_array_equal(whole.state, cut.state)
    np.testing.assert_array_equal(outcome.rows, same.rows)
    np.testing.assert_array_equal(outcome.activities, same.activities)


@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("name", PROGRAMS)
def test_thorough_code_has_the_bits_of_quick_code(name: str, lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PROPERMODEL_CACHE", "off")
    draft = PROGRAMS[name]()
    program = draft.program()
    quick = NativeMachine(program, Method.SEMI_IMPLICIT, lanes, long_run=math.inf)
    thorough = NativeMachine(program, Method.SEMI_IMPLICIT, lanes, long_run=0)
    memory, outcome = run(draft, quick, 200)
    expected_memory, expected = run(draft, thorough, 200)
    assert (quick.effort, thorough.effort) == (Effort.QUICK, Effort.THOROUGH)
    np.testing.assert_array_equal(memory.state, expected_memory.state)
    np.testing.assert_array_equal(outcome.rows, expected.rows)
    np.testing.assert_array_equal(outcome.activities, expected.activities)


def test_code_becomes_thorough_when_the_steps_taken_and_asked_for_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PROPERMODEL_CACHE", "off")
    draft = chain(3)
    machine = NativeMachine(draft.program(), Method.EULER, long_run=1000)
    memory = draft.memory()
    for until, is_quick in ((0.6, True), (0.9, True), (1.1, False)):
        machine.run(memory, Request(until=until, step=1e-3))
        assert (machine.effort is Effort.QUICK) is is_quick
    machine = NativeMachine(draft.program(), Method.EULER, long_run=1000)
    machine.run(draft.memory(), Request(until=2.0, step=1e-3, most_ticks=1))
    assert machine.effort is Effort.THOROUGH


def test_what_is_only_written_cannot_be_read() -> None:
    draft = oscillator()
    leaf = next(iter(draft.slots))
    draft.slots[leaf] = draft.rates[0].slot  # type: ignore[union-attr]
    with pytest.raises(ValueError, match="is read from rate, which functions only write"):
        InterpretedMachine(draft.program(), Method.EULER)


@pytest.mark.slow
def test_a_chain_of_two_thousand_sections_compiles_in_seconds() -> None:
    draft = chain(2000)
    machine = NativeMachine(draft.program(), Method.SEMI_IMPLICIT)
    memory = draft.memory()
    machine.run(memory, Request(until=1e-3, step=1e-5))
    assert np.isfinite(memory.state).all()
