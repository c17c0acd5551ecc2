"""Three subsystems of the truck against their equations written by hand and solved by SciPy."""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np
from scipy.integrate import solve_ivp

from propermodel.library.hydraulics import GasVessel, LineResistance, OpenTank
from propermodel.library.mechanics.rotation import RotatingInertia, ViscousFriction
from propermodel.library.mechanics.translation import Damper, DegressiveDamper, Fixed, Mass, Spring
from propermodel.library.powertrain.converter import TorqueConverter
from propermodel.library.powertrain.engine import Engine
from propermodel.library.powertrain.transmission import Transmission
from propermodel.library.thermal import WallConductance
from propermodel.modelling import Component, Input, connect
from tests.physics.systems import close, run, system

TOLERANCE = 1e-6  # of the range


def reference(rates, start, times, longest=np.inf):
    """The solution of dx/dt = rates(t, x) at some instants, row per state."""
    answer = solve_ivp(
        rates, (times[0], times[-1]), start, t_eval=times, method="DOP853", rtol=1e-9, atol=1e-12, max_step=longest
    )
    assert answer.success
    return answer.y


# -- an axle between its tyre and the body ---------------------------------------------------------------------


def quarter() -> Component:
    """A rear axle under its share of the body, when the road has just risen by 50 mm."""
    road, axle, body = Fixed(), Mass(mass=1100.0), Mass(mass=3800.0)
    tyre_spring, tyre_damper = Spring(stiffness=1.598e6, start_compression=0.05), Damper(damping=1.88e3)
    spring = Spring(stiffness=7.34e5)
    shock_absorber = DegressiveDamper(damping=4.0e4, degressivity_compression=3.0, degressivity_rebound=1.0)
    return system(
        connect(road.flange, tyre_spring.a, tyre_damper.a),
        connect(tyre_spring.b, tyre_damper.b, axle.flange, spring.a, shock_absorber.a),
        connect(spring.b, shock_absorber.b, body.flange),
        road=road,
        tyre_spring=tyre_spring,
        tyre_damper=tyre_damper,
        axle=axle,
        spring=spring,
        shock_absorber=shock_absorber,
        body=body,
    )


def test_an_axle_on_a_step_of_the_road():
    def rates(_, x):
        tyre, axle, suspension, body = x
        closing = axle - body
        degressivity = 3.0 if closing > 0.0 else 1.0
        force = 7.34e5 * suspension + 4.0e4 * closing / (1.0 + degressivity * abs(closing))
        return [-axle, (1.598e6 * tyre - 1.88e3 * axle - force) / 1100.0, closing, force / 3800.0]

    r = run(quarter(), 2.0, step=1e-4)
    tyre, axle, suspension, body = reference(rates, [0.05, 0.0, 0.0, 0.0], r.time, longest=1e-3)
    close(r["tyre_spring.port.displacement"], tyre, TOLERANCE)
    close(r["axle.flange.flow"], axle, TOLERANCE)
    close(r["spring.port.displacement"], suspension, TOLERANCE)
    close(r["body.flange.flow"], body, TOLERANCE)


# -- engine, converter and gear ----------------------------------------------------------------------------------


class Drive(Component):
    """An engine with a constant demand that pulls a load through the converter in one gear."""

    demand = Input("N.m")
    gear = Input("1")
    long_ago = Input("s")
    on = Input("1")
    off = Input("1")
    no_torque = Input("N.m")

    engine = Engine()
    converter = TorqueConverter()
    transmission = Transmission()
    load = RotatingInertia(inertia=60.0)
    friction = ViscousFriction(damping=10.0)

    connections = (
        connect(engine.crankshaft, converter.impeller),
        connect(converter.turbine, transmission.turbine),
        connect(transmission.output, load.shaft, friction.shaft),
        connect(demand, engine.demand),
        connect(gear, transmission.from_gear, transmission.to_gear),
        connect(long_ago, transmission.shift_start),
        connect(on, converter.engagement),
        connect(off, converter.clutch_closed),
        connect(no_torque, converter.clutch_capacity),
    )


