"""Systems without a closed form against their equations written by hand and solved by SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from propermodel.expressions import Expr, ExprLike, cos, exp, sin, tanh, time, where
from propermodel.library.hydraulics import OpenTank, Orifice
from propermodel.library.mechanics.rotation import RotatingInertia, TorsionSpring, ViscousFriction
from propermodel.library.mechanics.translation import Damper, Fixed, GasSpring, Mass, Spring, SpringDamper
from propermodel.library.thermal import HeatCapacity
from propermodel.modelling import (
    Compliance,
    Controller,
    Discrete,
    EffortSource,
    Electrical,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    State,
    Transformer,
    Translation,
    connect,
    parameter,
)
from tests.parts import Capacitor, Coil, Ground, Line, Motor, Resistor, Tank, Voltage
from tests.physics.systems import (
    CubicDamper,
    Drive,
    Push,
    Shaking,
    SineVoltage,
    Wall,
    close,
    compiled,
    run,
    system,
)

TOLERANCE = 1e-7  # of the range: RK4 at these steps and SciPy at 1e-10 are both far better


def reference(rates, start, times):
    """The solution of dx/dt = rates(t, x) at some instants, row per state."""
    answer = solve_ivp(rates, (times[0], times[-1]), start, t_eval=times, method="DOP853", rtol=1e-10, atol=1e-13)
    assert answer.success
    return answer.y


def test_quarter_car_on_a_sine_road():
    mb, mw, ks, cs, kt, ct = 1200.0, 80.0, 2.0e4, 1.5e3, 2.4e5, 1.5e2
    road = Shaking(velocity=0.3, frequency=3.0)
    tyre, suspension = SpringDamper(stiffness=kt, damping=ct), SpringDamper(stiffness=ks, damping=cs)
    wheel, body = Mass(mass=mw), Mass(mass=mb)
    r = run(
        system(
            connect(road.flange, tyre.a),
            connect(tyre.b, wheel.flange, suspension.a),
            connect(suspension.b, body.flange),
            road=road,
            tyre=tyre,
            wheel=wheel,
            suspension=suspension,
            body=body,
        ),
        2.0,
        step=5e-4,
    )

    def rates(t, x):
        xt, xs, vw, vb = x
        v = 0.3 * math.sin(6.0 * math.pi * t)
        ft, fs = kt * xt + ct * (v - vw), ks * xs + cs * (vw - vb)
        return [v - vw, vw - vb, (ft - fs) / mw, fs / mb]

    x = reference(rates, [0.0] * 4, r.time)
    close(r["tyre.spring.port.displacement"], x[0], TOLERANCE)
    close(r["suspension.spring.port.displacement"], x[1], TOLERANCE)
    close(r["wheel.flange.flow"], x[2], TOLERANCE)
    close(r["body.flange.flow"], x[3], TOLERANCE)
    close(r["tyre.a.effort"], kt * x[0] + ct * (0.3 * np.sin(6.0 * np.pi * r.time) - x[2]), TOLERANCE)


class Crank(Transformer):
    """From an angle to the height of a bob: v = length sin(angle) omega."""

    a = Port(Rotation)
    b = Port(Translation)
    length: Parameter = parameter("m")
    angle = Input("rad")

    def modulus(self) -> Expr:
        return self.length * sin(self.angle)


class Turned(SignalBlock):
    speed = Input("rad/s")
    angle = Output("rad")
    start: Parameter = parameter("rad")
    turned = State("rad", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.angle: self.turned}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.turned: self.speed}


def test_pendulum_with_large_swing():
    length, mass, g, start = 0.8, 1.5, 9.81, 2.5
    rotor = RotatingInertia(inertia=mass * length**2)
    crank = Crank(length=length)
    weight = Push(force=-mass * g)
    counter = Turned(start=start)
    r = run(
        system(
            connect(rotor.shaft, crank.a),
            connect(crank.b, weight.flange),
            connect(rotor.shaft.flow, counter.speed),
            connect(counter.angle, crank.angle),
            rotor=rotor,
            crank=crank,
            weight=weight,
            counter=counter,
        ),
        4.0,
        step=5e-4,
    )
    x = reference(lambda t, x: [x[1], -g / length * math.sin(x[0])], [start, 0.0], r.time)
    close(r["counter.angle"], x[0], TOLERANCE)
    close(r["rotor.shaft.flow"], x[1], TOLERANCE)


class ChangingGear(Transformer):
    """Shaft b turns n(t) times as fast as shaft a, n = 2 + sin(3 t)."""

    a = Port(Rotation)
    b = Port(Rotation)
    rate: Parameter = parameter("rad/s", default=3.0)

    def modulus(self) -> Expr:
        return 2.0 + sin(self.rate * time)


def test_an_inertia_behind_a_changing_ratio_reacts_to_the_change_too():
    torque, j1, j2 = 4.0, 0.5, 0.2
    drive = Drive(torque=torque)
    first = RotatingInertia(inertia=j1)
    gear = ChangingGear()
    second = RotatingInertia(inertia=j2)
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
    r = run(model, 4.0)

    def rates(t, x):
        n, dn = 2.0 + math.sin(3.0 * t), 3.0 * math.cos(3.0 * t)
        return [(torque - n * dn * j2 * x[0]) / (j1 + n * n * j2)]

    (w,) = reference(rates, [0.0], r.time)
    close(r["first.shaft.flow"], w, TOLERANCE)
    close(r["second.shaft.flow"], (2.0 + np.sin(3.0 * r.time)) * w, TOLERANCE)
    n, dn = 2.0 + np.sin(3.0 * r.time), 3.0 * np.cos(3.0 * r.time)
    acceleration = (torque - n * dn * j2 * w) / (j1 + n * n * j2)
    close(r["second.shaft.effort"], j2 * (n * acceleration + dn * w), 1e-6)


class SlidingPoint(Transformer):
    """The crosshead of a long connecting rod: v = -radius sin(angle) omega."""

    a = Port(Rotation)
    b = Port(Translation)
    radius: Parameter = parameter("m")
    angle = Input("rad")

    def modulus(self) -> Expr:
        return -self.radius * sin(self.angle)


def test_a_piston_on_a_crank_is_dependent_storage_with_a_modulus_that_follows_a_state():
    radius, inertia, mass, torque, friction, start = 0.1, 0.05, 3.0, 2.0, 0.05, 0.4
    rotor, crank, piston = RotatingInertia(inertia=inertia), SlidingPoint(radius=radius), Mass(mass=mass)
    drive, bearing, counter = Drive(torque=torque), ViscousFriction(damping=friction), Turned(start=start)
    model = compiled(
        system(
            connect(rotor.shaft, crank.a, drive.shaft, bearing.shaft),
            connect(crank.b, piston.flange),
            connect(rotor.shaft.flow, counter.speed),
            connect(counter.angle, crank.angle),
            rotor=rotor,
            crank=crank,
            piston=piston,
            drive=drive,
            bearing=bearing,
            counter=counter,
        )
    )
    assert [str(s.path) for s in model.system.states] == ["rotor.momentum", "counter.turned"]
    r = run(model, 4.0, step=5e-4)

    def rates(t, x):
        angle, w = x
        s, c = math.sin(angle), math.cos(angle)
        return [w, (torque - friction * w - mass * radius**2 * s * c * w * w) / (inertia + mass * radius**2 * s * s)]

    angle, w = reference(rates, [start, 0.0], r.time)
    close(r["rotor.shaft.flow"], w, 1e-6)
    close(r["piston.flange.flow"], -radius * np.sin(angle) * w, 1e-6)


def test_two_dampers_in_series_between_a_mass_and_a_shaker_make_a_nonlinear_loop():
    m, cubic, linear = 2.0, 40.0, 15.0
    mass = Mass(mass=m, start_velocity=1.0)
    one = CubicDamper(factor=cubic)
    two = Damper(damping=linear)
    shaker = Shaking(velocity=0.5, frequency=1.0)
    model = compiled(
        system(
            connect(mass.flange, one.a),
            connect(one.b, two.a),
            connect(two.b, shaker.flange),
            mass=mass,
            one=one,
            two=two,
            shaker=shaker,
        )
    )
    assert len(model.system.blocks) == 1
    r = run(model, 2.0)

    def force(v, t):
        slip = v - 0.5 * math.sin(2.0 * math.pi * t)  # of both dampers together; the cubic one takes s of it
        s = brentq(lambda s: cubic * s**3 - linear * (slip - s), -2.0, 2.0, xtol=1e-15, rtol=1e-14)
        return cubic * s**3

    (v,) = reference(lambda t, x: [-force(x[0], t) / m], [1.0], r.time)
    close(r["mass.flange.flow"], v, TOLERANCE)
    close(r["one.port.effort"], np.array([force(*pair) for pair in zip(v, r.time, strict=True)]), TOLERANCE)
    assert r["one.port.effort"] == pytest.approx(r["two.port.effort"], abs=1e-9)


class Diode(Resistance):
    """An exponential junction, smooth in both directions; only the voltage for a current is offered."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    saturation: Parameter = parameter("A")
    thermal_voltage: Parameter = parameter("V")

    def flow(self, effort: Expr) -> Expr:
        return self.saturation * (exp(effort / self.thermal_voltage) - 1.0)


