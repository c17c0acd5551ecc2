# pyright: basic
"""Prints the nodes of expressions, with what depends on time alone computed once for all lanes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from propermodel.codegen.llvm_math import call_math, call_power
from propermodel.codegen.llvm_tables import TableText
from propermodel.codegen.llvm_text import SCALAR, Module, Shape, Text, literal
from propermodel.codegen.program import Array
from propermodel.codegen.schedule import leaf_slot, power_plan, whole_power
from propermodel.expressions.core import Expr, Op


class Value(NamedTuple):
    """An LLVM value: a number or a truth, one per lane or (uniform) one for all."""

    text: str
    is_truth: bool = False
    is_uniform: bool = False


_ARITHMETIC = {Op.ADD: "fadd", Op.SUBTRACT: "fsub", Op.MULTIPLY: "fmul", Op.DIVIDE: "fdiv"}
_COMPARISON = {Op.LESS: "olt", Op.LESS_EQUAL: "ole", Op.EQUAL: "oeq"}
_CHOICE = {Op.MINIMUM: "ole", Op.MAXIMUM: "oge"}
_LOGIC = {Op.AND: "and", Op.OR: "or"}
_INTRINSIC = {Op.ABSOLUTE: "fabs", Op.SQUARE_ROOT: "sqrt", Op.FLOOR: "floor"}
_MATH = {
    Op.EXPONENTIAL: "exp",
    Op.LOGARITHM: "log",
    Op.SINE: "sin",
    Op.COSINE: "cos",
    Op.TANH: "tanh",
    Op.ARCTANGENT: "atan2",
}


class Block:
    """A run of instructions of one function, and the values known in it."""

    def __init__(self, module: Module, rows: Mapping[Expr, int], shape: Shape | None = None) -> None:
        self.text = Text(module, shape)
        self.values: dict[Expr, Value] = {}
        self._scalar = self.text.in_shape(SCALAR)
        self._layout = module.frame.layout
        self._rows = rows  # nodes kept in memory
        self._spread: dict[str, str] = {}
        self._tables = TableText(self.text)

    def value(self, node: Expr) -> Value:
        """The value of a node that is a leaf, kept in memory, or already computed."""
        known = self.values.get(node)
        if known is None:
            known = self.values[node] = self._outer(node)
        return known

    def number(self, node: Expr) -> str:
        """The value of such a node as one number per lane."""
        return self.fitted(self.value(node))

    def compute(self, node: Expr) -> None:
        """Compute a node whose arguments are available."""
        is_table = node.op in (Op.LOOKUP, Op.SLOPE)
        self.values[node] = self.result(node, [self.value(arg) for arg in (node.args[1:] if is_table else node.args)])

    def result(self, node: Expr, args: list[Value]) -> Value:
        """The value of a node's operation for these arguments; a table has coordinates only."""
        is_uniform = self.text.shape.lanes > 1 and all(arg.is_uniform for arg in args)
        text = self._scalar if is_uniform else self.text
        if node.op in (Op.LOOKUP, Op.SLOPE):
            result = self._tables.look_up(node, [self.fitted(arg, text) for arg in args], text)
        else:
            result = self._operation(node, args, text)
        return Value(result, node.is_condition, is_uniform)

    def compute_together(self, nodes: tuple[Expr, ...]) -> None:
        """Compute nodes of one elementary function, whose arguments are available, in one lane each."""
        wide = self.text.in_shape(Shape(1 << (len(nodes) - 1).bit_length()))
        filled = [nodes[min(lane, len(nodes) - 1)] for lane in range(wide.shape.lanes)]
        arguments: list[str] = []
        for place in range(len(nodes[0].args)):
            argument = "poison"
            for lane, node in enumerate(filled):
                argument = wide.with_part(argument, self.number(node.args[place]), lane)
            arguments.append(argument)
        results = call_math(wide, _MATH[nodes[0].op], *arguments)
        for lane, node in enumerate(nodes):
            self.values[node] = Value(wide.part(results, lane))

    def _outer(self, node: Expr) -> Value:
        if node.op is Op.CONSTANT:
            return Value(literal(node.data[0]), is_uniform=True)
        if node in self._rows:
            kept = self.text.load_row(self._rows[node])
            if node.is_condition:
                return Value(self.text.compare("une", kept, self.text.constant(0.0)), is_truth=True)
            return Value(kept)
        slot = leaf_slot(self._layout, node)
        if slot.array is Array.TIME:
            return Value("%t", is_uniform=True)
        return Value(self.text.load_row(self.text.frame.row(slot.array, slot.index)))

    def fitted(self, value: Value, text: Text | None = None) -> str:
        """A value as numbers of a text's shape, its own if no other is given."""
        text = text or self.text
        if not (value.is_truth or value.is_uniform):
            return value.text
        if value.is_truth:
            own = self._scalar if value.is_uniform else self.text
            number = own.choose(value.text, own.constant(1.0), own.constant(0.0))
            value = Value(number, is_uniform=value.is_uniform)
        if not value.is_uniform or text.shape.lanes == 1:
            return value.text
        if value.text.startswith("0x"):
            return _constant_text(value.text, text.shape)
        if value.text not in self._spread:
            self._spread[value.text] = text.spread(value.text)
        return self._spread[value.text]

    def _truth(self, value: Value, text: Text) -> str:
        if value.is_truth and (text.shape.lanes == 1 or not value.is_uniform):
            return value.text
        return text.compare("une", self.fitted(value, text), text.constant(0.0))

    def _operation(self, node: Expr, args: list[Value], text: Text) -> str:
        op = node.op
        if op in _ARITHMETIC:
            first, second = (self.fitted(arg, text) for arg in args)
            return text.emit(f"{_ARITHMETIC[op]} {text.kind} {first}, {second}")
        if op in _LOGIC:
            first, second = (self._truth(arg, text) for arg in args)
            return text.emit(f"{_LOGIC[op]} {text.shape.truth} {first}, {second}")
        if op is Op.NOT:
            return text.opposite(self._truth(args[0], text))
        if op is Op.WHERE:
            condition = self._truth(args[0], text)
            return text.choose(condition, *(self.fitted(arg, text) for arg in args[1:]))
        numbers = [self.fitted(arg, text) for arg in args]
        if op in _COMPARISON:
            return text.compare(_COMPARISON[op], *numbers)
        if op in _CHOICE:
            return text.choose(text.compare(_CHOICE[op], *numbers), *numbers)
        if op in _INTRINSIC:
            return text.intrinsic(_INTRINSIC[op], *numbers)
        if op in _MATH:
            return call_math(text, _MATH[op], *numbers)
        match op:
            case Op.POWER:
                return _power(text, numbers[0], node.args[1].data[0])
            case Op.NEGATE:
                return text.emit(f"fneg {text.kind} {numbers[0]}")
            case Op.SIGN:
                return _sign(text, numbers[0])
            case _:
                raise ValueError(f"no instruction for '{op}'")


def _constant_text(bits: str, shape: Shape) -> str:
    return "<" + ", ".join(f"double {bits}" for _ in range(shape.lanes)) + ">"


def _sign(text: Text, number: str) -> str:
    zero = text.constant(0.0)
    below = text.choose(text.compare("olt", number, zero), text.constant(-1.0), zero)
    return text.choose(text.compare("ogt", number, zero), text.constant(1.0), below)


def _power(text: Text, base: str, exponent: float) -> str:
    plan = power_plan(exponent)
    if plan is None:
        return call_power(text, base, exponent)
    result = whole_power(base, plan.whole, text.multiply) if plan.whole else None
    if plan.has_root:
        root = text.intrinsic("sqrt", base)
        result = root if result is None else text.multiply(result, root)
    assert result is not None
    return text.divide(text.constant(1.0), result) if plan.is_inverse else result
