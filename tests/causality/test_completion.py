"""Strokes beyond the laws offered: elements answer with what their law takes, where nothing else is possible."""

from __future__ import annotations

import math

import numpy as np
import pytest

from propermodel.bondgraph.flatten import flatten
from propermodel.causality.completion import assign_beyond_laws
from propermodel.compiler import Backend, CompiledModel, compile_model
from propermodel.diagnostics import StructureError
from propermodel.expressions import Expr, tanh
from propermodel.modelling import Model, Parameter, Port, Resistance, Translation, connect, elaborate, parameter
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.parts import Force, Mass
from tests.physics.systems import CubicDamper, Push, run, state_matrix, system
from tests.properties.graphs import Coupler, Field, Graph, Knot, Modulus, OnePort, Wire, model_of

ZERO, ONE = JunctionKind.ZERO, JunctionKind.ONE
C, I, R = ElementKind.COMPLIANCE, ElementKind.INERTIA, ElementKind.RESISTANCE
SE, SF = ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE


def drawn(kinds: str, ones: list[OnePort], wires: list[tuple[int, int]] | None = None, **rest) -> CompiledModel:
    """A graph in electricity: the kind of every junction, and what hangs there."""
    knots = tuple(Knot(JunctionKind(kind), "electrical") for kind in kinds)
    graph = Graph(knots, tuple(Wire(*w) for w in wires or []), tuple(ones), **rest)
    return compile_model(model_of(graph), backend=Backend.INTERPRETED)


