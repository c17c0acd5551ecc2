"""Immutable scalar expressions, shared by construction.

Two expressions that are built alike are the same object, so `==` compares structure, hashing is cheap and a
common subexpression is computed once in generated code. Model comparisons (`<`, `>`, `equals`) give
conditions, which are expressions too; using one as a Python truth value is an error that points to `where`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import StrEnum
from operator import is_
from threading import RLock
from typing import Any, NoReturn
from weakref import ref

from propermodel.diagnostics import ModelError, Path


class Op(StrEnum):
    """The kinds of expression node."""

    CONSTANT = "constant"  # data: (value, unit)
    SYMBOL = "symbol"  # data: Symbol
    ADD = "+"
    SUBTRACT = "-"
    MULTIPLY = "*"
    DIVIDE = "/"
    POWER = "**"  # the exponent is a constant
    NEGATE = "neg"
    ABSOLUTE = "abs"
    SIGN = "sign"
    SQUARE_ROOT = "sqrt"
    EXPONENTIAL = "exp"
    LOGARITHM = "log"
    SINE = "sin"
    COSINE = "cos"
    TANH = "tanh"
    ARCTANGENT = "atan2"
    FLOOR = "floor"
    MINIMUM = "min"
    MAXIMUM = "max"
    LESS = "<"
    LESS_EQUAL = "<="
    EQUAL = "=="
    AND = "and"
    OR = "or"
    NOT = "not"
    WHERE = "where"  # condition, value if true, value if false
    LOOKUP = "lookup"  # table symbol, one or two coordinates
    SLOPE = "slope"  # data: axis; derivative of a lookup along one coordinate


CONDITIONS = frozenset({Op.LESS, Op.LESS_EQUAL, Op.EQUAL, Op.AND, Op.OR, Op.NOT})


class SymbolKind(StrEnum):
    """What a symbol stands for; together with its path it is the symbol's identity."""

    TIME = "time"
    PARAMETER = "parameter"
    TABLE = "table"
    EFFORT = "effort"
    FLOW = "flow"
    POWER = "power"
    DISPLACEMENT = "displacement"
    MOMENTUM = "momentum"
    SIGNAL = "signal"
    STATE = "state"
    DISCRETE = "discrete"
    RATE = "rate"
    UNKNOWN = "unknown"


class Symbol:
    """The identity of a symbol leaf: its kind and path; the unit is carried along."""

    __slots__ = ("_hash", "kind", "path", "unit")

    def __init__(self, kind: SymbolKind, path: Path, unit: str = "") -> None:
        self.kind = kind
        self.path = path
        self.unit = unit
        self._hash = hash((kind, path, unit))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Symbol)
            and self.kind is other.kind
            and self.path == other.path
            and self.unit == other.unit
        )

    def __hash__(self) -> int:
        return self._hash

    def __repr__(self) -> str:
        return f"{self.kind}:{self.path}"


class _Interned(ref["Expr"]):
    """A weak reference to a node, which knows the key it is found by."""

    __slots__ = ("key",)
    key: tuple[Any, ...]


# A plain dictionary of weak references: most of the time of building a model is spent looking nodes up.
_interned: dict[tuple[Any, ...], _Interned] = {}
# Models are compiled in several threads at once. A node may be given up while its thread holds the lock.
_interning = RLock()


def _forget(reference: _Interned) -> None:
    with _interning:
        if _interned.get(reference.key) is reference:
            del _interned[reference.key]


