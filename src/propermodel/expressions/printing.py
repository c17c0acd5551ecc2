"""Expressions as text, with as few brackets as the reader needs."""

from __future__ import annotations

import math
from collections.abc import Mapping

from propermodel.expressions.core import Expr, Op, postorder

_INFIX = {
    Op.OR: (1, " or "),
    Op.AND: (2, " and "),
    Op.LESS: (4, " < "),
    Op.LESS_EQUAL: (4, " <= "),
    Op.EQUAL: (4, " == "),
    Op.ADD: (5, " + "),
    Op.SUBTRACT: (5, " - "),
    Op.MULTIPLY: (6, "*"),
    Op.DIVIDE: (6, "/"),
    Op.POWER: (8, "**"),
}
_ATOM = 10
# A formula with more nodes than this, shared parts counted every time, is only described.
LONGEST_FORMULA = 2000


def format_number(value: float) -> str:
    """A number with the fewest digits that give it back, integers without a decimal point."""
    if math.isfinite(value) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return repr(float(value))


def short_text(expr: Expr) -> str:
    """The expression as a formula, or its size where shared parts written out would make it endless."""
    sizes: dict[Expr, int] = {}
    order = postorder([expr])
    for node in order:
        sizes[node] = 1 + sum(sizes[arg] for arg in node.args)
    if sizes[expr] <= LONGEST_FORMULA:
        return to_text(expr)
    symbols = sum(1 for node in order if node.op is Op.SYMBOL)
    return f"<expression of {len(order)} nodes with {symbols} symbols>"


def _bracket(text: str, inner: int, outer: int) -> str:
    return f"({text})" if inner < outer else text


def to_text(expr: Expr, names: Mapping[Expr, str] | None = None) -> str:
    """The expression as a formula; `names` gives the text of leaves or subexpressions."""
    known: dict[Expr, tuple[str, int]] = {node: (text, _ATOM) for node, text in (names or {}).items()}
    for node in postorder([expr]):
        if node not in known:
            known[node] = _node_text(node, known)
    return known[expr][0]


def _node_text(node: Expr, known: Mapping[Expr, tuple[str, int]]) -> tuple[str, int]:
    args = [known[arg] for arg in node.args]
    if node.op is Op.CONSTANT:
        value, unit = node.data
        text = format_number(value) + (f" {unit}" if unit else "")
        return (text, 7 if value < 0 or unit else _ATOM)
    if node.op is Op.SYMBOL:
        return (str(node.data.path), _ATOM)
    if not node.args:
        return (getattr(node, "label", "?"), _ATOM)
    if node.op in _INFIX:
        level, mark = _INFIX[node.op]
        left = _bracket(*args[0], level + (node.op is Op.POWER))
        right = _bracket(*args[1], level + (node.op is not Op.ADD and node.op is not Op.MULTIPLY))
        return (f"{left}{mark}{right}", level)
    if node.op is Op.NEGATE:
        return (f"-{_bracket(*args[0], 6)}", 5)
    if node.op is Op.NOT:
        return (f"not {_bracket(*args[0], 4)}", 3)
    if node.op is Op.LOOKUP:
        return (f"{args[0][0]}({', '.join(text for text, _ in args[1:])})", _ATOM)
    if node.op is Op.SLOPE:
        return (f"d{args[0][0]}/d{node.data}({', '.join(text for text, _ in args[1:])})", _ATOM)
    return (f"{node.op}({', '.join(text for text, _ in args)})", _ATOM)
