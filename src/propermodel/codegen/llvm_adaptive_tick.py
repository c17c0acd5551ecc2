# pyright: basic
"""Prints the steps of one tick, of lengths that their errors ask for, as described in `step_control.py`."""

from __future__ import annotations

from propermodel.codegen.control_block import Code
from propermodel.codegen.llvm_extremes import watch_lines
from propermodel.codegen.llvm_implicit import close_lines
from propermodel.codegen.llvm_loops import has_solve
from propermodel.codegen.llvm_text import Frame, literal
from propermodel.codegen.machine import SAME_INSTANT, STEPS_BETWEEN_PAUSES
from propermodel.codegen.program import Program
from propermodel.codegen.step_control import (
    LEAST_ERROR,
    LEAST_ERROR_BEFORE,
    LEAST_FACTOR,
    LEAST_SHARE,
    LEAST_ULPS,
    MOST_FACTOR,
    SAFETY,
)


def adaptive_tick_lines(program: Program, frame: Frame, soonest: str) -> list[str]:
    """From the block `plan` to `instant`, or to one of the ends of the call."""
    has_close = program.implicit_step is not None
    is_changed = "true" if program.corrections else "false"  # by other than the step
    most = literal(MOST_FACTOR)
    return [
        "  br label %steps",
        "steps:",
        "  %ti = phi double [ %t, %plan ], [ %t.next, %go.on ], [ %ti, %retry ]",
        "  %i = phi i64 [ 0, %plan ], [ %i.next, %go.on ], [ %i.next, %retry ]",
        f"  %is.fresh = phi i1 [ true, %plan ], [ {is_changed}, %go.on ], [ %is.fresh, %retry ]",
        f"  %most.growth = phi double [ {most}, %plan ], [ {most}, %go.on ], [ {literal(1.0)}, %retry ]",
        "  %i.next = add nuw nsw i64 %i, 1",
        *_length_lines(soonest),
        "  %error = call double @attempt(ptr %w, ptr %tables, double %ti, double %h, double %tolerance, i1 %is.fresh)",
        f"  %is.good = fcmp ole double %error, {literal(1.0)}",
        "  br i1 %is.good, label %accepted, label %rejected",
        *_rejected_lines(),
        "accepted:",
        "  %t.end = fadd double %ti, %h",
        *_correct_lines(program),
        *(_compare_lines() if program.guards is not None else ()),
        "  %is.committed = call i1 @commit(ptr %w, ptr %tables, double %ti, double %h)",
        "  br i1 %is.committed, label %committed, label %step.failed",
        "committed:",
        "  %steps.before = load i64, ptr %steps.taken.at, align 8",
        "  %steps.after = add i64 %steps.before, 1",
        "  store i64 %steps.after, ptr %steps.taken.at, align 8",
        *_next_step_lines(),
        f"  %t.next = select i1 %is.last, double {soonest}, double %t.end",
        *watch_lines("step", "%t.next", "seen", "watch.failed"),
        "seen:",
        "  br i1 %is.last, label %tick.end, label %go.on",
        "go.on:",
        f"  %is.long = icmp sge i64 %i.next, {STEPS_BETWEEN_PAUSES}",
        "  br i1 %is.long, label %breathe, label %steps",
        # A pause at a step that is the same whatever was asked for, so that the numbers are.
        "breathe:",
        *(_breath_close_lines() if has_close else ()),
        "  store double %t.next, ptr %time.at, align 8",
        "  %breath.code = call i32 @check(ptr %w)",
        "  %breath.bad = icmp ne i32 %breath.code, 0",
        "  br i1 %breath.bad, label %state.failed, label %paused",
        "tick.end:",
        *(close_lines(soonest) if has_close else ()),
        f"  store double {soonest}, ptr %time.at, align 8",
        "  %code = call i32 @check(ptr %w)",
        "  %is.bad = icmp ne i32 %code, 0",
        "  br i1 %is.bad, label %state.failed, label %instant",
        *(_close_failed_lines(soonest) if has_close else ()),
        "watch.failed:",
        "  store double %t.next, ptr %time.at, align 8",
        "  br label %all.failed",
        "step.failed:",
        "  store double %ti, ptr %time.at, align 8",
        "  br label %all.failed",
        *(_event_lines(frame) if program.guards is not None else ()),
    ]


def _length_lines(soonest: str) -> list[str]:
    """The length of the step: what was intended, or all or half of what is left before the next instant."""
    return [
        f"  %left = fsub double {soonest}, %ti",
        "  %wanted = load double, ptr %next.step.at, align 8",
        f"  %nearly = fmul double %left, {literal(1.0 - SAME_INSTANT)}",
        "  %is.last = fcmp oge double %wanted, %nearly",
        f"  %half.left = fmul double %left, {literal(0.5)}",
        "  %is.short = fcmp olt double %wanted, %half.left",
        "  %part = select i1 %is.short, double %wanted, double %half.left",
        "  %h = select i1 %is.last, double %left, double %part",
        "  %is.cut = fcmp olt double %h, %wanted",
    ]


