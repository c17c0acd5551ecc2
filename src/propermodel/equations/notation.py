"""How formulas are written: plain text and LaTeX."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from propermodel.diagnostics import Path
from propermodel.equations.names import Name
from propermodel.expressions.core import Expr, Op, postorder
from propermodel.expressions.printing import format_number

Piece = tuple[str, int]  # a formula and how strongly its outermost sign binds

SUM, PRODUCT, SIGNED_POWER, ATOM = 5, 6, 8, 10
_CONDITIONS = {
    Op.OR: (1, "or", r"\vee"),
    Op.AND: (2, "and", r"\wedge"),
    Op.LESS: (4, "<", "<"),
    Op.LESS_EQUAL: (4, "<=", r"\leq"),
    Op.EQUAL: (4, "=", "="),
}
_LATEX_FUNCTIONS = {
    Op.EXPONENTIAL: r"\exp",
    Op.LOGARITHM: r"\ln",
    Op.SINE: r"\sin",
    Op.COSINE: r"\cos",
    Op.TANH: r"\tanh",
    Op.MINIMUM: r"\min",
    Op.MAXIMUM: r"\max",
}


@dataclass(frozen=True)
class Notation:
    """A way to write names and formulas."""

    node: Callable[[Expr, list[Piece]], Piece]
    name: Callable[[Name], str]
    rate: Callable[[str], str]
    pi: str
    times: str

    def formula(self, expr: Expr, names: Mapping[Expr, str]) -> str:
        """The expression with these names for its symbols."""
        return self.piece(expr, names)[0]

    def factor(self, expr: Expr, names: Mapping[Expr, str]) -> str:
        """The expression, in brackets where it is a sum."""
        return _bracket(self.piece(expr, names), PRODUCT)

    def piece(self, expr: Expr, names: Mapping[Expr, str]) -> Piece:
        """The expression and how strongly its outermost sign binds."""
        known: dict[Expr, Piece] = {}
        for node in postorder([expr]):
            if node in names:
                known[node] = names[node], ATOM
            elif node.op is Op.CONSTANT:
                known[node] = self.number(node.data[0])
            else:
                known[node] = self.node(node, [known[arg] for arg in node.args])
        return known[expr]

    def number(self, value: float) -> Piece:
        """A number with at most twelve digits; small multiples of pi as such."""
        times = round(value / math.pi)
        if 1 <= times <= 16 and math.isclose(value, times * math.pi, rel_tol=1e-14):
            return (self.pi, ATOM) if times == 1 else (f"{times}{self.times}{self.pi}", PRODUCT)
        value = float(f"{value:.12g}")
        return format_number(value), SUM if value < 0 else ATOM


def _bracket(piece: Piece, outer: int) -> str:
    return f"({piece[0]})" if piece[1] < outer else piece[0]


# -- plain text ------------------------------------------------------------------------------------------


def _text_node(node: Expr, args: list[Piece]) -> Piece:
    match node.op:
        case Op.ADD | Op.SUBTRACT:
            return f"{args[0][0]} {node.op} {_bracket(args[1], SUM + 1)}", SUM
        case Op.MULTIPLY:
            return f"{_bracket(args[0], PRODUCT)}*{_bracket(args[1], PRODUCT)}", PRODUCT
        case Op.DIVIDE:
            return f"{_bracket(args[0], PRODUCT)}/{_bracket(args[1], PRODUCT + 1)}", PRODUCT
        case Op.POWER:
            return f"{_bracket(args[0], SIGNED_POWER + 1)}^{_bracket(args[1], SIGNED_POWER)}", SIGNED_POWER
        case Op.NEGATE:
            return f"-{_bracket(args[0], PRODUCT)}", SUM
        case Op.ABSOLUTE:
            return f"|{args[0][0]}|" if "|" not in args[0][0] else f"abs({args[0][0]})", ATOM
        case Op.NOT:
            return f"not {_bracket(args[0], 4)}", 3
        case Op.LOOKUP:
            return f"{args[0][0]}({', '.join(text for text, _ in args[1:])})", ATOM
        case Op.SLOPE:
            return f"d{node.data + 1} {args[0][0]}({', '.join(text for text, _ in args[1:])})", ATOM
        case Op.WHERE:
            return f"({args[1][0]} if {args[0][0]} else {args[2][0]})", ATOM
        case _ if node.op in _CONDITIONS:
            level, mark, _ = _CONDITIONS[node.op]
            return f"{_bracket(args[0], level)} {mark} {_bracket(args[1], level)}", level
        case _:
            return f"{node.op}({', '.join(text for text, _ in args)})", ATOM


TEXT = Notation(node=_text_node, name=str, rate=lambda name: f"{name}'", pi="pi", times="*")


# -- LaTeX -----------------------------------------------------------------------------------------------

# The letters that textbooks use for a quantity; a name that ends on such a word keeps the rest as an index.
_LETTERS = {
    "mass": "m",
    "inertia": "J",
    "stiffness": "k",
    "damping": "b",
    "velocity": "v",
    "angular_velocity": r"\omega",
    "speed": r"\omega",
    "displacement": "x",
    "angle": r"\varphi",
    "momentum": "p",
    "force": "F",
    "torque": "T",
    "resistance": "R",
    "conductance": "G",
    "inductance": "L",
    "capacitance": "C",
    "voltage": "u",
    "current": "i",
    "pressure": "p",
    "volume_flow": "Q",
    "volume": "V",
    "area": "A",
    "density": r"\rho",
    "ratio": "n",
    "constant": "K",
    "temperature": r"\vartheta",
    "entropy": "S",
    "entropy_flow": r"\dot{S}",
    "bulk_modulus": "B",
    "time": "t",
}


def latex_names(names: Mapping[Expr, Name]) -> dict[Expr, str]:
    """Letters with indices; where two quantities would get the same, both are spelt out."""
    texts = {leaf: _latex_name(name) for leaf, name in names.items()}
    users: dict[str, int] = {}
    for text in texts.values():
        users[text] = users.get(text, 0) + 1
    return {leaf: text if users[text] == 1 else _spelt_out(names[leaf]) for leaf, text in texts.items()}


def _latex_name(name: Name) -> str:
    words = name.quantity.split("_")
    for count in range(len(words)):
        letter = _LETTERS.get("_".join(words[count:]))
        if letter is not None:
            index = [_upright("_".join(words[:count]))] if count else []
            index += [_upright(part) for part in name.owner]
            return f"{letter}_{{{','.join(index)}}}" if index else letter
    return _spelt_out(name)


def _spelt_out(name: Name) -> str:
    index = ",".join(_upright(part) for part in name.owner)
    return f"{_upright(name.quantity)}_{{{index}}}" if index else _upright(name.quantity)


def spelt_out(path: Path) -> str:
    """A path in upright letters."""
    return ".".join(_upright(part) for part in path)


def _upright(text: str) -> str:
    words = text.replace("[", " ").replace("]", "").replace("_", " ").split()
    return rf"\mathrm{{{' '.join(words)}}}".replace(" ", r"\ ")


def _latex_bracket(piece: Piece, outer: int) -> str:
    return rf"\left({piece[0]}\right)" if piece[1] < outer else piece[0]


def _latex_node(node: Expr, args: list[Piece]) -> Piece:
    listed = ", ".join(text for text, _ in args)
    match node.op:
        case Op.ADD | Op.SUBTRACT:
            return f"{args[0][0]} {node.op} {_latex_bracket(args[1], SUM + 1)}", SUM
        case Op.MULTIPLY:
            second = node.args[1]
            sign = r" \cdot " if second.op is Op.CONSTANT else r" \, "
            return f"{_latex_bracket(args[0], PRODUCT)}{sign}{_latex_bracket(args[1], PRODUCT)}", PRODUCT
        case Op.DIVIDE:
            return rf"\frac{{{args[0][0]}}}{{{args[1][0]}}}", PRODUCT
        case Op.POWER:
            return f"{_latex_power_base(args[0])}^{{{args[1][0]}}}", SIGNED_POWER
        case Op.NEGATE:
            return f"-{_latex_bracket(args[0], PRODUCT)}", SUM
        case Op.ABSOLUTE:
            return rf"\left|{args[0][0]}\right|", ATOM
        case Op.SQUARE_ROOT:
            return rf"\sqrt{{{args[0][0]}}}", ATOM
        case Op.FLOOR:
            return rf"\left\lfloor {args[0][0]} \right\rfloor", ATOM
        case Op.NOT:
            return rf"\neg {_latex_bracket(args[0], 4)}", 3
        case Op.LOOKUP:
            return rf"{args[0][0]}\left({', '.join(text for text, _ in args[1:])}\right)", ATOM
        case Op.SLOPE:
            inner = ", ".join(text for text, _ in args[1:])
            return rf"\partial_{{{node.data + 1}}} {args[0][0]}\left({inner}\right)", ATOM
        case Op.WHERE:
            first = rf"{args[1][0]} & \mathrm{{if}}\ {args[0][0]}"
            return rf"\begin{{cases}} {first} \\ {args[2][0]} & \mathrm{{otherwise}} \end{{cases}}", PRODUCT
        case _ if node.op in _CONDITIONS:
            level, _, mark = _CONDITIONS[node.op]
            return f"{_latex_bracket(args[0], level)} {mark} {_latex_bracket(args[1], level)}", level
        case _:
            function = _LATEX_FUNCTIONS.get(node.op) or rf"\mathrm{{{node.op}}}"
            return rf"{function}\left({listed}\right)", ATOM


def _latex_power_base(piece: Piece) -> str:
    text = _latex_bracket(piece, SIGNED_POWER + 1)
    # A dotted letter or one with an index takes its exponent only in braces.
    return f"{{{text}}}" if piece[1] == ATOM else text


def _latex_rate(name: str) -> str:
    letter, mark, index = name.partition("_{")
    return rf"\dot{{{letter}}}{mark}{index}"


LATEX = Notation(node=_latex_node, name=_latex_name, rate=_latex_rate, pi=r"\pi", times=r" \, ")