class Expr:
    """A scalar expression of numbers, symbols and functions."""

    __slots__ = ("__weakref__", "args", "data", "known_leaves", "op")
    op: Op
    args: tuple[Expr, ...]
    data: Any
    known_leaves: tuple[Expr, ...] | None  # of a node with arguments, once somebody has asked for them

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"expressions are immutable; cannot set '{name}'")

    def __bool__(self) -> bool:
        raise ModelError.of(
            "expression/truth-value",
            "an expression has no truth value while a model is being described",
            help="write where(condition, a, b) instead of 'if', and & | ~ instead of 'and or not'",
        )

    @property
    def is_condition(self) -> bool:
        """Whether the value is true or false rather than a number."""
        return self.op in CONDITIONS

    def __add__(self, other: ExprLike) -> Expr:
        return add(self, other)

    def __radd__(self, other: ExprLike) -> Expr:
        return add(other, self)

    def __sub__(self, other: ExprLike) -> Expr:
        return subtract(self, other)

    def __rsub__(self, other: ExprLike) -> Expr:
        return subtract(other, self)

    def __mul__(self, other: ExprLike) -> Expr:
        return multiply(self, other)

    def __rmul__(self, other: ExprLike) -> Expr:
        return multiply(other, self)

    def __truediv__(self, other: ExprLike) -> Expr:
        return divide(self, other)

    def __rtruediv__(self, other: ExprLike) -> Expr:
        return divide(other, self)

    def __pow__(self, exponent: float) -> Expr:
        return power(self, exponent)

    def __neg__(self) -> Expr:
        return negate(self)

    def __pos__(self) -> Expr:
        return self

    def __abs__(self) -> Expr:
        return absolute(self)

    def __lt__(self, other: ExprLike) -> Expr:
        return less(self, other)

    def __le__(self, other: ExprLike) -> Expr:
        return less_equal(self, other)

    def __gt__(self, other: ExprLike) -> Expr:
        return less(other, self)

    def __ge__(self, other: ExprLike) -> Expr:
        return less_equal(other, self)

    def __and__(self, other: Expr) -> Expr:
        return both(self, other)

    def __or__(self, other: Expr) -> Expr:
        return either(self, other)

    def __invert__(self) -> Expr:
        return negation(self)

    def __repr__(self) -> str:
        from propermodel.expressions.printing import short_text

        return short_text(self)


ExprLike = Expr | float | int


def intern_node(op: Op, args: tuple[Expr, ...], data: Any = None) -> Expr:
    """The one node of this kind with these arguments, without simplification."""
    key = (op, args, data)
    reference = _interned.get(key)
    if reference is not None:
        found = reference()
        if found is not None:
            return found
    node = object.__new__(Expr)
    assign = object.__setattr__
    assign(node, "op", op)
    assign(node, "args", args)
    assign(node, "data", data)
    assign(node, "known_leaves", None)
    reference = _Interned(node, _forget)
    reference.key = key
    with _interning:
        earlier = _interned.get(key)
        found = None if earlier is None else earlier()
        if found is not None:  # another thread was faster
            return found
        _interned[key] = reference
    return node


def constant(value: float, unit: str = "") -> Expr:
    """A number in SI base of `unit`; without a unit it is dimensionless."""
    # -0.0 and 0.0 are one key, which the arithmetic of models never tells apart.
    return intern_node(Op.CONSTANT, (), (float(value), unit))


def symbol(kind: SymbolKind, path: Path, unit: str = "") -> Expr:
    """A named leaf."""
    return intern_node(Op.SYMBOL, (), Symbol(kind, path, unit))


ZERO = constant(0.0)
ONE = constant(1.0)
MINUS_ONE = constant(-1.0)
TIME = symbol(SymbolKind.TIME, Path(("time",)), "s")


def as_expr(value: ExprLike) -> Expr:
    """The expression itself, or a number as a dimensionless constant."""
    if isinstance(value, Expr):
        return value
    # NumPy scalars are floats by conversion; anything else is a mistake at the author's line.
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise TypeError(f"expected a number or an expression, got {type(value).__name__}")
    return constant(float(value))


def number(expr: Expr) -> float | None:
    """The value of a bare (dimensionless) constant, otherwise None."""
    if expr.op is Op.CONSTANT and expr.data[1] == "":
        return expr.data[0]
    return None


def is_zero(expr: Expr) -> bool:
    """Whether this is the constant zero, with or without a unit."""
    return expr.op is Op.CONSTANT and expr.data[0] == 0.0


