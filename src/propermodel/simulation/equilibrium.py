"""Equilibria: states at which nothing changes but free positions, found by damped Newton's method.

Newton's method comes first (Deuflhard (2004), Newton Methods for Nonlinear Problems, damping by the natural
monotonicity test); where it stalls, implicit steps of growing length follow the system in time until it rests
(pseudo-transient continuation, Kelley and Keyes (1998), SIAM J. Numer. Anal. 35, 508).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from propermodel.codegen.machine import BoolArray, FloatArray, Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Involved, Path, SimulationError, one_of
from propermodel.equations.system import StateKind
from propermodel.expressions.core import Expr
from propermodel.modelling.model import Scenario
from propermodel.simulation.observables import observable_path
from propermodel.simulation.point import Point, jacobian_at
from propermodel.simulation.start import Start, start_of

TOLERANCE = 1e-9  # of the last correction, as a share of the size that a state has had on the way
RANK_TOLERANCE = 1e-11  # a singular value below this share of the largest counts as zero, rows and columns scaled
ROUNDING = 1e-13  # of the largest state, columns scaled
MOST_NEWTON_STEPS = 40
MOST_IMPLICIT_STEPS = 200
MOST_NAMED = 6


class Stability(StrEnum):
    """What small deviations from an equilibrium do; of the states that are neither free, held nor undetermined."""

    STABLE = "stable"
    UNSTABLE = "unstable"
    MARGINAL = "marginal"  # some deviation neither grows nor decays


@dataclass(frozen=True, slots=True)
class StateChange:
    """A state before and at the equilibrium."""

    path: Path
    unit: str
    before: float
    after: float
    is_rounding: bool  # the change is nothing beside those of the others


@dataclass(frozen=True, slots=True)
class Drift:
    """A state that keeps changing at a steady rate."""

    path: Path
    unit: str
    rate: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Equilibrium:
    """A point at which all states rest, except those that are free or held; controllers keep what they hold."""

    compiled: CompiledModel
    scenario: Scenario
    memory: Memory = field(repr=False)
    changes: tuple[StateChange, ...]  # every state
    drifts: tuple[Drift, ...]  # free states: nothing depends on them
    held: tuple[Drift, ...]  # states held by request, with the rate they would have
    undetermined: tuple[Path, ...]  # states of which a whole family of values is an equilibrium
    eigenvalues: np.ndarray[tuple[int], np.dtype[np.complex128]]
    stability: Stability
    iterations: int

    def __getitem__(self, state: Expr | Path | str) -> float:
        """The value of a state."""
        path = observable_path(state)
        for change in self.changes:
            if change.path == path:
                return change.after
        raise SimulationError.of(
            "simulation/unknown-state",
            f"'{path}' is no state of this model",
            help=one_of(str(path), (str(change.path) for change in self.changes)),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What must be said about it: what changed, what drifts, what is undetermined, whether it is stable."""
        changed = [c for c in self.changes if not c.is_rounding]
        texts = [f"{c.path} {c.before:.6g} -> {c.after:.6g} {c.unit}".rstrip() for c in changed]
        notes = [
            f"started at {_article(self.stability)} {self.stability} equilibrium"
            + (f"; changed {_listed(texts)}" if texts else "; the start was one already")
        ]
        if self.drifts:
            moving = [f"{d.path} by {d.rate:.6g} {d.unit or '1'}/s" for d in self.drifts if d.rate]
            resting = [str(d.path) for d in self.drifts if not d.rate]
            if moving:
                notes.append(f"nothing depends on these states, which keep changing steadily: {_listed(moving)}")
            if resting:
                notes.append(f"nothing depends on these states, which stay as they started: {_listed(resting)}")
        if self.undetermined:
            names = _listed([str(path) for path in self.undetermined])
            notes.append(f"many values of these states are equilibria; the nearest to the start was taken: {names}")
        if self.held:
            notes.append(
                "held, although they would change: "
                + _listed([f"{d.path} by {d.rate:.6g} {d.unit or '1'}/s" for d in self.held])
            )
        return tuple(notes)

    def __str__(self) -> str:
        lines = [
            f"{self.stability} equilibrium of {self.compiled.model.name} at {self.memory.time:g} s",
            f"  scenario {self.scenario.name}, {self.iterations} iterations",
        ]
        width = max((len(str(change.path)) for change in self.changes), default=0)
        lines.extend(f"  {c.path!s:<{width}}  {c.after:.6g} {c.unit}".rstrip() for c in self.changes)
        lines.extend(f"  note: {note}" for note in self.notes[1:])
        return "\n".join(lines)


def _article(stability: Stability) -> str:
    return "an" if stability is Stability.UNSTABLE else "a"


