"""Starts of storage that is not free to choose its own: what was stored is kept, and what was lost is said.

Two masses on one shaft have one speed. When their declared starts differ, they meet as in an impact: each dependent
storage takes up what it lacks from the states, along the same paths as later in the run. So merged inertias keep the
sum of ratio times momentum and merged compliances keep their charge or volume; energy is lost.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, SimulationError
from propermodel.equations.system import DependentStorage, EquationSystem
from propermodel.expressions.core import Expr, SymbolKind, leaves
from propermodel.expressions.derivatives import kept_derivatives
from propermodel.modelling.model import Storage
from propermodel.simulation.evaluate import HeldTable, evaluate, has_all
from propermodel.simulation.zeros import zero_parameters

# Starts that differ by less than this share of their size agree.
AGREEMENT = 1e-9
MOST_ITERATIONS = 30
MOST_HALVINGS = 20

Values = dict[Expr, float]


@dataclass(frozen=True)
class Starts:
    """What is known at the start: every symbol's value, declared starts included, and which the scenario gives."""

    values: Mapping[Expr, float]
    tables: Mapping[Path, HeldTable]
    given: frozenset[Path]

    def at(self, exprs: Iterable[Expr], changed: Mapping[Expr, float]) -> FloatArray:
        """The values of expressions when some symbols have others."""
        return np.array(evaluate(list(exprs), {**self.values, **changed}, self.tables))


def merge_starts(system: EquationSystem, starts: Starts) -> tuple[Values, tuple[str, ...]]:
    """The states that change so that dependent storage keeps what it was declared to hold, with a note on each change.

    The scenario has the last word: dependent storage that it does not mention follows a state that it does.

    Raises:
        SimulationError: no states keep what is stored.
    """
    notes: list[str] = []
    solvable = [d for d in system.dependents if _is_explicit(d, starts)]
    factors = {d.path: _factors(d, starts) for d in system.dependents}
    follows = {d.path: _follows(d, factors[d.path], starts) for d in system.dependents}
    free = [d for d in system.dependents if factors[d.path] and not follows[d.path]]
    # Storage that shares states meets as a whole or not at all: a part would depend on the choice of states.
    blocks = [block for block in _blocks(free, factors) if all(d in solvable for d in block)]
    members = [dependent for block in blocks for dependent in block]
    changed: Values = {}
    for block in blocks:
        found = _merged(block, factors, starts)
        if found:
            changed.update(found)
            notes.append(_merge_note(system, block, starts, found))
    for dependent in solvable:
        if dependent in members:
            continue
        declared = starts.values[dependent.symbol]
        (now,) = starts.at([dependent.stored], changed)
        if _differ(now, declared):
            has_states = any(leaf.data.kind is SymbolKind.STATE for leaf in leaves(dependent.stored))
            why = "it follows from other storage" if has_states else "a source decides it"
            if follows[dependent.path]:
                why = "the scenario gives the start of what it moves with"
            notes.append(f"{dependent.path} starts at {now:.6g} {dependent.unit}, not at {declared:.6g}: {why}")
    notes.extend(
        f"the start of {dependent.path} ({starts.values[dependent.symbol]:.6g} {dependent.unit}) is not used: "
        "it follows from an algebraic loop"
        for dependent in system.dependents
        if dependent not in solvable and starts.values[dependent.symbol] != 0.0
    )
    return changed, tuple(notes)


def _is_explicit(dependent: DependentStorage, starts: Starts) -> bool:
    return has_all(dependent.stored, starts.values, starts.tables) and not any(
        leaf.data.kind is SymbolKind.UNKNOWN for leaf in leaves(dependent.stored)
    )


def _factors(dependent: DependentStorage, starts: Starts) -> Values:
    """How each state gives way to a dependent storage; what an algebraic loop passes on counts as zero."""
    symbols = [state for state, _ in dependent.reactions]
    slopes = [slope for _, slope in dependent.reactions]
    unknown = dict.fromkeys((leaf for leaf in leaves(*slopes) if leaf.data.kind is SymbolKind.UNKNOWN), 0.0)
    values = starts.at(slopes, unknown)
    return {symbol: float(value) for symbol, value in zip(symbols, values, strict=True) if value != 0.0}


def _follows(dependent: DependentStorage, factors: Values, starts: Starts) -> bool:
    reached = {state.data.path for state in factors}
    return dependent.path not in starts.given and bool(reached & starts.given)


