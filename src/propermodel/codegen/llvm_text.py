# pyright: basic
"""LLVM IR as text, for any number of lanes: types, memory, instructions.

All numbers of a run live in one block of float64 *rows* with one entry per lane, addressed from one base pointer with
constant offsets, so LLVM knows which accesses are apart. No fast-math flags: a value does not depend on lanes,
inlining or how functions are cut.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

from propermodel.codegen.program import Array, Layout

WIDE = 8  # doubles per operation of loops over whole regions, which are padded to it

ARGUMENTS = "ptr noalias %w, ptr noalias %tables, double %t"
PASSED = "ptr %w, ptr %tables, double %t"


@dataclass(frozen=True)
class Shape:
    """The types of one value per lane."""

    lanes: int

    @cached_property
    def number(self) -> str:
        """The type of numbers."""
        return "double" if self.lanes == 1 else f"<{self.lanes} x double>"

    @cached_property
    def truth(self) -> str:
        """The type of conditions."""
        return "i1" if self.lanes == 1 else f"<{self.lanes} x i1>"

    @cached_property
    def suffix(self) -> str:
        """The type in names of intrinsics."""
        return "f64" if self.lanes == 1 else f"v{self.lanes}f64"

    @cached_property
    def alignment(self) -> int:
        """The alignment of a row in bytes."""
        size = 8 * self.lanes
        return min(size & -size, 64)

    def constant(self, value: float) -> str:
        """The same number in every lane."""
        text = literal(value)
        return text if self.lanes == 1 else "<" + ", ".join(f"double {text}" for _ in range(self.lanes)) + ">"

    def truth_constant(self, value: bool) -> str:
        """The same truth in every lane."""
        text = "true" if value else "false"
        return text if self.lanes == 1 else "<" + ", ".join(f"i1 {text}" for _ in range(self.lanes)) + ">"


SCALAR = Shape(1)


def literal(value: float) -> str:
    """A float64 as its bits."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


