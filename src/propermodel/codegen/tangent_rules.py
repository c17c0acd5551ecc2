"""Tangents of expressions: forward differentiation in several directions at once, through implicit blocks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from propermodel.codegen.dense import solve_columns
from propermodel.codegen.program import Solve
from propermodel.codegen.schedule import Order
from propermodel.codegen.state_jacobian import MOST_UNKNOWNS, SymbolicArithmetic
from propermodel.diagnostics import SimulationError
from propermodel.expressions.core import ZERO, Expr, is_zero, leaves
from propermodel.expressions.derivatives import combine_tangents

Tangents = tuple[Expr, ...]  # of one quantity, one for each direction


def needed_solves(solves: Iterable[Solve], values: Iterable[Expr]) -> list[Solve]:
    """The blocks that some values need, each after those that it needs itself."""
    owner = {unknown: solve for solve in solves for unknown in solve.unknowns}
    needs: dict[Solve, set[Solve]] = {}
    pending = [owner[leaf] for leaf in leaves(*values) if leaf in owner]
    while pending:
        solve = pending.pop()
        if solve not in needs:
            inside = leaves(*solve.residuals, *(entry for row in solve.jacobian for entry in row))
            needs[solve] = {owner[leaf] for leaf in inside if leaf in owner} - {solve}
            pending.extend(needs[solve])
    ordered: dict[Solve, None] = {}
    waiting = [solve for solve in dict.fromkeys(owner.values()) if solve in needs]
    while waiting:
        ordered.update((solve, None) for solve in waiting if needs[solve] <= ordered.keys())
        waiting = [solve for solve in waiting if solve not in ordered]
    return list(ordered)


class TangentRules:
    """Tangents of expressions, from those of their leaves; each node is differentiated once."""

    def __init__(self, known: Mapping[Expr, Tangents], count: int) -> None:
        self._known = dict(known)
        self._nothing: Tangents = (ZERO,) * count
        self._order = Order(lambda node: node in self._known)

    def of(self, root: Expr) -> Tangents:
        """The tangents of an expression whose unknowns have been solved for."""
        for node in self._order.new_below(root):
            self._known[node] = self._combined(node, [self._known.get(arg, self._nothing) for arg in node.args])
        return self._known.get(root, self._nothing)

    def _combined(self, node: Expr, tangents: list[Tangents]) -> Tangents:
        if all(tangent is self._nothing for tangent in tangents):
            return self._nothing
        found = combine_tangents(node, tangents)
        return self._nothing if all(map(is_zero, found)) else found

    def add_solution(self, solve: Solve) -> None:
        """Make the tangents of the unknowns z of r(z, x) = 0 known: dr/dz z' = - dr/dx x'."""
        if len(solve.unknowns) > MOST_UNKNOWNS:
            names = ", ".join(str(path) for path in dict.fromkeys(solve.paths[:3]))
            raise SimulationError.of(
                "simulation/large-block",
                f"sensitivities need the derivatives of {len(solve.unknowns)} unknowns that must be solved for "
                f"together ({names}, ...); they can be had for {MOST_UNKNOWNS}",
                help="break the loop or the rigid coupling by a compliance",
            )
        right = self._explicit(solve)
        moved = [k for k, column in enumerate(zip(*right, strict=True)) if not all(map(is_zero, column))]
        if not moved:
            return
        matrix = [list(row) for row in solve.jacobian]
        found = solve_columns(matrix, [[-row[k] for k in moved] for row in right], SymbolicArithmetic())
        for unknown, row in zip(solve.unknowns, found, strict=True):
            by_direction = dict(zip(moved, row, strict=True))
            self._known[unknown] = tuple(by_direction.get(k, ZERO) for k in range(len(self._nothing)))

    def _explicit(self, solve: Solve) -> list[Tangents]:
        """The tangents of the residuals while the unknowns stay."""
        unknowns = set(solve.unknowns)
        inside: dict[Expr, Tangents] = dict.fromkeys(unknowns, self._nothing)
        order = Order(lambda _: False)
        for root in solve.residuals:
            for node in order.new_below(root):
                if any(arg in inside for arg in node.args):
                    inside[node] = self._combined(
                        node, [inside[arg] if arg in inside else self.of(arg) for arg in node.args]
                    )
        return [inside[root] if root in inside else self.of(root) for root in solve.residuals]
