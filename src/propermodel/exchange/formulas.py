"""Expressions as formulas of Python that make the same expressions again."""

from __future__ import annotations

import dataclasses
import itertools
import keyword
import re
from collections import Counter
from collections.abc import Container, Iterable, Iterator

from propermodel.diagnostics import DocumentError
from propermodel.expressions.core import TIME, Expr, Op, Symbol, number, postorder, rebuild
from propermodel.modelling.model import Definition
from propermodel.modelling.schema import path_text

LONGEST = 90  # characters of a formula; longer parts get a name of their own
_ATOM, _UNARY = 10, 7
_INFIX = {
    Op.OR: (1, " | "),
    Op.AND: (2, " & "),
    Op.LESS: (4, " < "),
    Op.LESS_EQUAL: (4, " <= "),
    Op.ADD: (5, " + "),
    Op.SUBTRACT: (5, " - "),
    Op.MULTIPLY: (6, " * "),
    Op.DIVIDE: (6, " / "),
    Op.POWER: (8, "**"),
}
_CONDITIONS = (Op.OR, Op.AND, Op.LESS, Op.LESS_EQUAL)  # Python binds & and | more strongly than comparisons
_FUNCTIONS = {
    Op.ABSOLUTE: "abs",
    Op.SIGN: "sign",
    Op.SQUARE_ROOT: "sqrt",
    Op.EXPONENTIAL: "exp",
    Op.LOGARITHM: "log",
    Op.SINE: "sin",
    Op.COSINE: "cos",
    Op.TANH: "tanh",
    Op.ARCTANGENT: "atan2",
    Op.FLOOR: "floor",
    Op.MINIMUM: "minimum",
    Op.MAXIMUM: "maximum",
    Op.EQUAL: "equals",
    Op.WHERE: "where",
    Op.LOOKUP: "lookup",
}
# Names that the formulas and what is around them use.
TAKEN = frozenset(
    {*_FUNCTIONS.values(), "slope", "constant", "symbol", "path", "intern_node", "Op", "SymbolKind", "TIME", "inf"}
)


def identifier(text: str, taken: Container[str] = ()) -> str:
    """A name of Python for a text, different from those that are taken."""
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower() or "value"
    name = f"_{plain}" if plain[0].isdigit() else f"{plain}_" if keyword.iskeyword(plain) else plain
    return next(n for n in itertools.chain([name], (f"{name}_{k}" for k in itertools.count(2))) if n not in taken)


class Formulas:
    """The formulas of one definition: symbols and shared parts get names, all else is written where it is used."""

    def __init__(self, expressions: Iterable[Expr], taken: Iterable[str]) -> None:
        self._taken = {*TAKEN, *taken}
        self._texts: dict[Expr, tuple[str, int]] = {}
        self.lines: list[str] = []
        roots = list(expressions)
        order = postorder(roots)
        uses = Counter([*roots, *(arg for node in order for arg in node.args)])
        for node in order:
            self._texts[node] = self._text(node)
            text, level = self._texts[node]
            is_long = len(text) > LONGEST or (uses[node] > 1 and len(node.args) > 1)
            if node.args and (is_long or (uses[node] > 1 and level < _ATOM)):
                self._name(node, "part", text)

    def __call__(self, expr: Expr) -> str:
        """The text of an expression."""
        value = number(expr)
        return self._texts[expr][0] if value is None else f"constant({_number(value)})"

    def _name(self, node: Expr, wish: str, text: str) -> None:
        name = identifier(wish, self._taken)
        self._taken.add(name)
        self.lines.append(f"{name} = {text}")
        self._texts[node] = (name, _ATOM)

    def _text(self, node: Expr) -> tuple[str, int]:
        if node.op is Op.CONSTANT:
            value, unit = node.data
            if unit:
                return f"constant({_number(value)}, {unit!r})", _ATOM
            return _number(value), _ATOM if value >= 0.0 else _UNARY
        if node.op is Op.SYMBOL:
            return self._symbol(node), _ATOM
        if not _is_made_by_operators(node):
            return self._explicit(node), _ATOM
        args = [self._texts[arg] for arg in node.args]
        if node.op in _INFIX:
            level, mark = _INFIX[node.op]
            left, right = args
            return f"{self._inside(left, node, 0, level)}{mark}{self._inside(right, node, 1, level + 1)}", level
        if node.op is Op.NEGATE:
            return f"-{_bracket(args[0], _UNARY)}", _UNARY
        if node.op is Op.NOT:
            return f"~{_bracket(args[0], _ATOM)}", _UNARY
        texts = [text for text, _ in args]
        if node.op is Op.SLOPE:
            return f"slope({texts[0]}, {node.data}, {', '.join(texts[1:])})", _ATOM
        return f"{_FUNCTIONS[node.op]}({', '.join(texts)})", _ATOM

    def _inside(self, arg: tuple[str, int], node: Expr, place: int, level: int) -> str:
        if node.args[place].op in _CONDITIONS or (node.op is Op.POWER and place == 0):
            return _bracket(arg, _ATOM)
        return _bracket(arg, level)

    def _symbol(self, node: Expr) -> str:
        if node is TIME:
            return "TIME"
        data: Symbol = node.data
        if type(data) is not Symbol:
            raise DocumentError.of(
                "document/content",
                f"the expression mentions '{node!r}', which is not of the model",
                help="export a model that elaborate(...) or read_model(...) gave",
            )
        name = identifier(path_text(data.path), self._taken)
        self._taken.add(name)
        unit = f", {data.unit!r}" if data.unit else ""
        self.lines.append(f"{name} = symbol(SymbolKind.{data.kind.name}, path({path_text(data.path)!r}){unit})")
        return name

    def _explicit(self, node: Expr) -> str:
        args = [self(arg) for arg in node.args]
        data = "" if node.data is None else f", {node.data!r}"
        return f"intern_node(Op.{node.op.name}, ({', '.join(args)},){data})"


def _is_made_by_operators(node: Expr) -> bool:
    """Whether operators give this very node, and Python does not do the arithmetic of bare numbers first."""
    if all(number(arg) is not None for arg in node.args):
        return False
    try:
        return rebuild(node.op, node.args, node.data) is node
    except (ValueError, ArithmeticError):
        return False


def _bracket(arg: tuple[str, int], level: int) -> str:
    text, own = arg
    return f"({text})" if own < level else text


def _number(value: float) -> str:
    return {float("inf"): "inf", float("-inf"): "-inf"}.get(value) or repr(float(value))


def expressions_in(value: object) -> Iterator[Expr]:
    """Every expression in plain data, outside of other definitions."""
    stack: list[object] = [value]
    while stack:
        item = stack.pop()
        if isinstance(item, Expr):
            yield item
        elif isinstance(item, tuple):
            stack.extend(reversed(item))
        elif dataclasses.is_dataclass(item) and (item is value or not isinstance(item, Definition)):
            stack.extend(getattr(item, field.name) for field in reversed(dataclasses.fields(item)))