RPM = math.pi / 30.0
FULL_LOAD = (
    (0, 300, 700, 1000, 1200, 1440, 1600, 1800, 2000, 2200, 2400, 2640, 2640.001),
    (0, 400, 600, 950, 1090, 1166, 1160, 1130, 1090, 1040, 979, 0, 0),
)
FULL_INJECTION = (
    (0, 700, 1000, 1200, 1440, 1600, 1800, 2000, 2200, 2400, 2640),
    (90.4, 90.4, 129.4, 141.7, 146.0, 143.0, 138.7, 135.5, 133.2, 131.2, 16.8),
)
SPEED_RATIO = (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0, 1.11, 1.25, 1.67, 2.0)
CAPACITY = (
    *(30.141, 29.221, 28.152, 27.052, 25.356, 23.452, 21.188, 18.714, 16.145, 14.139, 12.183, 6.830, 0.0),
    *(-8.734, -17.313, -43.403, -69.252),
)
TORQUE_RATIO = (1.98, 1.84, 1.73, 1.63, 1.52, 1.41, 1.30, 1.20, 1.09, 1.03, 0.985, 0.985, 1, 1, 1, 1, 1)


def fuel_terms(speed):
    x = speed / 200.0
    return (
        0.5186 * x + 0.5004 * x**2 + 0.2071 * x**3,
        17.7718 * x - 17.9098 * x**2 + 9.1613 * x**3,
        1.0524 * x + 0.4329 * x**2,
    )


def motoring(speed):
    piston_speed = 0.127 * speed / math.pi
    pressure = 75.0 + 48.0 * speed / RPM / 1000.0 + 0.4 * piston_speed**2
    return 7.24e-3 / (4.0 * math.pi) * 1e3 * pressure


def steady_torque(rpm, milligrams):
    idle, slope, curve = fuel_terms(rpm * RPM)
    fuel = 3.0 * rpm / 60.0 * milligrams * 1e-3
    if fuel < idle:
        return motoring(rpm * RPM) * (fuel / idle - 1.0)
    return 1000.0 * (math.sqrt(slope**2 - 4.0 * curve * (idle - fuel)) - slope) / (2.0 * curve)


MAP_RPM, MAP_STEP = (*range(300, 2601, 100), 2640), 2.5  # mg


def mapped_torque(rpm, milligrams):
    """The torque between the four nearest points of the map."""
    i, j = bisect_right(MAP_RPM, rpm) - 1, int(milligrams / MAP_STEP)
    x, y = (rpm - MAP_RPM[i]) / (MAP_RPM[i + 1] - MAP_RPM[i]), milligrams / MAP_STEP - j
    near, far = (
        (1.0 - y) * steady_torque(n, MAP_STEP * j) + y * steady_torque(n, MAP_STEP * (j + 1))
        for n in MAP_RPM[i : i + 2]
    )
    return (1.0 - x) * near + x * far


def engine_torque(speed, demand):
    rpm = speed / RPM
    asked = min(max(demand, 60.0 * (74.704 - speed)), np.interp(rpm, *FULL_LOAD))
    idle, slope, curve = fuel_terms(speed)
    y = asked / 1000.0
    fuel = idle + slope * y + curve * y * y
    milligrams = min(fuel * 1e3 / (3.0 * rpm / 60.0), np.interp(rpm, *FULL_INJECTION))
    return mapped_torque(rpm, milligrams)


def passing(power, efficiency):
    """Real over ideal torque of a gear; the loss fades out below 100 W."""
    lost = (1.0 - efficiency) * min(abs(power) / 100.0, 1.0)
    return 1.0 - lost if power >= 0.0 else 1.0 / (1.0 - lost)


