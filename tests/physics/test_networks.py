"""Networks of resistors: linear ones are eliminated exactly however many loops they have, others go to Newton."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.library.electrical import Diode, Ground, Resistor, VoltageSource
from propermodel.simulation.trajectory import Trajectory

BACKENDS = [pm.Backend.NATIVE, pm.Backend.INTERPRETED]


def made(name: str, parts: dict[str, pm.Component], *connections: object) -> pm.Component:
    """A component from a dictionary of its parts."""
    return type(name, (pm.Component,), {**parts, "connections": connections})()


def run_of(compiled: pm.CompiledModel, stop: float = 0.1) -> Trajectory:
    return pm.simulate(compiled, pm.Scenario(stop=stop), method=pm.Method.RK4, step=0.01)


def grid(edges: list[tuple[int, int, float]], volts: float) -> pm.Component:
    """Resistors between numbered nodes; node 0 is ground, node 1 the supply."""
    parts: dict[str, pm.Component] = {"supply": VoltageSource(), "ground": Ground()}
    pins: dict[int, list[object]] = {0: [parts["ground"].pin], 1: [parts["supply"].pin]}
    for number, (a, b, ohm) in enumerate(edges):
        resistor = parts[f"r{number}"] = Resistor(resistance=ohm)
        pins.setdefault(a, []).append(resistor.a)
        pins.setdefault(b, []).append(resistor.b)
    joined = [pm.connect(*ends) for ends in pins.values()]
    return made("Grid", parts, pm.connect(pm.quantity(volts, "V"), parts["supply"].voltage), *joined)


def potentials(edges: list[tuple[int, int, float]], volts: float) -> np.ndarray:
    """The potentials of the nodes by nodal analysis."""
    count = 1 + max(max(a, b) for a, b, _ in edges)
    matrix = np.zeros((count, count))
    for a, b, ohm in edges:
        for one, other in ((a, b), (b, a)):
            matrix[one, one] += 1.0 / ohm
            matrix[one, other] -= 1.0 / ohm
    known = np.array([0.0, volts])
    free = np.linalg.solve(matrix[2:, 2:], -matrix[2:, :2] @ known)
    return np.concatenate([known, free])


def ladder(rungs: int) -> list[tuple[int, int, float]]:
    edges: list[tuple[int, int, float]] = []
    before = 1
    for rung in range(rungs):
        node = 2 + rung
        edges += [(before, node, 1.0 + 0.1 * rung), (node, 0, 5.0 + 0.3 * rung)]
        before = node
    return edges


def mesh(rows: int, columns: int) -> list[tuple[int, int, float]]:
    """A rectangular mesh between opposite corners, no two resistors alike."""
    names = {(0, 0): 1, (rows - 1, columns - 1): 0}
    for row in range(rows):
        for column in range(columns):
            names.setdefault((row, column), len(names))
    edges: list[tuple[int, int, float]] = []
    for (row, column), node in names.items():
        for further in ((row + 1, column), (row, column + 1)):
            if further in names:
                edges.append((node, names[further], 1.0 + 0.37 * len(edges) % 3.0))
    return edges


NETWORKS = {"ladder of 30": ladder(15), "mesh of 31": mesh(4, 5)}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", NETWORKS)
def test_a_linear_network_is_eliminated_exactly(name: str, backend: pm.Backend):
    edges = NETWORKS[name]
    assert len(edges) == int(name.split()[-1])
    compiled = pm.compile_model(pm.elaborate(grid(edges, 12.0)), backend=backend)
    assert compiled.system.blocks == ()
    run = run_of(compiled)
    known = potentials(edges, 12.0)
    for number, (a, b, ohm) in enumerate(edges):
        drop = known[a] - known[b]
        assert run.at_end(f"r{number}.port.effort") == pytest.approx(drop, rel=1e-10, abs=1e-12)
        assert run.at_end(f"r{number}.port.flow") == pytest.approx(drop / ohm, rel=1e-10, abs=1e-12)
    balance = pm.energy_balance(run)
    assert balance.dissipated == pytest.approx(balance.supplied, rel=1e-12)


def bridge() -> pm.Component:
    """A Wheatstone bridge whose galvanometer is a diode."""
    parts = {
        "supply": VoltageSource(),
        "upper_left": Resistor(resistance=100.0),
        "lower_left": Resistor(resistance=300.0),
        "upper_right": Resistor(resistance=300.0),
        "lower_right": Resistor(resistance=100.0),
        "diode": Diode(),
        "ground": Ground(),
    }
    return made(
        "DiodeBridge",
        parts,
        pm.connect(
            pm.quantity(5.0, "V") * pm.sin(pm.time * pm.quantity(2.0 * math.pi * 5.0, "rad/s")), parts["supply"].voltage
        ),
        pm.connect(parts["supply"].pin, parts["upper_left"].a, parts["upper_right"].a),
        pm.connect(parts["upper_left"].b, parts["lower_left"].a, parts["diode"].a),
        pm.connect(parts["upper_right"].b, parts["lower_right"].a, parts["diode"].b),
        pm.connect(parts["lower_left"].b, parts["lower_right"].b, parts["ground"].pin),
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_bridge_with_a_diode_is_torn_and_solved_by_newton(backend: pm.Backend):
    compiled = pm.compile_model(pm.elaborate(bridge()), backend=backend)
    (block,) = compiled.system.blocks
    assert len(block.unknowns) == 1
    run = run_of(compiled, 0.2)
    assert run.ending.is_complete
    v, i = run["diode.port.effort"], run["diode.port.flow"]
    supply = 5.0 * np.sin(2.0 * np.pi * 5.0 * run.time)
    # Seen from the diode, the bridge is a source of half the supply behind 150 Ohm.
    assert v + 150.0 * i == pytest.approx(0.5 * supply, abs=1e-9)
    law = 1e-9 * (np.exp(np.minimum(v, 0.8) / 0.02585) * (1.0 + (v - np.minimum(v, 0.8)) / 0.02585) - 1.0) + 1e-9 * v
    assert i == pytest.approx(law, abs=1e-9)


class Folded(pm.Resistance):
    """An implicit law with a greatest voltage: v = 2 i - i^2, which is 1 V at 1 A."""

    a = pm.Port(pm.Electrical)
    b = pm.Port(pm.Electrical)
    port = pm.Port(pm.Electrical, between=(a, b))

    def residual(self, effort: pm.Expr, flow: pm.Expr) -> pm.Expr:
        amperes = flow / pm.quantity(1.0, "A")
        return effort / pm.quantity(1.0, "V") - 2.0 * amperes + amperes * amperes


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_loop_without_a_solution_ends_the_run_with_a_status_that_names_the_element(backend: pm.Backend):
    parts = {"supply": VoltageSource(), "folded": Folded(), "ground": Ground()}
    rig = made(
        "Starved",
        parts,
        pm.connect(pm.quantity(10.0, "V/s") * pm.time, parts["supply"].voltage),
        pm.connect(parts["supply"].pin, parts["folded"].a),
        pm.connect(parts["folded"].b, parts["ground"].pin),
    )
    run = run_of(pm.compile_model(pm.elaborate(rig), backend=backend), 0.2)
    assert run.ending.status == "failed"
    assert run.ending.time == pytest.approx(0.1, abs=0.011)
    assert str(run.ending.path) == "folded"
    assert "folded" in run.ending.message
    solved = run.time < 0.095
    assert run["folded.port.flow"][solved] == pytest.approx(1.0 - np.sqrt(1.0 - 10.0 * run.time[solved]), abs=1e-9)
