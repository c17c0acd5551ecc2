"""Divisions become multiplications with reciprocals where this saves time.

A division takes as long as several multiplications, and many divisors (masses, resistances, volumes) are parameters,
or serve several times, or are known long before what they divide. The quotient may differ in its last bit.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from propermodel.codegen.program import Assign, Function, ImplicitStep, Program, Solve
from propermodel.codegen.schedule import Level, is_leaf, node_levels
from propermodel.expressions.core import ONE, Expr, Op, constant, intern_node

# About how many cycles pass until a result is ready; everything else takes `_SHORT`.
_LATENCIES = {
    Op.DIVIDE: 13,
    Op.SQUARE_ROOT: 18,
    Op.LOOKUP: 15,
    Op.EXPONENTIAL: 50,
    Op.LOGARITHM: 50,
    Op.SINE: 50,
    Op.COSINE: 50,
    Op.TANH: 60,
    Op.ARCTANGENT: 70,
    Op.POWER: 20,
}
_SHORT = 4


def with_reciprocals(program: Program) -> Program:
    """The program with such divisions replaced."""
    functions = program.functions
    done = _Rewriting(node_levels(functions, program.layout)).done

    def replaced(step: Assign | Solve) -> Assign | Solve:
        if isinstance(step, Assign):
            return Assign(step.slot, done[step.value])
        return replace(
            step,
            residuals=tuple(done[item] for item in step.residuals),
            jacobian=tuple(tuple(done[entry] for entry in row) for row in step.jacobian),
        )

    def of(function: Function) -> Function:
        return replace(function, steps=tuple(replaced(step) for step in function.steps))

    def replaced_step(step: ImplicitStep) -> ImplicitStep:
        return replace(
            step,
            first=of(step.first),
            first_again=None if step.first_again is None else of(step.first_again),
            later=tuple(of(function) for function in step.later),
            middle=None if step.middle is None else of(step.middle),
        )

    implicit = program.implicit_step
    return replace(
        program,
        rates=of(program.rates),
        displacement_rates=of(program.displacement_rates),
        observe=of(program.observe),
        samples=tuple(of(function) for function in program.samples),
        corrections=tuple(of(function) for function in program.corrections),
        guards=None if program.guards is None else of(program.guards),
        jumps=None if program.jumps is None else of(program.jumps),
        switching=None if program.switching is None else of(program.switching),
        implicit_step=None if implicit is None else replaced_step(implicit),
    )


class _Rewriting:
    def __init__(self, levels: dict[Expr, Level]) -> None:
        self.done: dict[Expr, Expr] = {}
        self._levels = levels
        self._uses = Counter(node.args[1] for node in levels if node.op is Op.DIVIDE)
        self._ready: dict[Expr, int] = {}
        for node in levels:
            begin = max((self._ready[arg] for arg in node.args), default=0)
            self._ready[node] = begin + (0 if is_leaf(node) else _LATENCIES.get(node.op, _SHORT))
            self.done[node] = self._replaced(node, tuple(self.done[arg] for arg in node.args))

    def _replaced(self, node: Expr, args: tuple[Expr, ...]) -> Expr:
        if node.op is not Op.DIVIDE or not self._is_better_multiplied(*node.args):
            return node if is_leaf(node) or args == node.args else intern_node(node.op, args, node.data)
        divisor = args[1]
        if divisor.op is Op.CONSTANT:
            return intern_node(Op.MULTIPLY, (args[0], constant(1.0 / divisor.data[0])))
        return intern_node(Op.MULTIPLY, (args[0], intern_node(Op.DIVIDE, (ONE, divisor))))

    def _is_better_multiplied(self, dividend: Expr, divisor: Expr) -> bool:
        if dividend.op is Op.CONSTANT:
            return False
        if self._levels[dividend] != self._levels[divisor]:
            return self._levels[dividend] > self._levels[divisor]
        return self._uses[divisor] > 1 or self._ready[dividend] > self._ready[divisor]
