"""Sums of products with number coefficients; exponents may be negative."""

from __future__ import annotations

# Products are multiplied out as long as the sum has no more terms than this.
MOST_TERMS = 24
# What the coefficients of like terms leave below this share of themselves is rounding.
ROUNDING = 1e-13

Monomial = tuple[tuple[int, float], ...]  # number of an atom and its exponent, by number
Polynomial = dict[Monomial, float]  # the coefficient of each product


def accumulate(poly: Polynomial, monomial: Monomial, coefficient: float) -> None:
    """Add a term to a sum in place; what is only rounding goes."""
    before = poly.get(monomial, 0.0)
    after = before + coefficient
    if abs(after) <= ROUNDING * max(abs(before), abs(coefficient)):
        poly.pop(monomial, None)
    else:
        poly[monomial] = after


def added(a: Polynomial, b: Polynomial, sign: float) -> Polynomial:
    """The sum of the first and so many times the second."""
    result = dict(a)
    for monomial, coefficient in b.items():
        accumulate(result, monomial, sign * coefficient)
    return result


def scaled(poly: Polynomial, factor: float) -> Polynomial:
    """Every term times a number."""
    return {monomial: factor * coefficient for monomial, coefficient in poly.items()}


def short(poly: Polynomial) -> Polynomial | None:
    """The sum itself, or None where it has too many terms."""
    return poly if len(poly) <= MOST_TERMS else None


def joined(a: Monomial, b: Monomial) -> Monomial:
    """The product of two products."""
    if not a or not b:
        return a or b
    exponents = dict(a)
    for atom, exponent in b:
        exponents[atom] = exponents.get(atom, 0.0) + exponent
    return tuple(sorted((atom, exponent) for atom, exponent in exponents.items() if exponent))


def raised(monomial: Monomial, exponent: float) -> Monomial:
    """A product raised to a power."""
    return tuple((atom, e * exponent) for atom, e in monomial)


def shared_factor(poly: Polynomial) -> Monomial:
    """What all terms share: factors above in all of them, or below in all of them."""
    shared: dict[int, float] | None = None
    for monomial in poly:
        here = dict(monomial)
        if shared is None:
            shared = here
            continue
        shared = {
            atom: min(exponent, here[atom], key=abs)
            for atom, exponent in shared.items()
            if atom in here and (exponent > 0) == (here[atom] > 0)
        }
    return tuple(sorted((shared or {}).items()))


def least_exponents(poly: Polynomial) -> Monomial:
    """The least exponent of every atom, at most zero: what a common denominator takes away."""
    least: dict[int, float] = {}
    for monomial in poly:
        for atom, exponent in monomial:
            if exponent < least.get(atom, 0.0):
                least[atom] = exponent
    return tuple(sorted(least.items()))


def quotient(top: Polynomial, bottom: Polynomial) -> Polynomial | None:
    """The exact quotient of two sums; None where the division leaves something."""
    lift = least_exponents({**top, **dict.fromkeys(bottom, 1.0)})
    rest = {joined(m, raised(lift, -1.0)): c for m, c in top.items()}
    divisor = {joined(m, raised(lift, -1.0)): c for m, c in bottom.items()}
    lead = max(divisor, key=_lexical)
    result: Polynomial = {}
    for _ in range(4 * MOST_TERMS):
        if not rest:
            return result
        first = max(rest, key=_lexical)
        factor = joined(first, raised(lead, -1.0))
        if any(exponent < 0 for _, exponent in factor):
            return None
        scale = rest[first] / divisor[lead]
        result[factor] = scale
        for monomial, coefficient in divisor.items():
            accumulate(rest, joined(factor, monomial), -scale * coefficient)
        rest.pop(first, None)
    return None


def _lexical(monomial: Monomial) -> tuple[tuple[int, float], ...]:
    """An order of products that multiplication keeps: by the exponent of the atom with the least number first."""
    return tuple((-atom, exponent) for atom, exponent in monomial)
