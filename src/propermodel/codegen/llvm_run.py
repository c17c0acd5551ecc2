# pyright: basic
"""Prints the loop over ticks: samples, rows, steps and checks, as described in `machine.py`; and single evaluations."""

from __future__ import annotations

from propermodel.codegen.control_block import Code
from propermodel.codegen.llvm_adaptive_tick import adaptive_tick_lines
from propermodel.codegen.llvm_extremes import kept_unknowns, write_extremes
from propermodel.codegen.llvm_fastest import is_watching, write_look
from propermodel.codegen.llvm_fixed_tick import fixed_tick_lines
from propermodel.codegen.llvm_instants import (
    due_lines,
    integral_lines,
    plan_lines,
    row_lines,
    sample_lines,
    word_lines,
)
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Module, literal
from propermodel.codegen.machine import SAME_INSTANT, Method
from propermodel.codegen.program import Program


def write_run(module: Module, program: Program, method: Method, state_rows: int) -> None:
    """Write `run`, the loop over ticks."""
    watches = is_watching(method, module.frame.shape.lanes)
    if watches:
        write_look(module, program, method, state_rows)
    write_extremes(module, program)
    frame = module.frame
    rates = len(program.samples)
    soonest, plan = plan_lines(rates)
    lines = [
        "entry:",
        *word_lines(rates),
        f"  %eps = fmul double %dt, {literal(SAME_INSTANT)}",
        f"  call void @prepare(ptr %w, ptr %tables, double {literal(0.0)})",
        f"  call void @refresh(ptr %w, ptr %tables, double {literal(0.0)})",
        "  br label %instant",
        "instant:",
        "  %t = load double, ptr %time.at, align 8",
        "  %limit = fadd double %t, %eps",
        *due_lines(),
        *sample_lines(program),
        *row_lines(frame, program),
        *integral_lines(frame, program),
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
        *plan,
        *(
            adaptive_tick_lines(program, frame, soonest)
            if method.is_adaptive
            else fixed_tick_lines(program, frame, soonest, is_watching=watches)
        ),
        *(
            line
            for label, code in (
                ("finished", Code.FINISHED),
                ("paused", Code.PAUSED),
                ("state.failed", Code.STATE_FAILED),
                ("all.failed", Code.ALL_FAILED),
            )
            for line in (f"{label}:", f"  ret i32 {int(code)}")
        ),
    ]
    body = "\n".join(line for line in lines if line)
    module.functions.append(f"define i32 @run(ptr noalias %w, ptr noalias %tables, ptr noalias %c) {{\n{body}\n}}")


def write_entries(module: Module, program: Program) -> None:
    """Write the functions that evaluate once; they return whether a lane is alive."""
    keep = kept_unknowns(module.frame, program)
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
