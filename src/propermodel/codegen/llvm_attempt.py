# pyright: basic
"""Prints what methods that control their step need: `attempt`, `restore`, `commit` and `close`, for one lane.

`attempt` takes a step and gives its error as a share of what is tolerated, infinite where an equation has no solution;
where that is so at the beginning already, which no shorter step can mend, it is no number.
`restore` takes it back, `revive` forgives what had no solution. `commit` makes it part of the run: sizes of the states,
and integrals of POWER, which go by the parabola through its values at the beginning, middle and end of the step, those
of the absolute value between its zeros.

An explicit method has evaluated the end already. With an implicit one the next step does so, or `close`; `pending` is
the length of the step whose integrals wait for this.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from propermodel.codegen.llvm_implicit import PENDING, write_weak_check
from propermodel.codegen.llvm_loops import Body, V, spread, wide
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, WIDE, Frame, Module, literal
from propermodel.codegen.program import Array, ImplicitStep, Program
from propermodel.codegen.step_control import TINY
from propermodel.codegen.tableaus import ExplicitTableau

_START, _END, _UNKNOWN = "attempt.start", "attempt.end", "attempt.unknown"
_SIZE, _LEAST = "size", "least.size"
_POWER_START, _POWER_OTHER = "power.start", "power.other"  # the other is in the middle, or at the end


def reserve_attempt(frame: Frame, program: Program, tableau: ExplicitTableau | None, state_rows: int) -> None:
    """Room for sizes, errors, what a step is taken back with, and powers along it."""
    lengths = program.layout.lengths
    for region in (Array.ERROR, _SIZE, _LEAST, _START, _END):
        frame.reserve(region, state_rows)
    frame.reserve(_UNKNOWN, lengths.get(Array.UNKNOWN, 0))
    for region in (_POWER_START, _POWER_OTHER):
        frame.reserve(region, lengths.get(Array.POWER, 0))
    if tableau is not None:
        for stage in range(len(tableau.c)):
            frame.reserve(_slope(stage), state_rows)


def write_attempt(module: Module, program: Program, tableau: ExplicitTableau | None, state_rows: int) -> None:
    """Write all of them."""
    writer = _Writer(module, program, state_rows)
    writer.write_norm()
    writer.write_restore()
    step = program.implicit_step
    if step is not None:
        writer.write_quadrature(_POWER_OTHER, Array.POWER)
        writer.write_implicit(step)
    elif tableau is not None:
        writer.write_quadrature(Array.POWER, _POWER_OTHER)
        writer.write_explicit(tableau)


def single_step_lines(program: Program) -> list[str]:
    """A step of length `%h` at `%t` whatever its error, with its integrals."""
    lines = [
        f"  %error = call double @attempt({PASSED}, double %h, double {literal(1.0)}, i1 true)",
        "  %t.end = fadd double %t, %h",
        *(f"  call void @correct.{k}(ptr %w, ptr %tables, double %t.end)" for k in range(len(program.corrections))),
        f"  %is.committed = call i1 @commit({PASSED}, double %h)",
    ]
    if program.implicit_step is not None:
        lines.append("  %is.closed = call i1 @close(ptr %w, ptr %tables, double %t.end)")
    return lines


def _slope(stage: int) -> str:
    return f"slope.{stage}"


class _Writer:
    def __init__(self, module: Module, program: Program, state_rows: int) -> None:
        self.module = module
        self.frame = module.frame
        self.program = program
        self.state_rows = state_rows
        self.powers = program.layout.lengths.get(Array.POWER, 0)
        for name, count in (("fabs", 1), ("sqrt", 1), ("copysign", 2)):
            arguments = ", ".join([V] * count)
            module.declare(f"llvm.{name}.v{WIDE}f64", f"declare {V} @llvm.{name}.v{WIDE}f64({arguments})")
        for name in ("fabs", "sqrt"):
            module.declare(f"llvm.{name}.f64", f"declare double @llvm.{name}.f64(double)")

    def _body(self) -> Body:
        return Body(self.module, self.program)

    # -- the error ---------------------------------------------------------------------------------

    def write_norm(self) -> None:
        """Write `error.norm`; it leaves the shares of all states in ERROR."""
        regions = self.frame.regions
        body = self._body()
        slots = "%largest.at"
        body.lines += [f"  {slots} = alloca {V}, align 64", f"  store {V} {wide(0.0)}, ptr {slots}, align 64"]

        def shares(pointer: Callable[[int], str], n: str) -> list[str]:
            error, x, size, least = (pointer(regions[region]) for region in (Array.ERROR, Array.STATE, _SIZE, _LEAST))
            return [
                f"  {n}.e = load {V}, ptr {error}, align 64",
                f"  {n}.x = load {V}, ptr {x}, align 64",
                f"  {n}.s = load {V}, ptr {size}, align 64",
                f"  {n}.least = load {V}, ptr {least}, align 64",
                f"  {n}.ex = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.e)",
                f"  {n}.xx = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.x)",
                *_larger(f"{n}.s1", f"{n}.xx", f"{n}.s"),
                *_larger(f"{n}.s2", f"{n}.s1", f"{n}.least"),
                *_larger(f"{n}.s3", f"{n}.s2", wide(TINY)),
                *spread(f"{n}.tol", "%tolerance"),
                f"  {n}.w = fmul {V} {n}.tol, {n}.s3",
                f"  {n}.q = fdiv {V} {n}.ex, {n}.w",
                f"  {n}.well = fcmp ord {V} {n}.q, {n}.q",
                f"  {n}.share = select <{WIDE} x i1> {n}.well, {V} {n}.q, {V} {wide(float('inf'))}",
                f"  store {V} {n}.share, ptr {error}, align 64",
                f"  {n}.before = load {V}, ptr {slots}, align 64",
                *_larger(f"{n}.largest", f"{n}.share", f"{n}.before"),
                f"  store {V} {n}.largest, ptr {slots}, align 64",
            ]

        body.over(0, self.state_rows, shares)
        body.lines.append(f"  %all = load {V}, ptr {slots}, align 64")
        found = ""
        for k in range(WIDE):
            body.lines.append(f"  %part{k} = extractelement {V} %all, i32 {k}")
            if k:
                body.lines += [
                    f"  %is.larger{k} = fcmp ogt double %part{k}, {found}",
                    f"  %up.to{k} = select i1 %is.larger{k}, double %part{k}, double {found}",
                ]
            found = f"%up.to{k}" if k else "%part0"
        body.define(
            "define internal double @error.norm(ptr noalias %w, double %tolerance) {", f"ret double {found}", ""
        )

    def write_restore(self) -> None:
        """Write `restore`, and `revive`, after which a failed solve counts no more."""
        body = self._body()
        body.copy(Array.STATE, _START, self.state_rows)
        body.copy(Array.UNKNOWN, _UNKNOWN, self.program.layout.lengths.get(Array.UNKNOWN, 0))
        body.define("define internal void @restore(ptr noalias %w) {", "ret void", "")
        body = self._body()
        for name, value in (("alive", 1.0), ("failed", 0.0)):
            place = self.frame.offset(self.frame.regions[name])
            body.lines += [
                f"  %{name}.at = getelementptr inbounds i8, ptr %w, i64 {place}",
                f"  store double {literal(value)}, ptr %{name}.at, align 8",
            ]
        body.define("define internal void @revive(ptr noalias %w) {", "ret void", "")

    # -- the integrals -----------------------------------------------------------------------------

    def write_quadrature(self, middle: str, end: str) -> None:
        """Write `quadrature`, which adds a step of some length to the integrals.

        With s from 0 to 1, power is q(s) = p + b s + a s^2. The zeros r of q, kept within the step, cut the integral of
        |q| into three parts; where there are none, they coincide or lie at its ends.
        """
        regions = self.frame.regions
        body = self._body()

        def parts(pointer: Callable[[int], str], n: str) -> list[str]:
            p, m, e, total, size = (
                pointer(regions[region]) for region in (_POWER_START, middle, end, "integral", "activity")
            )
            lines = [
                f"  {n}.{name} = load {V}, ptr {place}, align 64"
                for name, place in (("p", p), ("m", m), ("e", e), ("i0", total), ("a0", size))
            ]
            lines += [
                f"  {n}.ends = fadd {V} {n}.p, {n}.e",
                f"  {n}.mm = fmul {V} {n}.m, {wide(2.0)}",
                f"  {n}.bend = fsub {V} {n}.ends, {n}.mm",
                f"  {n}.a = fmul {V} {n}.bend, {wide(2.0)}",
                f"  {n}.rise = fsub {V} {n}.e, {n}.p",
                f"  {n}.b = fsub {V} {n}.rise, {n}.a",
                # zeros
                f"  {n}.bb = fmul {V} {n}.b, {n}.b",
                f"  {n}.ap = fmul {V} {n}.a, {n}.p",
                f"  {n}.ap4 = fmul {V} {n}.ap, {wide(4.0)}",
                f"  {n}.disc0 = fsub {V} {n}.bb, {n}.ap4",
                *_larger(f"{n}.disc", f"{n}.disc0", wide(0.0)),
                f"  {n}.root = call {V} @llvm.sqrt.v{WIDE}f64({V} {n}.disc)",
                f"  {n}.signed = call {V} @llvm.copysign.v{WIDE}f64({V} {n}.root, {V} {n}.b)",
                f"  {n}.sum = fadd {V} {n}.b, {n}.signed",
                f"  {n}.t = fmul {V} {n}.sum, {wide(-0.5)}",
                f"  {n}.r1 = fdiv {V} {n}.t, {n}.a",
                f"  {n}.r2 = fdiv {V} {n}.p, {n}.t",
                *_larger(f"{n}.r1a", f"{n}.r1", wide(0.0)),
                *_smaller(f"{n}.r1b", f"{n}.r1a", wide(1.0)),
                *_larger(f"{n}.r2a", f"{n}.r2", wide(0.0)),
                *_smaller(f"{n}.r2b", f"{n}.r2a", wide(1.0)),
                *_smaller(f"{n}.u", f"{n}.r1b", f"{n}.r2b"),
                *_larger(f"{n}.v", f"{n}.r1b", f"{n}.r2b"),
                # the integral from 0 to s: s (p + s (b / 2 + s a / 3))
                f"  {n}.b2 = fmul {V} {n}.b, {wide(0.5)}",
                f"  {n}.a3 = fmul {V} {n}.a, {wide(1.0 / 3.0)}",
                *_integral(n, f"{n}.u"),
                *_integral(n, f"{n}.v"),
                f"  {n}.c1 = fadd {V} {n}.b2, {n}.a3",
                f"  {n}.whole = fadd {V} {n}.p, {n}.c1",
                f"  {n}.second = fsub {V} {n}.v.q, {n}.u.q",
                f"  {n}.third = fsub {V} {n}.whole, {n}.v.q",
                f"  {n}.x1 = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.u.q)",
                f"  {n}.x2 = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.second)",
                f"  {n}.x3 = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.third)",
                f"  {n}.x12 = fadd {V} {n}.x1, {n}.x2",
                f"  {n}.x123 = fadd {V} {n}.x12, {n}.x3",
                *spread(f"{n}.h", "%span"),
                f"  {n}.di = fmul {V} {n}.whole, {n}.h",
                f"  {n}.da = fmul {V} {n}.x123, {n}.h",
                f"  {n}.i1 = fadd {V} {n}.i0, {n}.di",
                f"  {n}.a1 = fadd {V} {n}.a0, {n}.da",
                f"  store {V} {n}.i1, ptr {total}, align 64",
                f"  store {V} {n}.a1, ptr {size}, align 64",
            ]
            return lines

        body.over(0, self.powers, parts)
        body.define("define internal void @quadrature(ptr noalias %w, double %span) {", "ret void", "")

    def _grow(self, body: Body) -> None:
        """Let the sizes hold the states at the end of the step."""
        regions = self.frame.regions

        def larger(pointer: Callable[[int], str], n: str) -> list[str]:
            x, size = pointer(regions[Array.STATE]), pointer(regions[_SIZE])
            return [
                f"  {n}.x = load {V}, ptr {x}, align 64",
                f"  {n}.s = load {V}, ptr {size}, align 64",
                f"  {n}.xx = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.x)",
                *_larger(f"{n}.s1", f"{n}.xx", f"{n}.s"),
                f"  store {V} {n}.s1, ptr {size}, align 64",
            ]

        body.over(0, self.state_rows, larger)

    # -- implicit steps ----------------------------------------------------------------------------

    def write_implicit(self, step: ImplicitStep) -> None:
        """Write `complete`, and the others for linearly implicit stages."""
        write_weak_check(self.module, step)
        body = self._body()
        place = self.frame.offset(self.frame.regions[PENDING])
        body.lines += [
            f"  %pending.at = getelementptr inbounds i8, ptr %w, i64 {place}",
            "  %pending = load double, ptr %pending.at, align 8",
            f"  %is.open = fcmp ogt double %pending, {literal(0.0)}",
            "  br i1 %is.open, label %open, label %kept",
            "open:",
            "  call void @quadrature(ptr %w, double %pending)",
            f"  store double {literal(0.0)}, ptr %pending.at, align 8",
            "  br label %kept",
            "kept:",
        ]
        body.copy(_POWER_START, Array.POWER, self.powers)
        body.define("define internal void @complete(ptr noalias %w) {", "ret void", "")

        body = self._begun_attempt()
        body.set_step()
        body.evaluate(step.first, step.first.name, "%t", otherwise="hopeless")
        body.lines.append("  call void @check.weak(ptr %w, ptr %tables, double %t)")
        body.go_on_if_alive()
        body.lines.append("  call void @complete(ptr %w)")
        for k, (function, share) in enumerate(zip(step.later, step.shares, strict=True)):
            body.lines += _later(f"stage{k}", share)
            body.evaluate(function, function.name, f"%t.stage{k}")
        self._define_attempt(body)

        body = self._body()
        body.copy(_END, Array.STATE, self.state_rows)
        assert step.middle is not None
        body.lines += _later("middle", 0.5)
        body.evaluate(step.middle, step.middle.name, "%t.middle")
        body.evaluate(self.program.rates, "rates", "%t.middle")
        body.copy(_POWER_OTHER, Array.POWER, self.powers)
        body.copy(Array.STATE, _END, self.state_rows)
        self._grow(body)
        body.lines += [
            f"  %pending.at = getelementptr inbounds i8, ptr %w, i64 {place}",
            "  store double %h, ptr %pending.at, align 8",
        ]
        self._define_commit(body)

        body = self._body()
        body.evaluate(self.program.rates, "rates", "%t")
        body.lines.append("  call void @complete(ptr %w)")
        body.define(f"define internal i1 @close({ARGUMENTS}) {{", "ret i1 true", "ret i1 false")

    def _begun_attempt(self) -> Body:
        body = self._body()
        body.copy(_START, Array.STATE, self.state_rows)
        body.copy(_UNKNOWN, Array.UNKNOWN, self.program.layout.lengths.get(Array.UNKNOWN, 0))
        return body

    def _define_attempt(self, body: Body) -> None:
        body.lines.append("  %error = call double @error.norm(ptr %w, double %tolerance)")
        head = f"define internal double @attempt({ARGUMENTS}, double %h, double %tolerance, i1 %is.fresh) {{"
        infinite, none = (f"ret double {literal(float(name))}" for name in ("inf", "nan"))
        body.define(head, "ret double %error", infinite, none)

    def _define_commit(self, body: Body) -> None:
        body.define(f"define internal i1 @commit({ARGUMENTS}, double %h) {{", "ret i1 true", "ret i1 false")

    # -- explicit steps ----------------------------------------------------------------------------

    def write_explicit(self, tableau: ExplicitTableau) -> None:
        """Write the others for explicit stages; the last one is at the end of the step."""
        rates, last = self.program.rates, len(tableau.c) - 1
        body = self._begun_attempt()
        body.lines += ["  br i1 %is.fresh, label %fresh, label %go.on", "fresh:"]
        body.evaluate(rates, "rates", "%t", otherwise="hopeless")
        body.copy(_slope(0), Array.RATE, self.state_rows)
        body.copy(_POWER_START, Array.POWER, self.powers)
        body.lines += ["  br label %go.on", "go.on:"]
        for stage, (row, share) in enumerate(zip(tableau.a, tableau.c[1:], strict=True), 1):
            self._combine(body, Array.STATE, _START, row)
            body.lines += _later(f"stage{stage}", share)
            body.evaluate(rates, "rates", f"%t.stage{stage}")
            body.copy(_slope(stage), Array.RATE, self.state_rows)
        self._combine(body, Array.ERROR, None, tableau.error)
        self._define_attempt(body)

        body = self._body()
        body.copy(_END, Array.STATE, self.state_rows)
        body.copy(_POWER_OTHER, Array.POWER, self.powers)
        self._combine(body, Array.STATE, _START, tableau.middle)
        body.lines += _later("middle", 0.5)
        body.evaluate(rates, "rates", "%t.middle")
        body.lines.append("  call void @quadrature(ptr %w, double %h)")
        body.copy(_POWER_START, _POWER_OTHER, self.powers)
        body.copy(_slope(0), _slope(last), self.state_rows)
        body.copy(Array.STATE, _END, self.state_rows)
        self._grow(body)
        self._define_commit(body)

    def _combine(self, body: Body, target: str, start: str | None, weights: Sequence[float]) -> None:
        """Set target = start + h * (weighted sum of the slopes)."""
        regions = self.frame.regions
        used = [(stage, weight) for stage, weight in enumerate(weights) if weight]

        def lines(pointer: Callable[[int], str], n: str) -> list[str]:
            found: list[str] = []
            total = ""
            for stage, weight in used:
                found += [
                    f"  {n}.k{stage} = load {V}, ptr {pointer(regions[_slope(stage)])}, align 64",
                    f"  {n}.term{stage} = fmul {V} {n}.k{stage}, {wide(weight)}",
                ]
                if total:
                    found.append(f"  {n}.sum{stage} = fadd {V} {total}, {n}.term{stage}")
                total = f"{n}.sum{stage}" if total else f"{n}.term{stage}"
            found += [*spread(f"{n}.h", "%h"), f"  {n}.d = fmul {V} {total}, {n}.h"]
            result = f"{n}.d"
            if start is not None:
                found += [
                    f"  {n}.x = load {V}, ptr {pointer(regions[start])}, align 64",
                    f"  {n}.y = fadd {V} {n}.x, {n}.d",
                ]
                result = f"{n}.y"
            return [*found, f"  store {V} {result}, ptr {pointer(regions[target])}, align 64"]

        body.over(0, self.state_rows, lines)


def _later(name: str, share: float) -> list[str]:
    """The time a share of the step after its beginning."""
    return [f"  %away.{name} = fmul double %h, {literal(share)}", f"  %t.{name} = fadd double %t, %away.{name}"]


def _larger(name: str, a: str, b: str) -> list[str]:
    """The larger one; the second where the first is no number."""
    return [f"  {name}.is = fcmp ogt {V} {a}, {b}", f"  {name} = select <{WIDE} x i1> {name}.is, {V} {a}, {V} {b}"]


def _smaller(name: str, a: str, b: str) -> list[str]:
    return [f"  {name}.is = fcmp olt {V} {a}, {b}", f"  {name} = select <{WIDE} x i1> {name}.is, {V} {a}, {V} {b}"]


def _integral(n: str, s: str) -> list[str]:
    return [
        f"  {s}.1 = fmul {V} {s}, {n}.a3",
        f"  {s}.2 = fadd {V} {n}.b2, {s}.1",
        f"  {s}.3 = fmul {V} {s}, {s}.2",
        f"  {s}.4 = fadd {V} {n}.p, {s}.3",
        f"  {s}.q = fmul {V} {s}, {s}.4",
    ]
