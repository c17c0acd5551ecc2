"""A program at one instant of a run: the values of its expressions, and their exact derivatives.

Derivatives are made by forward differentiation with numbers, one sparse row per node, by the rules of
`expressions.derivatives`; unknowns of implicit blocks follow by the implicit function theorem. Controllers are held.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from propermodel.codegen.lower import Lowered
from propermodel.codegen.machine import FloatArray, Memory
from propermodel.codegen.numeric import Number, newton
from propermodel.codegen.program import Function, Solve
from propermodel.codegen.schedule import Call, leaf_slot, number_solves, sequence
from propermodel.diagnostics import SimulationError
from propermodel.equations.system import EquationSystem
from propermodel.expressions.core import Expr, Op
from propermodel.expressions.derivatives import local_partials
from propermodel.simulation.evaluation import Evaluation, missing

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Row = Mapping[Expr, float]  # the non-zero derivatives of one quantity, by leaf
NOTHING: Row = {}


class Point:
    """The values of the expressions of a system at the time and state of a memory, which is not changed."""

    def __init__(self, system: EquationSystem, lowered: Lowered, memory: Memory, *, from_above: bool = False) -> None:
        """Solve the implicit blocks at this point.

        Args:
            system: The equations.
            lowered: Their program.
            memory: The point.
            from_above: Whether derivatives where an absolute value or a root is zero are those of growing arguments, so
                that a vertical tangent shows, instead of zero, with which iterations go on.

        Raises:
            SimulationError: an implicit block has no solution here.
        """
        program = lowered.program
        self._from_above = from_above
        self.system = system
        self.lowered = lowered
        self.time = memory.time
        self.unknown: FloatArray = memory.unknown.copy()
        self._layout = program.layout
        self._evaluation = Evaluation(lowered, replace(memory, state=memory.state.copy(), unknown=self.unknown))
        self._values: dict[Expr, Number] = {}
        wanted = {solve.unknowns: solve for solve in number_solves(program)}
        self._solves = [wanted[block.unknowns] for block in system.blocks if block.unknowns in wanted]
        with np.errstate(all="ignore"):
            for solve in self._solves:
                self._solve(solve)

    def value(self, expr: Expr) -> float:
        """The value of one expression."""
        return float(self.values([expr])[0])

    def values(self, exprs: Sequence[Expr]) -> FloatArray:
        """The values of expressions of states, held values, parameters, unknowns and time."""
        with np.errstate(all="ignore"):
            self._compute(exprs, self._values)
        return np.array([float(self._values[expr]) for expr in exprs])

    def derivatives(self, roots: Sequence[Expr], wrt: Sequence[Expr]) -> csr_array:
        """The derivative of each root (row) with respect to each leaf or node (column), as a sparse matrix.

        Raises:
            SimulationError: the equations of an implicit block are singular here.
        """
        from scipy.sparse import csr_array

        rows = self._rows(roots, wrt)
        column = {leaf: index for index, leaf in enumerate(wrt)}
        pointer = np.cumsum([0, *(len(row) for row in rows)])
        indices = np.array([column[leaf] for row in rows for leaf in row], dtype=np.int64)
        data = np.array([value for row in rows for value in row.values()], dtype=np.float64)
        return csr_array((data, indices, pointer), shape=(len(rows), len(column)))

    def matrix(self, roots: Sequence[Expr], wrt: Sequence[Expr]) -> FloatArray:
        """The same with its zeros, for small models.

        Raises:
            SimulationError: the equations of an implicit block are singular here.
        """
        found = np.zeros((len(roots), len(wrt)))
        column = {leaf: index for index, leaf in enumerate(wrt)}
        for index, row in enumerate(self._rows(roots, wrt)):
            for leaf, value in row.items():
                found[index, column[leaf]] = value
        return found

    # -- values --------------------------------------------------------------------------------------------

    def _compute(self, roots: Iterable[Expr], known: dict[Expr, Number]) -> None:
        self._evaluation.complete(roots, known)

    def _solve(self, solve: Solve) -> None:
        items = sequence(Function("point", (solve,)), {solve: 0}, lambda _: False)
        (call,) = (item for item in items if isinstance(item, Call))
        self._compute(call.captures, self._values)
        slots = [leaf_slot(self._layout, unknown).index for unknown in solve.unknowns]

        def evaluate(at: list[Number]) -> tuple[list[Number], list[list[Number]]]:
            local = _Layered(self._values, dict(zip(solve.unknowns, at, strict=True)))
            roots = (*solve.residuals, *(entry for row in solve.jacobian for entry in row))
            self._compute(roots, local)
            residuals = [local[item] * 1.0 for item in solve.residuals]
            return residuals, [[local[item] * 1.0 for item in row] for row in solve.jacobian]

        solution, failed = newton(call, [self.unknown[index] for index in slots], np.True_, evaluate)
        if np.any(failed):
            names = ", ".join(str(path) for path in dict.fromkeys(solve.paths))
            raise SimulationError.of(
                "simulation/not-converged",
                f"the implicit block of {names} has no solution at {self.time:g} s",
                help="check the initial values and the laws around this loop",
            )
        self.unknown[slots] = solution
        self._values.update(zip(solve.unknowns, solution, strict=True))

    # -- derivatives ---------------------------------------------------------------------------------------

    def _rows(self, roots: Sequence[Expr], wrt: Iterable[Expr]) -> list[Row]:
        known: dict[Expr, Row] = {leaf: {leaf: 1.0} for leaf in wrt}
        with np.errstate(all="ignore"):
            for solve in self._solves:
                self._differentiate_solution(solve, known)
            self._differentiate(roots, known)
        return [known[root] for root in roots]

    def _differentiate(self, roots: Iterable[Expr], known: dict[Expr, Row]) -> None:
        for node in missing(roots, known):
            known[node] = self._row(node, known) if any(known[arg] for arg in node.args) else NOTHING

    def _row(self, node: Expr, known: Mapping[Expr, Row]) -> Row:
        if node.op is Op.WHERE:
            self._compute((node,), self._values)
            condition = self._values[node.args[0]]
            return known[node.args[1] if condition else node.args[2]]
        result: dict[Expr, float] = {}
        for partial, arg in zip(local_partials(node), node.args, strict=True):
            row = known[arg]
            if not row:
                continue
            self._compute((partial,), self._values)
            factor = float(self._values[partial])
            if factor == 0.0 and self._from_above:
                factor = self._from_above_zero(node, partial)
            if factor == 0.0:
                continue
            for leaf, value in row.items():
                result[leaf] = result.get(leaf, 0.0) + factor * value
        return result

    def _from_above_zero(self, node: Expr, partial: Expr) -> float:
        """What a derivative that is zero where its argument is zero tends to as the argument decreases to zero."""
        if partial.op is Op.SIGN:
            return 1.0
        is_vertical = node.op is Op.SQUARE_ROOT and self._values[node] == 0.0
        return math.inf if is_vertical else 0.0

    def _differentiate_solution(self, solve: Solve, known: dict[Expr, Row]) -> None:
        """The derivatives of the unknowns z(x) of residuals r(z, x) = 0: dz/dx = - (dr/dz)^-1 dr/dx."""
        unknowns = solve.unknowns
        inner = _Layered(known, {unknown: {unknown: 1.0} for unknown in unknowns})
        self._differentiate(solve.residuals, inner)
        rows = [inner[residual] for residual in solve.residuals]
        leaves = list(dict.fromkeys(leaf for row in rows for leaf in row if leaf not in unknowns))
        matrix = np.array([[row.get(unknown, 0.0) for unknown in unknowns] for row in rows])
        right = np.array([[row.get(leaf, 0.0) for leaf in leaves] for row in rows])
        try:
            slopes = -np.linalg.solve(matrix, right.reshape(len(unknowns), len(leaves)))
        except np.linalg.LinAlgError as error:
            names = ", ".join(str(path) for path in dict.fromkeys(solve.paths))
            raise SimulationError.of(
                "simulation/singular-block",
                f"the equations of the implicit block of {names} are singular at {self.time:g} s: "
                "its derivatives do not exist there",
                help="choose another point, or check the laws around this loop",
            ) from error
        for unknown, row in zip(unknowns, slopes, strict=True):
            known[unknown] = {leaf: float(value) for leaf, value in zip(leaves, row, strict=True) if value != 0.0}


class _Layered(dict[Expr, "Number"]):
    """A dictionary of its own entries on top of others, which it reads and does not change."""

    def __init__(self, below: Mapping[Expr, Number], own: Mapping[Expr, Number]) -> None:
        super().__init__(own)
        self._below = below

    def __missing__(self, node: Expr) -> Number:
        return self._below[node]

    def __contains__(self, node: object) -> bool:
        return super().__contains__(node) or node in self._below


@dataclass(frozen=True, eq=False)
class Jacobian:
    """The rates of all states at a point, and their derivatives with respect to the states."""

    rates: FloatArray
    matrix: csr_array


def jacobian_at(point: Point) -> Jacobian:
    """The rates and their Jacobian, controllers held."""
    rates = [state.derivative for state in point.system.states]
    symbols = [state.symbol for state in point.system.states]
    return Jacobian(point.values(rates), point.derivatives(rates, symbols))
