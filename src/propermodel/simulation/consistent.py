"""Starts on kinematic constraints: loops that close, and velocities that keep them closed, with a note on each change.

Displacements first: those that the scenario gives stay where the others can close the loops. Then momenta: where the
scenario gives some, the others follow; otherwise the declared ones meet as in an impact, which takes the least
energy away.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Diagnostic, Involved, SimulationError
from propermodel.equations.corrections import Correction, momentum_corrections
from propermodel.equations.system import Closure, EquationSystem
from propermodel.expressions.core import ONE, ZERO, Expr, SymbolKind, leaves, where
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.simulation.evaluate import has_all
from propermodel.simulation.merging import Starts, Values

MOST_ITERATIONS = 60
MOST_HALVINGS = 12
# Displacements (m, rad) and flows that differ from zero by less are on the constraint.
CLOSED = 1e-11


def close_loops(system: EquationSystem, starts: Starts) -> tuple[Values, tuple[str, ...]]:
    """The displacements that change so that every kinematic loop closes, with a note.

    Raises:
        SimulationError: no displacements near the given ones close the loops.
    """
    members = [c for c in system.closures if c.coordinates and _is_explicit(c.displacement, starts)]
    if not members:
        return {}, ()
    displacements = [c.displacement for c in members if c.displacement is not None]
    if np.max(np.abs(starts.at(displacements, {}))) <= CLOSED:
        return {}, ()
    every = list(dict.fromkeys(state for c in members for state, _ in c.coordinates))
    free = [state for state in every if state.data.path not in starts.given]
    found = _solved(displacements, free, starts) or _solved(displacements, every, starts)
    if found is None:
        raise _open(members, starts)
    changed = {state: value for state, value in found.items() if not _agree(value, starts.values[state])}
    if not changed:
        return found, ()
    names = ", ".join(str(c.element) for c in members)
    return found, (f"the kinematic loops closed by {names} were open: {_changes(system, starts, changed)}",)


def keep_loops_closed(system: EquationSystem, starts: Starts) -> tuple[Values, tuple[str, ...]]:
    """The momenta that change so that no kinematic loop opens, with notes and the energy that is lost.

    Raises:
        SimulationError: the loops depend on each other at this position, or no momenta keep them closed.
    """
    changed: Values = {}
    notes: list[str] = []
    for correction in momentum_corrections(system):
        if not all(_is_explicit(residual, starts, correction.unknowns) for residual in correction.residuals):
            continue
        now = replace(starts, values={**starts.values, **changed})
        if correction.rank is not None and not now.at([where(correction.rank, ONE, ZERO)], {})[0]:
            raise _singular(system, correction)
        found, why = _kept(system, correction, now)
        moved = {state: value for state, value in found.items() if not _agree(value, now.values[state])}
        if moved:
            closing = {closure.element for closure in system.closures}
            names = ", ".join(str(path) for path in correction.paths if path in closing)
            changed.update(found)
            notes.append(
                f"velocities at the kinematic loops closed by {names} did not fit, {why}: "
                f"{_changes(system, now, moved)}{_lost(system, now, moved)}"
            )
    return changed, tuple(notes)


# -- displacements -----------------------------------------------------------------------------------------


def _solved(values: Sequence[Expr], states: Sequence[Expr], starts: Starts) -> Values | None:
    """Values of some states, near their starts, at which expressions vanish; None if there are none.

    Newton's method, damped, each step the shortest that the linearised equations allow.
    """
    if not states:
        return None
    partials = partial_derivatives(values, states)
    entries = [p[s] for p in partials for s in states if s in p]
    pattern = [(i, j) for i, p in enumerate(partials) for j, s in enumerate(states) if s in p]

    def at(x: FloatArray) -> Values:
        return dict(zip(states, map(float, x), strict=True))

    def slopes(x: FloatArray) -> FloatArray:
        matrix = np.zeros((len(values), len(states)))
        matrix[tuple(zip(*pattern, strict=True))] = starts.at(entries, at(x))
        return matrix

    x = _newton(
        np.array([starts.values[s] for s in states]),
        lambda x: starts.at(values, at(x)),
        slopes,
    )
    return None if x is None else at(x)


def _newton(
    x: FloatArray, residual: Callable[[FloatArray], FloatArray], slopes: Callable[[FloatArray], FloatArray]
) -> FloatArray | None:
    r = residual(x)
    for _ in range(MOST_ITERATIONS):
        size = np.max(np.abs(r))
        if size <= CLOSED * 1e-3:
            return x
        matrix = slopes(x)
        if not np.all(np.isfinite(matrix)):
            return None
        step = np.linalg.lstsq(matrix, -r, rcond=None)[0]
        share = 1.0
        for _ in range(MOST_HALVINGS):
            there = residual(x + share * step)
            if np.all(np.isfinite(there)) and np.linalg.norm(there) < np.linalg.norm(r):
                break
            share *= 0.5
        else:
            return x if size <= CLOSED else None
        x, r = x + share * step, there
    return x if np.max(np.abs(r)) <= CLOSED else None


def _open(members: Sequence[Closure], starts: Starts) -> SimulationError:
    gaps = starts.at([c.displacement for c in members if c.displacement is not None], {})
    return SimulationError(
        [
            Diagnostic(
                "simulation/open-loop",
                "no displacements near the given ones close these kinematic loops",
                source=members[0].source,
                involved=tuple(
                    Involved(str(c.element), f"is open by {gap:.6g} {c.displacement_unit}", c.source)
                    for c, gap in zip(members, gaps, strict=True)
                ),
                help="check the lengths, or give displacements in the scenario from which the loops can close",
            )
        ]
    )


# -- momenta -----------------------------------------------------------------------------------------------


def _kept(system: EquationSystem, correction: Correction, starts: Starts) -> tuple[Values, str]:
    """The states after a correction, and how it was found."""
    states = [state for state, _ in correction.updates]
    given = [state for state in states if state.data.path in starts.given]
    if given and len(given) < len(states):
        found = _following(system, correction, starts, frozenset(given))
        if found is not None:
            return found, "and follow from what the scenario gives"
    unknowns = list(correction.unknowns)
    entries = [entry for row in correction.jacobian for entry in row]
    size = len(unknowns)

    def at(x: FloatArray) -> Values:
        return dict(zip(unknowns, map(float, x), strict=True))

    x = _newton(
        np.zeros(size),
        lambda x: starts.at(correction.residuals, at(x)),
        lambda x: starts.at(entries, at(x)).reshape(size, size),
    )
    if x is None:
        names = ", ".join(str(path) for path in correction.paths)
        raise SimulationError.of(
            "simulation/start",
            f"no momenta keep the kinematic loops of {names} closed",
            help="the loops may not be independent at this position: start from another, or take a constraint away",
        )
    values = starts.at([value for _, value in correction.updates], at(x))
    return dict(zip(states, map(float, values), strict=True)), "and meet as in an impact"


def _singular(system: EquationSystem, correction: Correction) -> SimulationError:
    members = [c for c in system.closures if c.element in correction.paths]
    return SimulationError(
        [
            Diagnostic(
                "simulation/singular-mechanism",
                "the mechanism starts in a singular position: its constraints depend on each other there",
                source=members[0].source,
                involved=tuple(Involved(str(c.element), "closes a kinematic loop", c.source) for c in members),
                help="start away from a dead centre or bars in one line; take away a constraint that is stated twice",
            )
        ]
    )


def _following(system: EquationSystem, correction: Correction, starts: Starts, given: frozenset[Expr]) -> Values | None:
    """The states that are not given, such that the flows vanish; None if they alone cannot make them vanish."""
    closures = [c for c in system.closures if c.flow is not None and c.element in correction.paths]
    flows = [c.flow for c in closures if c.flow is not None]
    states = [state for state, _ in correction.updates if state not in given]
    # An impulse of each closure on the free states alone: the least kinetic energy that does it.
    rows = [dict(c.impulses) for c in closures]
    slopes = [row.get(state) for row in rows for state in states]
    known = iter(starts.at([s for s in slopes if s is not None], {}))
    impulses = np.array([0.0 if s is None else next(known) for s in slopes]).reshape(len(rows), len(states)).T
    partials = partial_derivatives(flows, states)
    before = np.array([starts.values[state] for state in states])

    def at(x: FloatArray) -> Values:
        return dict(zip(states, map(float, before + impulses @ x), strict=True))

    def matrix(x: FloatArray) -> FloatArray:
        entries = [p.get(s) for p in partials for s in states]
        present = iter(starts.at([e for e in entries if e is not None], at(x)))
        rates = np.array([0.0 if e is None else next(present) for e in entries]).reshape(len(flows), len(states))
        return rates @ impulses

    x = _newton(np.zeros(len(flows)), lambda x: starts.at(flows, at(x)), matrix)
    return None if x is None else at(x)


# -- notes -------------------------------------------------------------------------------------------------


def _is_explicit(expr: Expr | None, starts: Starts, unknowns: Sequence[Expr] = ()) -> bool:
    """Whether an expression can be evaluated at the start, without solving a loop."""
    if expr is None:
        return False
    inside = [leaf for leaf in leaves(expr) if leaf not in unknowns]
    return all(leaf.data.kind is not SymbolKind.UNKNOWN for leaf in inside) and all(
        has_all(leaf, starts.values, starts.tables) for leaf in inside
    )


def _agree(one: float, other: float) -> bool:
    return abs(one - other) <= 1e-9 * max(abs(one), abs(other)) + CLOSED


def _changes(system: EquationSystem, starts: Starts, changed: Mapping[Expr, float]) -> str:
    units = {state.symbol: state.unit for state in system.states}
    return ", ".join(
        f"{state.data.path} {value:.6g} instead of {starts.values[state]:.6g} {units[state]}"
        for state, value in changed.items()
    )


def _lost(system: EquationSystem, starts: Starts, changed: Values) -> str:
    energies = [stored.energy for stored in system.energies]
    if not all(_is_explicit(energy, starts) for energy in energies):
        return ""
    lost = float(np.sum(starts.at(energies, {})) - np.sum(starts.at(energies, changed)))
    return f"; {lost:.6g} J are lost" if lost >= 0.0 else f"; {-lost:.6g} J are added"
