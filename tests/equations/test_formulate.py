"""Equations of small systems against equations derived by hand, at points with no zeros in them."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from propermodel.diagnostics import Path, StructureError
from propermodel.equations.system import BlockKind
from propermodel.expressions import Expr, sign, tanh, time
from propermodel.expressions import sin as sine
from propermodel.expressions import sqrt as root_of
from propermodel.expressions.derivatives import directional_derivative
from propermodel.expressions.interpret import interpret
from propermodel.modelling import (
    Compliance,
    Component,
    Controller,
    Input,
    MultiportCompliance,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    State,
    Transformer,
    Translation,
    Updates,
    ZeroEffort,
    ZeroFlow,
    connect,
    elaborate,
    parameter,
    prescribed_flow,
    quantity,
)
from propermodel.modelling.signals import Discrete
from tests.parts import (
    Bearing,
    Capacitor,
    Coil,
    Damper,
    Fixed,
    Flywheel,
    Force,
    Gear,
    Ground,
    Mass,
    Motor,
    Resistor,
    Spring,
    Torque,
    Voltage,
)
from tests.points import Point, equations_of
from tests.rigs import WALL, Edge, Rig, rigs


def approx(value: float) -> object:
    return pytest.approx(value, rel=1e-10, abs=1e-12)


# -- explicit systems -----------------------------------------------------------------------------------


class SeriesRLC(Component):
    source = Voltage(voltage=12.0)
    resistor = Resistor(resistance=3.0)
    coil = Coil(inductance=0.5)
    capacitor = Capacitor(capacitance=0.25)
    ground = Ground()

    connections = (
        connect(source.a, resistor.a),
        connect(resistor.b, coil.a),
        connect(coil.b, capacitor.a),
        connect(capacitor.b, source.b, ground.pin),
    )


def test_series_rlc():
    q, flux = 0.7, 1.3
    point = Point(equations_of(SeriesRLC()), {"coil.momentum": flux, "capacitor.displacement": q})
    current = flux / 0.5
    assert point.rates()["capacitor.displacement"] == approx(current)
    # The source takes the current that comes back to it, so the loop drives it with minus its voltage.
    drive = -point["source.port.flow"] / current * 12.0
    assert point.rates()["coil.momentum"] == approx(drive - 3.0 * current - q / 0.25)
    assert abs(drive) == approx(12.0)
    assert point["resistor.port.power"] == approx(3.0 * current**2)
    assert point["source.port.flow"] == approx(-current)


class Oscillator(Component):
    mass = Mass(mass=2.0)
    spring = Spring(stiffness=50.0)
    damper = Damper(damping=3.0)
    wall = Fixed()
    push = Force(force=7.0)

    connections = (
        connect(mass.flange, spring.a, damper.a, push.flange),
        connect(wall.flange, spring.b, damper.b),
    )


def test_mass_on_spring_and_damper():
    x, p = 0.1, 3.0
    point = Point(equations_of(Oscillator()), {"mass.momentum": p, "spring.displacement": x})
    v = p / 2.0
    assert point.rates() == {
        "spring.displacement": approx(v),
        "mass.momentum": approx(-50.0 * x - 3.0 * v - 7.0),
    }
    assert point["wall.flange.effort"] == approx(50.0 * x + 3.0 * v)
    assert point["wall.flange.power"] == 0.0
    assert point["push.flange.power"] == approx(7.0 * v)


class DrivenMotor(Component):
    source = Voltage(voltage=24.0)
    resistor = Resistor(resistance=0.8)
    coil = Coil(inductance=0.02)
    motor = Motor(constant=0.3)
    rotor = Flywheel(inertia=0.05)
    bearing = Bearing(friction=0.01)
    ground = Ground()

    connections = (
        connect(source.a, ground.pin),
        connect(source.b, resistor.a),
        connect(resistor.b, coil.a),
        connect(coil.b, motor.a),
        connect(motor.b, rotor.shaft, bearing.shaft),
    )


def test_dc_motor():
    flux, momentum = 0.06, 0.4
    point = Point(equations_of(DrivenMotor()), {"coil.momentum": flux, "rotor.momentum": momentum})
    i, w = flux / 0.02, momentum / 0.05
    # The source holds a against b at 24 V and a is grounded, so b stands at -24 V.
    assert point.rates() == {
        "coil.momentum": approx(-24.0 - 0.8 * i - 0.3 * w),
        "rotor.momentum": approx(0.3 * i - 0.01 * w),
    }
    assert point["motor.a.power"] == approx(0.3 * w * i)
    assert point["motor.b.power"] == approx(0.3 * w * i)


# -- dependent storage ------------------------------------------------------------------------------------


class GearedWheels(Component):
    first = Flywheel(inertia=0.4)
    gear = Gear(ratio=3.0)
    second = Flywheel(inertia=0.2)
    drive = Torque(torque=5.0)

    connections = (
        connect(first.shaft, gear.a, drive.shaft),
        connect(gear.b, second.shaft),
    )


def test_inertia_behind_a_gear_counts_with_the_square_of_the_ratio():
    system = equations_of(GearedWheels())
    (state,) = system.states
    momentum = 1.7
    point = Point(system, {str(state.path): momentum})
    total = 0.4 + 3.0**2 * 0.2
    share = 0.4 / total if state.path == Path(("first", "momentum")) else 3.0 * 0.2 / total
    assert point.rates()[str(state.path)] == approx(-5.0 * share)
    w = point["first.shaft.flow"]
    assert point["second.shaft.flow"] == approx(3.0 * w)
    assert point["second.shaft.momentum"] == approx(0.2 * 3.0 * w)
    assert system.solved[0].kinds == (BlockKind.DEPENDENT,)


class SwingingLever(Transformer):
    a = Port(Translation)
    b = Port(Translation)

    def modulus(self) -> Expr:
        return 1.0 + 0.5 * sine(time * quantity(2.0, "1/s"))


class TimedLever(Component):
    first = Mass(mass=2.0)
    lever = SwingingLever()
    second = Mass(mass=3.0)
    push = Force(force=4.0)

    connections = (connect(first.flange, lever.a, push.flange), connect(lever.b, second.flange))


def test_lever_whose_ratio_changes_with_time():
    system = equations_of(TimedLever())
    assert [str(s.path) for s in system.states] == ["first.momentum"]
    v, t = 1.5, 0.3
    point = Point(system, {"first.momentum": 2.0 * v}, time=t)
    n, rate = 1.0 + 0.5 * sin(2.0 * t), cos(2.0 * t)
    # m1 a = -F - n m2 (n a + n' v)
    a = (-4.0 - n * 3.0 * rate * v) / (2.0 + n * n * 3.0)
    assert point.rates()["first.momentum"] == approx(2.0 * a)
    assert point["second.flange.effort"] == approx(3.0 * (n * a + rate * v))


class Crank(Transformer):
    """Scotch yoke: the slider stands at -r cos(angle)."""

    a = Port(Rotation)
    b = Port(Translation)
    angle = Input("rad")
    radius: Parameter = parameter("m")

    def modulus(self) -> Expr:
        return self.radius * sine(self.angle)


class Integrator(SignalBlock):
    rate = Input("rad/s")
    value = Output("rad")
    state = State("rad")

    def outputs(self) -> Updates:
        return {self.value: self.state}

    def derivatives(self) -> Updates:
        return {self.state: self.rate}


class Yoke(Component):
    wheel = Flywheel(inertia=0.5)
    crank = Crank(radius=0.2)
    slider = Mass(mass=4.0)
    angle = Integrator()

    connections = (
        connect(wheel.shaft, crank.a),
        connect(crank.b, slider.flange),
        connect(wheel.shaft.flow, angle.rate),
        connect(angle.value, crank.angle),
    )


def test_crank_whose_ratio_depends_on_a_state():
    system = equations_of(Yoke())
    assert {str(s.path) for s in system.states} == {"wheel.momentum", "angle.state"}
    w, angle = 6.0, 0.9
    point = Point(system, {"wheel.momentum": 0.5 * w, "angle.state": angle})
    n, rate = 0.2 * sin(angle), 0.2 * cos(angle) * w
    # J a = -n m (n a + n' w): kinetic energy (J + m n^2) w^2 / 2 is conserved
    a = -n * 4.0 * rate * w / (0.5 + 4.0 * n * n)
    assert point.rates()["wheel.momentum"] == approx(0.5 * a)
    assert point.rates()["angle.state"] == approx(w)


class SeriesSprings(Component):
    wall = Fixed()
    first = Spring(stiffness=30.0)
    second = Spring(stiffness=70.0)
    mass = Mass(mass=2.0)

    connections = (
        connect(wall.flange, first.b),
        connect(first.a, second.b),
        connect(second.a, mass.flange),
    )


def test_springs_in_series_share_one_force():
    system = equations_of(SeriesSprings())
    springs = [s for s in system.states if s.path.name == "displacement"]
    assert len(springs) == 1
    (spring,) = springs
    k, other = (30.0, 70.0) if spring.path[0] == "first" else (70.0, 30.0)
    x, v = 0.3, 1.1
    point = Point(system, {str(spring.path): x, "mass.momentum": 2.0 * v})
    assert point.rates()[str(spring.path)] == approx(v * other / (k + other))
    assert point.rates()["mass.momentum"] == approx(-k * x)
    assert point["first.port.effort"] == approx(point["second.port.effort"])
    assert point["first.port.flow"] + point["second.port.flow"] == approx(v)


class HardSpring(Compliance):
    """Offers only a nonlinear law of its displacement."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))

    def effort(self, displacement: Expr) -> Expr:
        return displacement**3 * quantity(1.0, "N/m3")

    def energy(self, displacement: Expr) -> Expr:
        return displacement**4 * quantity(0.25, "N/m3")


