"""Every method has its order, in the answer and in the energy balance; both backends give the same numbers."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, Method
from propermodel.expressions import Expr, where
from propermodel.library.hydraulics import OpenTank, Orifice
from propermodel.library.mechanics.rotation import Gear, RotatingInertia, RotationalSpringDamper
from propermodel.library.mechanics.translation import Damper, Fixed, GasSpring, Mass, Spring
from propermodel.library.thermal import HeatCapacity
from propermodel.modelling import Compliance, Inertia, Parameter, Port, Translation, connect, parameter
from tests.parts import Line, Tank
from tests.physics.systems import CubicDamper, Drive, Push, Shaking, Wall, close, compiled, run, system
from tests.physics.test_against_scipy import HardeningSpring

ORDER = {Method.EULER: 1, Method.SEMI_IMPLICIT: 1, Method.RK4: 4, Method.ROS2: 2}
METHODS = list(ORDER)


def damped():
    mass = Mass(mass=2.0, start_velocity=0.3)
    spring = Spring(stiffness=50.0)
    damper = Damper(damping=3.0)
    wall = Fixed()
    return system(
        connect(mass.flange, spring.a, damper.a),
        connect(spring.b, damper.b, wall.flange),
        mass=mass,
        spring=spring,
        damper=damper,
        wall=wall,
    )


def driven_duffing():
    shaker = Shaking(velocity=0.4, frequency=0.7)
    spring = HardeningSpring(linear=10.0, cubic=400.0)
    damper = Damper(damping=0.3)
    mass = Mass(mass=1.0)
    return system(
        connect(shaker.flange, spring.a, damper.a),
        connect(spring.b, damper.b, mass.flange),
        shaker=shaker,
        spring=spring,
        damper=damper,
        mass=mass,
    )


def order_between(coarse: float, fine: float) -> float:
    return math.log2(coarse / fine)


@pytest.mark.parametrize("method", METHODS)
def test_halving_the_step_divides_the_error_by_two_to_the_order(method):
    step = 0.04 if method is Method.RK4 else 0.002
    t, decay = 2.0, 0.75
    w = math.sqrt(25.0 - decay**2)
    exact = 0.3 * math.exp(-decay * t) * (math.cos(w * t) - decay / w * math.sin(w * t))
    model = compiled(damped())
    errors = [
        abs(run(model, t, method=method, step=h, every=t).at_end("mass.flange.flow") - exact) for h in (step, step / 2)
    ]
    assert order_between(*errors) == pytest.approx(ORDER[method], abs=0.15)


@pytest.mark.parametrize("method", METHODS)
def test_a_nonlinear_driven_system_converges_at_the_order_too(method):
    step = 0.02 if method is Method.RK4 else 0.002
    model = compiled(driven_duffing())
    speeds = [run(model, 2.0, method=method, step=h)["mass.flange.flow"] for h in (step, step / 2, step / 4)]
    changes = [float(np.max(np.abs(b - a))) for a, b in pairwise(speeds)]
    assert order_between(*changes) == pytest.approx(ORDER[method], abs=0.25)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("make", [damped, driven_duffing])
def test_the_energy_residual_shrinks_with_the_step_at_the_order_of_the_method(method, make):
    step = 0.02 if method is Method.RK4 else 0.002
    model = compiled(make())
    residuals = [
        abs(energy_balance(run(model, 2.0, method=method, step=h)).integration_residual) for h in (step, step / 2)
    ]
    # An energy is quadratic in what the method gets wrong, so it may do better; never worse.
    assert order_between(*residuals) > ORDER[method] - 0.25
    assert residuals[0] > 0.0


@pytest.mark.parametrize("method", METHODS)
def test_wiring_loses_nothing_at_any_step(method):
    balance = energy_balance(run(driven_duffing(), 2.0, method=method, step=0.01))
    assert abs(balance.wiring_residual) < 1e-12 * balance.throughput


def test_semi_implicit_euler_keeps_the_energy_of_an_oscillator_bounded():
    mass, spring, wall = Mass(mass=1.0, start_velocity=1.0), Spring(stiffness=1.0), Fixed()
    model = compiled(
        system(connect(mass.flange, spring.a), connect(spring.b, wall.flange), mass=mass, spring=spring, wall=wall)
    )
    r = run(model, 1000.0, method=Method.SEMI_IMPLICIT, step=0.05)
    energy = r["mass.energy"] + r["spring.energy"]
    assert np.max(np.abs(energy - 0.5)) < 0.03  # a share of step/2; explicit Euler would have grown to e^50
    assert run(model, 100.0, method=Method.EULER, step=0.05).at_end("mass.energy") > 1.0


# -- energy that contradicts a law is exposed ----------------------------------------------------------------


class WrongSpring(Compliance):
    """A spring whose energy is not the integral of its force."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    linear: Parameter = parameter("N/m")
    cubic: Parameter = parameter("N/m3")

    def effort(self, displacement: Expr) -> Expr:
        return self.linear * displacement + self.cubic * displacement * displacement * displacement

    def energy(self, displacement: Expr) -> Expr:
        return self.linear * displacement * displacement / 2.0


class WrongMass(Inertia):
    flange = Port(Translation)
    mass: Parameter = parameter("kg")

    def momentum(self, flow: Expr) -> Expr:
        return self.mass * flow

    def energy(self, momentum: Expr) -> Expr:
        return momentum * momentum / self.mass


