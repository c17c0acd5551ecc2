# pyright: basic
"""Prints the fixed-step loop: steps, quadratures, samples, rows and checks, as described in `machine.py`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from propermodel.codegen.llvm_implicit import pending_lines, write_weak_check
from propermodel.codegen.llvm_text import ARGUMENTS, WIDE, Frame, Module, Text, literal
from propermodel.codegen.machine import QUADRATURE, Method
from propermodel.codegen.program import Array, Function, Program, Solve


def has_solve(function: Function) -> bool:
    """Whether an implicit block can fail in it."""
    return any(isinstance(step, Solve) for step in function.steps)


class _Loops:
    """Loops over regions in wide operations."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.lines: list[str] = []
        self._count = 0

    def over(self, first_row: int, rows: int, body: Callable[[Callable[[int], str], str], Sequence[str]]) -> None:
        """A loop over rows; the body gets the function from a first row to a pointer name, and a name prefix."""
        if not rows:
            return
        self._count += 1
        n = f"l{self._count}"
        blocks = -(-rows * self.frame.shape.lanes // WIDE)
        pointers: list[str] = []

        def pointer(row: int) -> str:
            name = f"%{n}.p{len(pointers)}"
            pointers.append(
                f"  {name}.base = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(row)}\n"
                f"  {name} = getelementptr inbounds <{WIDE} x double>, ptr {name}.base, i64 %{n}.i"
            )
            return name

        inner = body(pointer, f"%{n}")
        self.lines += [
            f"  br label %{n}.entry",
            f"{n}.entry:",
            f"  br label %{n}.loop",
            f"{n}.loop:",
            f"  %{n}.i = phi i64 [ 0, %{n}.entry ], [ %{n}.next, %{n}.loop ]",
            *pointers,
            *inner,
            f"  %{n}.next = add nuw nsw i64 %{n}.i, 1",
            f"  %{n}.more = icmp ult i64 %{n}.next, {blocks}",
            f"  br i1 %{n}.more, label %{n}.loop, label %{n}.end",
            f"{n}.end:",
        ]


_V = f"<{WIDE} x double>"


def _spread(name: str, scalar: str) -> list[str]:
    return [
        f"  {name}.first = insertelement {_V} poison, double {scalar}, i32 0",
        f"  {name} = shufflevector {_V} {name}.first, {_V} poison, <{WIDE} x i32> zeroinitializer",
    ]


def _wide(value: float) -> str:
    return "<" + ", ".join(f"double {literal(value)}" for _ in range(WIDE)) + ">"


class StepWriter:
    """Writes `step`, which advances the state and the integrals; it returns whether a lane is still alive."""

    def __init__(self, module: Module, program: Program, method: Method, momentum_rows: int, state_rows: int) -> None:
        self.module = module
        self.frame = module.frame
        self.program = program
        self.method = method
        self.momentum_rows = momentum_rows  # rows of the momenta at the beginning of the state regions, padded
        self.state_rows = state_rows
        self.loops = _Loops(self.frame)
        self._count = 0

    def write(self) -> None:
        """Write the function."""
        match self.method:
            case Method.EULER:
                self._euler()
            case Method.SEMI_IMPLICIT:
                self._semi_implicit()
            case Method.RK4:
                self._rk4()
            case Method.ROS2:
                self._implicit()
        if self.program.corrections:
            self._correct()
        body = "\n".join(self.loops.lines)
        head = f"define internal i1 @step({ARGUMENTS}, double %h, i1 %is.fresh) alwaysinline {{"
        self._define(head, body)
        if self.program.implicit_step is not None:
            self._write_close()

    def _define(self, head: str, body: str) -> None:
        dead = ["dead:", "  ret i1 false"] if "%dead" in body else []
        self.module.functions.append("\n".join([head, "entry:", body, "  ret i1 true", *dead, "}"]))

    def _evaluate(self, function: Function, name: str, time: str) -> None:
        self.loops.lines.append(f"  call void @{name}(ptr %w, ptr %tables, double {time})")
        if has_solve(function):
            self._go_on_if_alive()

    def _go_on_if_alive(self) -> None:
        self._count += 1
        self.loops.lines += [
            f"  %alive{self._count} = call i1 @is.alive(ptr %w)",
            f"  br i1 %alive{self._count}, label %go{self._count}, label %dead",
            f"go{self._count}:",
        ]

    def _advance(self, target: str, start: str, rate: str, factor: str, first: int, rows: int) -> None:
        """Set target = start + factor * rate over some rows of the state regions."""
        regions = self.frame.regions

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            to, x, f = (pointer(regions[region] + first) for region in (target, start, rate))
            return [
                f"  {n}.x = load {_V}, ptr {x}, align 64",
                f"  {n}.f = load {_V}, ptr {f}, align 64",
                *_spread(f"{n}.h", factor),
                f"  {n}.d = fmul {_V} {n}.f, {n}.h",
                f"  {n}.y = fadd {_V} {n}.x, {n}.d",
                f"  store {_V} {n}.y, ptr {to}, align 64",
            ]

        self.loops.over(first, rows, body)

    def _integrate(self, stage: int) -> None:
        """Add this evaluation's share to the integrals of POWER and of its absolute value."""
        share = QUADRATURE[self.method][stage]
        self.loops.lines.append(f"  %share{stage} = fmul double %h, {literal(share)}")
        self._add_powers(f"%share{stage}")

    def _add_powers(self, span: str) -> None:
        """Add POWER over a span of time to the integrals."""
        regions = self.frame.regions
        self.module.declare(f"llvm.fabs.v{WIDE}f64", f"declare {_V} @llvm.fabs.v{WIDE}f64({_V})")

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            p, total, size = (pointer(regions[name]) for name in (Array.POWER, "integral", "activity"))
            return [
                f"  {n}.p = load {_V}, ptr {p}, align 64",
                f"  {n}.i0 = load {_V}, ptr {total}, align 64",
                f"  {n}.a0 = load {_V}, ptr {size}, align 64",
                *_spread(f"{n}.h", span),
                f"  {n}.d = fmul {_V} {n}.p, {n}.h",
                f"  {n}.i1 = fadd {_V} {n}.i0, {n}.d",
                f"  {n}.s = call {_V} @llvm.fabs.v{WIDE}f64({_V} {n}.d)",
                f"  {n}.a1 = fadd {_V} {n}.a0, {n}.s",
                f"  store {_V} {n}.i1, ptr {total}, align 64",
                f"  store {_V} {n}.a1, ptr {size}, align 64",
            ]

        self.loops.over(regions[Array.POWER], self.program.layout.lengths.get(Array.POWER, 0), body)

    def _euler(self) -> None:
        self._evaluate(self.program.rates, "rates", "%t")
        self._integrate(0)
        self._advance(Array.STATE, Array.STATE, Array.RATE, "%h", 0, self.state_rows)

    def _semi_implicit(self) -> None:
        self._evaluate(self.program.rates, "rates", "%t")
        self._integrate(0)
        self._advance(Array.STATE, Array.STATE, Array.RATE, "%h", 0, self.momentum_rows)
        self.loops.lines.append("  %t.end = fadd double %t, %h")
        self._evaluate(self.program.displacement_rates, "displacement_rates", "%t.end")
        rest = self.state_rows - self.momentum_rows
        self._advance(Array.STATE, Array.STATE, Array.RATE, "%h", self.momentum_rows, rest)

    def _correct(self) -> None:
        self.loops.lines.append("  %t.after = fadd double %t, %h")
        for k, function in enumerate(self.program.corrections):
            self._evaluate(function, f"correct.{k}", "%t.after")

    def _rk4(self) -> None:
        rows = self.state_rows
        lines = self.loops.lines
        lines += [
            f"  %half = fmul double %h, {literal(0.5)}",
            "  %t.half = fadd double %t, %half",
            "  %t.end = fadd double %t, %h",
            f"  %sixth = fmul double %h, {literal(1.0 / 6.0)}",
        ]
        self._copy("start", Array.STATE)
        stages = (("%t", "%half"), ("%t.half", "%half"), ("%t.half", "%h"), ("%t.end", ""))
        for stage, (time, factor) in enumerate(stages):
            self._evaluate(self.program.rates, "rates", time)
            self._integrate(stage)
            if stage == 0:
                self._copy("sum", Array.RATE)
            else:
                self._advance("sum", "sum", Array.RATE, literal(2.0 if stage < 3 else 1.0), 0, rows)
            if factor:
                self._advance(Array.STATE, "start", Array.RATE, factor, 0, rows)
        self._advance(Array.STATE, "start", "sum", "%sixth", 0, rows)

    def _implicit(self) -> None:
        step = self.program.implicit_step
        assert step is not None
        write_weak_check(self.module, step)
        self._set_step()
        lines = self.loops.lines
        lines += ["  br i1 %is.fresh, label %renew, label %again", "renew:"]
        self._evaluate(step.first, step.first.name, "%t")
        lines.append("  call void @check.weak(ptr %w, ptr %tables, double %t)")
        self._go_on_if_alive()
        lines += ["  br label %first", "again:"]
        self._evaluate(step.first_again, step.first_again.name, "%t")
        lines += ["  br label %first", "first:"]
        lines += pending_lines(self.frame, QUADRATURE[self.method][0], "%h", "%h")
        self._add_powers("%open")
        for k, (function, share) in enumerate(zip(step.later, step.shares, strict=True)):
            lines += [f"  %away{k} = fmul double %h, {literal(share)}", f"  %t.stage{k} = fadd double %t, %away{k}"]
            self._evaluate(function, function.name, f"%t.stage{k}")

    def _set_step(self) -> None:
        """Let the functions of an implicit step know its length."""
        text = Text(self.module)
        text.store_row(self.frame.row(Array.STEP, 0), text.spread("%h"))
        self.loops.lines += text.lines

    def _write_close(self) -> None:
        """Write `close`, which completes the integrals at the end of the last step before an instant."""
        self.loops = _Loops(self.frame)
        self._evaluate(self.program.rates, "rates", "%t")
        self.loops.lines += pending_lines(self.frame, QUADRATURE[self.method][-1], literal(0.0), literal(0.0))
        self._add_powers("%open")
        self._define(f"define internal i1 @close({ARGUMENTS}) {{", "\n".join(self.loops.lines))

    def _copy(self, target: str, source: str) -> None:
        size = self.frame.offset(self.state_rows)
        if not size:
            return
        n = f"%copy.{target}"
        self.loops.lines += [
            f"  {n}.to = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(self.frame.regions[target])}",
            f"  {n}.from = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(self.frame.regions[source])}",
            f"  call void @llvm.memcpy.p0.p0.i64(ptr align 64 {n}.to, ptr align 64 {n}.from, i64 {size}, i1 false)",
        ]


def write_common(module: Module, state_rows: int) -> None:
    """Write `is.alive`, `instant`, `check` and the declarations the loop needs."""
    frame, shape = module.frame, module.frame.shape
    kind, align = shape.number, shape.alignment
    module.declare("memcpy", "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)")
    module.declare("ceil", "declare double @llvm.ceil.f64(double)")

    def any_lane(name: str, truth: str) -> list[str]:
        if shape.lanes == 1:
            return [f"  {name} = and i1 {truth}, true"]
        return [
            f"  {name}.bits = bitcast {shape.truth} {truth} to i{shape.lanes}",
            f"  {name} = icmp ne i{shape.lanes} {name}.bits, 0",
        ]

    alive = [
        f"  %at = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions['alive'])}",
        f"  %number = load {kind}, ptr %at, align {align}",
        f"  %alive = fcmp une {kind} %number, {shape.constant(0.0)}",
    ]
    module.functions.append(
        "\n".join(["define internal i1 @is.alive(ptr %w) {", *alive, *any_lane("%any", "%alive"), "  ret i1 %any", "}"])
    )
    module.functions.append(
        """define internal double @instant(double %origin, i64 %count, double %period) {
  %number = sitofp i64 %count to double
  %away = fmul double %number, %period
  %at = fadd double %origin, %away
  %is.first = icmp eq i64 %count, 0
  %result = select i1 %is.first, double %origin, double %at
  ret double %result
}"""
    )
    # 0: every state is well; 1: a state of a lane that is alive is not; 2: of every lane that is alive.
    pointers = "\n".join(
        f"  %{name}.at = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[region])}"
        for name, region in (("x", Array.STATE), ("l", "lower"), ("u", "upper"))
    )
    loads = "\n".join(
        f"  %{name}.p = getelementptr inbounds [{shape.lanes} x double], ptr %{name}.at, i64 %i\n"
        f"  %{name} = load {kind}, ptr %{name}.p, align {align}"
        for name in "xlu"
    )
    rest = "\n".join(any_lane("%is.any", "%bad") + any_lane("%is.left", "%good"))
    module.functions.append(
        f"""define internal i32 @check(ptr %w) noinline {{
entry:
{pointers}
{chr(10).join(alive)}
  br label %test
test:
  %i = phi i64 [ 0, %entry ], [ %next, %body ]
  %well = phi {shape.truth} [ {shape.truth_constant(True)}, %entry ], [ %well.next, %body ]
  %more = icmp ult i64 %i, {state_rows}
  br i1 %more, label %body, label %end
body:
{loads}
  %above = fcmp oge {kind} %x, %l
  %below = fcmp ole {kind} %x, %u
  %inside = and {shape.truth} %above, %below
  %well.next = and {shape.truth} %well, %inside
  %next = add nuw nsw i64 %i, 1
  br label %test
end:
  %ill = xor {shape.truth} %well, {shape.truth_constant(True)}
  %bad = and {shape.truth} %alive, %ill
  %good = and {shape.truth} %alive, %well
{rest}
  %all = select i1 %is.left, i32 1, i32 2
  %code = select i1 %is.any, i32 %all, i32 0
  ret i32 %code
}}"""
    )
