# pyright: basic
"""Prints the loop over ticks: samples, rows, steps and checks, as described in `machine.py`; and single evaluations."""

from __future__ import annotations

from enum import IntEnum

from propermodel.codegen.llvm_events import compare_lines, event_lines, keep_lines
from propermodel.codegen.llvm_implicit import close_failed_lines, close_lines
from propermodel.codegen.llvm_step import has_solve
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Frame, Module, literal
from propermodel.codegen.machine import SAME_INSTANT, STEPS_BETWEEN_CHECKS
from propermodel.codegen.program import Array, Program


class Word(IntEnum):
    """The words of the control block of a call; periods and counts of the rates follow."""

    TIME = 0
    UNTIL = 1
    STEP = 2
    ORIGIN = 3
    ROW_PERIOD = 4
    INTEGRAL_PERIOD = 5
    MOST_ROWS = 6
    TICKS_LEFT = 7
    SELECTED = 8
    SELECTED_COUNT = 9
    ROWS = 10
    ROW_TIMES = 11
    INTEGRALS = 12
    ACTIVITIES = 13
    INTEGRAL_TIMES = 14
    ROWS_WRITTEN = 15
    INTEGRAL_ROWS_WRITTEN = 16
    ROWS_TAKEN = 17
    INTEGRAL_ROWS_TAKEN = 18
    STEPS_TAKEN = 19
    JACOBIAN_EVERY = 20
    FIRST_RATE = 21


class Code(IntEnum):
    """What `run` returns."""

    FINISHED = 0
    PAUSED = 1
    STATE_FAILED = 2  # in some lane that is alive
    ALL_FAILED = 3  # no lane is alive after a solve
    EVENT = 4  # the step that would meet an event was taken back


def write_entries(module: Module, program: Program) -> None:
    """Write the functions that evaluate once; they return whether a lane is alive."""
    keep = _kept_unknowns(module.frame, program)
    samples = "\n".join(f"  call void @sample.{k}({PASSED})" for k in range(len(program.samples)))
    bodies = {
        "evaluate.rates": f"  call void @refresh({PASSED})\n  call void @rates({PASSED})",
        "evaluate.observe": f"  call void @refresh({PASSED})\n{keep[0]}\n  call void @observe({PASSED})\n{keep[1]}",
        "evaluate.sample": samples,
    }
    for name, body in bodies.items():
        module.functions.append(
            f"define i32 @{name}({ARGUMENTS}) {{\n  call void @prepare({PASSED})\n{body}\n"
            "  %alive = call i1 @is.alive(ptr %w)\n  %result = zext i1 %alive to i32\n  ret i32 %result\n}"
        )


def _kept_unknowns(frame: Frame, program: Program) -> tuple[str, str]:
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


