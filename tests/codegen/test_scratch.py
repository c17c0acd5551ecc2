"""Rows lent to values while they live."""

from __future__ import annotations

from propermodel.codegen.llvm_scratch import Life, Scratch
from propermodel.codegen.llvm_text import Frame, Shape
from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, SymbolKind, symbol
from tests.codegen.programs import oscillator


def values(count: int) -> list[Expr]:
    return [symbol(SymbolKind.UNKNOWN, Path((f"v{i}",))) for i in range(count)]


def scratch() -> Scratch:
    return Scratch(Frame(Shape(1), oscillator().program().layout, {}))


def test_a_row_is_lent_again_only_when_nothing_reads_it_any_more():
    a, b, c, d = values(4)
    lives = {a: Life(0, 1), b: Life(0, 3), c: Life(1, 2), d: Life(2, 3)}
    rows = scratch()
    with rows.lent(lives) as lent:
        # Within a piece a value may be written before another is read for the last time.
        assert len({lent[a], lent[b], lent[c]}) == 3
        assert lent[d] == lent[a]
    assert rows.frame.rows == 3


def test_a_function_inside_another_has_other_rows_and_one_after_it_the_same():
    a, b, c = values(3)
    rows = scratch()
    with rows.lent({a: Life(0, 1)}) as outer, rows.lent({b: Life(0, 1)}) as inner:
        assert inner[b] != outer[a]
    with rows.lent({c: Life(0, 1)}) as later:
        assert later[c] == outer[a]
    assert rows.frame.rows == 2
