"""Expressions in documents: one table of nodes, each stored once and referred to by its number."""

from __future__ import annotations

from propermodel.diagnostics import DocumentError, Path
from propermodel.expressions.core import (
    CONDITIONS,
    ZERO,
    Expr,
    Op,
    Symbol,
    SymbolKind,
    constant,
    intern_node,
    is_zero,
    number,
    symbol,
)
from propermodel.modelling.limits import exceeded
from propermodel.modelling.schema import (
    PATH,
    UNIT,
    Json,
    Place,
    Unreadable,
    as_index,
    as_list,
    described,
    malformed,
    number_data,
    path_text,
    read_number,
)

# Symbols that stand in a model; the others belong to the equations made from it.
_IN_MODELS = {kind.value: kind for kind in SymbolKind if kind not in (SymbolKind.RATE, SymbolKind.UNKNOWN)}

_TWO = frozenset(
    {
        Op.ADD,
        Op.SUBTRACT,
        Op.MULTIPLY,
        Op.DIVIDE,
        Op.POWER,
        Op.ARCTANGENT,
        Op.MINIMUM,
        Op.MAXIMUM,
        Op.LESS,
        Op.LESS_EQUAL,
        Op.EQUAL,
        Op.AND,
        Op.OR,
    }
)
_OPERATIONS = {op.value: op for op in Op if op not in (Op.CONSTANT, Op.SYMBOL)}


class ExpressionTable:
    """The nodes written so far."""

    def __init__(self) -> None:
        self.nodes: list[Json] = []
        self._index: dict[Expr, int] = {}

    def index(self, expr: Expr) -> int:
        """The number of an expression, after writing what is not there yet."""
        stack = [expr]
        while stack:
            node = stack[-1]
            missing = [arg for arg in node.args if arg not in self._index]
            if node in self._index:
                stack.pop()
            elif missing:
                stack.extend(reversed(missing))
            else:
                self._index[node] = len(self.nodes)
                self.nodes.append(self._node(node))
                stack.pop()
        return self._index[expr]

    def _node(self, node: Expr) -> Json:
        if node.op is Op.CONSTANT:
            value, unit = node.data
            return [node.op.value, number_data(value), *([unit] if unit else [])]
        if node.op is Op.SYMBOL:
            data: Symbol = node.data
            if type(data) is not Symbol or data.kind.value not in _IN_MODELS:
                raise malformed("the model", f"the expression mentions '{node!r}', which is not of the model")
            return [node.op.value, data.kind.value, path_text(data.path), data.unit]
        axis = [node.data] if node.op is Op.SLOPE else []
        return [node.op.value, *axis, *(self._index[arg] for arg in node.args)]


def read_expressions(data: Json, place: Place, faults: Unreadable) -> list[Expr]:
    """The expressions of a table of nodes, in its order; zero in place of those that cannot be read."""
    items = as_list(data, place)
    most = place.references.limits.expressions
    if len(items) > most:
        raise exceeded("expressions", f"there are {len(items)} expressions; at most {most} are read", place.text)
    found: list[Expr] = []
    unread: set[int] = set()
    for index, item in enumerate(items):
        try:
            # What is made of a node that cannot be read is no fault of its own.
            if not unread.intersection(_uses(item)):
                found.append(_read_node(item, found, place.item(index)))
                continue
        except DocumentError as error:
            faults.add(error)
        unread.add(index)
        found.append(ZERO)
    return found


def _uses(data: Json) -> list[int]:
    """The nodes that a node may be made of."""
    match data:
        case [str() as name, *rest] if name in _OPERATIONS:
            return [entry for entry in rest if isinstance(entry, int)]
        case _:
            return []


def _read_node(data: Json, before: list[Expr], place: Place) -> Expr:
    items = as_list(data, place)
    match items:
        case [Op.CONSTANT.value, value]:
            return constant(read_number(value, place.item(1)))
        case [Op.CONSTANT.value, value, unit]:
            return constant(read_number(value, place.item(1)), UNIT.read(unit, place.item(2)))
        case [Op.SYMBOL.value, kind, path, unit]:
            return _read_symbol(kind, PATH.read(path, place.item(2)), UNIT.read(unit, place.item(3)), place)
        case [str() as name, *rest] if name in _OPERATIONS:
            return _read_operation(_OPERATIONS[name], rest, before, place)
        case _:
            first = described(items[0]) if items else "an empty list"
            raise place.fault(f"expected a node of an expression, found {first} with {max(len(items) - 1, 0)} values")


def _read_symbol(kind: Json, path: Path, unit: str, place: Place) -> Expr:
    if not isinstance(kind, str) or kind not in _IN_MODELS:
        raise place.item(1).fault(f"expected the kind of a symbol, found {described(kind)}")
    if not path:
        raise place.item(2).fault("expected the path of a symbol")
    return symbol(_IN_MODELS[kind], path, unit)


def _read_operation(op: Op, rest: list[Json], before: list[Expr], place: Place) -> Expr:
    axis = None
    first = 1
    if op is Op.SLOPE:
        if not rest:
            raise place.fault("a slope needs an axis, a table and coordinates")
        axis, first = as_index(rest[0], 2, place.item(1)), 2
        rest = rest[1:]
    args = tuple(before[as_index(i, len(before), place.item(first + n))] for n, i in enumerate(rest))
    _check(op, axis, args, place)
    return intern_node(op, args, axis)


def _check(op: Op, axis: int | None, args: tuple[Expr, ...], place: Place) -> None:
    """Refuse a node that the operators could not have made."""
    if op in (Op.LOOKUP, Op.SLOPE):
        arity = "two or three"
        fits = len(args) in (2, 3) and (axis is None or axis < len(args) - 1)
    else:
        arity = {1: "one", 2: "two", 3: "three"}[3 if op is Op.WHERE else 2 if op in _TWO else 1]
        fits = len(args) == (3 if op is Op.WHERE else 2 if op in _TWO else 1)
    if not fits:
        raise place.fault(f"'{op}' takes {arity} argument{'s' * (arity != 'one')}, {len(args)} were given")
    tables = [_is_table(arg) for arg in args]
    if any(tables[1:]) or tables[0] is not (op in (Op.LOOKUP, Op.SLOPE)):
        raise place.fault(f"'{op}' has a table where a number is due, or a number where a table is due")
    wants = len(args) if op in (Op.AND, Op.OR, Op.NOT) else 1 if op is Op.WHERE else 0
    if [arg.op in CONDITIONS for arg in args] != [n < wants for n in range(len(args))]:
        raise place.fault(f"'{op}' has a condition where a number is due, or a number where a condition is due")
    if op is Op.POWER and number(args[1]) is None:
        raise place.fault("the exponent of a power must be a bare number")
    if op is Op.DIVIDE and is_zero(args[1]):
        raise place.fault("division by the constant zero")


def _is_table(expr: Expr) -> bool:
    return expr.op is Op.SYMBOL and expr.data.kind is SymbolKind.TABLE
