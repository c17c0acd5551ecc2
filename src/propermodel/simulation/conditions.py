"""Conditions written as text, over the names of a model: `car.speed > 20 km/h and time > 2 s`.

A small grammar, read without evaluating anything:

    condition  = conjunction { "or" conjunction }
    conjunction = negation { "and" negation }
    negation   = "not" negation | "(" condition ")" | sum ("<" | "<=" | ">" | ">=") sum
    sum        = product { ("+" | "-") product }
    product    = factor { ("*" | "/") factor }
    factor     = "-" factor | "(" sum ")" | "abs" "(" sum ")" | number [unit] | name
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError, one_of, parse_path
from propermodel.expressions.core import TIME, Expr, SymbolKind, absolute, constant, divide
from propermodel.expressions.dimensions import DimensionMismatch, dimension_of
from propermodel.expressions.units import parse_quantity, parse_unit

LONGEST = 2000  # characters
DEEPEST = 50  # brackets within brackets
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:\s*(?P<unit>(?!(?:and|or|not)\b)[A-Za-z][\w.]*"
    r"(?:/(?:\([\w./]+\)|[\w.]+))?))?|(?P<name>[A-Za-z_][\w]*(?:\[\d+\])*(?:\.[A-Za-z_][\w]*(?:\[\d+\])*)*)"
    r"|(?P<mark><=|>=|[<>()+\-*/]))"
)
_WORDS = frozenset({"and", "or", "not"})


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str  # number, name, mark, word, or end
    text: str
    unit: str
    place: int


def parse_condition(compiled: CompiledModel, text: str) -> Expr:
    """The condition that a text states of the states, held values, port variables, signals and parameters of a model.

    Numbers without a unit are in SI.

    Raises:
        SimulationError: the text is no condition, or mentions what the model does not have.
    """
    if len(text) > LONGEST:
        raise _refused(text[:40], 0, f"it has more than {LONGEST} characters")
    reader = _Reader(compiled, text)
    found = reader.condition(0)
    reader.expect_end()
    return found


def _tokens(text: str) -> list[_Token]:
    found: list[_Token] = []
    at = 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None:
            raise _refused(text, at + len(text[at:]) - len(text[at:].lstrip()), "this cannot be read")
        kind = match.lastgroup if match.lastgroup != "unit" else "number"
        assert kind is not None
        word = match[kind]
        found.append(_Token("word" if word in _WORDS else kind, word, match["unit"] or "", match.start(kind)))
        at = match.end()
    found.append(_Token("end", "", "", len(text)))
    return found


class _Reader:
    """Reads the tokens from left to right; every method takes what its rule says."""

    def __init__(self, compiled: CompiledModel, text: str) -> None:
        self._compiled = compiled
        self._text = text
        self._tokens = _tokens(text)
        self._at = 0
        self._names = _names(compiled)
        self._is_bare = False  # whether the present comparison has numbers without a unit

    def condition(self, depth: int) -> Expr:
        found = self._conjunction(depth)
        while self._took("or"):
            found = found | self._conjunction(depth)
        return found

    def expect_end(self) -> None:
        if self._next.kind != "end":
            raise self._wrong("a condition ends before this")

    def _conjunction(self, depth: int) -> Expr:
        found = self._negation(depth)
        while self._took("and"):
            found = found & self._negation(depth)
        return found

    def _negation(self, depth: int) -> Expr:
        self._check_depth(depth)
        if self._took("not"):
            return ~self._negation(depth + 1)
        if self._opens_condition():
            self._take("(")
            found = self.condition(depth + 1)
            self._take(")")
            return found
        return self._comparison(depth)

    def _opens_condition(self) -> bool:
        """Whether the bracket that opens here holds a condition, not a sum."""
        if self._next.text != "(":
            return False
        open_brackets = 0
        for token in self._tokens[self._at :]:
            open_brackets += (token.text == "(") - (token.text == ")")
            if not open_brackets:
                return False
            if token.text in ("<", "<=", ">", ">=", "and", "or", "not"):
                return True
        return False

    def _comparison(self, depth: int) -> Expr:
        self._is_bare = False
        begin = self._next.place
        left = self._sum(depth)
        mark = self._next.text
        if mark not in ("<", "<=", ">", ">="):
            raise self._wrong("a comparison (<, <=, > or >=) was expected")
        self._at += 1
        right = self._sum(depth)
        if not self._is_bare:
            self._check_dimensions(left, right, begin)
        match mark:
            case "<":
                return left < right
            case "<=":
                return left <= right
            case ">":
                return left > right
            case _:
                return left >= right

    def _check_dimensions(self, left: Expr, right: Expr, place: int) -> None:
        try:
            dimension_of(left - right)
        except DimensionMismatch as error:
            raise _refused(self._text, place, str(error)) from error

    def _sum(self, depth: int) -> Expr:
        found = self._product(depth)
        while self._next.text in ("+", "-"):
            is_added = self._next.text == "+"
            self._at += 1
            further = self._product(depth)
            found = found + further if is_added else found - further
        return found

    def _product(self, depth: int) -> Expr:
        found = self._factor(depth)
        while self._next.text in ("*", "/"):
            is_multiplied = self._next.text == "*"
            self._at += 1
            further = self._factor(depth)
            found = found * further if is_multiplied else divide(found, further)
        return found

    def _factor(self, depth: int) -> Expr:
        self._check_depth(depth)
        token = self._next
        if self._took("-"):
            return -self._factor(depth + 1)
        if self._took("("):
            found = self._sum(depth + 1)
            self._take(")")
            return found
        self._at += 1
        if token.kind == "name" and token.text == "abs" and self._took("("):
            found = absolute(self._sum(depth + 1))
            self._take(")")
            return found
        if token.kind == "number":
            return self._number(token)
        if token.kind == "name":
            return self._named(token)
        self._at -= 1
        raise self._wrong("a number or a name was expected")

    def _number(self, token: _Token) -> Expr:
        if not token.unit:
            self._is_bare = self._is_bare or float(token.text) != 0.0
            return constant(float(token.text))
        unit = parse_unit(token.unit)
        return constant(parse_quantity(token.text, token.unit), unit.text)

    def _named(self, token: _Token) -> Expr:
        if token.text == "time":
            return TIME
        path = parse_path(token.text)
        if path not in self._names:
            raise SimulationError.of(
                "simulation/unknown-observable",
                f"the model has no observable '{path}'",
                help=one_of(str(path), map(str, self._names)),
            )
        return self._names[path]

    @property
    def _next(self) -> _Token:
        return self._tokens[self._at]

    def _took(self, text: str) -> bool:
        if self._next.text != text:
            return False
        self._at += 1
        return True

    def _take(self, text: str) -> None:
        if not self._took(text):
            raise self._wrong(f"'{text}' was expected")

    def _check_depth(self, depth: int) -> None:
        if depth > DEEPEST:
            raise self._wrong(f"there are more than {DEEPEST} brackets within each other")

    def _wrong(self, problem: str) -> SimulationError:
        return _refused(self._text, self._next.place, problem)


def _names(compiled: CompiledModel) -> dict[Path, Expr]:
    """What a condition may mention, by path."""
    system, slots = compiled.system, compiled.lowered.program.layout.slots
    found = {parameter.path: parameter.symbol for parameter in compiled.graph.parameters.values()}
    found = {path: leaf for path, leaf in found.items() if leaf in slots}
    observables = compiled.lowered.observables
    found |= {leaf.data.path: leaf for leaf in system.values if leaf.data.path in observables}
    found |= {stored.element / "energy": stored.energy for stored in system.energies}
    found |= {held.data.path: held for held in slots if held.data.kind is SymbolKind.DISCRETE}
    return found | {state.path: state.symbol for state in system.states}


def _refused(text: str, place: int, problem: str) -> SimulationError:
    where = text[place : place + 20].strip() or "the end"
    return SimulationError.of(
        "simulation/condition",
        f"the condition '{text}' cannot be read at '{where}': {problem}",
        help="compare names of the model, time and numbers: body.flange.flow > 20 km/h and time > 2 s",
    )