def _listed(texts: list[str]) -> str:
    rest = len(texts) - MOST_NAMED
    return ", ".join(texts[:MOST_NAMED]) + (f" and {rest} more" if rest > 0 else "")


def find_equilibrium(
    compiled: CompiledModel, scenario: Scenario, *, hold: Iterable[Expr | Path | str] = ()
) -> Equilibrium:
    """The equilibrium near the start of a scenario, with its inputs as they are then and controllers held.

    States on which nothing depends (the position of a vehicle, a meter) may change at a steady rate. Where a family of
    states is in equilibrium, conserved quantities keep their start and the rest stays close to it.

    Args:
        compiled: The model.
        scenario: Inputs, parameters, and the start of the search.
        hold: States that keep their start, and need not rest.

    Raises:
        SimulationError: a state is unknown, or no equilibrium is found; the states that change most are named.
    """
    start = start_of(compiled, scenario).memory
    search = _Search(compiled, start, _held_states(compiled, hold))
    search.run()
    return search.found(scenario)


def equilibrium_start(compiled: CompiledModel, scenario: Scenario) -> Start:
    """The start of a run at the equilibrium near the start of a scenario, with notes on what was changed.

    Raises:
        SimulationError: no equilibrium is found.
    """
    found = find_equilibrium(compiled, scenario)
    return Start(found.memory.copy(), found.notes)


def _held_states(compiled: CompiledModel, hold: Iterable[Expr | Path | str]) -> BoolArray:
    paths = [state.path for state in compiled.system.states]
    faults = Faults(SimulationError)
    held = np.zeros(len(paths), dtype=np.bool_)
    for path in map(observable_path, hold):
        if path in paths:
            held[paths.index(path)] = True
            continue
        faults.add(
            Diagnostic(
                "simulation/unknown-state",
                f"'{path}' cannot be held: it is no state of this model",
                help=one_of(str(path), map(str, paths)),
            )
        )
    faults.raise_if_any()
    return held


