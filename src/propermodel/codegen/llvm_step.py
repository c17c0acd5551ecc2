# pyright: basic
"""Prints the fixed-step loop: steps, quadratures, samples, rows and checks, as described in `machine.py`."""

from __future__ import annotations

from propermodel.codegen.llvm_implicit import pending_lines, write_weak_check
from propermodel.codegen.llvm_loops import Body
from propermodel.codegen.llvm_sums import ADDING, SHARE
from propermodel.codegen.llvm_text import ARGUMENTS, Module, literal
from propermodel.codegen.machine import QUADRATURE, Method
from propermodel.codegen.program import Array, Program


class StepWriter:
    """Writes `step`, which advances the state and the integrals; it returns whether a lane is still alive."""

    def __init__(
        self,
        module: Module,
        program: Program,
        method: Method,
        momentum_rows: int,
        state_rows: int,
        *,
        adds_powers: bool,
    ) -> None:
        self.module = module
        self.frame = module.frame
        self.program = program
        self.method = method
        self.momentum_rows = momentum_rows  # rows of the momenta at the beginning of the state regions, padded
        self.state_rows = state_rows
        self.adds_powers = adds_powers  # there is a function that adds powers to their integrals
        self.body = Body(module, program)

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
            case Method.RODAS | Method.DOPRI5 | Method.CVODE:
                raise AssertionError("a method that controls its step has another loop")
        if self.program.corrections:
            self._correct()
        head = f"define internal i1 @step({ARGUMENTS}, double %h, i1 %is.fresh) alwaysinline {{"
        self.body.define(head, "ret i1 true", "ret i1 false")
        if self.program.implicit_step is not None:
            self._write_close()

    def _evaluate(self, stage: int, time: str) -> None:
        """Compute the rates, and add this evaluation's share to the integrals of POWER and of its absolute value."""
        share = QUADRATURE[self.method][stage]
        self.body.lines.append(f"  %share{stage} = fmul double %h, {literal(share)}")
        if self.adds_powers:
            self.body.fill(SHARE, f"%share{stage}")
            self.body.evaluate(self.program.rates, ADDING, time)
        else:
            self.body.evaluate(self.program.rates, "rates", time)
            self.body.add_powers(f"%share{stage}")

    def _euler(self) -> None:
        self._evaluate(0, "%t")
        self.body.advance(Array.STATE, Array.STATE, Array.RATE, "%h", 0, self.state_rows)

    def _semi_implicit(self) -> None:
        self._evaluate(0, "%t")
        self.body.advance(Array.STATE, Array.STATE, Array.RATE, "%h", 0, self.momentum_rows)
        self.body.lines.append("  %t.end = fadd double %t, %h")
        self.body.evaluate(self.program.displacement_rates, "displacement_rates", "%t.end")
        rest = self.state_rows - self.momentum_rows
        self.body.advance(Array.STATE, Array.STATE, Array.RATE, "%h", self.momentum_rows, rest)

    def _correct(self) -> None:
        self.body.lines.append("  %t.after = fadd double %t, %h")
        for k, function in enumerate(self.program.corrections):
            self.body.evaluate(function, f"correct.{k}", "%t.after")

    def _rk4(self) -> None:
        rows = self.state_rows
        lines = self.body.lines
        lines += [
            f"  %half = fmul double %h, {literal(0.5)}",
            "  %t.half = fadd double %t, %half",
            "  %t.end = fadd double %t, %h",
            f"  %sixth = fmul double %h, {literal(1.0 / 6.0)}",
        ]
        self.body.copy("start", Array.STATE, rows)
        stages = (("%t", "%half"), ("%t.half", "%half"), ("%t.half", "%h"), ("%t.end", ""))
        for stage, (time, factor) in enumerate(stages):
            self._evaluate(stage, time)
            if stage == 0:
                self.body.copy("sum", Array.RATE, rows)
            else:
                self.body.advance("sum", "sum", Array.RATE, literal(2.0 if stage < 3 else 1.0), 0, rows)
            if factor:
                self.body.advance(Array.STATE, "start", Array.RATE, factor, 0, rows)
        self.body.advance(Array.STATE, "start", "sum", "%sixth", 0, rows)

    def _implicit(self) -> None:
        step = self.program.implicit_step
        assert step is not None
        assert step.first_again is not None
        write_weak_check(self.module, step)
        self.body.set_step()
        lines = self.body.lines
        lines += ["  br i1 %is.fresh, label %renew, label %again", "renew:"]
        self.body.evaluate(step.first, step.first.name, "%t")
        lines.append("  call void @check.weak(ptr %w, ptr %tables, double %t)")
        self.body.go_on_if_alive()
        lines += ["  br label %first", "again:"]
        self.body.evaluate(step.first_again, step.first_again.name, "%t")
        lines += ["  br label %first", "first:"]
        lines += pending_lines(self.frame, QUADRATURE[self.method][0], "%h", "%h")
        self.body.add_powers("%open")
        for k, (function, share) in enumerate(zip(step.later, step.shares, strict=True)):
            lines += [f"  %away{k} = fmul double %h, {literal(share)}", f"  %t.stage{k} = fadd double %t, %away{k}"]
            self.body.evaluate(function, function.name, f"%t.stage{k}")

    def _write_close(self) -> None:
        """Write `close`, which completes the integrals at the end of the last step before an instant."""
        self.body = Body(self.module, self.program)
        self.body.evaluate(self.program.rates, "rates", "%t")
        self.body.lines += pending_lines(self.frame, QUADRATURE[self.method][-1], literal(0.0), literal(0.0))
        self.body.add_powers("%open")
        self.body.define(f"define internal i1 @close({ARGUMENTS}) {{", "ret i1 true", "ret i1 false")


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
