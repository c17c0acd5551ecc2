"""Expressions as a textbook writes them: like terms collected, factors grouped, no nested fractions.

Every expression is held in two forms, sums of products with one coefficient each: *flat*, in which a sum that is a
factor stays together, and *wide*, in which products are multiplied out as long as that stays short. What is shortest
when written is chosen. Values are kept, except where a factor that cancels is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from propermodel.expressions.core import (
    ONE,
    ZERO,
    Expr,
    Op,
    SymbolKind,
    add,
    constant,
    divide,
    intern_node,
    leaves,
    multiply,
    number,
    power,
    rebuild,
    subtract,
)
from propermodel.expressions.polynomials import (
    MOST_TERMS,
    Monomial,
    Polynomial,
    accumulate,
    added,
    joined,
    least_exponents,
    quotient,
    raised,
    scaled,
    shared_factor,
    short,
)

# A fraction within a fraction is as hard to read as so many operands.
FRACTION_WITHIN = 3


_FIXED = frozenset({SymbolKind.PARAMETER, SymbolKind.TABLE})


@dataclass(frozen=True, slots=True)
class Form:
    """One expression as sums of products; `wide` is None where multiplying out would make it long."""

    flat: Polynomial
    wide: Polynomial | None


class Simplifier:
    """Simplifies expressions that share parts; remembers what it has done.

    `known` gives the forms of leaves or subexpressions that stand for something else. `cut` is asked about every
    simplified node below a root: where it gives a symbol, that symbol stands for the node from then on.
    """

    def __init__(
        self,
        known: Mapping[Expr, Expr] | None = None,
        cut: Callable[[Expr, Expr], Expr | None] | None = None,
    ) -> None:
        self._atoms: list[Expr] = []
        self._numbers: dict[Expr, int] = {}
        self._sums: dict[int, Polynomial] = {}  # atoms that are sums
        self._fixed: list[bool] = []  # atoms of parameters only
        self._forms: dict[Expr, Form] = {}
        self._texts: dict[Expr, Expr] = {}
        self._sizes: dict[Expr, int] = {}
        self._nested: dict[Expr, tuple[int, int]] = {}  # divisions, and how many of them stand within another
        self._cut: Callable[[Expr, Expr], Expr | None] | None = None
        for leaf, value in (known or {}).items():
            self(value)
            self._forms[leaf] = self._forms[value]
        self._cut = cut

    def __call__(self, expr: Expr) -> Expr:
        """The simplified expression."""
        for node in _below(expr, self._forms):
            self._forms[node] = self._form(node)
            if self._cut is not None and node is not expr and node.args and not node.is_condition:
                symbol = self._cut(node, self._shortest(node))
                if symbol is not None:
                    self._forms[node] = self._single(self._atom(symbol))
                    self._texts[node] = symbol
        return self._shortest(expr)

    def size(self, expr: Expr) -> int:
        """How many operands and functions an expression has when it is written out."""
        for node in _below(expr, self._sizes):
            own = 0 if node.op in _ARITHMETIC else 1
            self._sizes[node] = own + sum(self._sizes[arg] for arg in node.args)
        return self._sizes[expr]

    def _awkwardness(self, expr: Expr) -> int:
        """The size of an expression, and what fractions within fractions cost its reader."""
        for node in _below(expr, self._nested):
            inner = [self._nested[arg] for arg in node.args]
            divisions = sum(below for below, _ in inner)
            within = sum(deep for _, deep in inner)
            is_division = node.op is Op.DIVIDE
            self._nested[node] = (divisions + is_division, divisions if is_division else within)
        return self.size(expr) + FRACTION_WITHIN * self._nested[expr][1]

    # -- atoms -------------------------------------------------------------------------------------------

    def _atom(self, expr: Expr) -> int:
        known = self._numbers.get(expr)
        if known is not None:
            return known
        self._numbers[expr] = number = len(self._atoms)
        self._atoms.append(expr)
        self._fixed.append(all(leaf.data.kind in _FIXED for leaf in leaves(expr)))
        return number

    def _sum_atom(self, poly: Polynomial) -> int:
        """The atom for a sum in standard order and sign."""
        expr = self._written({m: poly[m] for m in sorted(poly)})
        atom = self._atom(expr)
        self._sums.setdefault(atom, poly)
        return atom

    @staticmethod
    def _single(atom: int) -> Form:
        poly: Polynomial = {((atom, 1.0),): 1.0}
        return Form(poly, poly)

    # -- forms -------------------------------------------------------------------------------------------

    def _form(self, node: Expr) -> Form:
        match node.op:
            case Op.CONSTANT:
                poly: Polynomial = {(): node.data[0]} if node.data[0] else {}
                return Form(poly, poly)
            case Op.ADD | Op.SUBTRACT:
                a, b = (self._forms[arg] for arg in node.args)
                sign = 1.0 if node.op is Op.ADD else -1.0
                wide = None if a.wide is None or b.wide is None else short(added(a.wide, b.wide, sign))
                return Form(added(a.flat, b.flat, sign), wide)
            case Op.NEGATE:
                a = self._forms[node.args[0]]
                return Form(scaled(a.flat, -1.0), None if a.wide is None else scaled(a.wide, -1.0))
            case Op.MULTIPLY:
                a, b = (self._forms[arg] for arg in node.args)
                return Form(self._times(a.flat, b.flat), self._product(a.wide, b.wide))
            case Op.DIVIDE:
                a, b = (self._forms[arg] for arg in node.args)
                if not b.flat or (b.wide is not None and not b.wide):
                    return self._single(self._atom(intern_node(Op.DIVIDE, tuple(map(self._shortest, node.args)))))
                inverse = None if b.wide is None else self._inverse(b.wide)
                return Form(self._times(a.flat, self._inverse(b.flat)), self._product(a.wide, inverse))
            case Op.POWER:
                return self._powered(node)
            case Op.SYMBOL:
                return self._single(self._atom(node))
            case _:
                args = [self._shortest(arg) for arg in node.args]
                made = rebuild(node.op, args, node.data)
                value = number(made)
                if value is not None:
                    poly = {(): value} if value else {}
                    return Form(poly, poly)
                return self._single(self._atom(made))

    def _powered(self, node: Expr) -> Form:
        base, exponent = self._forms[node.args[0]], node.args[1].data[0]
        if exponent != int(exponent) or not base.flat or (exponent < 0 and base.wide is not None and not base.wide):
            made = power(self._shortest(node.args[0]), exponent)
            value = number(made)
            poly: Polynomial = {(): value} if value is not None else {((self._atom(made), 1.0),): 1.0}
            return Form(poly, poly)
        ((monomial, coefficient),) = self._factored(base.flat).items()
        flat: Polynomial = {tuple((a, e * exponent) for a, e in monomial): coefficient**exponent}
        wide: Polynomial | None = flat
        if base.wide is not None and len(base.wide) > 1 and exponent == 2.0:
            wide = self._product(base.wide, base.wide)
        elif base.wide is not None and len(base.wide) == 1:
            ((monomial, coefficient),) = base.wide.items()
            wide = {tuple((a, e * exponent) for a, e in monomial): coefficient**exponent}
        return Form(flat, wide)

    def _times(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """The product of two sums as one term; a sum with several terms becomes a factor."""
        if not a or not b:
            return {}
        ((m, c),) = self._factored(a).items()
        ((n, d),) = self._factored(b).items()
        return {joined(m, n): c * d}

    def _product(self, a: Polynomial | None, b: Polynomial | None) -> Polynomial | None:
        """The product of two sums, multiplied out; None where that is long."""
        if a is None or b is None or len(a) * len(b) > MOST_TERMS:
            return None
        result: Polynomial = {}
        for m, c in a.items():
            for n, d in b.items():
                accumulate(result, joined(m, n), c * d)
        return result

    def _factored(self, poly: Polynomial) -> Polynomial:
        """The sum as one term: what all terms share, times the remaining sum as one atom."""
        if len(poly) <= 1:
            return poly
        return self._as_factor(poly, shared_factor(poly))

    def _inverse(self, poly: Polynomial) -> Polynomial:
        """The reciprocal of a sum, as one term without nested fractions."""
        common = least_exponents(poly)
        cleared = self._expanded({joined(m, raised(common, -1.0)): c for m, c in poly.items()})
        if cleared is None or not cleared:
            cleared, common = poly, ()
        ((monomial, coefficient),) = self._as_factor(cleared, shared_factor(cleared), common).items()
        return {raised(monomial, -1.0): 1.0 / coefficient}

    def _as_factor(self, poly: Polynomial, common: Monomial, outside: Monomial = ()) -> Polynomial:
        rest = {joined(m, raised(common, -1.0)): c for m, c in poly.items()}
        shared = joined(common, outside)
        first = rest[min(rest)]
        magnitude = abs(first) if len({abs(c) for c in rest.values()}) == 1 else 1.0
        scale = magnitude if first > 0 else -magnitude
        if len(rest) == 1:
            ((monomial, coefficient),) = rest.items()
            return {joined(shared, monomial): coefficient}
        atom = self._sum_atom({m: c / scale for m, c in rest.items()})
        return {joined(shared, ((atom, 1.0),)): scale}

    def _expanded(self, poly: Polynomial) -> Polynomial | None:
        """The sum with factors that are sums multiplied out; None where that is long."""
        result: Polynomial = {}
        for monomial, coefficient in poly.items():
            term: Polynomial | None = {tuple((a, e) for a, e in monomial if not self._opens(a, e)): coefficient}
            for atom, exponent in monomial:
                if self._opens(atom, exponent):
                    for _ in range(int(exponent)):
                        term = self._product(term, self._sums[atom])
            if term is None:
                return None
            for m, c in term.items():
                accumulate(result, m, c)
        return short(result)

    def _opens(self, atom: int, exponent: float) -> bool:
        return atom in self._sums and exponent in (1.0, 2.0, 3.0)

    # -- choosing and writing ------------------------------------------------------------------------------

    def _shortest(self, node: Expr) -> Expr:
        """The shortest way found to write a node."""
        if node not in self._texts:
            form = self._forms[node]
            candidates = [self._written(form.flat)]
            if form.wide is not None and form.wide is not form.flat:
                candidates.append(self._written(form.wide))
            together = None if form.wide is None else self._together(form.wide)
            if together is not None:
                candidates.append(self._written(together))
            self._texts[node] = min(candidates, key=self._awkwardness)
        return self._texts[node]

    def _together(self, poly: Polynomial) -> Polynomial | None:
        """The sum over one denominator, with common factors cancelled; None where there is no denominator."""
        bottom = tuple((a, e) for a, e in least_exponents(poly) if e < 0 and a in self._sums)
        if not bottom:
            return None
        top = self._expanded({joined(m, raised(bottom, -1.0)): c for m, c in poly.items()})
        if top is None:
            return None
        left: list[tuple[int, float]] = []
        for atom, exponent in bottom:
            rest = exponent
            while rest < 0 and (divided := quotient(top, self._sums[atom])) is not None:
                top, rest = divided, rest + 1.0
            if rest < 0:
                left.append((atom, rest))
        return {joined(m, tuple(left)): c for m, c in top.items()}

    def _written(self, poly: Polynomial) -> Expr:
        """The sum as an expression, grouped by denominators, by parameters, then by variables."""
        if not poly:
            return ZERO
        terms = list(poly.items())
        groups: dict[Monomial, list[tuple[Monomial, float]]] = {}
        for monomial, coefficient in terms:
            below = tuple((a, e) for a, e in monomial if e < 0 and a in self._sums)
            groups.setdefault(below, []).append((joined(monomial, raised(below, -1.0)), coefficient))
        if len(groups) == 1 and () in groups:
            return self._summed(self._grouped(terms))
        parts: list[tuple[Expr, float]] = []
        for below, members in groups.items():
            if not below:
                parts.extend(self._grouped(members))
                continue
            ((shared, scale),) = self._factored(dict(members)).items()
            parts.append(self._signed(joined(shared, below), scale))
        return self._summed(parts)

    def _grouped(self, terms: list[tuple[Monomial, float]]) -> list[tuple[Expr, float]]:
        """Terms with their signs; those with the same parameters share a bracket, then those of one variable."""
        left: list[tuple[Monomial, float]] = terms
        parts: list[tuple[int, Expr, float]] = []
        place = {monomial: position for position, (monomial, _) in enumerate(terms)}
        for by_parameters in (True, False):
            groups: dict[tuple[float, Monomial], list[tuple[Monomial, float]]] = {}
            for monomial, coefficient in left:
                fixed, moving = self._split(monomial)
                key = (abs(coefficient), fixed) if by_parameters else (0.0, moving)
                groups.setdefault(key, []).append((monomial, coefficient))
            left = []
            for (magnitude, shared), members in groups.items():
                trivial = not shared and magnitude in (0.0, 1.0)
                if len(members) == 1 or trivial:
                    left.extend(members)
                    continue
                scale = magnitude or 1.0
                inner = {joined(m, raised(shared, -1.0)): c / scale for m, c in members}
                if by_parameters and () in inner:
                    left.extend(members)
                    continue
                bracket, sign = self._bracket(inner)
                parts.append((place[members[0][0]], self._term(shared, scale, bracket), sign))
            left = sorted(left, key=lambda term: place[term[0]])
        for monomial, coefficient in left:
            parts.append((place[monomial], *self._signed(monomial, coefficient)))
        parts.sort(key=lambda part: part[0])
        return [(expr, sign) for _, expr, sign in parts]

    def _bracket(self, inner: Polynomial) -> tuple[Expr, float]:
        """A sum in brackets, with a positive sign where one of its terms has one."""
        sign = -1.0 if all(c < 0 for c in inner.values()) else 1.0
        return self._summed(self._grouped(list(scaled(inner, sign).items()))), sign

    def _split(self, monomial: Monomial) -> tuple[Monomial, Monomial]:
        fixed = tuple((a, e) for a, e in monomial if self._fixed[a])
        return fixed, tuple((a, e) for a, e in monomial if not self._fixed[a])

    def _summed(self, parts: Iterable[tuple[Expr, float]]) -> Expr:
        """The sum of terms with signs; a positive term comes first where there is one."""
        parts = list(parts)
        first = next((i for i, (_, sign) in enumerate(parts) if sign > 0), 0)
        ordered = [parts[first], *parts[:first], *parts[first + 1 :]]
        total = ZERO
        for expr, sign in ordered:
            total = add(total, expr) if sign > 0 else subtract(total, expr)
        return total

    def _signed(self, monomial: Monomial, coefficient: float) -> tuple[Expr, float]:
        """A term and its sign; a difference in brackets is turned where that leaves no sign."""
        if coefficient < 0.0:
            for factor in monomial:
                inner = self._sums.get(factor[0], {})
                if factor[1] == 1.0 and any(c < 0 for c in inner.values()):
                    bracket, sign = self._bracket(scaled(inner, -1.0))
                    rest = tuple(other for other in monomial if other is not factor)
                    return self._term(rest, -coefficient, bracket), sign
        return self._term(monomial, abs(coefficient)), 1.0 if coefficient > 0 else -1.0

    def _term(self, monomial: Monomial, coefficient: float, bracket: Expr = ONE) -> Expr:
        """A product: number, parameters, variables, bracket; over what has negative exponents."""
        top, bottom = ONE, ONE
        above = below = 1.0
        inverse = 1.0 / coefficient
        has_top = bracket is not ONE or any(exponent > 0 for _, exponent in monomial)
        if has_top and coefficient < 1.0 and inverse <= 1000.0 and abs(inverse - round(inverse)) < 1e-12 * inverse:
            below = float(round(inverse))
        else:
            above = coefficient
        for atom, exponent in sorted(monomial, key=self._rank):
            expr = self._atoms[atom]
            if exponent > 0:
                top = multiply(top, power(expr, exponent))
            else:
                bottom = multiply(bottom, power(expr, -exponent))
        if bracket is not ONE and all(leaf.data.kind in _FIXED for leaf in leaves(bracket)):
            top = multiply(multiply(constant(above), bracket), top)
        else:
            top = multiply(multiply(constant(above), top), bracket)
        return divide(top, multiply(constant(below), bottom))

    def _rank(self, factor: tuple[int, float]) -> tuple[int, int]:
        atom = factor[0]
        return (2 * (not self._fixed[atom]) + (atom in self._sums), atom)


_ARITHMETIC = frozenset({Op.ADD, Op.SUBTRACT, Op.MULTIPLY, Op.DIVIDE, Op.POWER, Op.NEGATE})


def simplify(expr: Expr) -> Expr:
    """The expression as a textbook writes it; the same value wherever no factor that cancels is zero."""
    return Simplifier()(expr)


def _below(expr: Expr, known: Mapping[Expr, object]) -> list[Expr]:
    """The nodes below an expression that are not known, arguments before their users."""
    order: list[Expr] = []
    seen: set[Expr] = set()
    stack: list[tuple[Expr, bool]] = [(expr, False)]
    while stack:
        node, expanded = stack.pop()
        if node in seen or node in known:
            continue
        if expanded or not node.args:
            seen.add(node)
            order.append(node)
            continue
        stack.append((node, True))
        stack.extend((arg, False) for arg in reversed(node.args))
    return order