class TwoHardSprings(Component):
    wall = Fixed()
    first = HardSpring()
    second = HardSpring()
    mass = Mass(mass=2.0)

    connections = (
        connect(wall.flange, first.b),
        connect(first.a, second.b),
        connect(second.a, mass.flange),
    )


def test_dependent_storage_without_an_inverse_law_is_named():
    with pytest.raises(StructureError) as caught:
        equations_of(TwoHardSprings())
    (fault,) = caught.value.diagnostics
    assert fault.code == "causality/no-inverse"
    assert fault.message == "the force of the storage second is decided elsewhere, and its law cannot be inverted"
    assert fault.help == (
        "offer the inverse law displacement(effort), or put a part between that lets it have its own force"
    )
    assert str(fault.source).startswith("tests/equations/test_formulate.py:")


# -- algebraic loops ----------------------------------------------------------------------------------------


class Divider(Component):
    source = Voltage(voltage=10.0)
    upper = Resistor(resistance=3.0)
    lower = Resistor(resistance=2.0)
    ground = Ground()

    connections = (
        connect(source.a, upper.a),
        connect(upper.b, lower.a),
        connect(lower.b, source.b, ground.pin),
    )


def test_two_resistors_in_series():
    point = Point(equations_of(Divider()), {})
    assert abs(point["upper.port.flow"]) == approx(10.0 / 5.0)
    assert abs(point["lower.port.effort"]) == approx(4.0)
    assert point["lower.port.effort"] / point["upper.port.effort"] == approx(2.0 / 3.0)