def test_a_diode_fills_a_capacitor_through_a_resistor():
    saturation, vt, resistance, load, capacitance = 1e-3, 0.5, 10.0, 1000.0, 1e-4
    source = SineVoltage(voltage=5.0, frequency=50.0)
    series = Resistor(resistance=resistance)
    diode = Diode(saturation=saturation, thermal_voltage=vt)
    store, drain, ground = Capacitor(capacitance=capacitance), Resistor(resistance=load), Ground()
    r = run(
        system(
            connect(source.a, series.a),
            connect(series.b, diode.a),
            connect(diode.b, store.a, drain.a),
            connect(store.b, drain.b, source.b, ground.pin),
            source=source,
            series=series,
            diode=diode,
            store=store,
            drain=drain,
            ground=ground,
        ),
        0.06,
        step=2e-5,
    )

    def current(v, t):
        drop = 5.0 * math.sin(100.0 * math.pi * t) - v
        return brentq(
            lambda i: resistance * i + vt * math.log1p(i / saturation) - drop,
            -saturation * (1.0 - 1e-15),
            1.0,
            xtol=1e-16,
            rtol=1e-14,
        )

    (v,) = reference(lambda t, x: [(current(x[0], t) - x[0] / load) / capacitance], [0.0], r.time)
    close(r["store.port.effort"], v, 1e-6)


