"""Linearisation at a point of a run, at a start or at an equilibrium: exact derivatives, controllers held."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from propermodel.analysis.inputs import Opened, open_inputs
from propermodel.analysis.linear_model import ElementVariables, LinearModel, OperatingPoint
from propermodel.codegen.machine import BoolArray, FloatArray, Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Path, SimulationError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.model import ElementKind, Resistive, Scenario, Storage
from propermodel.simulation.equilibrium import Equilibrium
from propermodel.simulation.observables import observable_path
from propermodel.simulation.point import Point
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import Start, begin
from propermodel.simulation.trajectory import Trajectory


def linearise(
    compiled: CompiledModel,
    at: Scenario | Trajectory | Equilibrium,
    *,
    time: float | None = None,
    inputs: Iterable[Expr | Path | str] | None = None,
    outputs: Iterable[Expr | Path | str] | None = None,
) -> LinearModel:
    """The linear model of small deviations from an operating point.

    Derivatives are exact, through algebraic loops and dependent storage too, and one-sided where a law has a kink.
    Controllers keep the values they hold; continuous signal states are states.

    Args:
        compiled: The model.
        at: A scenario (its start), a run (its end, or the instant `time`), or an equilibrium.
        time: The instant of a run, s; the run is repeated up to it.
        inputs: Root inputs and prescribed ports, sources (what is added to their value), outputs of controllers; by
            default the inputs of the scenario, or where there are none, the sources.
        outputs: Observables; by default the states.

    Raises:
        SimulationError: a name is unknown, the run does not reach the instant, or the derivatives do not exist there.
    """
    memory, description = operating_point(compiled, at, time)
    opened = open_inputs(compiled, memory, inputs)
    point = Point(opened.system, opened.lowered, opened.memory, from_above=True)
    system = opened.system
    chosen = _outputs(compiled, outputs)
    units = [opened.lowered.observables[path].unit if path.name != "power" else "W" for path in chosen]
    signals = [_observable(opened, path) for path in chosen]
    ports, variables, stored = _element_variables(opened)
    rates = [state.derivative for state in system.states]
    roots = [*rates, *signals, *variables]
    states = [state.symbol for state in system.states]
    moving = [item.node for item in opened.inputs]
    drifting = [item.rate if item.rate is not None else item.node for item in opened.inputs]
    n, p = len(states), len(signals)
    seeds = list(dict.fromkeys([*states, *moving, *drifting]))
    column = {seed: index for index, seed in enumerate(seeds)}
    whole = point.derivatives(roots, seeds)
    head = csr_array(whole[: n + p]).toarray()
    on_inputs = head[:, [column[node] for node in moving]]
    on_rates = head[:, [column[node] for node in drifting]]
    without_rate = [index for index, item in enumerate(opened.inputs) if item.rate is None]
    on_rates[:, without_rate] = 0.0
    matrix = head[:, :n]
    _check_finite(head, [*(state.path for state in system.states), *chosen], point.time)
    rows = csr_array(whole[n + p :])[:, :n]
    half = rows.shape[0] // 2
    efforts, others = csr_array(rows[:half]), csr_array(rows[half:])
    known = np.flatnonzero(_is_finite(efforts) & _is_finite(others))
    return LinearModel(
        name=compiled.model.name,
        states=tuple(state.path for state in system.states),
        state_units=tuple(state.unit for state in system.states),
        inputs=tuple(item.path for item in opened.inputs),
        input_units=tuple(item.unit for item in opened.inputs),
        outputs=chosen,
        output_units=tuple(units),
        A=_frozen(matrix[:n]),
        B=_frozen(on_inputs[:n]),
        C=_frozen(matrix[n:]),
        D=_frozen(on_inputs[n:]),
        B_rate=_frozen(on_rates[:n]),
        D_rate=_frozen(on_rates[n:]),
        point=OperatingPoint(
            description=description,
            time=point.time,
            states=_frozen(opened.memory.state),
            inputs=_frozen(point.values([item.value for item in opened.inputs])),
            outputs=_frozen(point.values(signals)),
            rates=_frozen(point.values(rates)),
        ),
        elements=ElementVariables(
            paths=tuple(ports[index] for index in known),
            is_storage=tuple(stored[index] for index in known),
            efforts=csr_array(efforts[known]),
            others=csr_array(others[known]),
        ),
    )


def _frozen(values: FloatArray) -> FloatArray:
    result = np.array(values, dtype=np.float64)
    result.flags.writeable = False
    return result


def _is_finite(rows: Any) -> BoolArray:
    """Whether all entries of each row of a sparse matrix are finite."""
    result = np.ones(rows.shape[0], dtype=np.bool_)
    entries = rows.tocoo()
    result[entries.row[~np.isfinite(entries.data)]] = False
    return result


def _check_finite(matrix: FloatArray, rows: Sequence[Path], time: float) -> None:
    bad = np.flatnonzero(~np.isfinite(matrix).all(axis=1))
    if bad.size:
        names = ", ".join(str(rows[index]) for index in bad[:5])
        raise SimulationError.of(
            "linear/not-finite",
            f"the derivatives of {names} are not finite at {time:g} s",
            help="a law has a vertical tangent or no value there; choose another point",
        )


# -- the operating point -----------------------------------------------------------------------------------


def operating_point(
    compiled: CompiledModel, at: Scenario | Trajectory | Equilibrium, time: float | None
) -> tuple[Memory, str]:
    """The memory of a model at the start of a scenario, an instant of a run or an equilibrium, and where that is.

    Raises:
        SimulationError: it belongs to another compiled model, or the run does not reach the instant.
    """
    if isinstance(at, Scenario):
        if time is not None and time != at.start:
            raise SimulationError.of(
                "linear/point",
                f"a scenario says what the state is at its start ({at.start:g} s), not at {time:g} s",
                help="simulate it, and linearise at an instant of the run",
            )
        return begin(compiled, at), f"start of scenario {at.name}"
    if at.compiled is not compiled:
        raise SimulationError.of(
            "linear/point",
            "the run or equilibrium belongs to another compiled model",
            help="linearise with the compiled model that made it",
        )
    if isinstance(at, Equilibrium):
        return at.memory, f"equilibrium in scenario {at.scenario.name}"
    return memory_at(at, time), f"run of scenario {at.scenario.name}"


def memory_at(run: Trajectory, time: float | None) -> Memory:
    """The memory of a run at an instant, by default its end; an earlier instant is reached by repeating the run.

    Raises:
        SimulationError: the run does not cover the instant.
    """
    end = run.memory.time
    if time is None or time == end:
        return run.memory
    if not run.scenario.start <= time <= end:
        raise SimulationError.of(
            "linear/point",
            f"the run goes from {run.scenario.start:g} to {end:g} s; {time:g} s is outside",
            help="choose an instant inside the run, or simulate further",
        )
    start = begin(run.compiled, run.scenario)
    start.state[:] = [run.at_start(state.path) for state in run.compiled.system.states]
    start.discrete[:] = [run.at_start(held.data.path) for held in run.compiled.lowered.held]
    if time == run.scenario.start:
        return start
    again = simulate(
        run.compiled,
        replace(run.scenario, stop=time),
        method=run.method,
        step=run.step,
        jacobian_every=run.jacobian_every,
        tolerance=run.tolerance,
        record=(),
        record_every=time - run.scenario.start,
        integrals_every=time - run.scenario.start,
        start=Start(start, ()),
    )
    if not again.ending.is_complete:
        raise SimulationError.of(
            "linear/point",
            f"the run could not be repeated up to {time:g} s: {again.ending.message}",
            help="choose an earlier instant, or a smaller step",
        )
    return again.memory


# -- what is looked at -------------------------------------------------------------------------------------


def _outputs(compiled: CompiledModel, outputs: Iterable[Expr | Path | str] | None) -> tuple[Path, ...]:
    if outputs is None:
        return tuple(state.path for state in compiled.system.states)
    known = compiled.lowered.observables
    chosen = tuple(dict.fromkeys(map(observable_path, outputs)))
    faults = Faults(SimulationError)
    for path in chosen:
        is_power = path.name == "power" and path.parent / "effort" in known and path.parent / "flow" in known
        if path not in known and not is_power:
            faults.add(
                Diagnostic(
                    "simulation/unknown-observable",
                    f"the model has no observable '{path}'",
                    help=one_of(str(path), map(str, known)),
                )
            )
    faults.raise_if_any()
    return chosen


def _observable(opened: Opened, path: Path) -> Expr:
    known = opened.lowered.observables
    if path not in known:
        return _observable(opened, path.parent / "effort") * _observable(opened, path.parent / "flow")
    return opened.signals[known[path].index]


def _element_variables(opened: Opened) -> tuple[list[Path], list[Expr], list[bool]]:
    """Of every port of a storage or resistance: its element; all efforts, then what is stored or flows."""
    known = opened.lowered.observables
    paths: list[Path] = []
    efforts: list[Expr] = []
    others: list[Expr] = []
    stored: list[bool] = []
    for element in opened.system.causal.graph.normal.elements.values():
        if not isinstance(element.behaviour, Storage | Resistive):
            continue
        for port in element.ports:
            first, second = "effort", "flow"
            if isinstance(element.behaviour, Storage):
                is_compliance = element.behaviour.kind is ElementKind.COMPLIANCE
                first, second = ("effort", "displacement") if is_compliance else ("flow", "momentum")
            here = element.path / port
            if here / first not in known or here / second not in known:
                continue
            paths.append(element.path)
            stored.append(isinstance(element.behaviour, Storage))
            efforts.append(_observable(opened, here / first))
            others.append(_observable(opened, here / second))
    return paths, [*efforts, *others], stored