def add(a: ExprLike, b: ExprLike) -> Expr:
    """The sum a + b."""
    x, y = as_expr(a), as_expr(b)
    if is_zero(x):
        return y
    if is_zero(y):
        return x
    if y.op is Op.NEGATE:
        return subtract(x, y.args[0])
    if x.op is Op.NEGATE:
        return subtract(y, x.args[0])
    m, n = number(x), number(y)
    if m is not None and n is not None:
        return constant(m + n)
    return intern_node(Op.ADD, (x, y))


def subtract(a: ExprLike, b: ExprLike) -> Expr:
    """The difference a - b."""
    x, y = as_expr(a), as_expr(b)
    if is_zero(y):
        return x
    if is_zero(x):
        return negate(y)
    if x is y:
        return ZERO
    if y.op is Op.NEGATE:
        return add(x, y.args[0])
    m, n = number(x), number(y)
    if m is not None and n is not None:
        return constant(m - n)
    return intern_node(Op.SUBTRACT, (x, y))


def multiply(a: ExprLike, b: ExprLike) -> Expr:
    """The product a b."""
    x, y = as_expr(a), as_expr(b)
    if is_zero(x) or is_zero(y):
        return ZERO
    m, n = number(x), number(y)
    if m is not None and n is not None:
        return constant(m * n)
    if m == 1.0:
        return y
    if n == 1.0:
        return x
    if m == -1.0:
        return negate(y)
    if n == -1.0:
        return negate(x)
    if x.op is Op.NEGATE and y.op is Op.NEGATE:
        return multiply(x.args[0], y.args[0])
    if x.op is Op.NEGATE:
        return negate(multiply(x.args[0], y))
    if y.op is Op.NEGATE:
        return negate(multiply(x, y.args[0]))
    if y.op is Op.DIVIDE and y.args[0] is ONE:
        return divide(x, y.args[1])
    if x.op is Op.DIVIDE and x.args[0] is ONE:
        return divide(y, x.args[1])
    return intern_node(Op.MULTIPLY, (x, y))


def divide(a: ExprLike, b: ExprLike) -> Expr:
    """The quotient a / b."""
    x, y = as_expr(a), as_expr(b)
    if is_zero(y):
        raise ZeroDivisionError("division of an expression by the constant zero")
    if is_zero(x):
        return ZERO
    m, n = number(x), number(y)
    if m is not None and n is not None:
        return constant(m / n)
    if n == 1.0:
        return x
    if n == -1.0:
        return negate(x)
    if x is y:
        return ONE
    if x.op is Op.NEGATE:
        return negate(divide(x.args[0], y))
    if y.op is Op.NEGATE:
        return negate(divide(x, y.args[0]))
    return intern_node(Op.DIVIDE, (x, y))


def power(base: ExprLike, exponent: float) -> Expr:
    """The power of an expression with a constant exponent."""
    if isinstance(exponent, Expr):
        value = number(exponent)
        if value is None:
            raise TypeError("an exponent must be a number; write exp(y * log(x)) for a variable one")
        exponent = value
    x = as_expr(base)
    if exponent == 0.0:
        return ONE
    if exponent == 1.0:
        return x
    m = number(x)
    if m is not None:
        return constant(m**exponent)
    return intern_node(Op.POWER, (x, constant(exponent)))


def negate(a: ExprLike) -> Expr:
    """The expression with the opposite sign."""
    x = as_expr(a)
    if x.op is Op.CONSTANT:
        return constant(-x.data[0] if x.data[0] else 0.0, x.data[1])
    if x.op is Op.NEGATE:
        return x.args[0]
    if x.op is Op.SUBTRACT:
        return intern_node(Op.SUBTRACT, (x.args[1], x.args[0]))
    return intern_node(Op.NEGATE, (x,))


def _unary(op: Op, function: Callable[[float], float]) -> Callable[[ExprLike], Expr]:
    def build(a: ExprLike) -> Expr:
        x = as_expr(a)
        value = number(x)
        if value is not None:
            return constant(function(value))
        return intern_node(op, (x,))

    build.__doc__ = f"The function {op} of an expression."
    return build