def _rejected_lines() -> list[str]:
    return [
        "rejected:",
        "  %rejected.before = load i64, ptr %steps.rejected.at, align 8",
        "  %rejected.after = add i64 %rejected.before, 1",
        "  store i64 %rejected.after, ptr %steps.rejected.at, align 8",
        "  call void @restore(ptr %w)",
        "  %has.begun = fcmp ord double %error, %error",
        "  br i1 %has.begun, label %shorten, label %too.small",
        "shorten:",
        "  %e.root2 = call double @llvm.sqrt.f64(double %error)",
        "  %e.root4 = call double @llvm.sqrt.f64(double %e.root2)",
        f"  %shrink0 = fdiv double {literal(SAFETY)}, %e.root4",
        f"  %shrink.is = fcmp ogt double %shrink0, {literal(LEAST_FACTOR)}",
        f"  %shrink = select i1 %shrink.is, double %shrink0, double {literal(LEAST_FACTOR)}",
        "  %shorter = fmul double %h, %shrink",
        "  store double %shorter, ptr %next.step.at, align 8",
        "  %size.of.t = call double @llvm.fabs.f64(double %ti)",
        f"  %by.time = fmul double %size.of.t, {literal(LEAST_ULPS)}",
        f"  %by.step = fmul double %dt, {literal(LEAST_SHARE)}",
        "  %by.time.is = fcmp ogt double %by.time, %by.step",
        "  %smallest = select i1 %by.time.is, double %by.time, double %by.step",
        "  %is.too.small = fcmp olt double %shorter, %smallest",
        "  br i1 %is.too.small, label %too.small, label %retry",
        "retry:",
        "  call void @revive(ptr %w)",
        "  br label %steps",
        "too.small:",
        "  %is.solvable = call i1 @is.alive(ptr %w)",
        "  br i1 %is.solvable, label %give.up, label %step.failed",
        "give.up:",
        "  store double %ti, ptr %time.at, align 8",
        f"  ret i32 {int(Code.STEP_TOO_SMALL)}",
    ]


def _correct_lines(program: Program) -> list[str]:
    lines: list[str] = []
    for k, function in enumerate(program.corrections):
        lines.append(f"  call void @correct.{k}(ptr %w, ptr %tables, double %t.end)")
        if has_solve(function):
            lines += [
                f"  %correct{k}.alive = call i1 @is.alive(ptr %w)",
                f"  br i1 %correct{k}.alive, label %corrected{k}, label %step.failed",
                f"corrected{k}:",
            ]
    return lines


def _compare_lines() -> list[str]:
    """To `event` where a guard has become positive at the end of the step."""
    return [
        "  call void @guards(ptr %w, ptr %tables, double %t.end)",
        "  %is.solved = call i1 @is.alive(ptr %w)",
        "  br i1 %is.solved, label %compare, label %step.failed",
        "compare:",
        "  %is.event = call i1 @meets.event(ptr %w)",
        "  br i1 %is.event, label %event, label %unrisen",
        "unrisen:",
    ]


def _event_lines(frame: Frame) -> list[str]:
    """The state before the step, its time and its length; the integrals are at its beginning already."""
    return [
        "event:",
        "  call void @restore(ptr %w)",
        f"  %event.step = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions['event.step'])}",
        "  store double %h, ptr %event.step, align 8",
        "  store double %ti, ptr %time.at, align 8",
        f"  ret i32 {int(Code.EVENT)}",
    ]


def _next_step_lines() -> list[str]:
    roots = [f"  %e.{2**k} = call double @llvm.sqrt.f64(double %e.{2 ** (k - 1)})" for k in range(1, 5)]
    before = [f"  %b.{2**k} = call double @llvm.sqrt.f64(double %b.{2 ** (k - 1)})" for k in range(1, 5)]
    return [
        f"  %e.is = fcmp ogt double %error, {literal(LEAST_ERROR)}",
        f"  %e.1 = select i1 %e.is, double %error, double {literal(LEAST_ERROR)}",
        "  %b.1 = load double, ptr %last.error.at, align 8",
        *roots,
        *before,
        "  %e.square = fmul double %e.16, %e.16",
        "  %e.cube = fmul double %e.square, %e.16",
        f"  %dividend = fmul double {literal(SAFETY)}, %b.16",
        "  %factor0 = fdiv double %dividend, %e.cube",
        f"  %factor.is = fcmp ogt double %factor0, {literal(LEAST_FACTOR)}",
        f"  %factor1 = select i1 %factor.is, double %factor0, double {literal(LEAST_FACTOR)}",
        "  %factor.less = fcmp olt double %factor1, %most.growth",
        "  %factor = select i1 %factor.less, double %factor1, double %most.growth",
        "  %next0 = fmul double %h, %factor",
        # A step that was cut short says nothing against the one that was intended.
        "  %next.longer = fcmp ogt double %next0, %wanted",
        "  %is.free = xor i1 %is.cut, true",
        "  %takes.next = or i1 %is.free, %next.longer",
        "  %next1 = select i1 %takes.next, double %next0, double %wanted",
        "  %next.less = fcmp olt double %next1, %dt",
        "  %next = select i1 %next.less, double %next1, double %dt",
        "  store double %next, ptr %next.step.at, align 8",
        f"  %kept.is = fcmp ogt double %error, {literal(LEAST_ERROR_BEFORE)}",
        f"  %kept0 = select i1 %kept.is, double %error, double {literal(LEAST_ERROR_BEFORE)}",
        "  %kept = select i1 %is.cut, double %b.1, double %kept0",
        "  store double %kept, ptr %last.error.at, align 8",
    ]


def _close_failed_lines(time: str) -> list[str]:
    return ["close.failed:", f"  store double {time}, ptr %time.at, align 8", "  br label %all.failed"]


def _breath_close_lines() -> list[str]:
    return [
        "  %breath.closed = call i1 @close(ptr %w, ptr %tables, double %t.next)",
        "  br i1 %breath.closed, label %breath.done, label %breath.failed",
        "breath.failed:",
        "  store double %t.next, ptr %time.at, align 8",
        "  br label %all.failed",
        "breath.done:",
    ]