@pytest.mark.parametrize(
    ("spring", "mass"),
    [
        (WrongSpring(linear=10.0, cubic=400.0), Mass(mass=1.0)),
        (HardeningSpring(linear=10.0, cubic=400.0), WrongMass(mass=1.0)),
    ],
)
def test_a_law_that_disagrees_with_its_energy_is_exposed_at_any_step(spring, mass):
    shaker = Shaking(velocity=0.4, frequency=0.7)
    model = compiled(
        system(
            connect(shaker.flange, spring.a), connect(spring.b, mass.flange), shaker=shaker, spring=spring, mass=mass
        )
    )
    coarse, fine = (energy_balance(run(model, 2.3, step=h)) for h in (2e-3, 1e-3))
    assert coarse.relative_residual > 1e-3
    assert fine.integration_residual == pytest.approx(coarse.integration_residual, rel=1e-6)  # no step cures it
    right = HardeningSpring(linear=10.0, cubic=400.0)
    heavy = Mass(mass=1.0)
    healthy = system(
        connect(shaker.flange, right.a), connect(right.b, heavy.flange), shaker=shaker, right=right, heavy=heavy
    )
    assert energy_balance(run(healthy, 2.3, step=1e-3)).relative_residual < 1e-9


# -- both backends -------------------------------------------------------------------------------------------


def geared():
    drive = Drive(torque=6.0)
    first = RotatingInertia(inertia=0.5)
    gear = Gear(ratio=0.25)
    second = RotatingInertia(inertia=0.02)
    shaft, load = RotationalSpringDamper(stiffness=3.0, damping=0.02), RotatingInertia(inertia=0.1)
    return system(
        connect(drive.shaft, first.shaft, gear.a),
        connect(gear.b, second.shaft, shaft.a),
        connect(shaft.b, load.shaft),
        drive=drive,
        first=first,
        gear=gear,
        second=second,
        shaft=shaft,
        load=load,
    )


def looped():
    mass = Mass(mass=2.0, start_velocity=1.0)
    one = CubicDamper(factor=40.0)
    two = Damper(damping=15.0)
    shaker = Shaking(velocity=0.5, frequency=1.0)
    return system(
        connect(mass.flange, one.a),
        connect(one.b, two.a),
        connect(two.b, shaker.flange),
        mass=mass,
        one=one,
        two=two,
        shaker=shaker,
    )


def gassy():
    mass = Mass(mass=50.0, start_velocity=1.0)
    gas = GasSpring(gas_volume=2e-3, piston_area=1e-2, static_pressure=5e5)
    ground = Fixed()
    wall, shell = Wall(conductance=8.0), HeatCapacity(capacity=300.0)
    return system(
        connect(mass.flange, gas.a),
        connect(gas.b, ground.flange),
        connect(gas.wall, wall.a),
        connect(wall.b, shell.port),
        mass=mass,
        gas=gas,
        ground=ground,
        wall=wall,
        shell=shell,
    )


def oily():
    high = Tank(capacity=2e-6)
    orifice = Orifice(area=2e-4)
    line = Line(inertance=3e5)
    low = Tank(capacity=1e-6)
    sink = OpenTank()
    spill = Orifice(area=1e-5)
    return system(
        connect(high.port, orifice.a),
        connect(orifice.b, line.a),
        connect(line.b, low.port, spill.a),
        connect(spill.b, sink.port),
        high=high,
        orifice=orifice,
        line=line,
        low=low,
        spill=spill,
        sink=sink,
    )


class Bumper(Compliance):
    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m")
    gap: Parameter = parameter("m")

    def effort(self, displacement: Expr) -> Expr:
        return where(displacement > self.gap, self.stiffness * (displacement - self.gap), 0.0)

    def energy(self, displacement: Expr) -> Expr:
        depth = displacement - self.gap
        return where(displacement > self.gap, self.stiffness * depth * depth / 2.0, 0.0)


def bumping():
    push, mass, bumper, wall = Push(force=3.0), Mass(mass=1.0), Bumper(stiffness=200.0, gap=0.05), Fixed()
    return system(
        connect(push.flange, mass.flange, bumper.a),
        connect(bumper.b, wall.flange),
        push=push,
        mass=mass,
        bumper=bumper,
        wall=wall,
    )


@pytest.mark.parametrize("make", [damped, driven_duffing, geared, looped, gassy, oily, bumping])
@pytest.mark.parametrize("method", METHODS)
def test_native_and_interpreted_agree(make, method):
    given = {"initial": {"high.port.effort": 1e5}} if make is oily else {}
    native, slow = (
        run(make(), 0.4, step=1e-3, method=method, backend=backend, every=0.02, **given)
        for backend in (Backend.NATIVE, Backend.INTERPRETED)
    )
    assert native.statistics.steps == slow.statistics.steps == 400
    assert native.time.tobytes() == slow.time.tobytes()
    for path in native.paths:
        found, expected = native[path], slow[path]
        scale = float(np.ptp(expected)) or float(np.max(np.abs(expected))) or 1.0
        noise = 1e-13 * float(np.max(np.abs(expected)))  # a nearly constant column has only rounding as its range
        assert np.max(np.abs(found - expected)) <= 1e-12 * scale + noise, path
    close(native.memory.activity, slow.memory.activity, 1e-12)
