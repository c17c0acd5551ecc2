# pyright: basic
"""Prints the watch over the fastest mode, as described in `fastest.py`, for one lane and steps of one length."""

from __future__ import annotations

from collections.abc import Sequence

from propermodel.codegen.control_block import Word
from propermodel.codegen.fastest import LONGEST, LOOK_EVERY, NUDGE
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Frame, Module, literal
from propermodel.codegen.machine import LEAST_SIZE, Method
from propermodel.codegen.program import Array, Program

_SIZE, _DIRECTION, _RATE = "size", "direction", "look.rate"
# What an evaluation beside the run would change, and where it is kept meanwhile.
_KEPT = {region: f"look.{region}" for region in (Array.STATE, Array.UNKNOWN, "alive", "failed", "failed_time")}


def is_watching(method: Method, lanes: int) -> bool:
    """Whether the code for a method can be asked to watch its steps."""
    return method in LONGEST and lanes == 1


def reserve_watch(frame: Frame, program: Program, state_rows: int) -> None:
    """Room for sizes, the direction, and what an evaluation beside the run would change."""
    for region in (_SIZE, _DIRECTION, _RATE):
        frame.reserve(region, state_rows)
    for region, rows in _kept_rows(program, state_rows).items():
        frame.reserve(_KEPT[region], rows)


def _kept_rows(program: Program, state_rows: int) -> dict[str, int]:
    unknowns = program.layout.lengths.get(Array.UNKNOWN, 0)
    return {Array.STATE: state_rows, Array.UNKNOWN: unknowns, "alive": 1, "failed": 1, "failed_time": 1}


def look_lines(name: str, steps: str, time: str) -> list[str]:
    """Look where that is due, after so many steps; then `%{name}.is.fast` tells whether steps seem too long."""
    return [
        f"  %{name}.due = load i64, ptr %next.look.at, align 8",
        f"  %{name}.is.due = icmp sge i64 {steps}, %{name}.due",
        f"  br i1 %{name}.is.due, label %{name}.look, label %{name}.looked",
        f"{name}.look:",
        f"  %{name}.next = add i64 {steps}, {LOOK_EVERY}",
        f"  store i64 %{name}.next, ptr %next.look.at, align 8",
        f"  %{name}.seen = call i1 @look(ptr %w, ptr %tables, double {time}, double %h, ptr %c)",
        f"  br label %{name}.looked",
        f"{name}.looked:",
        f"  %{name}.is.fast = phi i1 [ false, %{name} ], [ %{name}.seen, %{name}.look ]",
    ]


_SCALE = [
    f"  %N.big = fcmp ogt double %N.2, {literal(LEAST_SIZE)}",
    f"  %N.size = select i1 %N.big, double %N.2, double {literal(LEAST_SIZE)}",
    f"  %N.scale = fmul double %N.size, {literal(NUDGE)}",
]
# The state at the end of a step, and the rates that have led there.
_MIDDLE_LINES = [
    "  %N.back = fmul double %N.1, %half",
    "  %N.middle = fsub double %N.0, %N.back",
    "  store double %N.middle, ptr %N.at0, align 8",
    f"  %N.more.sum = fadd double %N.sum, {literal(0.0)}",
]
# The state, its size, the direction: the size grows with the state, which moves along the direction.
_NUDGE_LINES = [
    "  %N.now = call double @llvm.fabs.f64(double %N.0)",
    "  %N.grows = fcmp ogt double %N.now, %N.1",
    "  %N.grown = select i1 %N.grows, double %N.now, double %N.1",
    "  store double %N.grown, ptr %N.at1, align 8",
    *(line.replace("%N.2", "%N.grown") for line in _SCALE),
    "  %N.part = fmul double %N.scale, %N.2",
    "  %N.moved = fadd double %N.0, %N.part",
    "  store double %N.moved, ptr %N.at0, align 8",
    f"  %N.more.sum = fadd double %N.sum, {literal(0.0)}",
]
# The rates before and after, and the size: the change takes the place of the rates before.
_CHANGE_LINES = [
    *_SCALE,
    "  %N.difference = fsub double %N.1, %N.0",
    "  %N.change = fdiv double %N.difference, %N.scale",
    "  store double %N.change, ptr %N.at0, align 8",
    "  %N.square = fmul double %N.change, %N.change",
    "  %N.more.sum = fadd double %N.sum, %N.square",
]
_SCALE_LINES = [
    "  %N.unit = fdiv double %N.0, %factor",
    "  store double %N.unit, ptr %N.at1, align 8",
    f"  %N.more.sum = fadd double %N.sum, {literal(0.0)}",
]


