# pyright: basic
"""Prints the fixed-step loop: steps, quadratures, samples, rows and checks, as described in `machine.py`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum

from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, WIDE, Frame, Module, literal
from propermodel.codegen.machine import QUADRATURE, SAME_INSTANT, STEPS_BETWEEN_CHECKS, Method
from propermodel.codegen.program import Array, Function, Program, Solve


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
    FIRST_RATE = 20


class Code(IntEnum):
    """What `run` returns."""

    FINISHED = 0
    PAUSED = 1
    STATE_FAILED = 2  # in some lane that is alive
    ALL_FAILED = 3  # no lane is alive after a solve


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
        body = "\n".join(self.loops.lines)
        self.module.functions.append(
            f"define internal i1 @step({ARGUMENTS}, double %h) alwaysinline {{\nentry:\n{body}\n  ret i1 true\n"
            f"dead:\n  ret i1 false\n}}"
            if "%dead" in body
            else f"define internal i1 @step({ARGUMENTS}, double %h) alwaysinline {{\nentry:\n{body}\n  ret i1 true\n}}"
        )

    def _evaluate(self, function: Function, name: str, time: str) -> None:
        self.loops.lines.append(f"  call void @{name}(ptr %w, ptr %tables, double {time})")
        if has_solve(function):
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
        regions = self.frame.regions
        self.module.declare(f"llvm.fabs.v{WIDE}f64", f"declare {_V} @llvm.fabs.v{WIDE}f64({_V})")

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            p, total, size = (pointer(regions[name]) for name in (Array.POWER, "integral", "activity"))
            return [
                f"  {n}.p = load {_V}, ptr {p}, align 64",
                f"  {n}.i0 = load {_V}, ptr {total}, align 64",
                f"  {n}.a0 = load {_V}, ptr {size}, align 64",
                *_spread(f"{n}.h", f"%share{stage}"),
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
        for stage, (time, factor) in enumerate((("%t", "%half"), ("%t.half", "%half"), ("%t.half", "%h"), ("%t.end", ""))):
            self._evaluate(self.program.rates, "rates", time)
            self._integrate(stage)
            if stage == 0:
                self._copy("sum", Array.RATE)
            else:
                self._advance("sum", "sum", Array.RATE, literal(2.0 if stage < 3 else 1.0), 0, rows)
            if factor:
                self._advance(Array.STATE, "start", Array.RATE, factor, 0, rows)
        self._advance(Array.STATE, "start", "sum", "%sixth", 0, rows)

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
        f"""define internal double @instant(double %origin, i64 %count, double %period) {{
  %number = sitofp i64 %count to double
  %away = fmul double %number, %period
  %at = fadd double %origin, %away
  %is.first = icmp eq i64 %count, 0
  %result = select i1 %is.first, double %origin, double %at
  ret double %result
}}"""
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
    kind, lanes = frame.shape.number, frame.shape.lanes
    lines += [
        "  %row.time.at = getelementptr inbounds double, ptr %row.times, i64 %row.index",
        "  store double %t, ptr %row.time.at, align 8",
        f"  %signals = getelementptr inbounds i8, ptr %w, i64 {frame.offset(frame.regions[Array.SIGNAL])}",
        "  %row.start = mul i64 %row.index, %selected.count",
        "  br label %gather",
        "gather:",
        "  %g = phi i64 [ 0, %" + ("row.copy" if has_solve(program.observe) else "row.do") + " ], [ %g.next, %gather.body ]",
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
        "  %is.well = call i1 @step(ptr %w, ptr %tables, double %ti, double %h)",
        "  br i1 %is.well, label %stepped, label %step.failed",
        "stepped:",
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
        "step.failed:",
        "  %f.steps = add i64 %steps.before, %i",
        "  store i64 %f.steps, ptr %steps.taken.at, align 8",
        "  store double %ti, ptr %time.at, align 8",
        "  br label %all.failed",
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
