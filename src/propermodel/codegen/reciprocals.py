"""Divisions by what seldom changes become multiplications with a reciprocal that is computed as seldom.

A division takes as long as ten multiplications, and most divisors in models (masses, resistances, volumes) are
parameters. The quotient may differ in its last bit.
"""

from __future__ import annotations

from dataclasses import replace

from propermodel.codegen.program import Assign, Function, Program, Solve
from propermodel.codegen.schedule import Level, is_leaf, node_levels
from propermodel.expressions.core import ONE, Expr, Op, constant, intern_node, postorder


def with_reciprocals(program: Program) -> Program:
    """The program with such divisions replaced."""
    functions = (program.rates, program.displacement_rates, program.observe, *program.samples)
    levels = node_levels(functions, program.layout)
    done: dict[Expr, Expr] = {}

    def replaced(root: Expr) -> Expr:
        if root not in done:
            for node in postorder([root]):
                if node not in done:
                    done[node] = _replaced(node, tuple(done[arg] for arg in node.args), levels)
        return done[root]

    def of(function: Function) -> Function:
        return replace(function, steps=tuple(_step(step) for step in function.steps))

    def _step(step: Assign | Solve) -> Assign | Solve:
        if isinstance(step, Assign):
            return replace(step, value=replaced(step.value))
        return replace(
            step,
            residuals=tuple(replaced(item) for item in step.residuals),
            jacobian=tuple(tuple(replaced(entry) for entry in row) for row in step.jacobian),
        )

    return replace(
        program,
        rates=of(program.rates),
        displacement_rates=of(program.displacement_rates),
        observe=of(program.observe),
        samples=tuple(of(function) for function in program.samples),
    )


def _replaced(node: Expr, args: tuple[Expr, ...], levels: dict[Expr, Level]) -> Expr:
    if node.op is Op.DIVIDE and levels[node.args[0]] > levels[node.args[1]]:
        divisor = args[1]
        if divisor.op is Op.CONSTANT:
            return intern_node(Op.MULTIPLY, (args[0], constant(1.0 / divisor.data[0])))
        return intern_node(Op.MULTIPLY, (args[0], intern_node(Op.DIVIDE, (ONE, divisor))))
    return node if is_leaf(node) or args == node.args else intern_node(node.op, args, node.data)
