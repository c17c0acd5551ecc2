"""A linear model as matrices of symbols: x' = A x + B u + c."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from propermodel.diagnostics import Diagnostic, Involved, StructureError
from propermodel.equations.names import Name
from propermodel.equations.notation import LATEX, TEXT, latex_names
from propermodel.equations.readable import HasEquations, ReadableEquations, state_equations
from propermodel.equations.system import EquationSystem
from propermodel.expressions.core import ZERO, Expr, Substitution, SymbolKind, is_zero, leaves
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.expressions.simplify import Simplifier

# Matrices with more columns than this are listed entry by entry.
MOST_COLUMNS = 12

Rows = tuple[tuple[Expr, ...], ...]


@dataclass(frozen=True)
class SymbolicMatrices:
    """x' = A x + B u + c in symbols of parameters; `a` and `b` hold what is not zero, by row and column."""

    title: str
    states: tuple[Expr, ...]
    inputs: tuple[Expr, ...]
    a: Mapping[tuple[int, int], Expr]
    b: Mapping[tuple[int, int], Expr]
    constant: tuple[Expr, ...]
    names: Mapping[Expr, Name]

    def entry(self, row: int, column: int) -> Expr:
        """An entry of A."""
        return self.a.get((row, column), ZERO)

    def text(self) -> str:
        """The matrices as plain text: row by row, or only what is not zero where they are large."""
        names = {leaf: str(name) for leaf, name in self.names.items()}
        lines = [f"{self.title}: x' = A x + B u" + (" + c" if self._has_constant else "")]
        lines.append("x = " + ", ".join(names[leaf] for leaf in self.states))
        if self.inputs:
            lines.append("u = " + ", ".join(names[leaf] for leaf in self.inputs))
        for letter, entries, width in (("A", self.a, len(self.states)), ("B", self.b, len(self.inputs))):
            if not width:
                continue
            lines.append("")
            if max(width, len(self.states)) > MOST_COLUMNS:
                lines.extend(
                    f"{letter}[{row + 1}, {column + 1}] = {TEXT.formula(value, names)}"
                    for (row, column), value in sorted(entries.items())
                )
            else:
                lines.extend(self._grid(letter, entries, width, lambda expr: TEXT.formula(expr, names)))
        if self._has_constant:
            lines += ["", *(f"c[{i + 1}] = {TEXT.formula(c, names)}" for i, c in enumerate(self.constant))]
        return "\n".join(lines)

    def latex(self) -> str:
        """The matrices as LaTeX (needs amsmath)."""
        names = latex_names(self.names)
        size = len(self.states)

        def matrix(entries: Mapping[tuple[int, int], Expr], width: int) -> str:
            rows = (
                " & ".join(LATEX.formula(entries.get((row, column), ZERO), names) for column in range(width))
                for row in range(size)
            )
            return r"\begin{bmatrix} " + r" \\ ".join(rows) + r" \end{bmatrix}"

        def column(items: list[str]) -> str:
            return r"\begin{bmatrix} " + r" \\ ".join(items) + r" \end{bmatrix}"

        parts = [
            r"\frac{\mathrm{d}}{\mathrm{d}t} " + column([names[leaf] for leaf in self.states]),
            "= " + matrix(self.a, size) + " " + column([names[leaf] for leaf in self.states]),
        ]
        if self.inputs:
            parts.append("+ " + matrix(self.b, len(self.inputs)) + " " + column([names[leaf] for leaf in self.inputs]))
        if self._has_constant:
            parts.append("+ " + column([LATEX.formula(c, names) for c in self.constant]))
        return "\n".join(parts) + "\n"

    def markdown(self) -> str:
        """The matrices as a formula in Markdown."""
        return f"## {self.title}\n\n$$\n{self.latex()}$$\n"

    @property
    def _has_constant(self) -> bool:
        return not all(is_zero(c) for c in self.constant)

    def _grid(
        self, letter: str, entries: Mapping[tuple[int, int], Expr], width: int, write: Callable[[Expr], str]
    ) -> list[str]:
        size = len(self.states)
        cells = [[write(entries.get((row, column), ZERO)) for column in range(width)] for row in range(size)]
        widths = [max(len(cells[row][column]) for row in range(size)) for column in range(width)]
        lines: list[str] = []
        for row in range(size):
            inside = "  ".join(cells[row][column].center(widths[column]) for column in range(width))
            lines.append(
                f"{letter if row == (size - 1) // 2 else ' '} {'=' if row == (size - 1) // 2 else ' '} [ {inside} ]"
            )
        return lines

    def __str__(self) -> str:
        return self.text()


def symbolic_matrices(of: EquationSystem | HasEquations) -> SymbolicMatrices:
    """The matrices of a linear model with constant coefficients.

    Raises:
        StructureError: the model is not linear, or its coefficients change with time; the states are named.
    """
    equations = state_equations(of)
    states = tuple(state.symbol for state in equations.states)
    moving = (*states, *equations.inputs)
    place = {leaf: number for number, leaf in enumerate(moving)}
    rates = _rates(equations)
    simplifier = Simplifier()
    a: dict[tuple[int, int], Expr] = {}
    b: dict[tuple[int, int], Expr] = {}
    constant: list[Expr] = []
    faults: list[Diagnostic] = []
    for row, (state, rate) in enumerate(zip(equations.states, rates, strict=True)):
        own = [leaf for leaf in leaves(rate) if leaf in place]
        slopes = partial_derivatives([rate], own)[0]
        entries = {place[leaf]: simplifier(slope) for leaf, slope in slopes.items()}
        rest = rate
        for leaf, slope in slopes.items():
            rest = rest - slope * leaf
        rest = simplifier(rest)
        varying = [
            leaf
            for entry in (*entries.values(), rest)
            for leaf in leaves(entry)
            if leaf.data.kind is not SymbolKind.PARAMETER
        ]
        if varying:
            faults.append(_nonlinear(equations, state.symbol, list(dict.fromkeys(varying))))
            continue
        for column, entry in entries.items():
            if not is_zero(entry):
                target = a if column < len(states) else b
                target[row, column if column < len(states) else column - len(states)] = entry
        constant.append(rest)
    if faults:
        raise StructureError(faults)
    return SymbolicMatrices(equations.title, states, equations.inputs, a, b, tuple(constant), equations.names)


def _rates(equations: ReadableEquations) -> list[Expr]:
    """The rates with definitions put in."""
    work = Substitution({})
    for definition in equations.definitions:
        work.define(definition.symbol, definition.value)
    return [work(state.derivative) for state in equations.states]


def _nonlinear(equations: ReadableEquations, state: Expr, varying: list[Expr]) -> Diagnostic:
    names = ", ".join(str(equations.names.get(leaf, leaf.data.path)) for leaf in varying[:5])
    return Diagnostic(
        "equations/nonlinear",
        f"the rate of {equations.names[state]} is not linear with constant coefficients",
        involved=(Involved(names, "stand in the coefficients"),),
        help="linearise the model at a point, which gives matrices of numbers",
    )
