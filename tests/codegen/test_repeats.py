"""Loops in place of what is repeated: no bit of any number changes, whatever is repeated and whatever is not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from propermodel.codegen.arrangement import PRINTING, Printing
from propermodel.codegen.interpreted import InterpretedMachine
from propermodel.codegen.llvm_repeats import sharing
from propermodel.codegen.machine import Memory, Method, Outcome, Request, Status
from propermodel.codegen.native import NativeMachine
from propermodel.codegen.print_program import print_program
from propermodel.codegen.program import Program
from propermodel.codegen.repeats import Repeat, Rows
from propermodel.compiler import compile_quietly
from propermodel.expressions import atan2, exp, maximum, minimum, sign, sin, sqrt, tanh, where
from propermodel.expressions.core import TIME, Expr, lookup, substitute
from propermodel.modelling import Component
from propermodel.modelling import repeat as component_repeat
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import start_of
from tests.codegen.programs import Draft, implicit, oscillator, tables
from tests.event_parts import BouncingBall
from tests.expressions.strategies import SYMBOLS, X, Y, Z, expressions


class Balls(Component):
    """Balls that fall side by side."""

    balls = component_repeat(20, BouncingBall())


STRAIGHT = Printing(loops_from=10**9)
LOOPS = Printing(loops_from=1)
STEPS = 30

Law = Callable[[Expr, Expr, Expr], Expr]  # of a displacement, a speed and a parameter

LAWS: Sequence[Law] = (
    lambda q, v, k: k * q + 0.3 * v,
    lambda q, v, k: k * q * abs(q) - v,
    lambda q, v, k: where(q > 0.1, k * q, v),
    lambda q, v, k: tanh(k * q) + 0.1 * v**3,
    lambda q, v, k: k * sin(q) + v * exp(-q * q),
    lambda q, v, k: sqrt(1.0 + q * q) * k - minimum(v, 0.2 * k),
    lambda q, v, k: maximum(q, v) * sign(v) * k,
    lambda q, v, k: where((q > -0.2) & (v < k), q, v) * (1.0 + k * TIME),
    lambda q, v, k: atan2(q, 2.0 + k) + q / (1.5 + v * v),
)


def sections(laws: Sequence[Law], *, tables: bool = False, solves: bool = False, holds: bool = False) -> Draft:
    """Masses in a row, with a law between each and the next; the ends differ from the rest."""
    draft = Draft()
    count = len(laws)
    random = np.random.default_rng(count)
    masses = [draft.parameter(f"m{k}", value) for k, value in enumerate(random.uniform(0.5, 2.0, count + 1))]
    gains = [draft.parameter(f"k{k}", value) for k, value in enumerate(random.uniform(-1.0, 2.0, count))]
    momenta = [draft.state(f"p{k}", value) for k, value in enumerate(random.normal(size=count + 1))]
    lengths = [draft.state(f"q{k}", value) for k, value in enumerate(random.normal(size=count))]
    draft.momenta, draft.displacements = [*range(count + 1)], [*range(count + 1, 2 * count + 1)]
    held = [draft.discrete(f"u{k}", 0.1 * k) for k in range(count)] if holds else []
    speeds = [p / m for p, m in zip(momenta, masses, strict=True)]
    closing = [a - b for a, b in pairwise(speeds)]
    forces = [law(q, v, k) for law, q, v, k in zip(laws, lengths, closing, gains, strict=True)]
    if tables:
        curves = [draft.table(f"t{k}", [[-1.0, 0.0, 1.0]], random.normal(size=3)) for k in range(count)]
        forces = [f + 2.0 * lookup(curve, q) for f, curve, q in zip(forces, curves, lengths, strict=True)]
    if holds:
        forces = [f + u * u * q for f, u, q in zip(forces, held, lengths, strict=True)]
    if solves:
        unknown = draft.unknown("s", 0.1)
        solve = draft.solve([unknown], [unknown**3 + 2.0 * unknown - forces[count // 2] - forces[0]])
        draft.rates.append(solve)
        draft.observe.append(solve)
        forces = [f - 0.1 * unknown * q for f, q in zip(forces, lengths, strict=True)]
    for q, v in zip(lengths, closing, strict=True):
        draft.displacement_rate(q, v)
    for k, p in enumerate(momenta):
        draft.rate(p, (forces[k - 1] if k else 0.0 * p) - (forces[k] if k < count else sin(TIME)))
    for force, v, before, after in zip(forces, closing, speeds[:-1], speeds[1:], strict=True):
        for power in (force * v, force * before, force * after):
            draft.power(power)
    for k, (force, q) in enumerate(zip(forces, lengths, strict=True)):
        draft.signal(force)
        draft.signal(q)
        draft.signal(0.5 * force * q + (1.0 if k % 2 else 2.0) * q)
    if holds:
        period = draft.parameter("period", 0.01)
        draft.sample(period, {u: 0.5 * u + q for u, q in zip(held, lengths, strict=True)})
    return draft


@dataclass(frozen=True)
class Found:
    """Everything a run gives."""

    memory: Memory
    outcome: Outcome
    rates: tuple[np.ndarray, np.ndarray]
    observed: np.ndarray


def found(draft: Draft, machine: NativeMachine | InterpretedMachine) -> Found:
    memory = draft.memory(machine.lanes)
    if machine.lanes > 1:
        own = [k for k in range(len(memory.parameter)) if k not in machine.program.periods]
        memory.parameter[own] *= 1.0 + 0.01 * np.arange(machine.lanes)
    outcome = machine.run(memory, Request(until=STEPS * 1e-3, step=1e-3, integral_period=7e-3, row_period=9e-3))
    return Found(memory, outcome, machine.rates(memory), machine.observe(memory))


def assert_equal(a: Found, b: Found) -> None:
    assert a.outcome.status is b.outcome.status
    for name in ("state", "discrete", "unknown", "integral", "activity"):
        np.testing.assert_array_equal(getattr(a.memory, name), getattr(b.memory, name), err_msg=name)
    for one, other in (
        (a.rates[0], b.rates[0]),
        (a.rates[1], b.rates[1]),
        (a.observed, b.observed),
        (a.outcome.integrals, b.outcome.integrals),
        (a.outcome.activities, b.outcome.activities),
        (a.outcome.rows, b.outcome.rows),
    ):
        np.testing.assert_array_equal(one, other)


def check(draft: Draft, method: Method, lanes: int) -> None:
    """Loops against straight-line code, in all that a run gives."""
    program = draft.program()
    straight, loops = (NativeMachine(program, method, lanes, printing) for printing in (STRAIGHT, LOOPS))
    assert_equal(found(draft, loops), found(draft, straight))


def loops_of(program: Program, method: Method = Method.EULER, lanes: int = 1, printing: Printing = LOOPS) -> int:
    return print_program(program, method, lanes, printing).text.count(".all = add")


@st.composite
def random_laws(draw: st.DrawFn) -> Law:
    """A law made of an expression of three symbols."""
    root = draw(expressions())
    return lambda q, v, k: substitute(root, {X: q, Y: v, Z: k})


@given(
    kinds=st.lists(st.one_of(st.sampled_from(LAWS), random_laws()), min_size=1, max_size=3),
    count=st.integers(16, 24),
    method=st.sampled_from([Method.SEMI_IMPLICIT, Method.RK4]),
    lanes=st.sampled_from([1, 4]),
    extras=st.fixed_dictionaries({}, optional=dict.fromkeys(("tables", "solves", "holds"), st.just(True))),
)
@settings(max_examples=6)
def test_loops_change_no_bit_of_a_random_row_of_sections(
    kinds: list[Law], count: int, method: Method, lanes: int, extras: dict[str, bool]
):
    check(sections([kinds[k % len(kinds)] for k in range(count)], **extras), method, lanes)


@pytest.mark.parametrize("law", LAWS)
def test_loops_change_no_bit_of_any_operation(law: Law):
    draft = sections([law] * 17)
    assert loops_of(draft.program()) > 3
    check(draft, Method.SEMI_IMPLICIT, 1)


@pytest.mark.parametrize("lanes", [1, 4])
def test_loops_change_no_bit_around_tables_solves_and_controllers(lanes: int):
    check(sections([LAWS[2], LAWS[7]] * 16, tables=True, solves=True, holds=True), Method.SEMI_IMPLICIT, lanes)


@pytest.mark.parametrize("method", [Method.ROS2, Method.DOPRI5])
def test_loops_change_no_bit_of_a_method(method: Method):
    check(sections([LAWS[0], LAWS[1]] * 10, holds=True), method, 1)


def plain(q: Expr, v: Expr, k: Expr) -> Expr:
    return k * q + minimum(abs(q), v * v)


def test_interpreted_code_has_the_bits_of_loops():
    # Of operations that are exact to the last bit on both sides, divisions by parameters apart.
    draft = sections([plain] * 20)
    program = draft.program()
    loops, interpreted = NativeMachine(program, Method.RK4, 1, LOOPS), InterpretedMachine(program, Method.RK4)
    memory = draft.memory()
    memory.parameter[:21] = 2.0 ** (np.arange(21) % 4)  # whose reciprocals are exact
    copies = memory.copy(), memory.copy()
    request = Request(until=0.03, step=1e-3)
    for machine, own in zip((loops, interpreted), copies, strict=True):
        machine.run(own, request)
    for name in ("state", "integral", "activity"):
        np.testing.assert_array_equal(getattr(copies[0], name), getattr(copies[1], name))
    np.testing.assert_array_equal(loops.observe(copies[0]), interpreted.observe(copies[1]))


@pytest.mark.parametrize("make", [oscillator, tables, lambda: implicit(14)])
@pytest.mark.parametrize("lanes", [1, 4])
def test_what_is_not_repeated_is_printed_as_before(make: Callable[[], Draft], lanes: int):
    program = make().program()
    texts = [print_program(program, Method.ROS2, lanes, printing).text for printing in (STRAIGHT, LOOPS)]
    assert texts[0] == texts[1]


@given(st.lists(expressions(), min_size=1, max_size=8), st.sampled_from([1, 4]))
@settings(max_examples=10)
def test_loops_change_no_bit_of_random_expressions(roots: list[Expr], lanes: int):
    draft = Draft()
    states = [draft.state(name, value) for name, value in (("x", 0.3), ("y", -0.7), ("z", 1.9))]
    for root in roots:
        draft.power(substitute(root, dict(zip(SYMBOLS, states, strict=True))))
    for state in states:
        draft.rate(state, -0.5 * state)
    check(draft, Method.EULER, lanes)


def test_a_small_program_has_no_loops():
    program = sections([LAWS[0]] * 24).program()
    assert loops_of(program, printing=PRINTING) == 0
    assert loops_of(program) > 0


def test_powers_are_added_up_where_they_are_computed():
    def adds(draft: Draft, method: Method, printing: Printing = LOOPS) -> bool:
        return "@rates.adding(" in print_program(draft.program(), method, 1, printing).text

    chain = sections([LAWS[0]] * 20)
    assert adds(chain, Method.RK4)
    assert not adds(chain, Method.RK4, STRAIGHT)
    assert not adds(chain, Method.DOPRI5)
    # An evaluation that ends with an implicit block that has no solution adds nothing.
    assert not adds(sections([LAWS[0]] * 20, solves=True), Method.RK4)


def test_code_of_a_repeated_model_does_not_grow_with_it():
    few, many = (
        len(print_program(sections([LAWS[1]] * count).program(), Method.SEMI_IMPLICIT, 1, LOOPS).text)
        for count in (40, 160)
    )
    assert many < 1.05 * few


def test_events_are_found_where_straight_code_finds_them():
    compiled = compile_quietly(elaborate(Balls()))
    program = compiled.lowered.program
    assert loops_of(program) > 0
    runs: list[tuple[Memory, Outcome]] = []
    for printing in (STRAIGHT, LOOPS):
        memory = start_of(compiled, Scenario(stop=1.0)).memory
        machine = NativeMachine(program, Method.SEMI_IMPLICIT, 1, printing)
        runs.append((memory, machine.run(memory, Request(until=1.0, step=1e-3))))
    (first, outcome), (second, expected) = runs
    assert outcome.status is expected.status is Status.EVENT
    assert outcome.time == expected.time
    np.testing.assert_array_equal(first.state, second.state)
    np.testing.assert_array_equal(first.guard, second.guard)


def repeat(operands: Sequence[int], target: int, count: int = 16) -> Repeat:
    return Repeat((TIME,) * count, tuple(Rows(first, 1) for first in operands), (Rows(target, 1),))


def test_repetitions_share_a_loop_when_instances_need_only_themselves():
    first, second = repeat([0, 100], 200), repeat([200, 300], 400)
    assert sharing([first, second]) == [[first, second]]


def test_what_needs_other_instances_has_a_loop_of_its_own():
    first, neighbour = repeat([0, 100], 200, 17), repeat([200, 201], 400)
    third = repeat([400, 300], 500)
    assert sharing([first, neighbour, third]) == [[first], [neighbour, third]]


def test_what_needs_an_earlier_loop_alone_joins_it():
    first, neighbour, third = repeat([0, 100], 200), repeat([201, 300], 400), repeat([200, 100], 500)
    assert sharing([first, neighbour, third]) == [[first, third], [neighbour]]