def _sign(x: float) -> float:
    return (x > 0) - (x < 0)


absolute = _unary(Op.ABSOLUTE, abs)
sign = _unary(Op.SIGN, _sign)
sqrt = _unary(Op.SQUARE_ROOT, math.sqrt)
exp = _unary(Op.EXPONENTIAL, math.exp)
log = _unary(Op.LOGARITHM, math.log)
sin = _unary(Op.SINE, math.sin)
cos = _unary(Op.COSINE, math.cos)
tanh = _unary(Op.TANH, math.tanh)
floor = _unary(Op.FLOOR, math.floor)


def _binary(op: Op, function: Callable[[float, float], float]) -> Callable[[ExprLike, ExprLike], Expr]:
    def build(a: ExprLike, b: ExprLike) -> Expr:
        x, y = as_expr(a), as_expr(b)
        m, n = number(x), number(y)
        if m is not None and n is not None:
            return constant(function(m, n))
        return intern_node(op, (x, y))

    build.__doc__ = f"The function {op} of two expressions."
    return build


atan2 = _binary(Op.ARCTANGENT, math.atan2)
_minimum = _binary(Op.MINIMUM, min)
_maximum = _binary(Op.MAXIMUM, max)


def atan(a: ExprLike) -> Expr:
    """The angle whose tangent is `a`."""
    return atan2(a, 1.0)


def tan(a: ExprLike) -> Expr:
    """The tangent of an angle."""
    return sin(a) / cos(a)


def minimum(*values: ExprLike) -> Expr:
    """The smallest of the values."""
    result = as_expr(values[0])
    for value in values[1:]:
        result = _minimum(result, value)
    return result


def maximum(*values: ExprLike) -> Expr:
    """The largest of the values."""
    result = as_expr(values[0])
    for value in values[1:]:
        result = _maximum(result, value)
    return result


def clip(value: ExprLike, low: ExprLike, high: ExprLike) -> Expr:
    """The value, held between `low` and `high`."""
    return _minimum(_maximum(value, low), high)


def _comparison(op: Op) -> Callable[[ExprLike, ExprLike], Expr]:
    def build(a: ExprLike, b: ExprLike) -> Expr:
        return intern_node(op, (as_expr(a), as_expr(b)))

    build.__doc__ = f"The condition a {op} b."
    return build


less = _comparison(Op.LESS)
less_equal = _comparison(Op.LESS_EQUAL)
equals = _comparison(Op.EQUAL)


def _condition(value: object) -> Expr:
    if not isinstance(value, Expr) or not value.is_condition:
        raise TypeError(f"expected a condition such as 'x > 0', got {value!r}")
    return value


def both(a: Expr, b: Expr) -> Expr:
    """The condition that holds when both conditions hold."""
    return intern_node(Op.AND, (_condition(a), _condition(b)))


def either(a: Expr, b: Expr) -> Expr:
    """The condition that holds when one of the conditions holds."""
    return intern_node(Op.OR, (_condition(a), _condition(b)))


def negation(a: Expr) -> Expr:
    """The condition that holds when `a` does not."""
    if _condition(a).op is Op.NOT:
        return a.args[0]
    return intern_node(Op.NOT, (a,))


def where(condition: Expr, if_true: ExprLike, if_false: ExprLike) -> Expr:
    """The value `if_true` where the condition holds, `if_false` elsewhere."""
    x, y = as_expr(if_true), as_expr(if_false)
    if x is y:
        return x
    return intern_node(Op.WHERE, (_condition(condition), x, y))


def lookup(table: Expr, *coordinates: ExprLike) -> Expr:
    """The linear interpolation of a table at one or two coordinates."""
    return intern_node(Op.LOOKUP, (table, *(as_expr(c) for c in coordinates)))


def slope(table: Expr, axis: int, *coordinates: ExprLike) -> Expr:
    """The derivative of a table's interpolation along coordinate `axis`, one-sided at grid points."""
    return intern_node(Op.SLOPE, (table, *(as_expr(c) for c in coordinates)), axis)


