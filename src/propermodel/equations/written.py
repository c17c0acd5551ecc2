"""Readable equations as text, Markdown and LaTeX."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from propermodel.equations.layout import INDENT, WIDTH, wrapped
from propermodel.equations.notation import LATEX, TEXT, Notation, latex_names, spelt_out
from propermodel.expressions.core import ONE, Expr, SymbolKind

if TYPE_CHECKING:
    from propermodel.equations.readable import ReadableEquations

FEW = 8  # as many states need no headings
_KINDS = {
    SymbolKind.PARAMETER: "parameter",
    SymbolKind.TABLE: "table",
    SymbolKind.DISCRETE: "held value",
    SymbolKind.TIME: "time",
    SymbolKind.STATE: "state",
}

Line = tuple[str, str]  # left, right


def text_of(equations: ReadableEquations) -> str:
    """The equations as plain text within `WIDTH` columns where names allow it."""
    names = {leaf: str(name) for leaf, name in equations.names.items()}
    count = len(equations.states)
    lines = [f"{equations.title}: {count} state{'' if count == 1 else 's'}"]
    if equations.inputs:
        lines.append("inputs: " + ", ".join(_with_unit(names[leaf], leaf.data.unit) for leaf in equations.inputs))
    grouped = count > FEW and len({state.group for state in equations.states}) > 1
    rows = _state_lines(equations, TEXT, names)
    group = None
    width = max((len(left) for left, _ in rows), default=0)
    for state, row in zip(equations.states, rows, strict=True):
        if grouped and state.group != group:
            group = state.group
            lines += ["", f"{group or equations.title}:"]
        lines += wrapped(*row, width)
    for heading, further in _further(equations, TEXT, names):
        lines += ["", *_heading(heading)]
        lines += [text for row in further for text in wrapped(*row, max(len(left) for left, _ in further))]
    return "\n".join(lines)


def markdown_of(equations: ReadableEquations) -> str:
    """The equations as Markdown."""
    names = latex_names(equations.names)
    parts = [f"## {equations.title}", ""]
    parts += [f"$${left} = {right}$$\n" for left, right in _state_lines(equations, LATEX, names)]
    for heading, further in _further(equations, LATEX, names):
        parts += [f"{heading[0].upper()}{heading[1:]}\n", *(f"$${left} = {right}$$\n" for left, right in further)]
    parts += ["| symbol | name | unit | kind |", "| --- | --- | --- | --- |"]
    given = set(equations.inputs)
    shown = {state.symbol for state in equations.states}
    for leaf, name in equations.names.items():
        kind = "input" if leaf in given else "state" if leaf in shown else _KINDS.get(leaf.data.kind, "variable")
        parts.append(f"| ${names[leaf]}$ | `{name}` | {leaf.data.unit or '1'} | {kind} |")
    return "\n".join(parts) + "\n"


def latex_of(equations: ReadableEquations) -> str:
    """The equations as LaTeX."""
    names = latex_names(equations.names)
    parts = _aligned(_state_lines(equations, LATEX, names))
    for heading, further in _further(equations, LATEX, names):
        parts += ["", rf"\noindent {heading}", *_aligned(further)]
    return "\n".join(parts) + "\n"


def _aligned(rows: list[Line]) -> list[str]:
    if not rows:
        return []
    inner = [f"  {left} &= {right}" for left, right in rows]
    return [r"\begin{align*}", " \\\\\n".join(inner), r"\end{align*}"]


def _state_lines(equations: ReadableEquations, notation: Notation, names: Mapping[Expr, str]) -> list[Line]:
    lines: list[Line] = []
    times = "*" if notation is TEXT else r" \, "
    for state in equations.states:
        rate = notation.rate(names[state.symbol])
        left = rate if state.coefficient is ONE else f"{notation.factor(state.coefficient, names)}{times}{rate}"
        lines.append((left, notation.formula(state.right, names)))
    return lines


def _further(
    equations: ReadableEquations, notation: Notation, names: Mapping[Expr, str]
) -> Iterable[tuple[str, list[Line]]]:
    """What the state equations mention, under headings."""
    dollar = "" if notation is TEXT else "$"
    for block in equations.blocks:
        unknowns = ", ".join(f"{dollar}{names[unknown]}{dollar}" for unknown in block.unknowns)
        yield f"solved together for {unknowns}:", [("0", notation.formula(r, names)) for r in block.residuals]
    if equations.outputs:
        yield "outputs:", [(names[d.symbol], notation.formula(d.value, names)) for d in equations.outputs]
    if equations.definitions:
        yield "where:", [(names[d.symbol], notation.formula(d.value, names)) for d in equations.definitions]
    for update in equations.updates:
        rows = [(names[held], notation.formula(value, names)) for held, value in update.values]
        controller = str(update.controller) if notation is TEXT else f"${spelt_out(update.controller)}$"
        yield f"at every run of {controller}:", rows
    for event in equations.events:
        condition = notation.formula(event.condition, names)
        rows = [(_after(names[target], notation), notation.formula(new, names)) for target, new in event.changes]
        yield f"when {dollar}{condition}{dollar}:", rows


def _heading(text: str) -> list[str]:
    """A heading on lines of `WIDTH`."""
    return textwrap.wrap(text, WIDTH, subsequent_indent=" " * INDENT, break_long_words=False, break_on_hyphens=False)


def _after(name: str, notation: Notation) -> str:
    """The name of a value after an event, on whose right side all values are those before it."""
    return name if notation is TEXT else f"{{{name}}}^{{+}}"


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name
