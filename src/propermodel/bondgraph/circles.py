"""Parameters that are defined by each other, so that none of them has a value."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from propermodel.bondgraph.graph import FlatParameter
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Involved
from propermodel.expressions.core import Expr, leaves


def parameter_circles(parameters: Iterable[FlatParameter]) -> list[Diagnostic]:
    """A fault for each circle of parameters that is met when they are computed in turn."""
    known = {parameter.symbol: parameter for parameter in parameters}
    done: set[Expr] = set()
    found: list[Diagnostic] = []
    for start, parameter in known.items():
        waiting: dict[Expr, Iterator[Expr]] = {} if start in done else {start: iter(leaves(parameter.value))}
        while waiting:
            last, needs = next(reversed(waiting.items()))
            needed = next((leaf for leaf in needs if leaf in known and leaf not in done), None)
            if needed is None:
                done.add(last)
                del waiting[last]
            elif needed in waiting:
                opened = list(waiting)
                found.append(_circle([known[item] for item in opened[opened.index(needed) :]]))
            else:
                waiting[needed] = iter(leaves(known[needed].value))
    return found


def _circle(members: list[FlatParameter]) -> Diagnostic:
    names = ", ".join(str(parameter.path) for parameter in members)
    needs = [*members[1:], members[0]]
    return Diagnostic(
        "model/parameter-circle",
        f"these parameters are defined by each other: {names}" if len(members) > 1 else f"{names} is defined by itself",
        source=next((parameter.source for parameter in members if parameter.source.line), NO_SOURCE),
        involved=tuple(
            Involved(str(parameter.path), f"needs {need.path}", parameter.source)
            for parameter, need in zip(members, needs, strict=True)
        ),
        help="give one of them a number",
    )
