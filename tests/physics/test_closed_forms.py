"""Small systems against the formulas of textbooks."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from propermodel.expressions import ExprLike
from propermodel.library.hydraulics import LineResistance, OpenTank, Orifice
from propermodel.library.hydraulics.components import Leakage, OilChamber
from propermodel.library.mechanics.rotation import Differential, Gear, RollingWheel, RotatingInertia, ViscousFriction
from propermodel.library.mechanics.translation import (
    Damper,
    DegressiveDamper,
    Fixed,
    Friction,
    GasSpring,
    Mass,
    QuadraticDrag,
    Spring,
)
from propermodel.library.thermal import HeatCapacity, WallConductance
from propermodel.modelling import (
    FlowSource,
    Hydraulic,
    Parameter,
    Port,
    Thermal,
    Transformer,
    Translation,
    connect,
    parameter,
)
from tests.parts import Capacitor, Coil, Ground, Lever, Line, Motor, Pipe, Resistor, Tank, Voltage
from tests.physics.systems import Drive, Moving, Push, Wall, close, compiled, eigenvalues, run, system

# -- mechanics ---------------------------------------------------------------------------------------------


def oscillator(m: float = 2.0, k: float = 50.0, c: float | None = None):
    mass, spring, wall = Mass(mass=m, start_velocity=0.3), Spring(stiffness=k), Fixed()
    if c is None:
        return system(
            connect(mass.flange, spring.a), connect(spring.b, wall.flange), mass=mass, spring=spring, wall=wall
        )
    damper = Damper(damping=c)
    return system(
        connect(mass.flange, spring.a, damper.a),
        connect(spring.b, damper.b, wall.flange),
        mass=mass,
        spring=spring,
        damper=damper,
        wall=wall,
    )


def test_a_mass_on_a_spring_swings_at_its_natural_frequency():
    r = run(oscillator(m=2.0, k=50.0), 3.0)
    w = 5.0
    close(r["mass.flange.flow"], 0.3 * np.cos(w * r.time))
    close(r["spring.port.displacement"], 0.3 / w * np.sin(w * r.time))
    close(r["spring.port.effort"], 50.0 * 0.3 / w * np.sin(w * r.time))


def test_a_damped_oscillator_decays():
    m, k, c = 2.0, 50.0, 3.0
    r = run(oscillator(m, k, c), 3.0)
    decay = c / (2.0 * m)
    w = math.sqrt(k / m - decay**2)
    close(r["spring.port.displacement"], 0.3 / w * np.exp(-decay * r.time) * np.sin(w * r.time))


def test_an_overdamped_oscillator_has_two_real_eigenvalues():
    m, k, c = 2.0, 50.0, 40.0
    root = math.sqrt(c**2 - 4.0 * k * m)
    assert eigenvalues(oscillator(m, k, c)) == pytest.approx([(-c - root) / (2 * m), (-c + root) / (2 * m)])


def test_a_spring_under_a_constant_force_swings_about_its_static_compression():
    m, k, force = 2.0, 50.0, 20.0
    mass, spring, wall, push = Mass(mass=m), Spring(stiffness=k), Fixed(), Push(force=force)
    r = run(
        system(
            connect(push.flange, mass.flange, spring.a),
            connect(spring.b, wall.flange),
            mass=mass,
            spring=spring,
            wall=wall,
            push=push,
        ),
        3.0,
    )
    close(r["spring.port.displacement"], force / k * (1.0 - np.cos(5.0 * r.time)))
    assert r["wall.flange.effort"] == pytest.approx(k * r["spring.port.displacement"])


def test_springs_in_series_are_softer_and_the_second_is_dependent_storage():
    m, k1, k2 = 2.0, 50.0, 200.0
    mass, first, second, wall = Mass(mass=m, start_velocity=0.3), Spring(stiffness=k1), Spring(stiffness=k2), Fixed()
    model = compiled(
        system(
            connect(mass.flange, first.a),
            connect(first.b, second.a),
            connect(second.b, wall.flange),
            mass=mass,
            first=first,
            second=second,
            wall=wall,
        )
    )
    assert len(model.system.states) == 2
    r = run(model, 3.0)
    k = k1 * k2 / (k1 + k2)
    w = math.sqrt(k / m)
    close(r["mass.flange.flow"], 0.3 * np.cos(w * r.time))
    close(r["first.port.effort"], k * 0.3 / w * np.sin(w * r.time))
    close(r["second.port.displacement"], k / k2 * 0.3 / w * np.sin(w * r.time))


def test_parallel_springs_add_up():
    m, k1, k2 = 2.0, 50.0, 200.0
    mass, first, second, wall = Mass(mass=m, start_velocity=0.3), Spring(stiffness=k1), Spring(stiffness=k2), Fixed()
    r = run(
        system(
            connect(mass.flange, first.a, second.a),
            connect(first.b, second.b, wall.flange),
            mass=mass,
            first=first,
            second=second,
            wall=wall,
        ),
        3.0,
    )
    close(r["mass.flange.flow"], 0.3 * np.cos(math.sqrt((k1 + k2) / m) * r.time))


def test_masses_welded_together_move_as_one():
    one, two, push = Mass(mass=2.0), Mass(mass=3.0), Push(force=10.0)
    model = compiled(system(connect(one.flange, two.flange, push.flange), one=one, two=two, push=push))
    assert len(model.system.states) == 1
    r = run(model, 1.0)
    close(r["two.flange.flow"], 2.0 * r.time)
    assert r["two.flange.effort"] == pytest.approx(6.0)


class Rope(Transformer):
    """Over a pulley: what goes down on one side comes up on the other."""

    a = Port(Translation)
    b = Port(Translation)

    def modulus(self) -> float:
        return -1.0


def test_atwood_machine():
    g, m1, m2 = 9.81, 3.0, 2.0
    left, right, rope = Mass(mass=m1), Mass(mass=m2), Rope()
    pull1, pull2 = Push(force=m1 * g), Push(force=m2 * g)
    model = compiled(
        system(
            connect(left.flange, pull1.flange, rope.a),
            connect(rope.b, right.flange, pull2.flange),
            left=left,
            right=right,
            rope=rope,
            pull1=pull1,
            pull2=pull2,
        )
    )
    assert len(model.system.states) == 1
    r = run(model, 1.0)
    close(r["left.flange.flow"], (m1 - m2) / (m1 + m2) * g * r.time)
    close(r["right.flange.flow"], -(m1 - m2) / (m1 + m2) * g * r.time)
    assert abs(r["rope.a.effort"]) == pytest.approx(2.0 * m1 * m2 / (m1 + m2) * g)


def test_a_lever_reflects_stiffness_with_the_square_of_its_ratio():
    m, k, ratio = 2.0, 50.0, 1.5
    mass, lever, spring, wall = Mass(mass=m, start_velocity=0.3), Lever(ratio=ratio), Spring(stiffness=k), Fixed()
    r = run(
        system(
            connect(mass.flange, lever.a),
            connect(lever.b, spring.a),
            connect(spring.b, wall.flange),
            mass=mass,
            lever=lever,
            spring=spring,
            wall=wall,
        ),
        3.0,
    )
    close(r["mass.flange.flow"], 0.3 * np.cos(ratio * math.sqrt(k / m) * r.time))


def test_drag_slows_a_vehicle_hyperbolically():
    m, area, rho, v0 = 1000.0, 2.0, 1.2, 30.0
    car, drag = Mass(mass=m, start_velocity=v0), QuadraticDrag(drag_area=area, air_density=rho)
    r = run(system(connect(car.flange, drag.flange), car=car, drag=drag), 20.0, step=0.01)
    close(r["car.flange.flow"], v0 / (1.0 + 0.5 * rho * area * v0 / m * r.time))


def test_dry_friction_slows_at_a_constant_rate():
    m, force, v0 = 2.0, 10.0, 5.0
    mass, rub, wall = Mass(mass=m, start_velocity=v0), Friction(force=force, width=0.01), Fixed()
    model = system(connect(mass.flange, rub.a), connect(rub.b, wall.flange), mass=mass, rub=rub, wall=wall)
    r = run(model, 0.9)
    close(r["mass.flange.flow"], v0 - force / m * r.time)


def test_smoothed_friction_creeps_to_rest_by_its_own_closed_form():
    # m v' = -F tanh(v / w) integrates to sinh(v / w) = sinh(v0 / w) exp(-F t / (m w)).
    m, force, width, v0 = 2.0, 1.0, 0.5, 1.0
    mass, rub, wall = Mass(mass=m, start_velocity=v0), Friction(force=force, width=width), Fixed()
    model = system(connect(mass.flange, rub.a), connect(rub.b, wall.flange), mass=mass, rub=rub, wall=wall)
    r = run(model, 4.0)
    close(r["mass.flange.flow"], width * np.arcsinh(math.sinh(v0 / width) * np.exp(-force * r.time / (m * width))))


@pytest.mark.parametrize(("speed", "degressivity"), [(0.4, 2.0), (-0.4, 0.5)])
def test_a_degressive_damper_has_its_own_curve_for_either_direction(speed, degressivity):
    push = Moving(velocity=speed)
    damper = DegressiveDamper(damping=1000.0, degressivity_compression=2.0, degressivity_rebound=0.5)
    wall = Fixed()
    r = run(
        system(connect(push.flange, damper.a), connect(damper.b, wall.flange), push=push, damper=damper, wall=wall), 0.1
    )
    assert r["damper.port.effort"] == pytest.approx(1000.0 * speed / (1.0 + degressivity * abs(speed)))


# -- rotation ----------------------------------------------------------------------------------------------


def test_geared_inertias_count_with_the_square_of_the_ratio():
    torque, i1, i2, ratio = 6.0, 0.5, 0.02, 0.25  # ratio: input over output speed
    drive = Drive(torque=torque)
    first = RotatingInertia(inertia=i1)
    gear = Gear(ratio=ratio)
    second = RotatingInertia(inertia=i2)
    model = compiled(
        system(
            connect(drive.shaft, first.shaft, gear.a),
            connect(gear.b, second.shaft),
            drive=drive,
            first=first,
            gear=gear,
            second=second,
        )
    )
    assert len(model.system.states) == 1
    r = run(model, 2.0)
    n = 1.0 / ratio
    close(r["first.shaft.flow"], torque / (i1 + n**2 * i2) * r.time)
    close(r["second.shaft.flow"], n * torque / (i1 + n**2 * i2) * r.time)
    assert r["gear.b.effort"] == pytest.approx(i2 * n * torque / (i1 + n**2 * i2))


def test_a_chain_of_gears_multiplies():
    torque, inertia = 6.0, 0.02
    drive, one, two, three = Drive(torque=torque), Gear(ratio=0.5), Gear(ratio=3.0), Gear(ratio=0.2)
    load = RotatingInertia(inertia=inertia)
    r = run(
        system(
            connect(drive.shaft, one.a),
            connect(one.b, two.a),
            connect(two.b, three.a),
            connect(three.b, load.shaft),
            drive=drive,
            one=one,
            two=two,
            three=three,
            load=load,
        ),
        1.0,
    )
    close(r["load.shaft.flow"], torque * (0.5 * 3.0 * 0.2) / inertia * r.time)


def test_a_rolling_wheel_carries_the_vehicle():
    torque, radius, mass, inertia = 100.0, 0.5, 200.0, 3.0
    drive = Drive(torque=torque)
    rim = RotatingInertia(inertia=inertia)
    wheel = RollingWheel(radius=radius)
    car = Mass(mass=mass)
    r = run(
        system(
            connect(drive.shaft, rim.shaft, wheel.a),
            connect(wheel.b, car.flange),
            drive=drive,
            rim=rim,
            wheel=wheel,
            car=car,
        ),
        2.0,
    )
    close(r["car.flange.flow"], torque / radius / (mass + inertia / radius**2) * r.time)


def test_a_differential_shares_torque_and_averages_speed():
    drive, axle = Drive(torque=10.0), Differential(share=0.4)
    left, right = RotatingInertia(inertia=2.0), RotatingInertia(inertia=3.0)
    r = run(
        system(
            connect(drive.shaft, axle.drive),
            connect(axle.left, left.shaft),
            connect(axle.right, right.shaft),
            drive=drive,
            axle=axle,
            left=left,
            right=right,
        ),
        1.0,
    )
    close(r["left.shaft.flow"], 0.4 * 10.0 / 2.0 * r.time)
    close(r["right.shaft.flow"], 0.6 * 10.0 / 3.0 * r.time)
    close(r["drive.shaft.flow"], 0.4 * r["left.shaft.flow"] + 0.6 * r["right.shaft.flow"])


# -- electricity -------------------------------------------------------------------------------------------


def loop(voltage: float, **elements):
    """A source and elements in series, back to ground."""
    source, ground = Voltage(voltage=voltage), Ground()
    around = [source, *elements.values()]
    joints = [connect(a.b if a is not source else source.a, b.a) for a, b in itertools.pairwise(around)]
    return system(*joints, connect(around[-1].b, source.b, ground.pin), source=source, ground=ground, **elements)


def test_rc_charges():
    r = run(loop(10.0, r=Resistor(resistance=100.0), c=Capacitor(capacitance=1e-3)), 0.5, step=1e-4)
    close(r["c.port.effort"], 10.0 * (1.0 - np.exp(-r.time / 0.1)))
    close(r["r.port.flow"], 0.1 * np.exp(-r.time / 0.1))


def test_rl_current_rises():
    r = run(loop(10.0, r=Resistor(resistance=5.0), l=Coil(inductance=0.2)), 0.2, step=1e-4)
    close(r["l.port.flow"], 2.0 * (1.0 - np.exp(-r.time * 25.0)))


@pytest.mark.parametrize("resistance", [2.0, 50.0])
def test_rlc_step(resistance):
    inductance, capacitance = 0.1, 1e-3
    model = loop(
        10.0, r=Resistor(resistance=resistance), l=Coil(inductance=inductance), c=Capacitor(capacitance=capacitance)
    )
    r = run(model, 0.2, step=2e-5)
    decay, w0 = resistance / (2.0 * inductance), 1.0 / math.sqrt(inductance * capacitance)
    w = np.emath.sqrt(w0**2 - decay**2)  # imaginary when overdamped: the same formula holds
    t = r.time
    expected = 10.0 * (1.0 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))
    close(r["c.port.effort"], expected.real)


def test_capacitors_in_series_divide_the_voltage():
    r = run(
        loop(10.0, r=Resistor(resistance=100.0), c1=Capacitor(capacitance=1e-3), c2=Capacitor(capacitance=3e-3)),
        0.5,
        step=1e-4,
    )
    whole = 1e-3 * 3e-3 / 4e-3
    charge = 10.0 * whole * (1.0 - np.exp(-r.time / (100.0 * whole)))
    close(r["c1.port.effort"], charge / 1e-3)
    close(r["c2.port.effort"], charge / 3e-3)


def test_a_bridge_of_resistors_is_solved_as_a_loop():
    # Wheatstone bridge: five resistors and no storage; nodal analysis is the independent answer.
    values = {"r1": 10.0, "r2": 40.0, "r3": 30.0, "r4": 20.0, "r5": 25.0}
    parts = {name: Resistor(resistance=value) for name, value in values.items()}
    source, ground = Voltage(voltage=12.0), Ground()
    r = run(
        system(
            connect(source.a, parts["r1"].a, parts["r2"].a),
            connect(parts["r1"].b, parts["r3"].a, parts["r5"].a),
            connect(parts["r2"].b, parts["r4"].a, parts["r5"].b),
            connect(parts["r3"].b, parts["r4"].b, source.b, ground.pin),
            source=source,
            ground=ground,
            **parts,
        ),
        1.0,
        step=0.1,
    )
    g1, g2, g3, g4, g5 = (1.0 / v for v in values.values())
    left, right = np.linalg.solve([[g1 + g3 + g5, -g5], [-g5, g2 + g4 + g5]], [12.0 * g1, 12.0 * g2])
    assert r["r3.port.effort"] == pytest.approx(left)
    assert r["r4.port.effort"] == pytest.approx(right)
    assert r["r5.port.flow"] == pytest.approx((left - right) * g5)


def motor_on(*load, voltage=12.0, resistance=0.5, constant=0.1, **parts):
    source = Voltage(voltage=voltage)
    winding = Resistor(resistance=resistance)
    motor = Motor(constant=constant)
    ground = Ground()
    return system(
        connect(source.a, winding.a),
        connect(winding.b, motor.a),
        connect(source.b, ground.pin),
        connect(motor.b, *load),
        source=source,
        winding=winding,
        motor=motor,
        ground=ground,
        **parts,
    )


def test_a_motor_with_a_flywheel_is_a_capacitor():
    voltage, resistance, constant, inertia = 12.0, 0.5, 0.1, 0.01
    rotor = RotatingInertia(inertia=inertia)
    r = run(motor_on(rotor.shaft, rotor=rotor), 1.0)
    rate = constant**2 / (resistance * inertia)
    close(r["rotor.shaft.flow"], voltage / constant * (1.0 - np.exp(-rate * r.time)))
    close(r["winding.port.flow"], voltage / resistance * np.exp(-rate * r.time))


def test_a_motor_runs_at_the_speed_where_its_torque_meets_the_load():
    voltage, resistance, constant, friction, load = 12.0, 0.5, 0.1, 0.02, 0.3
    rotor, bearing, brake = RotatingInertia(inertia=0.01), ViscousFriction(damping=friction), Drive(torque=-load)
    r = run(motor_on(rotor.shaft, bearing.shaft, brake.shaft, rotor=rotor, bearing=bearing, brake=brake), 20.0)
    speed = (constant * voltage - resistance * load) / (constant**2 + resistance * friction)
    assert r["rotor.shaft.flow"][-1] == pytest.approx(speed, rel=1e-10)
    assert r["winding.port.flow"][-1] == pytest.approx((friction * speed + load) / constant, rel=1e-10)


# -- hydraulics --------------------------------------------------------------------------------------------


def test_a_tank_empties_through_a_pipe_exponentially():
    tank, pipe, sink = Tank(capacity=2e-6), Pipe(loss=1e6), OpenTank()
    model = system(connect(tank.port, pipe.a), connect(pipe.b, sink.port), tank=tank, pipe=pipe, sink=sink)
    r = run(model, 5.0, initial={"tank.port.effort": 3e5})
    close(r["tank.port.effort"], 3e5 * np.exp(-r.time / 2.0))


def test_a_tank_empties_through_an_orifice_as_torricelli_says():
    capacity, area, p0, rho, cd = 2e-6, 1e-4, 4e5, 870.0, 0.61
    tank, orifice, sink = Tank(capacity=capacity), Orifice(area=area, discharge=cd, density=rho), OpenTank()
    model = system(connect(tank.port, orifice.a), connect(orifice.b, sink.port), tank=tank, orifice=orifice, sink=sink)
    empty_after = 2.0 * capacity * math.sqrt(p0) / (cd * area * math.sqrt(2.0 / rho))
    r = run(model, 0.9 * empty_after, initial={"tank.port.effort": p0}, step=1e-3)
    root = math.sqrt(p0) - cd * area * math.sqrt(2.0 / rho) / (2.0 * capacity) * r.time
    close(r["tank.port.effort"], root**2)


def test_leakage_empties_an_oil_chamber():
    volume, bulk, leak = 1e-3, 1.7e9, 1e-12
    chamber = OilChamber(volume=volume, bulk_modulus=bulk, start_pressure=2e7)
    gap = Leakage(conductance=leak)
    sink = OpenTank()
    model = system(connect(chamber.port, gap.a), connect(gap.b, sink.port), chamber=chamber, gap=gap, sink=sink)
    r = run(model, 2.0)
    close(r["chamber.port.effort"], 2e7 * np.exp(-leak * bulk / volume * r.time))


def test_a_line_between_a_tank_and_the_open_swings():
    capacity, inertance = 2e-6, 3e5
    tank, line, sink = Tank(capacity=capacity), Line(inertance=inertance), OpenTank()
    model = system(connect(tank.port, line.a), connect(line.b, sink.port), tank=tank, line=line, sink=sink)
    r = run(model, 5.0, initial={"tank.port.effort": 1e5})
    close(r["tank.port.effort"], 1e5 * np.cos(r.time / math.sqrt(capacity * inertance)))


class Pump(FlowSource):
    port = Port(Hydraulic)
    volume_flow: Parameter = parameter("m3/s")

    def flow(self) -> ExprLike:
        return -self.volume_flow


@pytest.mark.parametrize("flow", [2e-3, -2e-3])
def test_losses_in_series_add_up_in_either_direction(flow):
    pump = Pump(volume_flow=flow)
    line = LineResistance(resistance=1e11)
    orifice = Orifice(area=1e-4)
    sink = OpenTank()
    r = run(
        system(
            connect(pump.port, line.a),
            connect(line.b, orifice.a),
            connect(orifice.b, sink.port),
            pump=pump,
            line=line,
            orifice=orifice,
            sink=sink,
        ),
        0.1,
    )
    drop = math.copysign(1e11 * flow**2 + 0.5 * 870.0 * (flow / (0.61 * 1e-4)) ** 2, flow)
    assert r["pump.port.effort"] == pytest.approx(drop)


# -- heat --------------------------------------------------------------------------------------------------


def test_a_body_cools_to_ambient_exponentially():
    capacity, conductance, hot = 500.0, 20.0, 400.0
    body, wall = HeatCapacity(capacity=capacity, start_temperature=hot), WallConductance(conductance=conductance)
    r = run(system(connect(body.port, wall.port), body=body, wall=wall), 60.0, step=0.05)
    close(r["body.port.effort"], (hot - 300.0) * np.exp(-conductance / capacity * r.time))


def test_two_bodies_meet_at_the_mean_of_their_temperatures_and_energy_is_what_entropy_costs():
    c1, c2, t1, t2, ambient = 500.0, 200.0, 400.0, 320.0, 300.0
    hot, cold = HeatCapacity(capacity=c1, start_temperature=t1), HeatCapacity(capacity=c2, start_temperature=t2)
    wall = Wall(conductance=20.0)
    model = system(connect(hot.port, wall.a), connect(wall.b, cold.port), hot=hot, cold=cold, wall=wall)
    r = run(model, 300.0, step=0.05)
    end = (c1 * t1 + c2 * t2) / (c1 + c2)
    rate = 20.0 * (1.0 / c1 + 1.0 / c2)
    close(r["hot.port.effort"], end - ambient + (t1 - end) * np.exp(-rate * r.time))
    assert r["hot.port.effort"][-1] == pytest.approx(end - ambient, rel=1e-6)
    assert r["cold.port.effort"][-1] == pytest.approx(end - ambient, rel=1e-6)
    made = c1 * math.log(end / t1) + c2 * math.log(end / t2)
    assert made > 0.0
    stored = sum(r.at_end(f"{body}.energy") - r.at_start(f"{body}.energy") for body in ("hot", "cold"))
    assert stored == pytest.approx(-ambient * made, rel=1e-9)


class EntropyFlow(FlowSource):
    port = Port(Thermal)
    entropy_flow: Parameter = parameter("W/K")

    def flow(self) -> ExprLike:
        return -self.entropy_flow


class Insulated(FlowSource):
    port = Port(Thermal)

    def flow(self) -> float:
        return 0.0


def test_entropy_heats_a_body_exponentially():
    body, heater = HeatCapacity(capacity=500.0), EntropyFlow(entropy_flow=2.0)
    r = run(system(connect(body.port, heater.port), body=body, heater=heater), 50.0, step=0.05)
    close(r["body.port.effort"], 300.0 * (np.exp(2.0 * r.time / 500.0) - 1.0))


def test_an_insulated_gas_spring_is_adiabatic():
    volume, area, pressure, kappa = 2e-3, 1e-2, 5e5, 1.4
    press = Moving(velocity=0.05)
    gas = GasSpring(gas_volume=volume, piston_area=area, static_pressure=pressure, heat_capacity_ratio=kappa)
    ground = Fixed()
    shell = Insulated()
    r = run(
        system(
            connect(press.flange, gas.a),
            connect(gas.b, ground.flange),
            connect(gas.wall, shell.port),
            press=press,
            gas=gas,
            ground=ground,
            shell=shell,
        ),
        2.0,
    )
    left = (volume - area * 0.05 * r.time) / volume
    close(r["gas.wall.effort"], 300.0 * left ** (1.0 - kappa) - 300.0)
    close(r["gas.port.effort"], area * pressure * (left**-kappa - 1.0))


def test_friction_against_the_frame_sets_the_final_speed():
    drive, wheel, bearing = Drive(torque=3.0), RotatingInertia(inertia=0.4), ViscousFriction(damping=0.2)
    r = run(system(connect(drive.shaft, wheel.shaft, bearing.shaft), drive=drive, wheel=wheel, bearing=bearing), 5.0)
    close(r["wheel.shaft.flow"], 15.0 * (1.0 - np.exp(-0.5 * r.time)))
