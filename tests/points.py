"""Evaluates a system of equations with plain numbers, blocks included, without any generated code."""

from __future__ import annotations

from collections.abc import Mapping

from scipy.optimize import root

from propermodel.bondgraph.flatten import flatten
from propermodel.causality.assign import assign_causality
from propermodel.diagnostics import ModelError, Path, parse_path
from propermodel.equations.formulate import formulate
from propermodel.equations.system import EquationSystem
from propermodel.expressions.core import TIME, Expr, Op, postorder
from propermodel.expressions.interpret import interpret, interpret_all
from propermodel.modelling import Component, Model, elaborate


def equations_of(model: Component | Model) -> EquationSystem:
    """Flattened, causal, formulated."""
    if isinstance(model, Component):
        model = elaborate(model)
    return formulate(assign_causality(flatten(model)))


class Point:
    """A system of equations at given states, inputs, held values and time."""

    def __init__(
        self,
        system: EquationSystem,
        states: Mapping[str, float],
        inputs: Mapping[str, float] | None = None,
        held: Mapping[str, float] | None = None,
        time: float = 0.0,
    ) -> None:
        self.system = system
        graph = system.causal.graph
        self.known: dict[Expr, float] = {TIME: time}
        for _ in graph.parameters:  # a value may refer to a parameter that is declared later
            for flat in graph.parameters.values():
                try:
                    self.known[flat.symbol] = interpret(flat.value, self.known)
                except ModelError:
                    continue
        given = {parse_path(path): value for path, value in (inputs or {}).items()}
        everything = [*system.values.values(), *(s.derivative for s in system.states)]
        everything += [r for b in system.blocks for r in b.residuals]
        for node in postorder(everything):
            if node.op is Op.LOOKUP:
                table = node.args[0]
                self.known[table] = 0.0
                if table.data.path in given:
                    self.known[node] = given[table.data.path]
        names = {str(s.path): s.symbol for s in system.states}
        assert set(states) == set(names), f"states are {sorted(names)}"
        for path, value in states.items():
            self.known[names[path]] = value
        for path, value in (held or {}).items():
            leaf = next(h for c in graph.controllers for h, _ in c.starts if str(h.data.path) == path)
            self.known[leaf] = value
        self.solve()

    def solve(self) -> None:
        """Find the unknowns of the implicit blocks, in their order."""
        for block in self.system.blocks:

            def residuals(x, block=block):
                return interpret_all(block.residuals, {**self.known, **dict(zip(block.unknowns, x, strict=True))})

            answer = root(residuals, [0.1] * len(block.unknowns), tol=1e-13)
            assert max(abs(r) for r in residuals(answer.x)) < 1e-9, answer.message
            self.known.update(zip(block.unknowns, map(float, answer.x), strict=True))

    def rates(self) -> dict[str, float]:
        """The derivative of every state."""
        return {str(s.path): interpret(s.derivative, self.known) for s in self.system.states}

    def __getitem__(self, path: str) -> float:
        """The value of an observable or signal."""
        wanted: Path = parse_path(path)
        symbol = next(s for s in self.system.values if s.data.path == wanted)
        return interpret(self.system.values[symbol], self.known)