@dataclass
class Frame:
    """Where everything is in the block of a run: regions of rows, fixed ones first, then rows taken one by one."""

    shape: Shape
    layout: Layout
    state_rows: Mapping[int, int]  # index of a state to its row within the state regions
    power_rows: Sequence[int] = ()  # of every POWER within its regions; none: as they are numbered
    regions: dict[str, int] = field(default_factory=dict)
    rows: int = 0

    def reserve(self, region: str, count: int) -> None:
        """Give a region its rows, padded so that wide operations may run over its end."""
        self.regions[region] = self.rows
        padded = -(-count * self.shape.lanes // WIDE) * WIDE
        self.rows += -(-padded // self.shape.lanes)
        while self.rows * self.shape.lanes % WIDE:
            self.rows += 1

    def new_row(self, count: int = 1) -> int:
        """A row (or several) of its own."""
        self.rows += count
        return self.rows - count

    def row(self, array: Array, index: int) -> int:
        """The row of one entry of an array."""
        if array in (Array.STATE, Array.RATE, Array.ERROR):
            index = self.state_rows[index]
        elif array is Array.POWER and self.power_rows:
            index = self.power_rows[index]
        return self.regions[array] + index

    def is_in(self, array: Array, row: int) -> bool:
        """Whether a row is one of an array."""
        return 0 <= row - self.regions[array] < self.layout.lengths.get(array, 0)

    def offset(self, row: int) -> int:
        """The offset of a row in bytes."""
        return row * 8 * self.shape.lanes


class Module:
    """The text of one LLVM module, and what its functions have in common."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.functions: list[str] = []
        self.declared: dict[str, str] = {}

    def declare(self, name: str, signature: str) -> str:
        """Declare an outside function once; returns its name."""
        self.declared[name] = signature
        return name

    def text(self) -> str:
        """The whole module."""
        return "\n".join([*self.declared.values(), *self.functions])


class Text:
    """Instructions of one function under construction; the arithmetic is on one number per lane."""

    def __init__(self, module: Module, shape: Shape | None = None) -> None:
        self.module = module
        self.frame = module.frame
        self.shape = shape or module.frame.shape
        self.kind = self.shape.number  # the type of numbers
        self.lines: list[str] = []
        self._addresses: dict[int, str] = {}
        self._numbers = count(1)

    def in_shape(self, shape: Shape) -> Text:
        """The same text, written to with values of another shape."""
        other = copy(self)
        other.shape = shape
        other.kind = shape.number
        return other

    def name(self) -> str:
        """A fresh name."""
        return f"%v{next(self._numbers)}"

    def emit(self, operation: str) -> str:
        """Add an instruction with a result; returns the result's name."""
        name = f"%v{next(self._numbers)}"
        self.lines.append(f"  {name} = {operation}")
        return name

    def do(self, operation: str) -> None:
        """Add an instruction without a result."""
        self.lines.append(f"  {operation}")

    def label(self, name: str) -> None:
        """Begin a basic block."""
        self.lines.append(f"{name}:")

    def address(self, row: int) -> str:
        """The pointer to a row; in a function with branches ask first in its entry block."""
        known = self._addresses.get(row)
        if known is None:
            known = self.emit(f"getelementptr inbounds i8, ptr %w, i64 {self.frame.offset(row)}")
            self._addresses[row] = known
        return known

    def load_row(self, row: int) -> str:
        """The numbers of a row."""
        return self.emit(f"load {self.kind}, ptr {self.address(row)}, align {self.shape.alignment}")

    def store_row(self, row: int, text: str) -> None:
        """Write the numbers of a row."""
        self.do(f"store {self.kind} {text}, ptr {self.address(row)}, align {self.shape.alignment}")

    def subtract_product(self, a: str, b: str, c: str) -> str:
        """The value a - b c."""
        return self.emit(f"fsub {self.kind} {a}, {self.multiply(b, c)}")

    def divide(self, a: str, b: str) -> str:
        """The quotient."""
        return self.emit(f"fdiv {self.kind} {a}, {b}")

    def swapped_if_larger(self, a: list[str], b: list[str]) -> tuple[list[str], list[str]]:
        """Both lists, exchanged where the first entry of `b` is larger in size than that of `a`."""
        is_larger = self.compare("ogt", self.size(b[0]), self.size(a[0]))
        first = [self.choose(is_larger, y, x) for x, y in zip(a, b, strict=True)]
        second = [self.choose(is_larger, x, y) for x, y in zip(a, b, strict=True)]
        return first, second

    def multiply(self, a: str, b: str) -> str:
        """The product."""
        return self.emit(f"fmul {self.kind} {a}, {b}")

    def add(self, a: str, b: str) -> str:
        """The sum."""
        return self.emit(f"fadd {self.kind} {a}, {b}")

    def subtract(self, a: str, b: str) -> str:
        """The difference."""
        return self.emit(f"fsub {self.kind} {a}, {b}")

    def constant(self, value: float) -> str:
        """A number."""
        return self.shape.constant(value)

    def intrinsic(self, name: str, *texts: str) -> str:
        """The result of a generic floating-point intrinsic."""
        full = f"llvm.{name}.{self.shape.suffix}"
        self.module.declare(full, f"declare {self.kind} @{full}({', '.join(self.kind for _ in texts)})")
        return self.emit(f"call {self.kind} @{full}({', '.join(f'{self.kind} {text}' for text in texts)})")

    def size(self, a: str) -> str:
        """The absolute value."""
        return self.intrinsic("fabs", a)

    def compare(self, test: str, a: str, b: str) -> str:
        """Where the comparison holds."""
        return self.emit(f"fcmp {test} {self.kind} {a}, {b}")

    def choose(self, condition: str, a: str, b: str) -> str:
        """One value where the condition holds, the other elsewhere."""
        return self.emit(f"select {self.shape.truth} {condition}, {self.kind} {a}, {self.kind} {b}")

    def both(self, a: str, b: str) -> str:
        """Where both hold."""
        return self.emit(f"and {self.shape.truth} {a}, {b}")

    def opposite(self, a: str) -> str:
        """Where it does not hold."""
        return self.emit(f"xor {self.shape.truth} {a}, {self.shape.truth_constant(True)}")

    def any(self, truth: str) -> str:
        """Whether it holds in any lane, as i1."""
        lanes = self.shape.lanes
        if lanes == 1:
            return truth
        bits = self.emit(f"bitcast <{lanes} x i1> {truth} to i{lanes}")
        return self.emit(f"icmp ne i{lanes} {bits}, 0")

    def variable(self, kind: str) -> str:
        """A local variable."""
        return self.emit(f"alloca {kind}")

    def get(self, kind: str, variable: str) -> str:
        """The value of a local variable."""
        return self.emit(f"load {kind}, ptr {variable}")

    def put(self, kind: str, text: str, variable: str) -> None:
        """Set a local variable."""
        self.do(f"store {kind} {text}, ptr {variable}")

    def spread(self, scalar: str) -> str:
        """The same number in every lane."""
        if self.shape.lanes == 1:
            return scalar
        first = self.emit(f"insertelement {self.kind} poison, double {scalar}, i32 0")
        zeros = f"<{self.shape.lanes} x i32> zeroinitializer"
        return self.emit(f"shufflevector {self.kind} {first}, {self.kind} poison, {zeros}")

    def part(self, text: str, lane: int) -> str:
        """The number of one lane."""
        return text if self.shape.lanes == 1 else self.emit(f"extractelement {self.kind} {text}, i32 {lane}")

    def with_part(self, text: str, part: str, lane: int) -> str:
        """The numbers with that of one lane replaced."""
        if self.shape.lanes == 1:
            return part
        return self.emit(f"insertelement {self.kind} {text}, double {part}, i32 {lane}")

    def counted(self, variable: str) -> str:
        """Count one more; the new count."""
        more = self.emit(f"add i32 {self.get('i32', variable)}, 1")
        self.put("i32", more, variable)
        return more
