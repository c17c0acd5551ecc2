# pyright: basic
"""Prints how extremes between two rows are kept: what is observed, merged and written, where a request asks for it."""

from __future__ import annotations

from propermodel.codegen.control_block import Word
from propermodel.codegen.llvm_loops import has_solve
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Frame, Module
from propermodel.codegen.program import Array, Program

_SIDES = (("least", "olt", Word.LEAST, Word.LEAST_ROWS), ("greatest", "ogt", Word.GREATEST, Word.GREATEST_ROWS))
_NOTHING = {"least": float("inf"), "greatest": float("-inf")}


def kept_unknowns(frame: Frame, program: Program) -> tuple[str, str]:
    """Instructions around `observe`: recording must not change where the next iteration starts."""
    size = frame.offset(program.layout.lengths.get(Array.UNKNOWN, 0))
    if not size or not has_solve(program.observe):
        return "", ""
    place, copy = frame.offset(frame.regions[Array.UNKNOWN]), frame.offset(frame.regions["kept_unknown"])
    before = (
        f"  %keep.a = getelementptr inbounds i8, ptr %w, i64 {place}\n"
        f"  %keep.b = getelementptr inbounds i8, ptr %w, i64 {copy}\n"
        f"  call void @llvm.memcpy.p0.p0.i64(ptr %keep.b, ptr %keep.a, i64 {size}, i1 false)"
    )
    return before, f"  call void @llvm.memcpy.p0.p0.i64(ptr %keep.a, ptr %keep.b, i64 {size}, i1 false)"


def watch_lines(name: str, time: str, well: str, failed: str) -> list[str]:
    """Look at the signals at a time, where extremes are asked for; on to `well`, or without a solution to `failed`."""
    return [
        f"  br i1 %is.watched, label %{name}.watch, label %{well}",
        f"{name}.watch:",
        f"  %{name}.seen = call i1 @watch(ptr %w, ptr %tables, double {time}, ptr %c)",
        f"  br i1 %{name}.seen, label %{well}, label %{failed}",
    ]


def write_extremes(module: Module, program: Program) -> None:
    """Write `watch`, `merge` and `keep.extremes`."""
    before, after = kept_unknowns(module.frame, program)
    alive = "call i1 @is.alive(ptr %w)" if has_solve(program.observe) else "and i1 true, true"
    module.functions += [
        f"""define internal i1 @watch({ARGUMENTS}, ptr %c) noinline {{
{before}
  call void @observe({PASSED})
{after}
  call void @merge(ptr %w, ptr %c)
  %alive = {alive}
  ret i1 %alive
}}""",
        _merge(module.frame),
        _keep(module.frame),
    ]


def _merge(frame: Frame) -> str:
    """The signals that were observed count; numbers that are none do not."""
    kind, lanes = frame.shape.number, frame.shape.lanes
    lines = [
        f"  %signals = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[Array.SIGNAL])}",
        *_word("selected", Word.SELECTED, "ptr"),
        *_word("count", Word.SELECTED_COUNT, "i64"),
        *(line for name, _, word, _ in _SIDES for line in _word(name, word, "ptr")),
    ]
    body = [
        "  %index.at = getelementptr inbounds i64, ptr %selected, i64 %i",
        "  %index = load i64, ptr %index.at, align 8",
        f"  %value.at = getelementptr inbounds [{lanes} x double], ptr %signals, i64 %index",
        f"  %value = load {kind}, ptr %value.at, align 8",
    ]
    for name, is_beyond, _, _ in _SIDES:
        body += [
            f"  %{name}.at.i = getelementptr inbounds [{lanes} x double], ptr %{name}, i64 %i",
            f"  %{name}.old = load {kind}, ptr %{name}.at.i, align 8",
            f"  %{name}.beyond = fcmp {is_beyond} {kind} %value, %{name}.old",
            f"  %{name}.new = select {frame.shape.truth} %{name}.beyond, {kind} %value, {kind} %{name}.old",
            f"  store {kind} %{name}.new, ptr %{name}.at.i, align 8",
        ]
    return _loop("merge(ptr %w, ptr %c)", lines, body)


def _keep(frame: Frame) -> str:
    """Write the extremes beside the row that begins at `%start`; the next ones begin with the signals of this row."""
    kind, lanes = frame.shape.number, frame.shape.lanes
    lines = _word("count", Word.SELECTED_COUNT, "i64")
    body = ["  %place = add i64 %start, %i"]
    for name, _, word, rows in _SIDES:
        lines += [*_word(name, word, "ptr"), *_word(f"{name}.rows", rows, "ptr")]
        body += [
            f"  %{name}.from = getelementptr inbounds [{lanes} x double], ptr %{name}, i64 %i",
            f"  %{name}.to = getelementptr inbounds [{lanes} x double], ptr %{name}.rows, i64 %place",
            f"  %{name}.value = load {kind}, ptr %{name}.from, align 8",
            f"  store {kind} %{name}.value, ptr %{name}.to, align 8",
            f"  store {kind} {frame.shape.constant(_NOTHING[name])}, ptr %{name}.from, align 8",
        ]
    return _loop("keep.extremes(ptr %w, ptr %c, i64 %start)", lines, body, ["  call void @merge(ptr %w, ptr %c)"])


def _word(name: str, word: Word, kind: str) -> list[str]:
    return [
        f"  %{name}.word = getelementptr inbounds i64, ptr %c, i64 {int(word)}",
        f"  %{name} = load {kind}, ptr %{name}.word, align 8",
    ]


def _loop(head: str, before: list[str], body: list[str], after: list[str] | None = None) -> str:
    """A function that does something for each selected signal `%i` of `%count`."""
    return "\n".join(
        [
            f"define internal void @{head} noinline {{",
            "entry:",
            *before,
            "  br label %test",
            "test:",
            "  %i = phi i64 [ 0, %entry ], [ %i.next, %body ]",
            "  %more = icmp slt i64 %i, %count",
            "  br i1 %more, label %body, label %end",
            "body:",
            *body,
            "  %i.next = add nuw nsw i64 %i, 1",
            "  br label %test",
            "end:",
            *(after or ()),
            "  ret void",
            "}",
        ]
    )
