"""How long equations are broken over lines: between terms first, then between factors, then within brackets."""

from __future__ import annotations

import re
from collections.abc import Iterator

WIDTH = 100
INDENT = 8  # of what continues a formula; what continues one of its terms stands 4 columns further
STEP = 2  # and further by this for every bracket it stands in
DEEPEST = 8  # brackets that still count for that

_CLAUSES = re.compile(r" (?=(?:if|else|or|and) )|(?<=,)(?= )")
_SIGNS = re.compile(r" (?=(?:\+|-|<|<=|=) )")
_BRACKETED = re.compile(r"(?=[*/]\()")
_FACTORS = re.compile(r"(?=[*/])")


def wrapped(left: str, right: str, width: int) -> list[str]:
    """The lines of an equation, within `WIDTH` columns where its names allow it.

    Args:
        left: What stands before the equality sign.
        right: What stands after it.
        width: The room for left sides of equations that stand below each other.
    """
    head = f"  {left:<{width}} = "
    if len(head) + len(right) > WIDTH:
        head = f"  {left} = "
    lines = [head]
    if len(head) > WIDTH:
        # What is joined to a line is measured with the equality sign, which stands on the last one.
        lines = _broken("  ", _pieces(left, WIDTH - INDENT - len(" =")), WIDTH - len(" ="))
        lines[-1] += " = "
    is_broken = False
    for number, term in enumerate(_cut(right, list(_places(right, _SIGNS, 0)))):
        if len(lines[-1].rstrip()) + 1 + len(term.strip()) > WIDTH or is_broken:
            lines.append(" " * INDENT)
        pieces = _pieces(term.strip(), WIDTH - INDENT)
        is_broken = len(pieces) > 1
        gap = " " if number and lines[-1].strip() else ""
        lines[-1:] = _broken(lines[-1] + gap, pieces)
    return [line.rstrip() for line in lines]


def _broken(begin: str, pieces: list[tuple[str, int]], width: int = WIDTH) -> list[str]:
    """The pieces of a term on lines: the first after what has begun, the others below it by their depth."""
    lines = [begin + pieces[0][0]]
    for number, (piece, depth) in enumerate(pieces[1:]):
        if not number or len(lines[-1]) + len(piece) > width:
            lines.append(" " * _indent(depth) + piece.strip())
        else:
            lines[-1] += piece
    return lines


def _indent(depth: int) -> int:
    """The columns before what continues a term within so many brackets."""
    return INDENT + 4 + STEP * min(depth, DEEPEST)


def _pieces(term: str, room: int) -> list[tuple[str, int]]:
    """A term, cut where it is bound least until every piece has room, if it can; with the depth of each cut."""
    if len(term) <= room:
        return [(term, 0)]
    depths = _depths(term)
    places: set[int] = set()
    for depth in range(max(depths) + 1):
        for pattern in (_CLAUSES, _SIGNS, _BRACKETED, _FACTORS):
            ends = [*sorted(places), len(term)]
            long = [
                (a, b) for a, b in zip([0, *ends], ends, strict=False) if b - a > room + INDENT - _indent(depths[a])
            ]
            if long:
                places.update(p for p in _places(term, pattern, depth) if any(a < p < b for a, b in long))
    begins = [0, *sorted(places)]
    return list(zip(_cut(term, sorted(places)), [depths[begin] for begin in begins], strict=True))


def _places(formula: str, pattern: re.Pattern[str], depth: int) -> Iterator[int]:
    """Where a pattern is found within so many brackets."""
    depths = _depths(formula)
    return (match.start() for match in pattern.finditer(formula) if match.start() and depths[match.start()] == depth)


def _depths(formula: str) -> list[int]:
    """The number of brackets and bars around every character."""
    found: list[int] = []
    depth = bars = 0
    for sign in formula:
        bars = 1 - bars if sign == "|" else bars
        depth += (sign in "([") - (sign in ")]")
        found.append(depth + bars)
    return found


def _cut(formula: str, places: list[int]) -> list[str]:
    """A formula cut at these places."""
    ends = [*places, len(formula)]
    return [formula[begin:end] for begin, end in zip([0, *places], ends, strict=True)]
