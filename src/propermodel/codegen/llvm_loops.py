# pyright: basic
"""Bodies of functions that work on whole regions in wide operations, and call the functions of a program."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from propermodel.codegen.llvm_text import WIDE, Module, Text, literal
from propermodel.codegen.program import Array, Function, Program, Solve

V = f"<{WIDE} x double>"


def has_solve(function: Function) -> bool:
    """Whether an implicit block can fail in it."""
    return any(isinstance(step, Solve) for step in function.steps)


def spread(name: str, scalar: str) -> list[str]:
    """A scalar in every place of a wide value."""
    return [
        f"  {name}.first = insertelement {V} poison, double {scalar}, i32 0",
        f"  {name} = shufflevector {V} {name}.first, {V} poison, <{WIDE} x i32> zeroinitializer",
    ]


def wide(value: float) -> str:
    """A wide constant."""
    return "<" + ", ".join(f"double {literal(value)}" for _ in range(WIDE)) + ">"


class Body:
    """The lines of one function; after a failed solve they go to the label `dead`, or to another one."""

    def __init__(self, module: Module, program: Program) -> None:
        self.module = module
        self.frame = module.frame
        self.program = program
        self.lines: list[str] = []
        self._loops = 0
        self._checks = 0
        self._copies = 0

    def define(self, head: str, result: str, dead: str, hopeless: str = "") -> None:
        """Write the function into the module: what it returns at its end, and at the labels `dead` and `hopeless`."""
        ends = ["dead:", f"  {dead}"] if any("%dead" in line for line in self.lines) else []
        ends += ["hopeless:", f"  {hopeless}"] if any("%hopeless" in line for line in self.lines) else []
        self.module.functions.append("\n".join([head, "entry:", *self.lines, f"  {result}", *ends, "}"]))

    def over(self, first_row: int, rows: int, body: Callable[[Callable[[int], str], str], Sequence[str]]) -> None:
        """A loop over rows; the body gets the function from a first row to a pointer name, and a name prefix."""
        if not rows:
            return
        self._loops += 1
        n = f"l{self._loops}"
        blocks = -(-rows * self.frame.shape.lanes // WIDE)
        pointers: list[str] = []

        def pointer(row: int) -> str:
            name = f"%{n}.p{len(pointers)}"
            pointers.append(
                f"  {name}.base = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(row)}\n"
                f"  {name} = getelementptr inbounds {V}, ptr {name}.base, i64 %{n}.i"
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

    def evaluate(self, function: Function, name: str, time: str, otherwise: str = "dead") -> None:
        """Call a function of the program."""
        self.lines.append(f"  call void @{name}(ptr %w, ptr %tables, double {time})")
        if has_solve(function):
            self.go_on_if_alive(otherwise)

    def go_on_if_alive(self, otherwise: str = "dead") -> None:
        """Leave where no lane is alive."""
        self._checks += 1
        self.lines += [
            f"  %alive{self._checks} = call i1 @is.alive(ptr %w)",
            f"  br i1 %alive{self._checks}, label %go{self._checks}, label %{otherwise}",
            f"go{self._checks}:",
        ]

    def advance(self, target: str, start: str, rate: str, factor: str, first: int, rows: int) -> None:
        """Set target = start + factor * rate over some rows of the state regions."""
        regions = self.frame.regions

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            to, x, f = (pointer(regions[region] + first) for region in (target, start, rate))
            return [
                f"  {n}.x = load {V}, ptr {x}, align 64",
                f"  {n}.f = load {V}, ptr {f}, align 64",
                *spread(f"{n}.h", factor),
                f"  {n}.d = fmul {V} {n}.f, {n}.h",
                f"  {n}.y = fadd {V} {n}.x, {n}.d",
                f"  store {V} {n}.y, ptr {to}, align 64",
            ]

        self.over(first, rows, body)

    def add_powers(self, span: str) -> None:
        """Add POWER over a span of time to the integrals."""
        regions = self.frame.regions
        self.module.declare(f"llvm.fabs.v{WIDE}f64", f"declare {V} @llvm.fabs.v{WIDE}f64({V})")

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            p, total, size = (pointer(regions[name]) for name in (Array.POWER, "integral", "activity"))
            return [
                f"  {n}.p = load {V}, ptr {p}, align 64",
                f"  {n}.i0 = load {V}, ptr {total}, align 64",
                f"  {n}.a0 = load {V}, ptr {size}, align 64",
                *spread(f"{n}.h", span),
                f"  {n}.d = fmul {V} {n}.p, {n}.h",
                f"  {n}.i1 = fadd {V} {n}.i0, {n}.d",
                f"  {n}.s = call {V} @llvm.fabs.v{WIDE}f64({V} {n}.d)",
                f"  {n}.a1 = fadd {V} {n}.a0, {n}.s",
                f"  store {V} {n}.i1, ptr {total}, align 64",
                f"  store {V} {n}.a1, ptr {size}, align 64",
            ]

        self.over(regions[Array.POWER], self.program.layout.lengths.get(Array.POWER, 0), body)

    def fill(self, region: str, scalar: str) -> None:
        """Let every lane of a region of one row have the same number."""

        def body(pointer: Callable[[int], str], n: str) -> list[str]:
            return [
                *spread(f"{n}.all", scalar),
                f"  store {V} {n}.all, ptr {pointer(self.frame.regions[region])}, align 64",
            ]

        self.over(self.frame.regions[region], 1, body)

    def copy(self, target: str, source: str, rows: int) -> None:
        """Copy rows of one region to another."""
        size = self.frame.offset(rows)
        if not size:
            return
        self._copies += 1
        n = f"%copy{self._copies}"
        self.lines += [
            f"  {n}.to = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(self.frame.regions[target])}",
            f"  {n}.from = getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(self.frame.regions[source])}",
            f"  call void @llvm.memcpy.p0.p0.i64(ptr align 64 {n}.to, ptr align 64 {n}.from, i64 {size}, i1 false)",
        ]

    def set_step(self) -> None:
        """Let the functions of an implicit step know its length."""
        text = Text(self.module)
        text.store_row(self.frame.row(Array.STEP, 0), text.spread("%h"))
        self.lines += text.lines
