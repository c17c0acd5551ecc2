"""Equal programs have equal digests in every process; whatever differs shows."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest

from propermodel.codegen.fingerprint import fingerprint
from propermodel.codegen.program import Array, Assign, Program, Slot
from propermodel.diagnostics import Path
from propermodel.expressions import maximum, sin
from propermodel.expressions.core import SymbolKind, constant, symbol
from tests.codegen.programs import chain, oscillator

PRINTED = """
from propermodel.codegen.fingerprint import fingerprint
from tests.codegen.programs import chain
print(fingerprint(chain(3).program()))
"""


def test_it_is_the_same_in_another_process():
    run = [sys.executable, "-c", PRINTED]
    printed = [
        subprocess.run(run, capture_output=True, text=True, check=True, env=environment).stdout.strip()
        for environment in _environments()
    ]
    assert printed == [fingerprint(chain(3).program())] * 2


def _environments() -> list[dict[str, str]]:
    import os

    paths = os.pathsep.join(sys.path)
    return [os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": paths} for seed in ("1", "2")]


def test_programs_differ_by_size_and_laws():
    made = [chain(3), chain(4), oscillator(), oscillator(driven=False)]
    assert len({fingerprint(draft.program()) for draft in made}) == len(made)


def test_values_of_parameters_are_no_part_of_a_program():
    assert fingerprint(oscillator(damping=0.5).program()) == fingerprint(oscillator(damping=0.4).program())


def variants(program: Program) -> list[Program]:
    """The program with one thing changed in each."""
    first, *others = program.rates.steps
    assert isinstance(first, Assign)
    layout = program.layout
    changed_rates = [
        replace(first, value=first.value + 1e-300),
        replace(first, slot=Slot(Array.RATE, 7)),
    ]
    moved = {leaf: Slot(slot.array, slot.index + 1) for leaf, slot in layout.slots.items()}
    return [
        *(replace(program, rates=replace(program.rates, steps=(step, *others))) for step in changed_rates),
        replace(program, rates=replace(program.rates, steps=(*others, first))),
        replace(program, rates=replace(program.rates, name="other")),
        replace(program, periods=(*program.periods, 0)),
        replace(program, guards=program.observe),
        replace(program, jumps=program.observe),
        replace(program, corrections=(program.observe,)),
        replace(program, layout=replace(layout, slots=moved)),
        replace(program, layout=replace(layout, momenta=())),
        replace(program, layout=replace(layout, lengths={**layout.lengths, Array.SIGNAL: 99})),
    ]


def test_every_field_counts():
    program = oscillator().program()
    digests = [fingerprint(one) for one in (program, *variants(program))]
    assert len(set(digests)) == len(digests)


A, B = (symbol(SymbolKind.SIGNAL, Path((name,))) for name in "ab")


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (constant(0.1), constant(0.1 + 2**-55)),
        (A - B, B - A),
        ((A + B) * A, (A + B) * B),
        (maximum(A, B), A + B),
        (("ab", "c"), ("a", "bc")),
        (("1",), (1,)),
        ((1.0,), (1,)),
        ((True,), (1,)),
        (((), 1), ((1,),)),
        ({"a": 1, "b": 2}, {"b": 2, "a": 1}),
        ({"a": (1, 2)}, {"a": 1, "b": 2}),
    ],
)
def test_values_that_look_alike_differ(one: object, other: object):
    assert fingerprint(one) != fingerprint(other)


def test_shared_nodes_are_written_once():
    expr = A
    for _ in range(200):  # 2**200 paths
        expr = sin(expr) + expr
    assert fingerprint(expr) == fingerprint((expr,)[0])


def test_deep_expressions_need_no_recursion():
    expr = A
    for _ in range(20_000):
        expr = sin(expr)
    assert fingerprint(expr) != fingerprint(A)


def test_what_has_no_content_is_refused():
    with pytest.raises(TypeError, match="object has no fingerprint"):
        fingerprint((1, object()))
