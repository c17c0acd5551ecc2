"""Predictions along runs with several operating points: a coupling that is there now and then."""

from __future__ import annotations

import numpy as np
import pytest

import propermodel as pm
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import parse_path
from propermodel.expressions import Expr, ExprLike, floor, time, where
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import Input, Output, SignalBlock, Transformer, Translation, quantity
from propermodel.reduction.operating_points import operating_points
from propermodel.simulation.trajectory import Trajectory
from tests.physics.systems import SinePush

PERIOD, SHARE = 20.0, 0.25  # s, and the share of it for which the lever works


class NowAndThen(SignalBlock):
    """One for a quarter of every period, otherwise zero."""

    ratio = Output("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        phase = time / quantity(PERIOD, "s")
        return {self.ratio: where(phase - floor(phase) < SHARE, 1.0, 0.0)}


class Lever(Transformer):
    """Carries a share of its flow on."""

    a = pm.Port(Translation)
    b = pm.Port(Translation)
    ratio = Input("1")

    def modulus(self) -> Expr:
        return self.ratio


class Brake(pm.Component):
    """A pushed mass, which a lever connects now and then to a part with a spring and a damper."""

    shaker = SinePush(force=10.0, frequency=0.3)
    mass = Mass(mass=5.0)
    drag = Damper(damping=1.0)
    signal = NowAndThen()
    lever = Lever()
    tool = Mass(mass=1.0)
    spring = Spring(stiffness=3.0)
    brake = Damper(damping=20.0)
    ground = Fixed()

    connections = (
        pm.connect(shaker.flange, mass.flange, drag.a, lever.a),
        pm.connect(lever.b, tool.flange, spring.a, brake.a),
        pm.connect(ground.flange, drag.b, spring.b, brake.b),
        pm.connect(signal.ratio, lever.ratio),
    )


def run(model: pm.Model) -> Trajectory:
    return pm.simulate(
        pm.compile_model(model), pm.Scenario(stop=100.0), method=pm.Method.RK4, step=2e-3, record_every=2e-2
    )


def test_what_works_now_and_then_is_predicted():
    model = pm.elaborate(Brake())
    full = run(model)
    prediction = pm.predict_errors(full, ["mass.flange.flow"])
    for name in ("brake.port", "spring.port", "tool.flange"):
        removal = pm.ZeroEffort(parse_path(name))
        predicted = prediction.of([removal])
        assert predicted is not None
        other = run(model.without([removal]))
        true = pm.compare(full, other, ["mass.flange.flow"]).outputs[0].rms
        assert true > 0.001
        assert 0.5 < predicted.worst / true < 2.0, name


def test_instants_are_divided_by_slopes_that_vary():
    slow = np.where(np.arange(400) % 100 < 30, 1.0, 0.0)
    constant = np.full(400, 7.0)
    found = operating_points([0, 0], np.array([slow, constant]), np.array([slow, 0.5 * constant]))
    assert len(set(found[slow == 1.0])) == len(set(found[slow == 0.0])) == 1
    assert found[0] != found[50]


@pytest.mark.parametrize("slope", [np.linspace(1.0, 2.0, 400), np.r_[100.0, np.ones(399)]])
def test_slopes_that_hardly_or_rarely_vary_make_no_operating_points(slope: FloatArray):
    assert not np.any(operating_points([0], slope[np.newaxis], np.ones((1, 400))))
