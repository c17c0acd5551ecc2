# pyright: basic
"""Prints the steps of one tick, all of the same length."""

from __future__ import annotations

from propermodel.codegen.control_block import Code
from propermodel.codegen.llvm_events import compare_lines, event_lines, keep_lines
from propermodel.codegen.llvm_extremes import watch_lines
from propermodel.codegen.llvm_fastest import look_lines
from propermodel.codegen.llvm_implicit import close_failed_lines, close_lines
from propermodel.codegen.llvm_text import Frame, literal
from propermodel.codegen.machine import SAME_INSTANT, STEPS_BETWEEN_CHECKS
from propermodel.codegen.program import Program


def fixed_tick_lines(program: Program, frame: Frame, soonest: str, *, is_watching: bool) -> list[str]:
    """From the block `plan` to `instant`, or to one of the ends of the call."""
    well = "watched" if is_watching else "instant"
    return [
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
        *_watch_lines(soonest),
        f"  %i.rest = and i64 %i.next, {STEPS_BETWEEN_CHECKS - 1}",
        "  %is.glance = icmp eq i64 %i.rest, 0",
        "  br i1 %is.glance, label %glance, label %step.end",
        "glance:",
        *(_glance_lines() if is_watching else ()),
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
        f"  br i1 %is.bad, label %state.failed, label %{well}",
        *(_watched_lines(soonest) if is_watching else ()),
        "glance.failed:",
        "  %g.steps = add i64 %steps.before, %i.next",
        "  store i64 %g.steps, ptr %steps.taken.at, align 8",
        "  %g.number = sitofp i64 %i.next to double",
        "  %g.away = fmul double %g.number, %h",
        "  %g.time = fadd double %t, %g.away",
        "  store double %g.time, ptr %time.at, align 8",
        "  br label %state.failed",
        *(close_failed_lines(soonest) if program.implicit_step is not None else ()),
        "watch.failed:",
        "  %w.steps = add i64 %steps.before, %i.next",
        "  store i64 %w.steps, ptr %steps.taken.at, align 8",
        "  store double %ti, ptr %time.at, align 8",
        "  br label %all.failed",
        "step.failed:",
        "  %f.steps = add i64 %steps.before, %i",
        "  store i64 %f.steps, ptr %steps.taken.at, align 8",
        "  store double %ti, ptr %time.at, align 8",
        "  br label %all.failed",
        *(event_lines(program, frame, int(Code.EVENT)) if program.guards is not None else ()),
    ]


def _watch_lines(soonest: str) -> list[str]:
    """Look at the signals after a step that stays; on to `seen`."""
    return [
        "  %seen.number = sitofp i64 %i.next to double",
        "  %seen.away = fmul double %seen.number, %h",
        "  %seen.within = fadd double %t, %seen.away",
        "  %seen.last = icmp sge i64 %i.next, %n",
        f"  %seen.at = select i1 %seen.last, double {soonest}, double %seen.within",
        *watch_lines("step", "%seen.at", "seen", "watch.failed"),
        "seen:",
    ]


def _glance_lines() -> list[str]:
    """Look at the fastest mode within a long tick, which goes on whatever is seen."""
    return [
        "  %glance.steps = add i64 %steps.before, %i.next",
        *look_lines("glance", "%glance.steps", "%seen.at"),
    ]


def _watched_lines(soonest: str) -> list[str]:
    """Look at it at the end of a tick, and pause where steps seem to be too long."""
    return [
        "watched:",
        *look_lines("watched", "%steps.after", soonest),
        "  br i1 %watched.is.fast, label %paused, label %instant",
    ]