class Hardening(Resistance):
    """F = c (v + v^3), given this way only."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m")
    speed: Parameter = parameter("m/s", default=1.0)

    def effort(self, flow: Expr) -> Expr:
        ratio = flow / self.speed
        return self.damping * flow * (1.0 + ratio * ratio)


def pushed(damper: Resistance) -> Model:
    """A mass, pushed through a damper."""
    push, load = Push(force=20.0), Mass(mass=1.0)
    joints = (connect(push.flange, damper.a), connect(damper.b, load.flange))
    return elaborate(system(*joints, push=push, damper=damper, load=load))


@pytest.mark.parametrize("backend", Backend)
def test_a_law_that_gives_the_effort_is_solved_for_the_flow(backend: Backend):
    answer = run(pushed(Hardening(damping=2.0)), 1.0, backend=backend)
    assert answer["damper.port.flow"] == pytest.approx(np.full(101, 2.0), rel=1e-9)  # 2 (v + v^3) = 20
    assert answer.at_end("load.flange.flow") == pytest.approx(20.0)


def test_a_law_that_is_flat_at_zero_is_not_solved():
    with pytest.raises(StructureError, match="damper forces the other one"):
        compile_model(pushed(CubicDamper(factor=2.0)))


class Brake(Resistance):
    """Friction that saturates: it has no inverse."""

    flange = Port(Translation)
    force: Parameter = parameter("N")
    width: Parameter = parameter("m/s")

    def effort(self, flow: Expr) -> Expr:
        return self.force * tanh(flow / self.width)


def test_a_law_that_saturates_is_not_solved():
    push, brake = Force(force=1.0), Brake(force=2.0, width=0.1)
    model = elaborate(system(connect(push.flange, brake.flange), push=push, brake=brake))
    assert assign_beyond_laws(flatten(model)) is None
    with pytest.raises(StructureError, match="nothing sets the velocity"):
        compile_model(model)


def test_storage_keeps_its_state_beside_a_law_that_claims_its_effort():
    """A current of 1 A meets a capacitor, u = 2 q, and a resistance whose voltage is i + i^3."""
    model = drawn("0", [OnePort(C, 0, 2.0), OnePort(R, 0, 1.0, law="cubic"), OnePort(SF, 0, 1.0, turned=True)])
    assert [str(s.path) for s in model.system.states] == ["e0.displacement"]
    assert not model.system.dependents
    answer = run(model, 40.0, step=0.02, initial={"e0.displacement": 0.5})
    assert answer.at_start("e1.port.flow") == pytest.approx(0.6823278038280193)  # i + i^3 = 1
    assert answer.at_end("e1.port.flow") == pytest.approx(1.0, rel=1e-6)


def test_storage_without_an_inverse_law_depends_on_other_storage():
    """A linear and a cubic capacitor at one voltage: q1 = u, q2 + q2^3 = u."""
    model = drawn("0", [OnePort(C, 0, 1.0), OnePort(C, 0, 1.0, law="cubic"), OnePort(SF, 0, 1.0, turned=True)])
    answer = run(model, 4.0, step=1e-3)
    linear, cubic = answer["e0.port.displacement"], answer["e1.port.displacement"]
    assert cubic + cubic**3 == pytest.approx(linear, abs=1e-9)
    assert linear + cubic == pytest.approx(answer.time, abs=1e-7)  # the charge that flowed in


def test_a_field_may_depend_at_one_port_and_keep_a_state_at_another():
    """Coupled coils, the first in series with a third: one current, so two states for three fluxes."""
    coils = Field(I, (0, 1), ((2.0, 1.0), (1.0, 3.0)))
    model = drawn("11", [OnePort(I, 0, 1.0), OnePort(C, 0, 1.0), OnePort(R, 1, 1.0)], fields=(coils,))
    assert len(model.system.states) == 3
    assert len(model.system.dependents) == 1
    # L = inverse of the matrix, with 1 H more in the first branch; x = (current, charge, current).
    inductance = np.linalg.inv(np.array(coils.matrix)) + np.diag([1.0, 0.0])
    rates = np.zeros((3, 3))
    rates[np.ix_([0, 1], [0, 1])] = np.linalg.solve(inductance, np.diag([0.0, -1.0]))
    rates[:2, 2] = np.linalg.solve(inductance, [-1.0, 0.0])
    rates[2, 0] = 1.0
    expected, found = np.linalg.eigvals(rates), np.linalg.eigvals(state_matrix(model))
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(expected), abs=1e-9)


def test_strokes_are_found_where_the_first_choice_leads_nowhere():
    """Two parallel ways between junctions; sequential assignment meets a junction that nothing determines."""
    gyrator = Coupler(ElementKind.GYRATOR, (1, 0), Modulus(0.5))
    ones = [
        OnePort(I, 0, 1.0, law="cubic"),
        OnePort(R, 1, 1.0),
        OnePort(C, 1, 1.0),
        OnePort(I, 2, 1.0),
        OnePort(SE, 2, 1.0),
    ]
    model = drawn("011", ones, [(1, 0), (2, 0)], couplers=(gyrator,))
    answer = run(model, 1.0)
    assert math.isfinite(answer.at_end("e1.port.flow"))
    power = sum(answer.at_end(f"e{n}.port.effort") * answer.at_end(f"e{n}.port.flow") for n in range(5))
    assert power == pytest.approx(0.0, abs=1e-12)


def test_a_dependence_that_cancels_does_not_make_a_higher_index():
    """Both sides of the gyrator carry one flow, so its efforts cancel: the two capacitors hold one voltage."""
    gyrator = Coupler(ElementKind.GYRATOR, (0, 2), Modulus(1.5))
    ones = [OnePort(C, 0, 1.0), OnePort(C, 1, 2.0), OnePort(SF, 1, 1.0, turned=True)]
    model = drawn("100", ones, [(0, 1), (2, 0)], couplers=(gyrator,))
    assert len(model.system.states) == len(model.system.dependents) == 1
    answer = run(model, 1.0)
    assert answer["e0.port.effort"] == pytest.approx(-answer["e1.port.effort"], abs=1e-9)


def test_a_source_with_nothing_to_act_on_keeps_its_value():
    model = drawn("1", [OnePort(SE, 0, 4.0), OnePort(SF, 0, 0.0), OnePort(C, 0, 1.0)])
    answer = run(model, 1.0)
    assert answer.at_end("e0.port.effort") == pytest.approx(4.0)