def _blocks(members: list[DependentStorage], factors: Mapping[Path, Values]) -> list[list[DependentStorage]]:
    """Dependent storages that share states, in the order of the model."""
    blocks: list[tuple[set[Expr], list[DependentStorage]]] = []
    for dependent in members:
        reached, inside = set(factors[dependent.path]), [dependent]
        apart: list[tuple[set[Expr], list[DependentStorage]]] = []
        for states, others in blocks:
            if states & reached:
                reached, inside = reached | states, [*others, *inside]
            else:
                apart.append((states, others))
        blocks = [*apart, (reached, inside)]
    return [inside for _, inside in blocks]


def _merged(block: list[DependentStorage], known: Mapping[Path, Values], starts: Starts) -> Values:
    """The states of a block after its storages have met; empty where their starts agree.

    With s the stored quantities, s0 their declared starts and x0 the states, x = x0 + G (s - s0) and s = s(x).
    """
    factors = [known[dependent.path] for dependent in block]
    states = list(dict.fromkeys(state for found in factors for state in found))
    gain = np.array([[found.get(state, 0.0) for found in factors] for state in states])
    stored = [dependent.stored for dependent in block]
    slopes = [slope.get(s) for slope in kept_derivatives(tuple(stored), tuple(states)) for s in states]
    declared = np.array([starts.values[dependent.symbol] for dependent in block])
    before = np.array([starts.values[state] for state in states])
    level = starts.at(stored, {})
    if np.all(np.isfinite(level)) and not any(map(_differ, level, declared)):
        return {}
    scale = float(np.max(np.abs([*level, *declared])))

    def at(taken: FloatArray) -> Values:
        return dict(zip(states, map(float, before + gain @ taken), strict=True))

    def missing(taken: FloatArray) -> FloatArray:
        return declared + taken - starts.at(stored, at(taken))

    def is_better(taken: FloatArray, least: float) -> bool:
        return float(np.max(np.abs(missing(taken)))) < max(least, 1e-12 * scale)

    taken = np.zeros(len(block))
    for _ in range(MOST_ITERATIONS):
        residual = missing(taken)
        least = float(np.max(np.abs(residual)))
        if least <= 1e-14 * scale:
            return at(taken)
        present = iter(starts.at([s for s in slopes if s is not None], at(taken)))
        rates = np.array([0.0 if s is None else next(present) for s in slopes]).reshape(len(block), len(states))
        if not (np.all(np.isfinite(rates)) and math.isfinite(least)):
            break
        step = np.linalg.lstsq(np.eye(len(block)) - rates @ gain, residual, rcond=None)[0]
        if np.max(np.abs(step)) <= 1e-13 * scale:
            return at(taken - step)
        # A step past the solution, or to where a law has no value, is shortened.
        shorter = (taken - 0.5**halvings * step for halvings in range(MOST_HALVINGS))
        found = next((trial for trial in shorter if is_better(trial, least)), None)
        if found is None:
            break
        taken = found
    names = ", ".join(str(dependent.path) for dependent in block)
    zero = zero_parameters(stored, lambda leaf: starts.values[leaf])
    raise SimulationError.of(
        "simulation/start",
        f"no start of the states keeps what {names} should store{zero and f', because {zero}'}",
        help="give this parameter another value" if zero else "give these parts starts that agree",
    )


def _differ(one: float, other: float) -> bool:
    return abs(one - other) > AGREEMENT * max(abs(one), abs(other))


def _merge_note(system: EquationSystem, block: list[DependentStorage], starts: Starts, found: Values) -> str:
    levels = starts.at([dependent.stored for dependent in block], found)
    after = {**found, **{d.symbol: float(level) for d, level in zip(block, levels, strict=True)}}
    units = {s.symbol: s.unit for s in system.states} | {d.symbol: d.unit for d in block}
    changes = ", ".join(
        f"{symbol.data.path} {value:.6g} instead of {starts.values[symbol]:.6g} {units[symbol]}"
        for symbol, value in after.items()
    )
    text = f"declared starts contradict each other and were merged, keeping what is stored: {changes}"
    energies = _energies(system, after)
    if not all(has_all(energy, starts.values, starts.tables) for energy in energies):
        return text
    lost = float(np.sum(starts.at(energies, {})) - np.sum(starts.at(energies, after)))
    return f"{text}; {lost:.6g} J are lost"


def _energies(system: EquationSystem, symbols: Iterable[Expr]) -> list[Expr]:
    """The energies of the storages with these coordinates, in their own coordinates."""
    owners = {symbol.data.path.parent for symbol in symbols}
    elements = system.causal.graph.normal.elements.values()
    return [e.behaviour.energy for e in elements if e.path in owners and isinstance(e.behaviour, Storage)]
