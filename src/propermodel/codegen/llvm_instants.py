# pyright: basic
"""Prints what happens at an instant: controllers that are due, rows that are due, and which instant is the next."""

from __future__ import annotations

from propermodel.codegen.control_block import Word
from propermodel.codegen.llvm_extremes import kept_unknowns, watch_lines
from propermodel.codegen.llvm_loops import has_solve
from propermodel.codegen.llvm_text import PASSED, Frame
from propermodel.codegen.program import Array, Program


def word_lines(rates: int) -> list[str]:
    """Read the control block `%c`; words that change get a pointer."""
    lines: list[str] = []
    for name, place, kind in (
        ("until", Word.UNTIL, "double"),
        ("dt", Word.STEP, "double"),
        ("origin", Word.ORIGIN, "double"),
        ("row.period", Word.ROW_PERIOD, "double"),
        ("integral.period", Word.INTEGRAL_PERIOD, "double"),
        ("most.rows", Word.MOST_ROWS, "i64"),
        ("jacobian.every", Word.JACOBIAN_EVERY, "i64"),
        ("tolerance", Word.TOLERANCE, "double"),
        ("selected", Word.SELECTED, "ptr"),
        ("selected.count", Word.SELECTED_COUNT, "i64"),
        ("rows", Word.ROWS, "ptr"),
        ("row.times", Word.ROW_TIMES, "ptr"),
        ("integrals", Word.INTEGRALS, "ptr"),
        ("activities", Word.ACTIVITIES, "ptr"),
        ("integral.times", Word.INTEGRAL_TIMES, "ptr"),
        ("least", Word.LEAST, "ptr"),
        *((f"period{k}", Word.FIRST_RATE + 2 * k, "double") for k in range(rates)),
    ):
        lines.append(f"  %{name}.at = getelementptr inbounds i64, ptr %c, i64 {int(place)}")
        lines.append(f"  %{name} = load {kind}, ptr %{name}.at, align 8")
    for name, place in (
        ("time", Word.TIME),
        ("ticks", Word.TICKS_LEFT),
        ("row.count", Word.ROWS_WRITTEN),
        ("integral.count", Word.INTEGRAL_ROWS_WRITTEN),
        ("row.number", Word.ROWS_TAKEN),
        ("integral.number", Word.INTEGRAL_ROWS_TAKEN),
        ("steps.taken", Word.STEPS_TAKEN),
        ("steps.rejected", Word.STEPS_REJECTED),
        ("next.step", Word.NEXT_STEP),
        ("last.error", Word.LAST_ERROR),
        ("next.look", Word.NEXT_LOOK),
        *((f"sample.number{k}", Word.FIRST_RATE + 2 * k + 1) for k in range(rates)),
    ):
        lines.append(f"  %{name}.at = getelementptr inbounds i64, ptr %c, i64 {int(place)}")
    return [*lines, "  %is.watched = icmp ne ptr %least, null"]


def due_lines() -> list[str]:
    """Which rows are due at `%t`; on to `sample0`, or to `paused` where there is no room for them."""
    lines: list[str] = []
    for name in ("row", "integral"):
        lines += [
            f"  %{name}.k = load i64, ptr %{name}.number.at, align 8",
            f"  %{name}.due.at = call double @instant(double %origin, i64 %{name}.k, double %{name}.period)",
            f"  %{name}.due = fcmp ole double %{name}.due.at, %limit",
            f"  %{name}.index = load i64, ptr %{name}.count.at, align 8",
            f"  %{name}.full = icmp sge i64 %{name}.index, %most.rows",
            f"  %{name}.stuck = and i1 %{name}.due, %{name}.full",
        ]
    return [*lines, "  %stuck = or i1 %row.stuck, %integral.stuck", "  br i1 %stuck, label %paused, label %sample0"]


def sample_lines(program: Program) -> list[str]:
    """From `sample0`: the controllers that are due, by rate."""
    lines: list[str] = []
    for k, function in enumerate(program.samples):
        lines += [
            f"sample{k}:",
            f"  %sample{k}.k = load i64, ptr %sample.number{k}.at, align 8",
            f"  %sample{k}.due.at = call double @instant(double %origin, i64 %sample{k}.k, double %period{k})",
            f"  %sample{k}.due = fcmp ole double %sample{k}.due.at, %limit",
            f"  br i1 %sample{k}.due, label %sample{k}.do, label %sample{k + 1}",
            f"sample{k}.do:",
            f"  call void @sample.{k}({PASSED})",
        ]
        if has_solve(function):
            lines += [
                f"  %sample{k}.alive = call i1 @is.alive(ptr %w)",
                f"  br i1 %sample{k}.alive, label %sample{k}.done, label %all.failed",
                f"sample{k}.done:",
            ]
        lines += [
            f"  %sample{k}.next = add i64 %sample{k}.k, 1",
            f"  store i64 %sample{k}.next, ptr %sample.number{k}.at, align 8",
            f"  br label %sample{k + 1}",
        ]
    lines.append(f"sample{len(program.samples)}:")
    if program.samples:
        lines.append(f"  call void @refresh({PASSED})")
    return lines