def test_an_engine_pulls_a_load_through_converter_and_gear():
    ratio, efficiency = 2.24, 0.97  # third gear

    def rates(_, x):
        engine, output = x
        turbine = ratio * output
        r = turbine / engine
        impeller_torque = 1e-3 * np.interp(r, SPEED_RATIO, CAPACITY) * engine**2
        turbine_torque = np.interp(r, SPEED_RATIO, TORQUE_RATIO) * impeller_torque
        ideal = ratio * (turbine_torque - 0.05 * turbine)
        passed = passing(ideal * output, efficiency) * ideal
        return [
            (engine_torque(engine, 600.0) - 5000.0 / engine - impeller_torque) / 1.4,
            (passed - 10.0 * output) / (60.0 + 1.02 + 0.10 * ratio**2),
        ]

    inputs = {"demand": 600.0, "gear": 3.0, "long_ago": -10.0, "on": 1.0, "off": 0.0, "no_torque": 0.0}
    r = run(Drive(), 6.0, step=1e-4, inputs=inputs)
    engine, output = reference(rates, [700.0 * RPM, 0.0], r.time, longest=5e-3)
    close(r["engine.crankshaft.flow"], engine, TOLERANCE)
    close(r["load.shaft.flow"], output, TOLERANCE)


# -- a gas accumulator -------------------------------------------------------------------------------------------

V, M, WALL, AMBIENT, LINE = 0.12, 16.64, 100.0, 300.0, 1.0e12
R, A0, B0, C0 = 296.80, 136.005, 1.454304e-3, 1.040331e6
A, B, C, ALPHA, GAMMA, CV0 = 0.1155410, 2.966548e-6, 3356.603, 5.786149e-9, 6.753738e-6, 743.0


def pressure(v, T):
    wave = C / (v**3 * T**2) * (1.0 + GAMMA / v**2) * math.exp(-GAMMA / v**2)
    return R * T / v + (B0 * R * T - A0 - C0 / T**2) / v**2 + (B * R * T - A) / v**3 + A * ALPHA / v**6 + wave


def pressure_slope(v, T):
    wave = 2.0 * C / (v**3 * T**3) * (1.0 + GAMMA / v**2) * math.exp(-GAMMA / v**2)
    return R / v + (B0 * R + 2.0 * C0 / T**3) / v**2 + B * R / v**3 - wave


def heat_capacity(v, T):
    decay = math.exp(-GAMMA / v**2)
    wave = 6.0 * C / T**3 * ((1.0 - decay) / GAMMA - decay / (2.0 * v**2))
    return CV0 + 6.0 * C0 / (T**3 * v) - wave


def test_a_hot_accumulator_empties_through_its_line():
    vessel = GasVessel(volume=V, gas_mass=M, start_oil=0.05, start_temperature=360.0)
    wall, line, tank = WallConductance(conductance=WALL), LineResistance(resistance=LINE), OpenTank()
    rig = system(
        connect(vessel.oil, line.a),
        connect(line.b, tank.port),
        connect(vessel.wall, wall.port),
        vessel=vessel,
        wall=wall,
        line=line,
        tank=tank,
    )

    def rates(_, x):
        oil, T = x
        v = (V - oil) / M
        outflow = math.sqrt((pressure(v, T) - 101325.0) / LINE)
        cooling = T * pressure_slope(v, T) * outflow + WALL * (T - AMBIENT)
        return [-outflow, -cooling / (M * heat_capacity(v, T))]

    r = run(rig, 8.0, step=1e-3)
    oil, T = reference(rates, [0.05, 360.0], r.time)
    assert 0.0 < oil[-1] < 0.02
    close(r["vessel.oil.displacement"], oil, TOLERANCE)
    close(r["vessel.wall.effort"], T - AMBIENT, TOLERANCE)
    close(
        r["vessel.oil.effort"],
        np.array([pressure((V - o) / M, t) for o, t in zip(oil, T, strict=True)]) - 101325.0,
        TOLERANCE,
    )
