# pyright: basic
"""Prints what programs with events need besides: guards compared after a step, which may be taken back; evaluations."""

from __future__ import annotations

from propermodel.codegen.llvm_attempt import single_step_lines
from propermodel.codegen.llvm_implicit import PENDING, close_before_event_lines
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Frame, Module, literal
from propermodel.codegen.machine import Method
from propermodel.codegen.program import Array, Program

# What a step changes, and where it is kept until the guards have been compared.
_KEPT = {Array.STATE: "before.state", Array.UNKNOWN: "before.unknown", "integral": "before.integral"}
_KEPT |= {"activity": "before.activity", PENDING: "before.pending"}


def reserve_events(frame: Frame, program: Program, state_rows: int) -> None:
    """Room for guards, jumps, what is kept of a step, and the length of the step in which an event lies."""
    lengths = program.layout.lengths
    guards = lengths.get(Array.GUARD, 0)
    frame.reserve(Array.GUARD, guards)
    frame.reserve("guard.before", guards)
    frame.reserve(Array.JUMP, lengths.get(Array.JUMP, 0))
    frame.reserve(Array.SWITCHING, lengths.get(Array.SWITCHING, 0))
    for region, rows in _kept_rows(program, state_rows).items():
        frame.reserve(_KEPT[region], rows)
    frame.reserve("event.step", 1)


def _kept_rows(program: Program, state_rows: int) -> dict[str, int]:
    lengths = program.layout.lengths
    powers = lengths.get(Array.POWER, 0)
    unknowns = lengths.get(Array.UNKNOWN, 0)
    rows = {Array.STATE: state_rows, Array.UNKNOWN: unknowns, "integral": powers, "activity": powers}
    return rows if program.implicit_step is None else {**rows, PENDING: 1}


def write_events(module: Module, program: Program, method: Method, state_rows: int) -> None:
    """Write `meets.event` and the entries `evaluate.guards`, `evaluate.jumps`, `advance`.

    Programs with ideal switches also get `evaluate.switching`; where steps are of one length, `keep` and `take.back`.
    """
    if not method.is_adaptive:
        _write_keeping(module, program, state_rows)
    _write_meets_event(module, program)
    for name in ("guards", "jumps", *(["switching"] if program.switching is not None else [])):
        module.functions.append(_entry(f"evaluate.{name}", ARGUMENTS, f"  call void @{name}({PASSED})"))
    step = "  %well = call i1 @step(ptr %w, ptr %tables, double %t, double %h, i1 true)"
    if method.is_adaptive:
        step = "\n".join(single_step_lines(program))
    elif program.implicit_step is not None:
        step += "\n  %t.end = fadd double %t, %h\n  %is.closed = call i1 @close(ptr %w, ptr %tables, double %t.end)"
    module.functions.append(_entry("advance", f"{ARGUMENTS}, double %h", step))


def _write_keeping(module: Module, program: Program, state_rows: int) -> None:
    frame = module.frame
    rows = _kept_rows(program, state_rows)
    for name, is_back in (("keep", False), ("take.back", True)):
        lines: list[str] = []
        for k, region in enumerate(rows):
            copy = _KEPT[region]
            target, source = (region, copy) if is_back else (copy, region)
            size = frame.offset(rows[region])
            lines += [
                f"  %to{k} = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[target])}",
                f"  %from{k} = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[source])}",
                f"  call void @llvm.memcpy.p0.p0.i64(ptr %to{k}, ptr %from{k}, i64 {size}, i1 false)",
            ]
        module.functions.append("\n".join([f"define internal void @{name}(ptr %w) {{", *lines, "  ret void", "}"]))


def _entry(name: str, arguments: str, body: str) -> str:
    return (
        f"define i32 @{name}({arguments}) {{\n  call void @prepare({PASSED})\n  call void @refresh({PASSED})\n{body}\n"
        "  %alive = call i1 @is.alive(ptr %w)\n  %result = zext i1 %alive to i32\n  ret i32 %result\n}"
    )


def _write_meets_event(module: Module, program: Program) -> None:
    """Whether a guard has become positive; if none has, the guards are kept for the next comparison."""
    frame = module.frame
    count = program.layout.lengths.get(Array.GUARD, 0)
    now, before = (frame.offset(frame.regions[region]) for region in (Array.GUARD, "guard.before"))
    module.functions.append(
        f"""define internal i1 @meets.event(ptr %w) noinline {{
entry:
  %now = getelementptr inbounds i8, ptr %w, i64 {now}
  %before = getelementptr inbounds i8, ptr %w, i64 {before}
  br label %test
test:
  %i = phi i64 [ 0, %entry ], [ %next, %well ]
  %more = icmp ult i64 %i, {count}
  br i1 %more, label %body, label %none
body:
  %now.at = getelementptr inbounds double, ptr %now, i64 %i
  %before.at = getelementptr inbounds double, ptr %before, i64 %i
  %g = load double, ptr %now.at, align 8
  %g0 = load double, ptr %before.at, align 8
  %holds = fcmp ogt double %g, {literal(0.0)}
  %held.not = fcmp ule double %g0, {literal(0.0)}
  %risen = and i1 %holds, %held.not
  br i1 %risen, label %event, label %well
well:
  %next = add nuw nsw i64 %i, 1
  br label %test
none:
  call void @llvm.memcpy.p0.p0.i64(ptr %before, ptr %now, i64 {8 * count}, i1 false)
  ret i1 false
event:
  ret i1 true
}}"""
    )


def keep_lines() -> list[str]:
    """Before a step of the loop."""
    return ["  call void @keep(ptr %w)"]


def compare_lines() -> list[str]:
    """After a step of the loop: on to `unrisen`, or take the step back and go to `event`."""
    return [
        "  %ti.end = fadd double %ti, %h",
        "  call void @guards(ptr %w, ptr %tables, double %ti.end)",
        "  %is.solved = call i1 @is.alive(ptr %w)",
        "  br i1 %is.solved, label %compare, label %step.failed",
        "compare:",
        "  %is.event = call i1 @meets.event(ptr %w)",
        "  br i1 %is.event, label %event, label %unrisen",
        "unrisen:",
    ]


def event_lines(program: Program, frame: Frame, code: int) -> list[str]:
    """The end of the loop at an event: the state before the step, its time and its length."""
    return [
        "event:",
        "  call void @take.back(ptr %w)",
        *(close_before_event_lines() if program.implicit_step is not None else ()),
        f"  %event.step = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions['event.step'])}",
        "  store double %h, ptr %event.step, align 8",
        "  %e.steps = add i64 %steps.before, %i",
        "  store i64 %e.steps, ptr %steps.taken.at, align 8",
        "  store double %ti, ptr %time.at, align 8",
        f"  ret i32 {code}",
    ]
