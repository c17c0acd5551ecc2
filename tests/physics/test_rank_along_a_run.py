"""Linear equations that a signal makes singular along a run: told where it happens, and only there."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from examples.double_pendulum import DoublePendulum
from examples.pendulum_by_transformers import PendulumByTransformers
from examples.slider_crank import SliderCrank
from propermodel.equations.rank import RankLoss
from propermodel.expressions import Expr, time
from propermodel.library.control import Gain
from propermodel.library.electrical import ConstantCurrent, ConstantVoltage, Ground, Resistor, VariableResistor
from propermodel.library.mechanics.rotation import ModulatedGear, RotatingInertia, TorqueSource
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.simulation.trajectory import RunStatus
from tests.physics.systems import compiled, scenario

VOLT = pm.quantity(1.0, "V")
SECOND = pm.quantity(1.0, "s")


def ohms(value: Expr) -> Expr:
    return value * pm.quantity(1.0, "Ohm")


def current_divider(law: Expr) -> pm.Component:
    class Divider(pm.Component):
        """1 A through 2 Ohm beside a resistance that changes with time."""

        feed = ConstantCurrent(current=1.0)
        fixed = Resistor(resistance=2.0)
        changing = VariableResistor()
        ground = Ground()

        connections = (
            pm.connect(feed.p, fixed.a, changing.a),
            pm.connect(fixed.b, changing.b, feed.n, ground.pin),
            pm.connect(law, changing.resistance),
        )

    return Divider()


def run(component: pm.Component, stop: float = 1.0, step: float = 1e-2, method: pm.Method = pm.Method.RK4):
    return pm.simulate(compiled(component), scenario(stop), step=step, method=method, record_every=0.05)


@pytest.mark.parametrize("step", [1e-2, 1.0 / 129.0])
@pytest.mark.parametrize("method", [pm.Method.EULER, pm.Method.RK4, pm.Method.ROS2])
def test_a_run_ends_where_a_negative_resistance_meets_its_positive_twin(step: float, method: pm.Method):
    answer = run(current_divider(ohms(1.0 - 4.0 * time / SECOND)), step=step, method=method)
    assert answer.ending.status is RunStatus.FAILED
    assert answer.ending.time == pytest.approx(0.75, abs=1e-9)
    assert "determinant passes zero" in answer.ending.message
    assert "time changes" in answer.ending.message
    before = answer.time < 0.75
    r = 1.0 - 4.0 * answer.time[before]
    np.testing.assert_allclose(answer["fixed.port.effort"][before], 2.0 * r / (2.0 + r), rtol=1e-9, atol=1e-12)


def test_a_resistance_may_pass_zero():
    answer = run(current_divider(ohms(1.0 - 2.0 * time / SECOND)))
    assert answer.ending.is_complete
    r = 1.0 - 2.0 * answer.time
    np.testing.assert_allclose(answer["fixed.port.effort"], 2.0 * r / (2.0 + r), rtol=1e-9, atol=1e-12)


def test_a_jump_over_zero_ends_nothing():
    answer = run(current_divider(ohms(pm.where(time > pm.quantity(0.503, "s"), -5.0, 1.0))))
    assert answer.ending.is_complete
    r = np.where(answer.time > 0.503, -5.0, 1.0)
    np.testing.assert_allclose(answer["fixed.port.effort"], 2.0 * r / (2.0 + r), rtol=1e-12)
    assert not answer.events


def test_a_gain_that_reaches_one_in_a_loop_of_signals():
    class Loop(pm.Component):
        """A voltage that a signal adds to itself."""

        battery = ConstantVoltage(voltage=1.0)
        load = Resistor(resistance=1.0)
        ground = Ground()
        feedback = Gain(gain=1.0)

        connections = (
            pm.connect(battery.p, load.a),
            pm.connect(battery.n, load.b, ground.pin),
            pm.connect(load.port.effort / VOLT + 2.0 * time / SECOND * feedback.result, feedback.signal),
        )

    answer = run(Loop())
    assert answer.ending.status is RunStatus.FAILED
    assert answer.ending.time == pytest.approx(0.5, abs=1e-9)
    before = answer.time < 0.49
    np.testing.assert_allclose(answer["feedback.result"][before], 1.0 / (1.0 - 2.0 * answer.time[before]), rtol=1e-9)


def test_inertias_behind_a_gear_are_not_watched():
    class Drive(pm.Component):
        """A flywheel behind a gear whose ratio swings through zero."""

        motor = TorqueSource()
        rotor = RotatingInertia(inertia=1.0)
        gear = ModulatedGear()
        wheel = RotatingInertia(inertia=2.0)

        connections = (
            pm.connect(motor.shaft, rotor.shaft, gear.a),
            pm.connect(gear.b, wheel.shaft),
            pm.connect(pm.sin(2.0 * math.pi * time / SECOND), gear.ratio),
            pm.connect(pm.quantity(1.0, "N.m"), motor.torque),
        )

    assert not compiled(Drive()).system.events


@pytest.mark.parametrize("kind", [DoublePendulum, PendulumByTransformers, SliderCrank, HybridTruck])
def test_dependent_storage_is_not_watched(kind: type[pm.Component]):
    assert not [event for event in compiled(kind()).system.events if isinstance(event, RankLoss)]