class Clutch(Resistance):
    """Constant friction torque while it slips; it holds once the slip is small."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    torque: Parameter = parameter("N.m")
    engaged_after: Parameter = parameter("s")
    width: Parameter = parameter("rad/s", default=0.01)

    def effort(self, flow: Expr) -> Expr:
        return where(time >= self.engaged_after, self.torque * tanh(flow / self.width), 0.0 * self.torque)

    def locked(self) -> Expr:
        return (time >= self.engaged_after) & (abs(self.port.flow) < self.width)


def test_a_closing_clutch_keeps_momentum_and_costs_the_energy_of_the_reduced_inertia():
    j1, j2, w1 = 0.4, 0.6, 50.0
    first = RotatingInertia(inertia=j1, start_speed=w1)
    clutch = Clutch(torque=40.0, engaged_after=0.1)
    second = RotatingInertia(inertia=j2)
    r = run(
        system(
            connect(first.shaft, clutch.a),
            connect(clutch.b, second.shaft),
            first=first,
            clutch=clutch,
            second=second,
        ),
        1.0,
        step=1e-4,
    )
    common = j1 * w1 / (j1 + j2)
    assert r["first.shaft.flow"][-1] == pytest.approx(common, rel=1e-9)
    assert r["second.shaft.flow"][-1] == pytest.approx(common, rel=1e-9)
    momentum = j1 * r["first.shaft.flow"] + j2 * r["second.shaft.flow"]
    assert momentum == pytest.approx(j1 * w1, rel=1e-12)
    lost = 0.5 * j1 * j2 / (j1 + j2) * w1**2
    stored = sum(r.at_end(f"{body}.energy") - r.at_start(f"{body}.energy") for body in ("first", "second"))
    assert stored == pytest.approx(-lost, rel=1e-9)
    closing = (j1 * j2 / (j1 + j2)) * w1 / 40.0
    slip = r["clutch.port.flow"]
    sliding = (r.time > 0.1) & (r.time < 0.1 + 0.99 * closing)
    assert slip[sliding] == pytest.approx(w1 - 40.0 * (j1 + j2) / (j1 * j2) * (r.time[sliding] - 0.1), abs=0.02)


class SpeedControl(Controller):
    """Proportional and integral, once a period."""

    target: Parameter = parameter("rad/s")
    gain: Parameter = parameter("V.s/rad")
    rate: Parameter = parameter("V/rad")
    speed = Input("rad/s")
    voltage = Output("V")
    integral = Discrete("V")

    def step(self) -> dict[Expr, ExprLike]:
        error = self.target - self.speed
        integral = self.integral + self.rate * self.period * error
        return {self.integral: integral, self.voltage: self.gain * error + integral}


class Amplifier(EffortSource):
    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    voltage = Input("V")

    def effort(self) -> Expr:
        return self.voltage


def test_a_sampled_controller_holds_its_output_between_samples():
    resistance, inductance, constant, inertia, friction, period = 0.5, 0.01, 0.1, 0.01, 0.005, 0.02
    gain, rate, target = 0.3, 1.5, 20.0
    control = SpeedControl(period=period, target=target, gain=gain, rate=rate)
    source = Amplifier()
    winding = Resistor(resistance=resistance)
    coil = Coil(inductance=inductance)
    motor = Motor(constant=constant)
    ground = Ground()
    rotor, bearing = RotatingInertia(inertia=inertia), ViscousFriction(damping=friction)
    r = run(
        system(
            connect(source.a, winding.a),
            connect(winding.b, coil.a),
            connect(coil.b, motor.a),
            connect(source.b, ground.pin),
            connect(motor.b, rotor.shaft, bearing.shaft),
            connect(rotor.shaft.flow, control.speed),
            connect(control.voltage, source.voltage),
            control=control,
            source=source,
            winding=winding,
            coil=coil,
            motor=motor,
            ground=ground,
            rotor=rotor,
            bearing=bearing,
        ),
        1.0,
        step=5e-4,
        every=period,
    )
    # Between samples the plant is linear with a constant input: its exact step over one period.
    a = np.array([[-resistance / inductance, -constant / inductance], [constant / inertia, -friction / inertia]])
    b = np.array([1.0 / inductance, 0.0])
    whole = expm(np.block([[a, b[:, None]], [np.zeros((1, 3))]]) * period)
    x, integral, speeds, currents = np.zeros(2), 0.0, [], []
    for _ in r.time:
        speeds.append(x[1])
        currents.append(x[0])
        error = target - x[1]
        integral += rate * period * error
        x = whole[:2, :2] @ x + whole[:2, 2] * (gain * error + integral)
    close(r["rotor.shaft.flow"], np.array(speeds), TOLERANCE)
    close(r["coil.port.flow"], np.array(currents), 1e-6)


def test_two_tanks_with_an_orifice_and_a_line():
    c1, c2, inertance, area, rho, cd = 2e-6, 1e-6, 3e5, 2e-4, 870.0, 0.61
    high = Tank(capacity=c1)
    orifice = Orifice(area=area, discharge=cd, density=rho)
    line = Line(inertance=inertance)
    low = Tank(capacity=c2)
    r = run(
        system(
            connect(high.port, orifice.a),
            connect(orifice.b, line.a),
            connect(line.b, low.port),
            high=high,
            orifice=orifice,
            line=line,
            low=low,
        ),
        4.0,
        initial={"high.port.effort": 1e5},
    )

    def rates(t, x):
        p1, q, p2 = x
        loss = 0.5 * rho * q * abs(q) / (cd * area) ** 2
        return [-q / c1, (p1 - p2 - loss) / inertance, q / c2]

    p1, q, p2 = reference(rates, [1e5, 0.0, 0.0], r.time)
    close(r["high.port.effort"], p1, 1e-6)
    close(r["line.port.flow"], q, 1e-6)
    close(r["low.port.effort"], p2, 1e-6)


class HardeningSpring(Compliance):
    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    linear: Parameter = parameter("N/m")
    cubic: Parameter = parameter("N/m3")

    def effort(self, displacement: Expr) -> Expr:
        return self.linear * displacement + self.cubic * displacement * displacement * displacement

    def energy(self, displacement: Expr) -> Expr:
        square = displacement * displacement
        return self.linear * square / 2.0 + self.cubic * square * square / 4.0


def test_duffing_oscillator():
    m, k, k3, c = 1.0, 10.0, 400.0, 0.3
    shaker = Shaking(velocity=0.4, frequency=0.7)
    spring = HardeningSpring(linear=k, cubic=k3)
    damper = Damper(damping=c)
    mass = Mass(mass=m)
    r = run(
        system(
            connect(shaker.flange, spring.a, damper.a),
            connect(spring.b, damper.b, mass.flange),
            shaker=shaker,
            spring=spring,
            damper=damper,
            mass=mass,
        ),
        5.0,
    )

    def rates(t, x):
        v = 0.4 * math.sin(1.4 * math.pi * t)
        return [v - x[1], (k * x[0] + k3 * x[0] ** 3 + c * (v - x[1])) / m]

    x, v = reference(rates, [0.0, 0.0], r.time)
    close(r["spring.port.displacement"], x, TOLERANCE)
    close(r["mass.flange.flow"], v, TOLERANCE)


def test_a_gas_spring_whose_wall_conducts_damps_a_mass():
    v0, area, p0, kappa, hot, ca, m = 2e-3, 1e-2, 5e5, 1.4, 8.0, 300.0, 50.0
    mass = Mass(mass=m, start_velocity=1.0)
    gas = GasSpring(gas_volume=v0, piston_area=area, static_pressure=p0, heat_capacity_ratio=kappa)
    ground = Fixed()
    wall, shell = Wall(conductance=hot), HeatCapacity(capacity=ca)
    r = run(
        system(
            connect(mass.flange, gas.a),
            connect(gas.b, ground.flange),
            connect(gas.wall, wall.a),
            connect(wall.b, shell.port),
            mass=mass,
            gas=gas,
            ground=ground,
            wall=wall,
            shell=shell,
        ),
        2.0,
        step=5e-4,
    )
    gas_constant = p0 * v0 / 300.0
    cv = gas_constant / (kappa - 1.0)

    def rates(t, x):
        s, v, temperature, shell = x
        volume = v0 - area * s
        pressure = gas_constant * temperature / volume
        heat = hot * (temperature - shell)
        return [v, -(pressure - p0) * area / m, (pressure * area * v - heat) / cv, heat / ca]

    s, v, temperature, shell_temperature = reference(rates, [0.0, 1.0, 300.0, 300.0], r.time)
    close(r["gas.port.displacement"], s, TOLERANCE)
    close(r["mass.flange.flow"], v, TOLERANCE)
    close(r["gas.wall.effort"] + 300.0, temperature, 1e-6)
    close(r["shell.port.effort"] + 300.0, shell_temperature, 1e-6)


def test_a_motor_drives_a_load_over_a_soft_shaft():
    resistance, inductance, constant, j1, j2, k, c = 0.5, 0.01, 0.1, 0.01, 0.05, 3.0, 0.002
    source = Voltage(voltage=12.0)
    winding = Resistor(resistance=resistance)
    coil = Coil(inductance=inductance)
    motor = Motor(constant=constant)
    ground = Ground()
    rotor = RotatingInertia(inertia=j1)
    shaft = TorsionSpring(stiffness=k)
    load = RotatingInertia(inertia=j2)
    bearing = ViscousFriction(damping=c)
    r = run(
        system(
            connect(source.a, winding.a),
            connect(winding.b, coil.a),
            connect(coil.b, motor.a),
            connect(source.b, ground.pin),
            connect(motor.b, rotor.shaft, shaft.a),
            connect(shaft.b, load.shaft, bearing.shaft),
            source=source,
            winding=winding,
            coil=coil,
            motor=motor,
            ground=ground,
            rotor=rotor,
            shaft=shaft,
            load=load,
            bearing=bearing,
        ),
        1.0,
        step=5e-4,
    )

    def rates(t, x):
        i, w1, twist, w2 = x
        return [
            (12.0 - resistance * i - constant * w1) / inductance,
            (constant * i - k * twist) / j1,
            w1 - w2,
            (k * twist - c * w2) / j2,
        ]

    i, w1, twist, w2 = reference(rates, [0.0] * 4, r.time)
    close(r["coil.port.flow"], i, 1e-6)
    close(r["rotor.shaft.flow"], w1, 1e-6)
    close(r["shaft.port.effort"], k * twist, 1e-6)
    close(r["load.shaft.flow"], w2, 1e-6)


class TimedBeam(Transformer):
    a = Port(Translation)
    b = Port(Translation)
    rate: Parameter = parameter("rad/s", default=2.0)

    def modulus(self) -> Expr:
        return 1.5 + 0.5 * cos(self.rate * time)


def test_springs_in_series_across_a_changing_lever_are_dependent_storage():
    # Force balance at the massless lever: f1 = n f2 with f1 = k1 x1, f2 = k2 x2; x1' = v - u, x2' = n u.
    m, k1, k2 = 2.0, 60.0, 90.0
    mass = Mass(mass=m, start_velocity=0.5)
    one = Spring(stiffness=k1)
    beam = TimedBeam()
    two = Spring(stiffness=k2)
    wall = Fixed()
    model = compiled(
        system(
            connect(mass.flange, one.a),
            connect(one.b, beam.a),
            connect(beam.b, two.a),
            connect(two.b, wall.flange),
            mass=mass,
            one=one,
            beam=beam,
            two=two,
            wall=wall,
        )
    )
    assert len(model.system.states) == 2
    r = run(model, 4.0)

    def rates(t, x):
        v, x1 = x
        n, dn = 1.5 + 0.5 * math.cos(2.0 * t), -math.sin(2.0 * t)
        # x2 = k1 x1 / (n k2), so n u = x2' = k1 (x1' / n - x1 n' / n^2) / k2 with x1' = v - u.
        u = k1 / k2 * (v / n - x1 * dn / n**2) / (n + k1 / (k2 * n))
        return [-k1 * x1 / m, v - u]

    v, x1 = reference(rates, [0.5, 0.0], r.time)
    close(r["mass.flange.flow"], v, TOLERANCE)
    close(r["one.port.displacement"], x1, TOLERANCE)


def test_water_hammer_in_a_line_of_three_segments():
    inertance, capacity, area, p0 = 2e6, 1e-9, 5e-6, 3e5
    lines = {f"line{i}": Line(inertance=inertance) for i in range(3)}
    tanks = {f"tank{i}": Tank(capacity=capacity) for i in range(3)}
    nozzle, sink = Orifice(area=area), OpenTank()
    ends = [lines["line0"].b, lines["line1"].b]
    joints = [
        connect(tanks["tank0"].port, lines["line0"].a),
        connect(ends[0], tanks["tank1"].port, lines["line1"].a),
        connect(ends[1], tanks["tank2"].port, lines["line2"].a),
        connect(lines["line2"].b, nozzle.a),
        connect(nozzle.b, sink.port),
    ]
    r = run(
        system(*joints, **lines, **tanks, nozzle=nozzle, sink=sink),
        1.0,
        step=5e-4,
        initial={"tank0.port.effort": p0},
    )

    def rates(t, x):
        p, q = x[:3], x[3:]
        loss = 0.5 * 870.0 * q[2] * abs(q[2]) / (0.61 * area) ** 2
        return [
            -q[0] / capacity,
            (q[0] - q[1]) / capacity,
            (q[1] - q[2]) / capacity,
            (p[0] - p[1]) / inertance,
            (p[1] - p[2]) / inertance,
            (p[2] - loss) / inertance,
        ]

    x = reference(rates, [p0, 0, 0, 0, 0, 0], r.time)
    close(r["tank0.port.effort"], x[0], 1e-6)
    close(r["tank2.port.effort"], x[2], 1e-6)