_BUILDERS: dict[Op, Callable[..., Expr]] = {
    Op.ADD: add,
    Op.SUBTRACT: subtract,
    Op.MULTIPLY: multiply,
    Op.DIVIDE: divide,
    Op.POWER: power,
    Op.NEGATE: negate,
    Op.ABSOLUTE: absolute,
    Op.SIGN: sign,
    Op.SQUARE_ROOT: sqrt,
    Op.EXPONENTIAL: exp,
    Op.LOGARITHM: log,
    Op.SINE: sin,
    Op.COSINE: cos,
    Op.TANH: tanh,
    Op.FLOOR: floor,
    Op.ARCTANGENT: atan2,
    Op.MINIMUM: _minimum,
    Op.MAXIMUM: _maximum,
    Op.LESS: less,
    Op.LESS_EQUAL: less_equal,
    Op.EQUAL: equals,
    Op.AND: both,
    Op.OR: either,
    Op.NOT: negation,
    Op.WHERE: where,
    Op.LOOKUP: lookup,
}


def rebuild(op: Op, args: Sequence[Expr], data: Any = None) -> Expr:
    """A node of this kind from new arguments, simplified as the operators do."""
    if op is Op.SLOPE:
        return slope(args[0], data, *args[1:])
    builder = _BUILDERS.get(op)
    return builder(*args) if builder else intern_node(op, tuple(args), data)


def postorder(roots: Iterable[Expr]) -> list[Expr]:
    """Every node below the roots once, arguments before their users."""
    seen: set[Expr] = set()
    order: list[Expr] = []
    for root in roots:
        stack = [root]
        while stack:
            node = stack[-1]
            if node not in seen:
                missing = [arg for arg in node.args if arg not in seen]
                if missing:
                    missing.reverse()
                    stack.extend(missing)
                    continue
                seen.add(node)
                order.append(node)
            stack.pop()
    return order


def leaves(*roots: Expr) -> tuple[Expr, ...]:
    """The symbols below the roots, in order of first appearance; those of one root are remembered."""
    is_single = len(roots) == 1
    if is_single:
        (root,) = roots
        if not root.args:
            return () if root.op is Op.CONSTANT else (root,)
        if root.known_leaves is not None:
            return root.known_leaves
    seen: set[Expr] = set()
    found: list[Expr] = []
    stack = list(reversed(roots))
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if not node.args:
            if node.op is not Op.CONSTANT:
                found.append(node)
        elif node.known_leaves is not None:
            stack.extend(node.known_leaves[::-1])
        else:
            stack.extend(node.args[::-1])
    answer = tuple(found)
    if is_single:
        object.__setattr__(roots[0], "known_leaves", answer)
    return answer


class Substitution:
    """Replaces leaves or subexpressions; remembers what it has done, so shared parts are visited once."""

    def __init__(self, mapping: Mapping[Expr, Expr]) -> None:
        self._done: dict[Expr, Expr] = dict(mapping)

    def define(self, leaf: Expr, expr: Expr) -> Expr:
        """Replace a further leaf by an expression (itself completed first); gives the completed expression.

        The leaf must not have been met before.
        """
        value = self(expr)
        self._done[leaf] = value
        return value

    def __call__(self, expr: Expr) -> Expr:
        """The expression with the replacements made."""
        done = self._done
        stack = [expr]
        while stack:
            node = stack[-1]
            if node not in done:
                missing = [arg for arg in node.args if arg not in done]
                if missing:
                    stack.extend(missing)
                    continue
                new = [done[arg] for arg in node.args]
                is_same = all(map(is_, new, node.args))
                done[node] = node if is_same else rebuild(node.op, new, node.data)
            stack.pop()
        return done[expr]


def substitute(expr: Expr, mapping: Mapping[Expr, Expr]) -> Expr:
    """The expression with leaves or subexpressions replaced."""
    return Substitution(mapping)(expr)
