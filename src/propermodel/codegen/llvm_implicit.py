# pyright: basic
"""Prints what implicit steps need besides: their singular equations reported, and the quadrature of POWER closed.

An implicit step adds half of its length times POWER at its beginning, and what the step before it has left open: half
of that one's length. `close` adds what the last step before an instant has left open.
"""

from __future__ import annotations

from propermodel.codegen.llvm_text import ARGUMENTS, Frame, Module, Text, literal
from propermodel.codegen.program import Array, ImplicitStep, Program

PENDING = "pending"  # the length of the step whose end is not yet in the integrals


def reserve_implicit(frame: Frame, program: Program) -> None:
    """Room for the step's length, factors, stages and the first weak equation."""
    for array in (Array.STEP, Array.FACTOR, Array.STAGE, Array.WEAK):
        frame.reserve(array, program.layout.lengths.get(array, 0))
    frame.reserve(PENDING, 1)


def write_weak_check(module: Module, step: ImplicitStep) -> None:
    """Write `check.weak`: lanes whose equations are singular fail, with the state from before the step."""
    frame = module.frame
    weak, alive, failed, failed_time = (frame.regions[r] for r in (Array.WEAK, "alive", "failed", "failed_time"))
    text = Text(module)
    zero = text.constant(0.0)
    for row in (weak, alive, failed, failed_time):
        text.address(row)
    number = text.load_row(weak)
    is_alive = text.compare("une", text.load_row(alive), zero)
    bad = text.both(is_alive, text.compare("une", number, zero))
    text.do(f"br i1 {text.any(bad)}, label %fail, label %end")
    text.label("fail")
    text.store_row(failed, text.choose(bad, text.subtract(zero, number), text.load_row(failed)))
    text.store_row(failed_time, text.choose(bad, text.spread("%t"), text.load_row(failed_time)))
    text.store_row(alive, text.choose(bad, zero, text.load_row(alive)))
    for index, slot in enumerate(step.start):
        row = frame.row(Array.STATE, index)
        before = text.load_row(frame.row(slot.array, slot.index))
        text.store_row(row, text.choose(bad, before, text.load_row(row)))
    text.do("br label %end")
    text.label("end")
    text.do("ret void")
    body = "\n".join(text.lines)
    module.functions.append(f"define internal void @check.weak({ARGUMENTS}) noinline {{\nentry:\n{body}\n}}")


def pending_lines(frame: Frame, share: float, added: str, left: str) -> list[str]:
    """Set `%open` to a share of the pending length and one that is added, and leave another length pending."""
    return [
        f"  %pending.at = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[PENDING])}",
        "  %pending = load double, ptr %pending.at, align 8",
        f"  %pending.more = fadd double %pending, {added}",
        f"  %open = fmul double %pending.more, {literal(share)}",
        f"  store double {left}, ptr %pending.at, align 8",
    ]


def close_lines(time: str) -> list[str]:
    """At the end of a tick."""
    return [
        f"  %is.closed = call i1 @close(ptr %w, ptr %tables, double {time})",
        "  br i1 %is.closed, label %closed, label %close.failed",
        "closed:",
    ]


def close_failed_lines(time: str) -> list[str]:
    """Where POWER at the end of a tick cannot be computed."""
    return [
        "close.failed:",
        "  %c.steps = add i64 %steps.before, %n",
        "  store i64 %c.steps, ptr %steps.taken.at, align 8",
        f"  store double {time}, ptr %time.at, align 8",
        "  br label %all.failed",
    ]


def close_before_event_lines() -> list[str]:
    """Where a step has been taken back: the integrals end where the state is."""
    return [
        "  %is.open.closed = call i1 @close(ptr %w, ptr %tables, double %ti)",
        "  br i1 %is.open.closed, label %taken.back, label %step.failed",
        "taken.back:",
    ]