def write_look(module: Module, program: Program, method: Method, state_rows: int) -> None:
    """Write `look`: multiply the direction with the Jacobian; whether steps `%h` seem too long for the mean factor."""
    frame = module.frame
    for name in ("sqrt", "fabs"):
        module.declare(f"llvm.{name}.f64", f"declare double @llvm.{name}.f64(double)")
    kept = _kept_rows(program, state_rows).items()
    lines = [
        f"define internal i1 @look({ARGUMENTS}, double %h, ptr %c) noinline {{",
        "entry:",
        *(line for region, rows in kept for line in _copy(frame, _KEPT[region], region, rows)),
        f"  %half = fmul double %h, {literal(0.5)}",
        *_loop(frame, "middle", state_rows, (Array.STATE, Array.RATE), _MIDDLE_LINES),
        f"  call void @rates({PASSED})",
        *_copy(frame, _RATE, Array.RATE, state_rows),
        *_loop(frame, "nudge", state_rows, (Array.STATE, _SIZE, _DIRECTION), _NUDGE_LINES),
        f"  call void @rates({PASSED})",
        *_loop(frame, "change", state_rows, (_RATE, Array.RATE, _SIZE), _CHANGE_LINES),
        *(line for region, rows in kept for line in _copy(frame, region, _KEPT[region], rows)),
        "  %factor = call double @llvm.sqrt.f64(double %change.sum)",
        f"  %is.positive = fcmp ogt double %factor, {literal(0.0)}",
        f"  %is.finite = fcmp olt double %factor, {literal(float('inf'))}",
        "  %is.factor = and i1 %is.positive, %is.finite",
        "  br i1 %is.factor, label %rescale, label %nothing",
        "nothing:",
        "  ret i1 false",
        "rescale:",
        *_loop(frame, "scale", state_rows, (_RATE, _DIRECTION), _SCALE_LINES),
        f"  %fastest.at = getelementptr inbounds i64, ptr %c, i64 {int(Word.FASTEST)}",
        "  %fastest = load double, ptr %fastest.at, align 8",
        "  %square = fmul double %fastest, %factor",
        "  %mean = call double @llvm.sqrt.f64(double %square)",
        f"  %has.begun = fcmp ogt double %fastest, {literal(0.0)}",
        "  %now = select i1 %has.begun, double %mean, double %factor",
        "  store double %now, ptr %fastest.at, align 8",
        "  %product = fmul double %now, %h",
        f"  %is.fast = fcmp ogt double %product, {literal(LONGEST[method])}",
        "  ret i1 %is.fast",
        "}",
    ]
    module.functions.append("\n".join(lines))


def _copy(frame: Frame, target: str, source: str, rows: int) -> list[str]:
    if not rows:
        return []
    name = f"%{target}.from.{source}"
    return [
        f"  {name}.to = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[target])}",
        f"  {name} = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[source])}",
        f"  call void @llvm.memcpy.p0.p0.i64(ptr {name}.to, ptr {name}, i64 {frame.offset(rows)}, i1 false)",
    ]


def _loop(frame: Frame, name: str, rows: int, regions: Sequence[str], body: Sequence[str]) -> list[str]:
    """A loop over the states with the numbers `%N.0`, `%N.1`, ... of regions, which adds up `%N.sum`; N is its name."""
    pointers = [
        f"  %N.base{k} = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[region])}"
        for k, region in enumerate(regions)
    ]
    loads = [
        line
        for k in range(len(regions))
        for line in (
            f"  %N.at{k} = getelementptr inbounds double, ptr %N.base{k}, i64 %N.i",
            f"  %N.{k} = load double, ptr %N.at{k}, align 8",
        )
    ]
    lines = [
        *pointers,
        "  br label %N.begin",
        "N.begin:",
        "  br label %N.test",
        "N.test:",
        "  %N.i = phi i64 [ 0, %N.begin ], [ %N.next, %N.body ]",
        f"  %N.sum = phi double [ {literal(0.0)}, %N.begin ], [ %N.more.sum, %N.body ]",
        f"  %N.more = icmp ult i64 %N.i, {rows}",
        "  br i1 %N.more, label %N.body, label %N.end",
        "N.body:",
        *loads,
        *body,
        "  %N.next = add nuw nsw i64 %N.i, 1",
        "  br label %N.test",
        "N.end:",
    ]
    return [line.replace("N.", f"{name}.") for line in lines]