class Quadratic(Resistance):
    """Offers only its effort, so that it has one causality."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    drag: Parameter = parameter("N.s2/m2")

    def effort(self, flow: Expr) -> Expr:
        return self.drag * flow * abs(flow)


class Turbulent(Quadratic):
    """The same law, offered in both causalities."""

    def flow(self, effort: Expr) -> Expr:
        return sign(effort) * root_of(abs(effort) / self.drag)


class PulledDampers(Component):
    push = Force(force=-6.0)
    linear = Damper(damping=1.5)
    quadratic = Turbulent(drag=0.5)
    wall = Fixed()

    connections = (
        connect(push.flange, linear.a),
        connect(linear.b, quadratic.a),
        connect(quadratic.b, wall.flange),
    )


def test_two_dampers_in_series_share_a_force():
    point = Point(equations_of(PulledDampers()), {})
    assert point["linear.port.flow"] == approx(6.0 / 1.5)
    assert point["quadratic.port.flow"] == approx(sqrt(6.0 / 0.5))


class ParallelDampers(Component):
    """One velocity, two dampers, driven through a third: 1.5 (u - v) = 0.5 v |v| + 2 v."""

    drive = Port(Translation)
    coupling = Damper(damping=1.5)
    quadratic = Quadratic(drag=0.5)
    linear = Damper(damping=2.0)
    wall = Fixed()

    connections = (
        connect(drive, coupling.a),
        connect(coupling.b, quadratic.a, linear.a),
        connect(quadratic.b, linear.b, wall.flange),
        prescribed_flow(drive),
    )


@pytest.mark.parametrize("u", [4.0, -4.0, 0.3])
def test_nonlinear_loop_is_solved_for_its_unknowns(u):
    system = equations_of(ParallelDampers())
    point = Point(system, {}, inputs={"drive.flow": u})
    v = point["linear.port.flow"]
    assert 1.5 * (u - v) == approx(0.5 * v * abs(v) + 2.0 * v)
    # 0.5 v^2 + 3.5 |v| - 1.5 |u| = 0
    assert abs(v) == approx(-3.5 + sqrt(3.5**2 + 2 * 1.5 * abs(u)))
    assert len(system.blocks) == 1
    assert system.blocks[0].unknowns


def test_jacobian_of_a_block_is_the_derivative_of_its_residuals():
    system = equations_of(ParallelDampers())
    point = Point(system, {}, inputs={"drive.flow": 4.0})
    (block,) = system.blocks
    for row, residual in zip(block.jacobian, block.residuals, strict=True):
        for entry, unknown in zip(row, block.unknowns, strict=True):
            h = 1e-6
            up, down = ({**point.known, unknown: point.known[unknown] + d} for d in (h, -h))
            slope = (interpret(residual, up) - interpret(residual, down)) / (2 * h)
            assert interpret(entry, point.known) == pytest.approx(slope, rel=1e-6, abs=1e-8)


# -- locked resistances -------------------------------------------------------------------------------------


class Clutch(Resistance):
    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    closed = Input("1")

    def effort(self, flow: Expr) -> Expr:
        return quantity(20.0, "N.m") * tanh(flow / quantity(0.1, "rad/s"))

    def locked(self) -> Expr:
        return self.closed > 0.5


class Driveline(Component):
    pedal = Input("1")
    engine = Flywheel(inertia=0.3)
    load = Flywheel(inertia=1.2)
    clutch = Clutch()
    drive = Torque(torque=-50.0)

    connections = (
        connect(engine.shaft, drive.shaft, clutch.a),
        connect(clutch.b, load.shaft),
        connect(pedal, clutch.closed),
    )


def test_locked_clutch_holds_its_slip():
    system = equations_of(Driveline())
    states = {"engine.momentum": 0.3 * 100.0, "load.momentum": 1.2 * 100.0}
    point = Point(system, states, inputs={"pedal": 1.0})
    torque = point["clutch.port.effort"]
    assert torque == approx(50.0 * 1.2 / 1.5)  # both accelerate alike
    assert point.rates()["engine.momentum"] / 0.3 == approx(point.rates()["load.momentum"] / 1.2)


def test_slip_of_a_clutch_that_locks_decays():
    system = equations_of(Driveline())
    point = Point(system, {"engine.momentum": 0.3 * 101.0, "load.momentum": 1.2 * 100.0}, inputs={"pedal": 1.0})
    rates = point.rates()
    assert rates["engine.momentum"] / 0.3 - rates["load.momentum"] / 1.2 == approx(-1.0 / 0.02)


def test_open_clutch_follows_its_law():
    system = equations_of(Driveline())
    states = {"engine.momentum": 0.3 * 100.05, "load.momentum": 1.2 * 100.0}
    point = Point(system, states, inputs={"pedal": 0.0})
    assert point["clutch.port.effort"] == pytest.approx(20.0 * np.tanh(0.5))
    assert point.rates()["load.momentum"] == pytest.approx(20.0 * np.tanh(0.5))


# -- fields -------------------------------------------------------------------------------------------------


class BentField(MultiportCompliance):
    """Energy (k1 q1^2 + k2 q2^2) / 2 in coordinates with q1 = u + bend w^2 and q2 = w."""

    one = Port(Translation)
    two = Port(Translation)
    u = State("m")
    w = State("m")
    k1: Parameter = parameter("N/m")
    k2: Parameter = parameter("N/m")
    bend: Parameter = parameter("1/m")

    def first(self) -> Expr:
        return self.u + self.bend * self.w * self.w

    def displacements(self) -> Updates:
        return {self.one.displacement: self.first(), self.two.displacement: self.w}

    def efforts(self) -> Updates:
        return {self.one.effort: self.k1 * self.first(), self.two.effort: self.k2 * self.w}

    def energy(self) -> Expr:
        return (self.k1 * self.first() * self.first() + self.k2 * self.w * self.w) / 2.0


class FieldBetweenMasses(Component):
    field = BentField(k1=20.0, k2=30.0, bend=0.7)
    left = Mass(mass=1.0)
    right = Mass(mass=2.0)

    connections = (connect(field.one, left.flange), connect(field.two, right.flange))


def test_field_in_coordinates_of_the_authors_choice():
    u, w, v1, v2 = 0.4, -0.6, 1.2, 0.9
    system = equations_of(FieldBetweenMasses())
    point = Point(system, {"field.u": u, "field.w": w, "left.momentum": v1, "right.momentum": 2.0 * v2})
    q1 = u + 0.7 * w * w
    assert point.rates() == {
        "field.u": approx(v1 - 2.0 * 0.7 * w * v2),
        "field.w": approx(v2),
        "left.momentum": approx(-20.0 * q1),
        "right.momentum": approx(-30.0 * w),
    }
    assert point["field.one.displacement"] == approx(q1)


class CoupledField(MultiportCompliance):
    """Two displacements on one energy; the efforts are its gradient."""

    one = Port(Translation)
    two = Port(Translation)
    first = State("m")
    second = State("m")

    def energy(self) -> Expr:
        k = quantity(8.0, "N/m")
        return k * self.first * self.first / 2.0 + k * self.first * self.second / 4.0 + k * self.second * self.second


class GradientField(Component):
    field = CoupledField()
    left = Mass(mass=1.0)
    right = Mass(mass=2.0)

    connections = (connect(field.one, left.flange), connect(field.two, right.flange))


def test_efforts_of_a_field_are_the_gradient_of_its_energy():
    states = {"field.first": 0.3, "field.second": 0.5, "left.momentum": 1.0, "right.momentum": 1.0}
    point = Point(equations_of(GradientField()), states)
    assert point["field.one.effort"] == approx(8.0 * 0.3 + 2.0 * 0.5)
    assert point["field.two.effort"] == approx(2.0 * 0.3 + 16.0 * 0.5)


# -- controllers --------------------------------------------------------------------------------------------


class Counter(Controller):
    count = Discrete("1")
    value = Output("1")

    def step(self) -> Updates:
        return {self.count: self.count + 1.0, self.value: self.count + 1.0}


class Doubler(Controller):
    given = Input("1")
    doubled = Output("1")

    def step(self) -> Updates:
        return {self.doubled: 2.0 * self.given}


class Reader(Component):
    last = Doubler()
    middle = Doubler()
    first = Counter()

    connections = (connect(first.value, middle.given), connect(middle.doubled, last.given))


def test_controllers_run_after_those_they_read_from():
    system = equations_of(Reader())
    assert [str(path) for path, _ in system.updates] == ["first", "middle", "last"]
    held = {"first.count": 3.0, "first.value": 7.0, "middle.doubled": 5.0, "last.doubled": 0.0}
    point = Point(system, {}, held=held)
    new = {str(leaf.data.path): interpret(value, point.known) for _, pairs in system.updates for leaf, value in pairs}
    assert new == {"first.count": 4.0, "first.value": 4.0, "middle.doubled": 14.0, "last.doubled": 10.0}


# -- any rig ------------------------------------------------------------------------------------------------


def drawn_point(rig: Rig, data: st.DataObject, model=None) -> Point:
    system = equations_of(model or rig.component())
    values = {str(s.path): data.draw(st.floats(-3.0, 3.0), label=str(s.path)) for s in system.states}
    return Point(system, values)


def motion(rig: Rig, point: Point) -> tuple[dict[int, float], dict[int, float]]:
    velocities = {i: point[f"m{i}.flange.flow"] for i in range(len(rig.masses))}
    stretch = {n: point[f"e{n}.port.displacement"] for n, e in enumerate(rig.edges) if e.kind == "spring"}
    return velocities, stretch


@given(rigs(), st.data())
@settings(max_examples=120)
def test_any_rig_moves_as_newton_says(rig, data):
    point = drawn_point(rig, data)
    velocities, stretch = motion(rig, point)
    accelerations = rig.accelerations(velocities, stretch)
    rates = point.rates()
    for i, mass in enumerate(rig.masses):
        assert point[f"m{i}.flange.effort"] == pytest.approx(mass * accelerations[i], rel=1e-7, abs=1e-7)
        if f"m{i}.momentum" in rates:
            assert rates[f"m{i}.momentum"] == pytest.approx(mass * accelerations[i], rel=1e-7, abs=1e-7)
    for n, edge in enumerate(rig.edges):
        across = velocities.get(edge.i, 0.0) - velocities.get(edge.j, 0.0)
        if edge.kind == "lever":
            assert velocities[edge.j] == pytest.approx(edge.size * velocities[edge.i], rel=1e-7, abs=1e-7)
        elif edge.kind == "spring":
            assert rates[f"e{n}.displacement"] == pytest.approx(across, rel=1e-7, abs=1e-7)
    assert WALL not in velocities


@given(rigs(), st.data())
@settings(max_examples=60)
def test_powers_into_all_elements_of_a_rig_sum_to_zero(rig, data):
    point = drawn_point(rig, data)
    total = sum(point[f"m{i}.flange.power"] for i in range(len(rig.masses))) + point["push.flange.power"]
    total += sum(point[f"e{n}.port.power"] for n, e in enumerate(rig.edges) if e.kind != "lever")
    total += sum(point[f"e{n}.a.power"] - point[f"e{n}.b.power"] for n, e in enumerate(rig.edges) if e.kind == "lever")
    scale = 1.0 + sum(abs(point[f"m{i}.flange.power"]) for i in range(len(rig.masses)))
    assert abs(total) <= 1e-7 * scale


@given(rigs(), st.data())
@settings(max_examples=60)
def test_power_into_storage_is_the_rate_of_its_energy(rig, data):
    point = drawn_point(rig, data)
    rates = {s.symbol: s.derivative for s in point.system.states}
    for stored in point.system.energies:
        rate = interpret(directional_derivative([stored.energy], rates)[0], point.known)
        port = "flange" if stored.element[0].startswith("m") else "port"
        assert rate == pytest.approx(point[f"{stored.element}.{port}.power"], rel=1e-7, abs=1e-7)


@given(rigs(), st.data())
@settings(max_examples=80)
def test_removing_springs_and_dampers_is_making_them_weightless(rig, data):
    removable = [n for n, e in enumerate(rig.edges) if e.kind != "lever"]
    assume(removable)
    chosen = data.draw(st.lists(st.sampled_from(removable), unique=True, min_size=1))
    removals = [ZeroEffort(Path((f"e{n}", "port"))) for n in chosen]
    reduced = elaborate(rig.component()).without(removals)
    point = drawn_point(rig, data, reduced)
    velocities = {i: point[f"m{i}.flange.flow"] for i in range(len(rig.masses))}
    kept = [n for n, e in enumerate(rig.edges) if e.kind == "spring" and n not in chosen]
    stretch = {n: point[f"e{n}.port.displacement"] for n in kept} | dict.fromkeys(chosen, 0.0)
    accelerations = rig.with_sizes(dict.fromkeys(chosen, 0.0)).accelerations(velocities, stretch)
    for i, mass in enumerate(rig.masses):
        assert point[f"m{i}.flange.effort"] == pytest.approx(mass * accelerations[i], rel=1e-7, abs=1e-7)
    for n in chosen:
        edge = rig.edges[n]
        across = velocities.get(edge.i, 0.0) - velocities.get(edge.j, 0.0)
        assert point[f"e{n}.port.effort"] == 0.0
        assert point[f"e{n}.port.flow"] == pytest.approx(across, rel=1e-7, abs=1e-7)


def joined(groups: list[set[int]], i: int, j: int) -> bool:
    """Let i and j move together, unless they already do; tells whether they did not."""
    first, second = (next(g for g in groups if node in g) for node in (i, j))
    if first is second:
        return False
    groups.remove(second)
    first |= second
    return True


@given(rigs(), st.data())
@settings(max_examples=80)
def test_a_spring_or_damper_without_flow_is_a_rigid_link(rig, data):
    groups = [{node} for node in range(-1, len(rig.masses))]
    for edge in rig.edges:
        if edge.kind == "lever":
            joined(groups, edge.i, edge.j)
    edges = list(enumerate(rig.edges))
    chosen = [n for n, e in edges if e.kind != "lever" and data.draw(st.booleans()) and joined(groups, e.i, e.j)]
    assume(chosen)
    removals = [ZeroFlow(Path((f"e{n}", "port"))) for n in chosen]
    model = elaborate(rig.component()).without(removals)
    point = drawn_point(rig, data, model)
    velocities = {i: point[f"m{i}.flange.flow"] for i in range(len(rig.masses))}
    stretch: dict[int, float] = {}
    for n, edge in edges:
        if edge.kind == "spring" and n not in chosen:
            stretch[n] = point[f"e{n}.port.displacement"]
    rigid = {n: Edge("lever", e.i, e.j, 1.0) if n in chosen else e for n, e in edges}
    accelerations = Rig(rig.masses, tuple(rigid.values()), rig.force).accelerations(velocities, stretch)
    for i, mass in enumerate(rig.masses):
        assert point[f"m{i}.flange.effort"] == pytest.approx(mass * accelerations[i], rel=1e-6, abs=1e-6)
    for n in chosen:
        assert velocities.get(rig.edges[n].i, 0.0) == pytest.approx(velocities.get(rig.edges[n].j, 0.0), abs=1e-6)
        assert point[f"e{n}.port.flow"] == pytest.approx(0.0, abs=1e-9)
