"""Linearly implicit (Rosenbrock-W) steps as straight-line functions of a program.

Every stage solves linear equations with one matrix, in the form without products with the Jacobian J (Hairer and
Wanner, Solving Ordinary Differential Equations II, 1996, section IV.7). With u = -w, so that no sign is computed,

    (J - I / (gamma h)) w_i = f(t + alpha_i h, x - sum_j a_ij w_j) - sum_j c_ij / h w_j + g_i h df/dt
    x(t + h) = x - sum_i m_i w_i

POWER is computed at the beginning of the step only: stages may lie far beside the solution where it is stiff.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from propermodel.codegen.machine import Method
from propermodel.codegen.program import Array, Assign, Function, ImplicitStep, Program, Slot, Solve
from propermodel.codegen.sparse_lu import SparseFactors, factorise
from propermodel.codegen.state_jacobian import StateJacobian, state_jacobian
from propermodel.codegen.tableaus import TABLEAUS, Tableau
from propermodel.diagnostics import Path
from propermodel.expressions.core import (
    ZERO,
    Expr,
    Op,
    SymbolKind,
    constant,
    divide,
    multiply,
    postorder,
    subtract,
    symbol,
    where,
)

STEP = symbol(SymbolKind.TIME, Path(("step",)), "s")


def with_step_of(program: Program, method: Method) -> Program:
    """The program with the step of a method, if that is linearly implicit and not yet there; otherwise as it is.

    Raises:
        SimulationError: the derivatives pass an implicit block that is too large.
    """
    tableau = TABLEAUS.get(method)
    if tableau is None or program.implicit_step is not None:
        return program
    return _Builder(program, tableau).program()


class _Builder:
    def __init__(self, program: Program, tableau: Tableau) -> None:
        self._program = program
        self._tableau = tableau
        self._size = program.layout.lengths.get(Array.STATE, 0)
        self._slots: dict[Expr, Slot] = {STEP: Slot(Array.STEP, 0)}
        self._counts: dict[Array, int] = {Array.STEP: 1, Array.WEAK: 1, Array.FACTOR: 0, Array.STAGE: 0}
        by_index = {slot.index: leaf for leaf, slot in program.layout.slots.items() if slot.array is Array.STATE}
        self._states = [by_index[i] for i in range(self._size)]

    def program(self) -> Program:
        program = self._program
        jacobian = state_jacobian(program.rates, program.layout)
        factors, keeping, is_weak = self._factors(jacobian)
        kept = factors.mapped(lambda entry: keeping.get(entry, entry))
        start = self._new(Array.STAGE, self._states)
        drift = dict(zip(jacobian.drift, self._new(Array.STAGE, jacobian.drift.values()), strict=True))
        handed_on = self._tableau.m if self._tableau.middle else self._tableau.a
        solutions = [self._new(Array.STAGE, self._states) for _ in handed_on]
        stores = [*self._stores(keeping), Assign(Slot(Array.WEAK, 0), is_weak)]
        step = ImplicitStep(
            first=self._first("first_stage", factors, jacobian, start, drift, solutions[0], stores),
            first_again=self._first("first_stage_again", kept, jacobian, start, drift, solutions[0], [])
            if self._tableau.takes_any_matrix
            else None,
            later=tuple(self._later(i, kept, start, drift, solutions) for i in range(1, len(self._tableau.m))),
            shares=self._tableau.alpha[1:],
            start=tuple(self._slots[leaf] for leaf in start),
            middle=self._middle(start, solutions) if self._tableau.middle else None,
        )
        layout = replace(
            program.layout,
            slots={**program.layout.slots, **self._slots},
            lengths={**program.layout.lengths, **self._counts},
        )
        return replace(program, layout=layout, implicit_step=step)

    def _new(self, array: Array, values: Iterable[object]) -> list[Expr]:
        """A symbol for each value, with its slot."""
        found: list[Expr] = []
        for _ in values:
            index = self._counts[array]
            self._counts[array] += 1
            leaf = symbol(SymbolKind.UNKNOWN, Path(("implicit step", array.value, str(index))))
            self._slots[leaf] = Slot(array, index)
            found.append(leaf)
        return found

    def _factors(self, jacobian: StateJacobian) -> tuple[SparseFactors, Mapping[Expr, Expr], Expr]:
        """The factors of J - I / (gamma h), the symbols under which those that change are kept, and WEAK."""
        unit = divide(1.0 / self._tableau.gamma, STEP)
        entries = dict(jacobian.entries)
        for i in range(self._size):
            entries[i, i] = subtract(entries.get((i, i), ZERO), unit)
        found = factorise(self._size, entries, unit)
        changing = self._changing(found.factors)
        weak = ZERO
        for i in reversed(range(self._size)):
            weak = where(found.is_weak[i], constant(i + 1.0), weak)
        return found.factors, dict(zip(changing, self._new(Array.FACTOR, changing), strict=True)), weak

    def _changing(self, factors: SparseFactors) -> list[Expr]:
        """The factors that are other than functions of parameters, each once."""
        entries: dict[Expr, None] = {}
        factors.mapped(lambda entry: entries.setdefault(entry) or entry)
        slots = self._program.layout.slots
        fixed: set[Expr] = set()
        for node in postorder(entries):
            if node.args:
                is_fixed = all(arg in fixed for arg in node.args)
            else:
                is_fixed = node.op is Op.CONSTANT or (node in slots and slots[node].array is Array.PARAMETER)
            if is_fixed:
                fixed.add(node)
        return [entry for entry in entries if entry.args and entry not in fixed]

    def _stores(self, keeping: Mapping[Expr, Expr]) -> list[Assign]:
        return [Assign(self._slots[leaf], entry) for entry, leaf in keeping.items()]

    def _first(
        self,
        name: str,
        factors: SparseFactors,
        jacobian: StateJacobian,
        start: list[Expr],
        drift: Mapping[int, Expr],
        solution: list[Expr],
        stores: list[Assign],
    ) -> Function:
        program = self._program
        right = self._rates()
        for i, value in jacobian.drift.items():
            right[i] = right[i] + multiply(multiply(self._tableau.drift[0], STEP), value)
        found = factors.solve(right)
        return Function(
            name,
            (
                *(step for step in program.rates.steps if isinstance(step, Solve)),
                *(step for step in program.rates.steps if isinstance(step, Assign) and step.slot.array is Array.POWER),
                *stores,
                *(Assign(self._slots[leaf], jacobian.drift[i]) for i, leaf in drift.items()),
                *self._kept(start, self._states),
                *self._kept(solution, found),
                *self._moved(self._states, [(self._tableau.a[0][0], found)]),
            ),
        )

    def _later(
        self,
        stage: int,
        factors: SparseFactors,
        start: list[Expr],
        drift: Mapping[int, Expr],
        solutions: list[list[Expr]],
    ) -> Function:
        tableau = self._tableau
        right = self._rates()
        per_step = [divide(c, STEP) for c in tableau.c[stage - 1]]
        for i in range(self._size):
            for factor, earlier in zip(per_step, solutions[:stage], strict=True):
                right[i] = subtract(right[i], multiply(factor, earlier[i]))
        if tableau.drift[stage]:
            for i, leaf in drift.items():
                right[i] = right[i] + multiply(multiply(tableau.drift[stage], STEP), leaf)
        found = factors.solve(right)
        is_last = stage == len(tableau.m) - 1
        weights, before = tableau.m if is_last else tableau.a[stage], tableau.a[stage - 1]
        every = [*solutions[:stage], found]
        # A stage that stands at the end of the one before, and its solution added, begins where that one has led.
        is_next = weights[:-1] == before
        moved = (
            self._moved(self._states, [(weights[-1], found)])
            if is_next
            else self._moved(start, list(zip(weights, every, strict=True)))
        )
        return Function(
            f"stage_{stage}",
            (
                *(step for step in self._program.rates.steps if isinstance(step, Solve)),
                *(self._kept(solutions[stage], found) if stage < len(solutions) else ()),
                *(self._errors(every) if is_last else ()),
                *moved,
            ),
        )

    def _errors(self, solutions: list[list[Expr]]) -> list[Assign]:
        """ERROR, but for its sign."""
        weighted = [pair for pair in zip(self._tableau.error, solutions, strict=False) if pair[0]]
        if not weighted:
            return []
        self._counts[Array.ERROR] = self._size
        values = [sum((multiply(w, solution[i]) for w, solution in weighted), ZERO) for i in range(self._size)]
        return [Assign(Slot(Array.ERROR, i), value) for i, value in enumerate(values)]

    def _middle(self, start: list[Expr], solutions: list[list[Expr]]) -> Function:
        terms = list(zip(self._tableau.middle, solutions, strict=True))
        return Function("middle", tuple(self._moved(start, terms)))

    def _rates(self) -> list[Expr]:
        rates = [ZERO] * self._size
        for step in self._program.rates.steps:
            if isinstance(step, Assign) and step.slot.array is Array.RATE:
                rates[step.slot.index] = step.value
        return rates

    def _kept(self, symbols: list[Expr], values: list[Expr]) -> list[Assign]:
        return [Assign(self._slots[leaf], value) for leaf, value in zip(symbols, values, strict=True)]

    def _moved(self, start: list[Expr], terms: list[tuple[float, list[Expr]]]) -> list[Assign]:
        """STATE away from the start by solutions of the stages."""
        moved: list[Assign] = []
        for i, before in enumerate(start):
            value = before
            for weight, solution in terms:
                value = subtract(value, multiply(weight, solution[i]))
            moved.append(Assign(Slot(Array.STATE, i), value))
        return moved