class _Search:
    """The iteration from a start to an equilibrium."""

    def __init__(self, compiled: CompiledModel, start: Memory, held: BoolArray) -> None:
        self.compiled = compiled
        self.start = start
        self.memory = start.copy()
        self.held = held
        self.iterations = 0
        self._size = np.abs(start.state)  # the size that each state has had
        self._evaluate()
        matrix = self._jacobian.matrix
        used = np.zeros(len(held), dtype=np.bool_)
        used[np.unique(matrix.indices[matrix.data != 0.0])] = True
        may_drift = np.array([s.kind is not StateKind.MOMENTUM for s in compiled.system.states], dtype=np.bool_)
        self.free: BoolArray = ~used & may_drift & ~held
        self.active = np.flatnonzero(~(self.free | held))

    def _evaluate(self) -> None:
        point = Point(self.compiled.system, self.compiled.lowered, self.memory)
        self.memory.unknown[:] = point.unknown
        self._jacobian = jacobian_at(point)

    @property
    def _rates(self) -> FloatArray:
        return self._jacobian.rates[self.active]

    @property
    def _matrix(self) -> FloatArray:
        return self._jacobian.matrix[self.active][:, self.active].toarray()

    def run(self) -> None:
        """Iterate to an equilibrium.

        Raises:
            SimulationError: there is none to be found.
        """
        if self._newton():
            return
        best = self.memory.copy()
        self._restart()
        if self._implicit_steps() and self._newton():
            return
        if not np.isfinite(self._jacobian.rates).all():
            self.memory = best
            self._evaluate()
        raise self._not_found()

    def _restart(self) -> None:
        self.memory = self.start.copy()
        self._size = np.abs(self.start.state)
        self._evaluate()

    def _newton(self) -> bool:
        for _ in range(MOST_NEWTON_STEPS):
            solver = _Solver(self._matrix)
            step = solver.solve(-self._rates, self._conserved_error(solver))
            if not np.isfinite(step).all():
                return False
            if self._is_small(solver, step) and self._rests(solver):
                self._move(step)
                return self._rests(solver)
            if not self._damped(solver, step):
                return False
            self.iterations += 1
        return False

    def _conserved_error(self, solver: _Solver) -> FloatArray:
        """By how much conserved quantities (combinations whose rate vanishes) have left their start."""
        return solver.conserved @ (self.start.state - self.memory.state)[self.active]

    def _is_small(self, solver: _Solver, step: FloatArray) -> bool:
        size = self._size[self.active]
        # A state that is zero at rest has no size of its own: what the others make of rounding is small.
        rounding = ROUNDING * np.max(np.abs(solver.scaled(size)), initial=0.0)
        is_small = np.abs(step) <= TOLERANCE * np.maximum(size, np.abs(step))
        return bool(np.all(is_small | (np.abs(solver.scaled(step)) <= rounding)) or not step.any())

    def _rests(self, solver: _Solver) -> bool:
        """Whether what no step can remove of the rates is rounding."""
        rest = solver.unreachable(self._rates)
        scale = np.abs(self._matrix) @ self._size[self.active] if len(self.active) else np.zeros(0)
        return bool(np.all(np.abs(rest) <= 1e-8 * scale + 1e-300) or not rest.any())

    def _damped(self, solver: _Solver, step: FloatArray) -> bool:
        before = self.memory.state.copy(), self.memory.unknown.copy()
        norm = solver.norm(step)
        factor = self._within_limits(step)
        while factor > 1e-4:
            self.memory.state[self.active] = before[0][self.active] + factor * step
            if self._try():
                next_step = solver.solve(-self._rates, self._conserved_error(solver))
                if np.isfinite(next_step).all() and solver.norm(next_step) <= (1.0 - factor / 4.0) * norm:
                    self._size = np.maximum(self._size, np.abs(self.memory.state))
                    return True
            factor *= 0.5
        self.memory.state[:], self.memory.unknown[:] = before
        self._evaluate()
        return False

    def _try(self) -> bool:
        try:
            self._evaluate()
        except SimulationError:  # an implicit block has no solution so far away: a shorter step is tried
            return False
        return bool(np.isfinite(self._jacobian.rates).all() and np.isfinite(self._jacobian.matrix.data).all())

    def _within_limits(self, step: FloatArray) -> float:
        """The share of a step that keeps every state inside the range it is meant for."""
        state = self.memory.state[self.active]
        low, high = self.memory.lower[self.active], self.memory.upper[self.active]
        with np.errstate(all="ignore"):
            room = np.where(step > 0.0, (high - state) / step, np.where(step < 0.0, (low - state) / step, math.inf))
        least = float(np.min(room, initial=math.inf))
        return 1.0 if least >= 1.0 else max(0.9 * least, 0.0)

    def _move(self, step: FloatArray) -> None:
        self.memory.state[self.active] += step * self._within_limits(step)
        self._evaluate()

    def _implicit_steps(self) -> bool:
        """Follow the system in time by implicit steps that grow as it comes to rest."""
        matrix = self._matrix
        fastest = float(np.max(np.sum(np.abs(matrix), axis=1), initial=0.0)) or 1.0
        length = 1.0 / fastest
        for _ in range(MOST_IMPLICIT_STEPS):
            count = len(self.active)
            step: FloatArray = np.asarray(
                np.linalg.lstsq(np.eye(count) / length - self._matrix, self._rates, rcond=None)[0], dtype=np.float64
            )
            state, unknown = self.memory.state.copy(), self.memory.unknown.copy()
            self.memory.state[self.active] += self._within_limits(step) * step
            if not np.isfinite(step).all() or not self._try():
                self.memory.state[:], self.memory.unknown[:] = state, unknown
                self._evaluate()
                length *= 0.1
                continue
            self.iterations += 1
            self._size = np.maximum(self._size, np.abs(self.memory.state))
            moved = np.abs(step) > 0.2 * np.maximum(self._size[self.active], 1e-300)
            length *= 1.0 if moved.any() else 3.0
            if length * fastest > 1e12:
                return True
        return True

    # -- answers -------------------------------------------------------------------------------------------

    def _not_found(self) -> SimulationError:
        states = self.compiled.system.states
        rates = self._jacobian.rates
        size = np.maximum(self._size, np.abs(self.memory.state))
        with np.errstate(all="ignore"):
            share = np.abs(rates) / np.where(size > 0.0, size, 1.0)
        order = [i for i in self.active[np.argsort(-np.nan_to_num(share[self.active], nan=math.inf))] if rates[i]]
        worst = order[:MOST_NAMED]
        names = ", ".join(str(states[i].path) for i in worst[:3])
        return SimulationError.of(
            "simulation/no-equilibrium",
            f"no equilibrium of {self.compiled.model.name} was found at {self.memory.time:g} s"
            + (f": {names} cannot be brought to rest" if names else ""),
            involved=[
                Involved(
                    str(states[i].path),
                    f"= {self.memory.state[i]:.6g} {states[i].unit} changes by {rates[i]:.6g} "
                    f"{states[i].unit or '1'}/s",
                    states[i].source,
                )
                for i in worst
            ],
            help="a force or flow may have nothing that answers it; give initial values nearer to the equilibrium, "
            "or hold a state: find_equilibrium(..., hold=[...])",
        )

    def found(self, scenario: Scenario) -> Equilibrium:
        """The equilibrium that the iteration has reached."""
        states = self.compiled.system.states
        rates = self._jacobian.rates
        solver = _Solver(self._matrix)
        eigenvalues = np.linalg.eigvals(self._matrix).astype(np.complex128)

        unchanged = np.ones(len(states), dtype=np.bool_)
        change = solver.scaled((self.memory.state - self.start.state)[self.active])
        unchanged[self.active] = np.abs(change) <= 1e-9 * np.max(np.abs(change), initial=0.0)

        def drift(index: int) -> Drift:
            return Drift(states[index].path, states[index].unit, float(rates[index]))

        return Equilibrium(
            compiled=self.compiled,
            scenario=scenario,
            memory=self.memory,
            changes=tuple(
                StateChange(state.path, state.unit, float(before), float(after), bool(rounding))
                for state, before, after, rounding in zip(
                    states, self.start.state, self.memory.state, unchanged, strict=True
                )
            ),
            drifts=tuple(drift(int(i)) for i in np.flatnonzero(self.free)),
            held=tuple(drift(int(i)) for i in np.flatnonzero(self.held)),
            undetermined=tuple(states[self.active[i]].path for i in solver.undetermined),
            eigenvalues=eigenvalues,
            stability=_stability(eigenvalues, solver.deficiency),
            iterations=self.iterations,
        )