def write_run(module: Module, program: Program) -> None:
    """Write `run`, the loop over ticks."""
    frame = module.frame
    rates = len(program.samples)
    powers = program.layout.lengths.get(Array.POWER, 0)
    power_bytes = frame.offset(powers)
    power_doubles = powers * frame.shape.lanes
    lines: list[str] = []

    def word(name: str, place: int, kind: str) -> None:
        lines.append(f"  %{name}.at = getelementptr inbounds i64, ptr %c, i64 {int(place)}")
        lines.append(f"  %{name} = load {kind}, ptr %{name}.at, align 8")

    lines.append("entry:")
    for name, place, kind in (
        ("until", Word.UNTIL, "double"),
        ("dt", Word.STEP, "double"),
        ("origin", Word.ORIGIN, "double"),
        ("row.period", Word.ROW_PERIOD, "double"),
        ("integral.period", Word.INTEGRAL_PERIOD, "double"),
        ("most.rows", Word.MOST_ROWS, "i64"),
        ("jacobian.every", Word.JACOBIAN_EVERY, "i64"),
        ("selected", Word.SELECTED, "ptr"),
        ("selected.count", Word.SELECTED_COUNT, "i64"),
        ("rows", Word.ROWS, "ptr"),
        ("row.times", Word.ROW_TIMES, "ptr"),
        ("integrals", Word.INTEGRALS, "ptr"),
        ("activities", Word.ACTIVITIES, "ptr"),
        ("integral.times", Word.INTEGRAL_TIMES, "ptr"),
    ):
        word(name, place, kind)
    for k in range(rates):
        word(f"period{k}", Word.FIRST_RATE + 2 * k, "double")
    for name, place in (
        ("time", Word.TIME),
        ("ticks", Word.TICKS_LEFT),
        ("row.count", Word.ROWS_WRITTEN),
        ("integral.count", Word.INTEGRAL_ROWS_WRITTEN),
        ("row.number", Word.ROWS_TAKEN),
        ("integral.number", Word.INTEGRAL_ROWS_TAKEN),
        ("steps.taken", Word.STEPS_TAKEN),
        *((f"sample.number{k}", Word.FIRST_RATE + 2 * k + 1) for k in range(rates)),
    ):
        lines.append(f"  %{name}.at = getelementptr inbounds i64, ptr %c, i64 {int(place)}")
    lines += [
        f"  %eps = fmul double %dt, {literal(SAME_INSTANT)}",
        f"  call void @prepare(ptr %w, ptr %tables, double {literal(0.0)})",
        f"  call void @refresh(ptr %w, ptr %tables, double {literal(0.0)})",
        "  br label %instant",
        "instant:",
        "  %t = load double, ptr %time.at, align 8",
        "  %limit = fadd double %t, %eps",
    ]
    for name in ("row", "integral"):
        lines += [
            f"  %{name}.k = load i64, ptr %{name}.number.at, align 8",
            f"  %{name}.due.at = call double @instant(double %origin, i64 %{name}.k, double %{name}.period)",
            f"  %{name}.due = fcmp ole double %{name}.due.at, %limit",
            f"  %{name}.index = load i64, ptr %{name}.count.at, align 8",
            f"  %{name}.full = icmp sge i64 %{name}.index, %most.rows",
            f"  %{name}.stuck = and i1 %{name}.due, %{name}.full",
        ]
    lines += ["  %stuck = or i1 %row.stuck, %integral.stuck", "  br i1 %stuck, label %paused, label %sample0"]
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
    lines.append(f"sample{rates}:")
    if rates:
        lines.append(f"  call void @refresh({PASSED})")
    lines.append("  br i1 %row.due, label %row.do, label %row.end")
    before, after = _kept_unknowns(frame, program)
    lines += ["row.do:", before, f"  call void @observe({PASSED})", after]
    if has_solve(program.observe):
        lines += [
            "  %row.alive = call i1 @is.alive(ptr %w)",
            "  br i1 %row.alive, label %row.copy, label %all.failed",
            "row.copy:",
        ]
    observed = "row.copy" if has_solve(program.observe) else "row.do"
    kind, lanes = frame.shape.number, frame.shape.lanes
    lines += [
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
        "  %row.index.next = add i64 %row.index, 1",
        "  store i64 %row.index.next, ptr %row.count.at, align 8",
        "  %row.k.next = add i64 %row.k, 1",
        "  store i64 %row.k.next, ptr %row.number.at, align 8",
        "  br label %row.end",
        "row.end:",
        "  br i1 %integral.due, label %integral.do, label %integral.end",
        "integral.do:",
        "  %integral.time.at = getelementptr inbounds double, ptr %integral.times, i64 %integral.index",
        "  store double %t, ptr %integral.time.at, align 8",
        f"  %integral.start = mul i64 %integral.index, {power_doubles}",
    ]
    for name, region in (("integrals", "integral"), ("activities", "activity")):
        lines += [
            f"  %{name}.from = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[region])}",
            f"  %{name}.to = getelementptr inbounds double, ptr %{name}, i64 %integral.start",
            f"  call void @llvm.memcpy.p0.p0.i64(ptr %{name}.to, ptr %{name}.from, i64 {power_bytes}, i1 false)",
        ]
    lines += [
        "  %integral.index.next = add i64 %integral.index, 1",
        "  store i64 %integral.index.next, ptr %integral.count.at, align 8",
        "  %integral.k.next = add i64 %integral.k, 1",
        "  store i64 %integral.k.next, ptr %integral.number.at, align 8",
        "  br label %integral.end",
        "integral.end:",
        "  %is.over = fcmp oge double %limit, %until",
        "  br i1 %is.over, label %finished, label %count",
        "count:",
        "  %ticks = load i64, ptr %ticks.at, align 8",
        "  %is.enough = icmp sle i64 %ticks, 0",
        "  br i1 %is.enough, label %paused, label %plan",
        "plan:",
        "  %ticks.next = sub i64 %ticks, 1",
        "  store i64 %ticks.next, ptr %ticks.at, align 8",
    ]
    soonest = "%until"
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
    lines += [
        f"  %span = fsub double {soonest}, %t",
        "  %share = fdiv double %span, %dt",
        f"  %less = fsub double %share, {literal(SAME_INSTANT)}",
        "  %whole = call double @llvm.ceil.f64(double %less)",
        f"  %is.many = fcmp ogt double %whole, {literal(1.0)}",
        f"  %n.number = select i1 %is.many, double %whole, double {literal(1.0)}",
        "  %n = fptosi double %n.number to i64",
        "  %h = fdiv double %span, %n.number",
        "  %steps.before = load i64, ptr %steps.taken.at, align 8",
        "  br label %steps",
        "steps:",
        "  %i = phi i64 [ 0, %plan ], [ %i.next, %step.end ]",
        "  %i.number = sitofp i64 %i to double",
        "  %i.away = fmul double %i.number, %h",
        "  %ti = fadd double %t, %i.away",
        *(keep_lines() if program.guards is not None else ()),
        "  %i.served = urem i64 %i, %jacobian.every",
        "  %is.fresh = icmp eq i64 %i.served, 0",
        "  %is.well = call i1 @step(ptr %w, ptr %tables, double %ti, double %h, i1 %is.fresh)",
        "  br i1 %is.well, label %stepped, label %step.failed",
        "stepped:",
        *(compare_lines() if program.guards is not None else ()),
        "  %i.next = add nuw nsw i64 %i, 1",
        f"  %i.rest = and i64 %i.next, {STEPS_BETWEEN_CHECKS - 1}",
        "  %is.glance = icmp eq i64 %i.rest, 0",
        "  br i1 %is.glance, label %glance, label %step.end",
        "glance:",
        "  %glance.code = call i32 @check(ptr %w)",
        "  %glance.bad = icmp eq i32 %glance.code, 2",
        "  br i1 %glance.bad, label %glance.failed, label %step.end",
        "step.end:",
        "  %i.more = icmp slt i64 %i.next, %n",
        "  br i1 %i.more, label %steps, label %tick.end",
        "tick.end:",
        *(close_lines(soonest) if program.implicit_step is not None else ()),
        "  %steps.after = add i64 %steps.before, %n",
        "  store i64 %steps.after, ptr %steps.taken.at, align 8",
        f"  store double {soonest}, ptr %time.at, align 8",
        "  %code = call i32 @check(ptr %w)",
        "  %is.bad = icmp ne i32 %code, 0",
        "  br i1 %is.bad, label %state.failed, label %instant",
        "glance.failed:",
        "  %g.steps = add i64 %steps.before, %i.next",
        "  store i64 %g.steps, ptr %steps.taken.at, align 8",
        "  %g.number = sitofp i64 %i.next to double",
        "  %g.away = fmul double %g.number, %h",
        "  %g.time = fadd double %t, %g.away",
        "  store double %g.time, ptr %time.at, align 8",
        "  br label %state.failed",
        *(close_failed_lines(soonest) if program.implicit_step is not None else ()),
        "step.failed:",
        "  %f.steps = add i64 %steps.before, %i",
        "  store i64 %f.steps, ptr %steps.taken.at, align 8",
        "  store double %ti, ptr %time.at, align 8",
        "  br label %all.failed",
        *(event_lines(program, frame, int(Code.EVENT)) if program.guards is not None else ()),
        "finished:",
        f"  ret i32 {int(Code.FINISHED)}",
        "paused:",
        f"  ret i32 {int(Code.PAUSED)}",
        "state.failed:",
        f"  ret i32 {int(Code.STATE_FAILED)}",
        "all.failed:",
        f"  ret i32 {int(Code.ALL_FAILED)}",
    ]
    body = "\n".join(lines)
    module.functions.append(f"define i32 @run(ptr noalias %w, ptr noalias %tables, ptr noalias %c) {{\n{body}\n}}")