def row_lines(frame: Frame, program: Program) -> list[str]:
    """The row of signals, where it is due; on to `row.end`."""
    before, after = kept_unknowns(frame, program)
    kind, lanes = frame.shape.number, frame.shape.lanes
    # Where no controller is due nothing has changed since the last step.
    is_still = not program.samples
    lines = [
        f"  br i1 %row.due, label %row.do, label {'%row.end' if is_still else '%row.not'}",
        *([] if is_still else ["row.not:", *watch_lines("instant", "%t", "row.end", "all.failed")]),
        "row.do:",
        before,
        f"  call void @observe({PASSED})",
        after,
    ]
    if has_solve(program.observe):
        lines += [
            "  %row.alive = call i1 @is.alive(ptr %w)",
            "  br i1 %row.alive, label %row.copy, label %all.failed",
            "row.copy:",
        ]
    observed = "row.copy" if has_solve(program.observe) else "row.do"
    return [
        *lines,
        "  %row.time.at = getelementptr inbounds double, ptr %row.times, i64 %row.index",
        "  store double %t, ptr %row.time.at, align 8",
        f"  %signals = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[Array.SIGNAL])}",
        "  %row.start = mul i64 %row.index, %selected.count",
        "  br label %gather",
        "gather:",
        f"  %g = phi i64 [ 0, %{observed} ], [ %g.next, %gather.body ]",
        "  %g.more = icmp slt i64 %g, %selected.count",
        "  br i1 %g.more, label %gather.body, label %gather.end",
        "gather.body:",
        "  %g.index.at = getelementptr inbounds i64, ptr %selected, i64 %g",
        "  %g.index = load i64, ptr %g.index.at, align 8",
        f"  %g.from = getelementptr inbounds [{lanes} x double], ptr %signals, i64 %g.index",
        f"  %g.value = load {kind}, ptr %g.from, align 8",
        "  %g.place = add i64 %row.start, %g",
        f"  %g.to = getelementptr inbounds [{lanes} x double], ptr %rows, i64 %g.place",
        f"  store {kind} %g.value, ptr %g.to, align 8",
        "  %g.next = add i64 %g, 1",
        "  br label %gather",
        "gather.end:",
        "  br i1 %is.watched, label %row.extremes, label %row.done",
        "row.extremes:",
        "  call void @merge(ptr %w, ptr %c)",
        "  call void @keep.extremes(ptr %w, ptr %c, i64 %row.start)",
        "  br label %row.done",
        "row.done:",
        "  %row.index.next = add i64 %row.index, 1",
        "  store i64 %row.index.next, ptr %row.count.at, align 8",
        "  %row.k.next = add i64 %row.k, 1",
        "  store i64 %row.k.next, ptr %row.number.at, align 8",
        "  br label %row.end",
    ]


def integral_lines(frame: Frame, program: Program) -> list[str]:
    """From `row.end`: the row of integrals, where it is due; on to `integral.end`."""
    powers = program.layout.lengths.get(Array.POWER, 0)
    size = frame.offset(powers)
    lines = [
        "row.end:",
        "  br i1 %integral.due, label %integral.do, label %integral.end",
        "integral.do:",
        "  %integral.time.at = getelementptr inbounds double, ptr %integral.times, i64 %integral.index",
        "  store double %t, ptr %integral.time.at, align 8",
        f"  %integral.start = mul i64 %integral.index, {powers * frame.shape.lanes}",
    ]
    for name, region in (("integrals", "integral"), ("activities", "activity")):
        lines += [
            f"  %{name}.from = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[region])}",
            f"  %{name}.to = getelementptr inbounds double, ptr %{name}, i64 %integral.start",
            f"  call void @llvm.memcpy.p0.p0.i64(ptr %{name}.to, ptr %{name}.from, i64 {size}, i1 false)",
        ]
    return [
        *lines,
        "  %integral.index.next = add i64 %integral.index, 1",
        "  store i64 %integral.index.next, ptr %integral.count.at, align 8",
        "  %integral.k.next = add i64 %integral.k, 1",
        "  store i64 %integral.k.next, ptr %integral.number.at, align 8",
        "  br label %integral.end",
    ]


def plan_lines(rates: int) -> tuple[str, list[str]]:
    """The name of the next instant, and the lines that find it."""
    soonest = "%until"
    lines: list[str] = []
    dues = [("row", "%row.period", "%row.number.at"), ("integral", "%integral.period", "%integral.number.at")]
    dues += [(f"sample{k}", f"%period{k}", f"%sample.number{k}.at") for k in range(rates)]
    for name, period, number in dues:
        lines += [
            f"  %{name}.k2 = load i64, ptr {number}, align 8",
            f"  %{name}.at2 = call double @instant(double %origin, i64 %{name}.k2, double {period})",
            f"  %{name}.sooner = fcmp olt double %{name}.at2, {soonest}",
            f"  %{name}.soonest = select i1 %{name}.sooner, double %{name}.at2, double {soonest}",
        ]
        soonest = f"%{name}.soonest"
    return soonest, lines