def _stability(eigenvalues: np.ndarray[tuple[int], np.dtype[np.complex128]], deficiency: int) -> Stability:
    """The stability by eigenvalues; as many of the smallest as there are undetermined combinations do not count."""
    order = np.argsort(np.abs(eigenvalues))
    counted = eigenvalues[order[deficiency:]]
    if not len(counted):
        return Stability.MARGINAL if deficiency else Stability.STABLE
    rounding = 1e-9 * float(np.max(np.abs(counted)))
    if np.any(counted.real > rounding):
        return Stability.UNSTABLE
    # A slow stiff system has small eigenvalues; only those that rounding hides from zero are marginal.
    damping = -counted.real / np.maximum(np.abs(counted), 1e-300)
    return Stability.MARGINAL if deficiency or np.any(damping < 1e-9) else Stability.STABLE


class _Solver:
    """Solutions of J x = b, rows and columns scaled; where J is singular the smallest that conserves what it must."""

    def __init__(self, matrix: FloatArray) -> None:
        count = len(matrix)
        self._row, self._column = _scales(matrix)
        scaled = self._row[:, np.newaxis] * matrix * self._column
        left, sizes, right = np.linalg.svd(scaled) if count else (np.zeros((0, 0)),) * 3
        sizes = np.ravel(sizes)
        rank = int(np.sum(sizes > RANK_TOLERANCE * np.max(sizes, initial=0.0)))
        self.deficiency = count - rank
        self._left, self._sizes, self._right = left[:, :rank], sizes[:rank], right[:rank]
        self._no_rate = left[:, rank:].T
        # w J = 0 says that w x does not change: a conserved quantity.
        self.conserved: FloatArray = self._no_rate * self._row
        moving = np.abs(right[rank:])
        self.undetermined = np.flatnonzero(np.max(moving, axis=0, initial=0.0) > 1e-6) if count else np.zeros(0, int)

    def solve(self, right: FloatArray, conserved: FloatArray) -> FloatArray:
        """The step that removes the rates and brings conserved quantities back, as far as both can be."""
        solution = self._right.T @ ((self._left.T @ (self._row * right)) / self._sizes)
        if self.deficiency:
            free = self._null.T
            missing = conserved - self.conserved @ (self._column * solution)
            along = np.linalg.lstsq(self.conserved @ (self._column[:, np.newaxis] * free), missing, rcond=1e-9)[0]
            solution = solution + free @ along
        return self._column * solution

    @property
    def _null(self) -> FloatArray:
        full = np.linalg.svd(self._right)[2] if len(self._right) else np.eye(len(self._column))
        return full[len(self._right) :]

    def unreachable(self, rates: FloatArray) -> FloatArray:
        """The part of rates that no step can remove."""
        if not self.deficiency:
            return np.zeros(len(rates))
        return (self._no_rate.T @ (self._no_rate @ (self._row * rates))) / self._row

    def norm(self, step: FloatArray) -> float:
        """The size of a step, scaled."""
        return float(np.linalg.norm(self.scaled(step)))

    def scaled(self, step: FloatArray) -> FloatArray:
        """A step in sizes that can be compared."""
        return step / self._column


def _scales(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Factors of rows and columns that bring the entries near one (Ruiz (2001), RAL-TR-2001-034)."""
    row, column = np.ones(len(matrix)), np.ones(len(matrix))
    for _ in range(10):
        scaled = np.abs(row[:, np.newaxis] * matrix * column)
        largest_of_row, largest_of_column = (np.max(scaled, axis=axis, initial=0.0) for axis in (1, 0))
        row /= np.sqrt(np.where(largest_of_row > 0.0, largest_of_row, 1.0))
        column /= np.sqrt(np.where(largest_of_column > 0.0, largest_of_column, 1.0))
    return row, column
