"""How the start of a run changes with parameters.

Where a start is a formula of parameters, the derivative is exact. Starts that are computed (dependent storage that
meets, loops that are closed, starts read from signals, equilibria) are differentiated by differences of fourth order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from propermodel.bondgraph.graph import FlatParameter
from propermodel.bondgraph.parameters import parameter_rates
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.equations.system import StateVariable
from propermodel.expressions.core import Expr, leaves
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import Start, parameter_values

DISTANCE = 1e-3  # of the values between which differences are taken, as a share of the parameter
ROUNDING = 1e-13  # smaller sums of differences, beside the values, are rounding

Values = dict[Expr, float]


@dataclass(frozen=True, eq=False)
class StartTangents:
    """The derivatives of a start with respect to parameters: what each parameter carries along, states, held values."""

    parameters: tuple[Mapping[Expr, float], ...]  # of each direction: the derivative of every parameter that changes
    state: FloatArray  # directions x states
    discrete: FloatArray  # directions x held values
    by_differences: tuple[Path, ...]  # states whose start no formula gives


def start_tangents(
    compiled: CompiledModel,
    scenario: Scenario,
    parameters: Sequence[Path],
    start: Callable[[Scenario], Start],
    *,
    is_declared: bool,
) -> StartTangents:
    """The derivatives of a start.

    Args:
        compiled: The model.
        scenario: The scenario.
        parameters: With respect to which.
        start: How the start follows from a scenario.
        is_declared: Whether that begins with the declared values, so that formulas say what they are.

    Raises:
        SimulationError: there is no start near the given one.
    """
    flat = compiled.graph.parameters
    values = parameter_values(compiled, scenario.parameters)
    rates = tuple(parameter_rates(flat, values, path, scenario.parameters) for path in parameters)
    held = dict(compiled.graph.held)
    for symbol in compiled.lowered.held:
        values[symbol] = scenario.initial.get(symbol.data.path, interpret(held[symbol], values))
    states = compiled.system.states
    computed = [not is_declared or not _is_formula(compiled, scenario, state, values) for state in states]
    found = StartTangents(
        parameters=rates,
        state=np.zeros((len(parameters), len(states))),
        discrete=np.zeros((len(parameters), len(compiled.lowered.held))),
        by_differences=tuple(state.path for state, is_computed in zip(states, computed, strict=True) if is_computed),
    )
    for k, path in enumerate(parameters):
        along = dict(rates[k])
        for i, symbol in enumerate(compiled.lowered.held):
            if symbol.data.path not in scenario.initial:
                along[symbol] = found.discrete[k, i] = _rate(held[symbol], rates[k], values)
        for i, state in enumerate(states):
            if not computed[i] and state.path not in scenario.initial:
                found.state[k, i] = _rate(state.start, along, values)
        if any(computed):
            differences = _differences(flat[path], values, scenario, start)
            found.state[k, computed] = differences[computed]
    return found


def _is_formula(compiled: CompiledModel, scenario: Scenario, state: StateVariable, known: Values) -> bool:
    """Whether a state starts with what the scenario gives, or with a formula of parameters."""
    if compiled.system.dependents or compiled.system.closures:
        return False
    if state.path in scenario.initial:
        return True
    is_given_at_port = any(path.is_below(state.path.parent) for path in scenario.initial)
    return not is_given_at_port and all(leaf in known for leaf in leaves(state.start))


def _rate(formula: Expr, along: Mapping[Expr, float], values: Values) -> float:
    (slopes,) = partial_derivatives([formula], along)
    return sum(interpret(slope, values) * along[leaf] for leaf, slope in slopes.items())


def _differences(
    parameter: FlatParameter, values: Values, scenario: Scenario, start: Callable[[Scenario], Start]
) -> FloatArray:
    """The derivatives of all states at the start, from starts with other values of a parameter, within its range."""
    here = values[parameter.symbol]
    # At most an eighth of the range, so that four steps have room on one side of any place in it.
    distance = min(DISTANCE * (abs(here) or 1.0), (parameter.high - parameter.low) / 8.0)

    def states(steps: int) -> FloatArray:
        other = {**scenario.parameters, parameter.path: here + steps * distance}
        return start(replace(scenario, parameters=other)).memory.state

    def has_room(steps: int) -> bool:
        return parameter.low <= here + steps * distance <= parameter.high

    if has_room(-2) and has_room(2):
        stencil = {-2: 1.0, -1: -8.0, 1: 8.0, 2: -1.0}
    else:
        distance = distance if has_room(4) else -distance
        stencil = {0: -25.0, 1: 48.0, 2: -36.0, 3: 16.0, 4: -3.0}
    starts = np.array([states(steps) for steps in stencil])
    found = np.array(list(stencil.values())) @ starts
    noise = ROUNDING * np.abs(starts).max(axis=0)
    return np.where(np.abs(found) > noise, found, 0.0) / (12.0 * distance)
