# pyright: basic
"""Prints table look-ups: the cell of the coordinates, then the polynomial of the cell; see `tables.py`.

Every look-up keeps its last cell (limits, reference point and coefficients, for each lane) among the numbers of the
run, as coordinates seldom leave a cell within a step: a search is the exception, and values do not depend on it.
"""

from __future__ import annotations

from propermodel.codegen.llvm_text import Module, Shape, Text, literal
from propermodel.codegen.program import Extrapolation
from propermodel.expressions.core import Expr, Op

DESCRIPTOR_WORDS = 16  # of a table: its axes, then the pointer to its cells
AXIS_WORDS = 6  # pairs, points, start, density, low, high
_CONSTANT = "!invariant.load !0"  # tables do not change during a call
_AXIS_ITEMS = 3  # of a kept cell, per axis: lower and upper limit, reference point; then come the coefficients


class TableText:
    """Prints the look-ups of one function; a cell that is needed again is not looked for again."""

    def __init__(self, text: Text) -> None:
        self._layout = text.frame.layout
        self._text = text
        self._tables: dict[int, str] = {}
        self._limits: dict[tuple[int, int, Shape], str] = {}
        self._cells: dict[tuple[Expr | Shape, ...], tuple[list[str], list[str]]] = {}

    def look_up(self, node: Expr, coordinates: list[str], text: Text) -> str:
        """The interpolation of a table, or its slope."""
        c, away = self._cell(node.args[0], node.args[1:], coordinates, text)

        def combine(constant: str, factor: str, distance: str) -> str:
            return text.add(constant, text.multiply(factor, distance))

        if len(away) == 1:
            return combine(c[0], c[1], away[0]) if node.op is Op.LOOKUP else c[1]
        if node.op is Op.LOOKUP:
            return combine(combine(c[0], c[1], away[0]), combine(c[2], c[3], away[0]), away[1])
        return combine(c[1], c[3], away[1]) if node.data == 0 else combine(c[2], c[3], away[0])

    def _cell(
        self, table: Expr, nodes: tuple[Expr, ...], coordinates: list[str], text: Text
    ) -> tuple[list[str], list[str]]:
        """The coefficients of the cell, and the distances from its reference point."""
        key = (table, *nodes, text.shape)
        if key not in self._cells:
            self._cells[key] = self._find(self._layout.table_index[table], coordinates, text)
        return self._cells[key]

    def _find(self, index: int, coordinates: list[str], text: Text) -> tuple[list[str], list[str]]:
        slot = self._layout.tables[index]
        axes = len(coordinates)
        items = _AXIS_ITEMS * axes + 2 * axes
        stride = 8 * text.shape.lanes
        place = text.frame.offset(text.frame.new_row(-(-items * stride // text.frame.offset(1))))
        site = text.emit(f"getelementptr inbounds i8, ptr %w, i64 {place}")
        passed = ", ".join(f"{text.kind} {coordinate}" for coordinate in coordinates)
        name = site_function(text.module, text.shape, axes, slot.is_uniform)
        text.do(f"call void @{name}(ptr {self._table(index)}, ptr {site}, {passed})")
        kept = {
            item: _load(text, site, stride * item)
            for item in range(items)
            if item >= _AXIS_ITEMS * axes or item % _AXIS_ITEMS == 2
        }
        away: list[str] = []
        holds = slot.extrapolation is Extrapolation.HOLD
        for axis, coordinate in enumerate(coordinates):
            held = self._held(index, AXIS_WORDS * axis, coordinate, text) if holds else coordinate
            away.append(text.subtract(held, kept[_AXIS_ITEMS * axis + 2]))
        return [kept[item] for item in range(_AXIS_ITEMS * axes, items)], away

    def _held(self, index: int, first: int, coordinate: str, text: Text) -> str:
        for word, test in ((4, "olt"), (5, "ogt")):
            key = (index, first + word, text.shape)
            if key not in self._limits:
                at = text.emit(f"getelementptr inbounds i64, ptr {self._table(index)}, i64 {first + word}")
                self._limits[key] = text.spread(text.emit(f"load double, ptr {at}, align 8, {_CONSTANT}"))
            limit = self._limits[key]
            coordinate = text.choose(text.compare(test, coordinate, limit), limit, coordinate)
        return coordinate

    def _table(self, index: int) -> str:
        if index not in self._tables:
            place = DESCRIPTOR_WORDS * index
            self._tables[index] = self._text.emit(f"getelementptr inbounds i64, ptr %tables, i64 {place}")
        return self._tables[index]


def _load(text: Text, base: str, offset: int) -> str:
    at = text.emit(f"getelementptr inbounds i8, ptr {base}, i64 {offset}")
    return text.emit(f"load {text.kind}, ptr {at}, align 8")


def site_function(module: Module, shape: Shape, axes: int, is_uniform: bool) -> str:
    """The name of the function that makes sure that a kept cell is that of the coordinates."""
    name = f"cell{axes}.{'uniform' if is_uniform else 'any'}.{shape.suffix}"
    if name not in module.declared:
        parameters = ["ptr %table", "ptr %site", *(f"{shape.number} %u{axis}" for axis in range(axes))]
        module.declare(f"{name}.miss", _miss(module, shape, f"{name}.miss", parameters, axes, is_uniform))
        module.declare(name, _check(module, shape, name, parameters, axes))
    return name


def _check(module: Module, shape: Shape, name: str, parameters: list[str], axes: int) -> str:
    text = Text(module, shape)
    inside = shape.truth_constant(True)
    for axis in range(axes):
        lower, upper = (_load(text, "%site", 8 * shape.lanes * (_AXIS_ITEMS * axis + i)) for i in range(2))
        inside = text.both(inside, text.compare("oge", f"%u{axis}", lower))
        inside = text.both(inside, text.compare("olt", f"%u{axis}", upper))
    is_miss = text.any(text.opposite(inside))
    text.do(f"br i1 {is_miss}, label %miss, label %end, !prof !1")
    text.label("miss")
    text.do(f"call void @{name}.miss({', '.join(parameters)})")
    text.do("br label %end")
    text.label("end")
    text.do("ret void")
    return _define(name, parameters, text, "alwaysinline")


def _miss(module: Module, shape: Shape, name: str, parameters: list[str], axes: int, is_uniform: bool) -> str:
    text = Text(module, shape)
    stride = 8 * shape.lanes
    find = "uniform" if is_uniform else "bisect"
    for lane in range(shape.lanes):
        site = text.emit(f"getelementptr inbounds i8, ptr %site, i64 {8 * lane}")
        numbers: list[str] = []
        for axis in range(axes):
            grid = text.emit(f"getelementptr inbounds i64, ptr %table, i64 {AXIS_WORDS * axis}")
            numbers.append(text.emit(f"call i64 @cell.{find}(ptr {grid}, double {text.part(f'%u{axis}', lane)})"))
            limits = text.emit(f"getelementptr inbounds i8, ptr {site}, i64 {stride * _AXIS_ITEMS * axis}")
            text.do(f"call void @cell.limits(ptr {grid}, i64 {numbers[-1]}, ptr {limits}, i64 {stride})")
        place = numbers[0]
        if axes == 2:
            points_at = text.emit(f"getelementptr inbounds i64, ptr %table, i64 {AXIS_WORDS + 1}")
            width = text.emit(f"add i64 {text.emit(f'load i64, ptr {points_at}')}, 1")
            place = text.emit(f"add i64 {text.emit(f'mul i64 {place}, {width}')}, {numbers[1]}")
        cells_at = text.emit(f"getelementptr inbounds i64, ptr %table, i64 {2 * AXIS_WORDS}")
        cells = text.emit(f"load ptr, ptr {cells_at}")
        start = text.emit(f"getelementptr inbounds [{2 * axes} x double], ptr {cells}, i64 {place}")
        for item in range(2 * axes):
            source = text.emit(f"getelementptr inbounds double, ptr {start}, i64 {item}")
            target = text.emit(f"getelementptr inbounds i8, ptr {site}, i64 {stride * (_AXIS_ITEMS * axes + item)}")
            text.do(f"store double {text.emit(f'load double, ptr {source}')}, ptr {target}")
    text.do("ret void")
    return _define(name, parameters, text, "noinline cold")


def _define(name: str, parameters: list[str], text: Text, attributes: str) -> str:
    body = "\n".join(text.lines)
    return f"define internal void @{name}({', '.join(parameters)}) {attributes} {{\n{body}\n}}"


# The number of the cell of a coordinate along an axis, computed or searched for, and the limits of a cell.
TABLE_FUNCTIONS = f"""
define internal i64 @cell.uniform(ptr %axis, double %u) {{
  %pairs = load ptr, ptr %axis
  %points.at = getelementptr inbounds i64, ptr %axis, i64 1
  %points = load i64, ptr %points.at
  %start.at = getelementptr inbounds i64, ptr %axis, i64 2
  %start = load double, ptr %start.at
  %density.at = getelementptr inbounds i64, ptr %axis, i64 3
  %density = load double, ptr %density.at
  %away = fsub double %u, %start
  %scaled = fmul double %away, %density
  %shifted = fadd double %scaled, {literal(1.0)}
  %is.inside = fcmp ogt double %shifted, {literal(0.0)}
  %not.below = select i1 %is.inside, double %shifted, double {literal(0.0)}
  %most = sitofp i64 %points to double
  %is.above = fcmp ogt double %not.below, %most
  %clamped = select i1 %is.above, double %most, double %not.below
  %guess = fptosi double %clamped to i64
  %lower.at = getelementptr inbounds [2 x double], ptr %pairs, i64 %guess
  %upper.at = getelementptr inbounds [2 x double], ptr %lower.at, i64 1
  %lower = load double, ptr %lower.at
  %upper = load double, ptr %upper.at
  %is.low = fcmp olt double %u, %lower
  %is.over = fcmp oge double %u, %upper
  %has.next = icmp slt i64 %guess, %points
  %is.high = and i1 %is.over, %has.next
  %down = sext i1 %is.low to i64
  %up = zext i1 %is.high to i64
  %corrected = add i64 %guess, %down
  %result = add i64 %corrected, %up
  ret i64 %result
}}

define internal i64 @cell.bisect(ptr %axis, double %u) {{
entry:
  %pairs = load ptr, ptr %axis
  %points.at = getelementptr inbounds i64, ptr %axis, i64 1
  %points = load i64, ptr %points.at
  br label %loop
loop:
  %low = phi i64 [ 0, %entry ], [ %low.next, %body ]
  %high = phi i64 [ %points, %entry ], [ %high.next, %body ]
  %is.done = icmp uge i64 %low, %high
  br i1 %is.done, label %end, label %body
body:
  %sum = add i64 %low, %high
  %middle = lshr i64 %sum, 1
  %above = add i64 %middle, 1
  %at = getelementptr inbounds [2 x double], ptr %pairs, i64 %above
  %edge = load double, ptr %at
  %is.not.above = fcmp ole double %edge, %u
  %low.next = select i1 %is.not.above, i64 %above, i64 %low
  %high.next = select i1 %is.not.above, i64 %high, i64 %middle
  br label %loop
end:
  ret i64 %low
}}

define internal void @cell.limits(ptr %axis, i64 %cell, ptr %to, i64 %stride) {{
  %pairs = load ptr, ptr %axis
  %lower.at = getelementptr inbounds [2 x double], ptr %pairs, i64 %cell
  %upper.at = getelementptr inbounds [2 x double], ptr %lower.at, i64 1
  %reference.at = getelementptr inbounds double, ptr %lower.at, i64 1
  %lower = load double, ptr %lower.at
  %upper = load double, ptr %upper.at
  %reference = load double, ptr %reference.at
  %to.upper = getelementptr inbounds i8, ptr %to, i64 %stride
  %to.reference = getelementptr inbounds i8, ptr %to.upper, i64 %stride
  store double %lower, ptr %to
  store double %upper, ptr %to.upper
  store double %reference, ptr %to.reference
  ret void
}}

!0 = !{{}}
!1 = !{{!"branch_weights", i32 1, i32 100}}
"""
