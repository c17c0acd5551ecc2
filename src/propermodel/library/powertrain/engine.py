"""A diesel engine: torque from a map of speed and injected fuel, an injection controller, one lumped inertia."""

from __future__ import annotations

import math
from typing import TypeVar

from propermodel.expressions import Expr, ExprLike, clip, maximum, minimum, where
from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.modelling import (
    Component,
    EffortSource,
    Input,
    Output,
    Parameter,
    Port,
    Rotation,
    SignalBlock,
    State,
    connect,
    parameter,
    quantity,
    table,
)

# Polynomial fitted to the map of the NREL ADVISOR file FC_CI205cat3126_emis (Caterpillar 3126E, 205 kW; maker's sheet
# and 13-mode ESC test by Battelle) above 181 N m and 1000 rpm: rms error 2.6 %, largest 12 % at the corners. At zero
# torque it is tied to motoring friction over an indicated efficiency of 0.42. Only facts were used, the file is not
# copied.
MAP_SOURCE = "NREL ADVISOR FC_CI205cat3126_emis (Caterpillar 3126E), re-fitted; derived"
IDLE_FUEL = (0.5186, 0.5004, 0.2071)
FUEL_SLOPE = (17.7718, -17.9098, 9.1613)
FUEL_CURVE = (1.0524, 0.4329)
DISPLACEMENT = 7.24e-3  # m3, Caterpillar 3126B sheet
STROKE = 0.127  # m, Caterpillar 3126B sheet

FULL_LOAD_RPM = (0, 300, 700, 1000, 1200, 1440, 1600, 1800, 2000, 2200, 2400, 2640, 2640.001)
FULL_LOAD = (0, 400, 600, 950, 1090, 1166, 1160, 1130, 1090, 1040, 979, 0, 0)
FULL_INJECTION_RPM = (0, 700, 1000, 1200, 1440, 1600, 1800, 2000, 2200, 2400, 2640)
FULL_INJECTION_MG = (90.4, 90.4, 129.4, 141.7, 146.0, 143.0, 138.7, 135.5, 133.2, 131.2, 16.8)
MAP_RPM = (*range(300, 2601, 100), 2640)
MAP_MG = tuple(2.5 * k for k in range(67))

Number = TypeVar("Number", Expr, float)


def fuel_polynomial(x: Number) -> tuple[Number, Number, Number]:
    """Fuel in g/s as m_0 + m_1 y + m_2 y^2, with x = omega / 200 rad/s and y = T / 1000 N m."""
    idle = x * (IDLE_FUEL[0] + x * (IDLE_FUEL[1] + x * IDLE_FUEL[2]))
    slope = x * (FUEL_SLOPE[0] + x * (FUEL_SLOPE[1] + x * FUEL_SLOPE[2]))
    return idle, slope, x * (FUEL_CURVE[0] + x * FUEL_CURVE[1])


def fuel_rate(speed: Expr, torque: Expr, motoring_torque: Expr) -> Expr:
    """Fuel for a brake torque; it falls linearly to zero when the engine is motored."""
    idle, slope, curve = fuel_polynomial(speed / quantity(200.0, "rad/s"))
    y = torque / quantity(1000.0, "N.m")
    driving = idle + y * (slope + y * curve)
    motoring = idle * (1.0 + torque / motoring_torque)
    return maximum(where(torque >= 0.0, driving, motoring), 0.0) * quantity(1.0, "g/s")


def motoring_torque(rpm: float) -> float:
    """Friction of direct-injection diesels (Heywood 1988), N m: 75 + 48 n / 1000 + 0.4 S_p^2 kPa of mean pressure."""
    piston_speed = 2.0 * STROKE * rpm / 60.0
    return DISPLACEMENT / (4.0 * math.pi) * 1e3 * (75.0 + 48.0 * rpm / 1000.0 + 0.4 * piston_speed**2)


def mapped_torque(rpm: float, injected_mg: float) -> float:
    """Brake torque in N m for injected fuel: the fuel polynomial solved for torque; three injections a revolution."""
    fuel = 3.0 * rpm / 60.0 * injected_mg * 1e-3
    idle, slope, curve = fuel_polynomial(rpm * math.pi / 30.0 / 200.0)
    if fuel < idle:
        return motoring_torque(rpm) * (fuel / idle - 1.0)
    return 1000.0 * (math.sqrt(slope * slope - 4.0 * curve * (idle - fuel)) - slope) / (2.0 * curve)


class InjectionController(SignalBlock):
    """Fuel per stroke for the torque demanded: idle governor, motoring and full-load limits, smoke limit.

    T = clip(max(T_demand, k_id (omega_id - omega)), -T_f, T_full); the governor is alive when fuel is cut.
    """

    speed = Input("rad/s")
    demand = Input("N.m")
    injected_mass = Output("kg")
    fuel = Output("kg/s")
    full_load_torque = Output("N.m")
    idle_speed: Parameter = parameter("rad/s", default=74.704, low=0.0, source="700 rpm in neutral", status="estimated")
    idle_gain: Parameter = parameter("N.m.s/rad", default=60.0, low=0.0, status="estimated")
    displacement: Parameter = parameter(
        "m3", default=DISPLACEMENT, low=0.0, source="Caterpillar 3126B sheet", status="published"
    )
    piston_stroke: Parameter = parameter(
        "m", default=STROKE, low=0.0, source="Caterpillar 3126B sheet", status="published"
    )
    torque_scale: Parameter = parameter("1", default=1.0, low=0.0, doc="size of the engine for design studies")
    full_load = table(
        "N.m", ("rpm",), [FULL_LOAD_RPM], FULL_LOAD, source="330 hp rating, drawn to the shape of the 205 kW curve"
    )
    full_injection = table("mg", ("rpm",), [FULL_INJECTION_RPM], FULL_INJECTION_MG, source=MAP_SOURCE)

    def motoring_torque(self) -> Expr:
        """Friction of direct-injection diesels (Heywood 1988): 75 + 48 n / 1000 + 0.4 S_p^2 kPa of mean pressure."""
        piston_speed = self.piston_stroke * self.speed / math.pi
        constant, linear = quantity(75.0, "kPa"), quantity(48.0, "kPa") * (self.speed / quantity(1000.0, "rpm"))
        mean_pressure = constant + linear + quantity(0.4, "kPa.s2/m2") * piston_speed * piston_speed
        return self.displacement / (4.0 * math.pi) * mean_pressure

    def outputs(self) -> dict[Expr, ExprLike]:
        motoring, full = self.motoring_torque(), self.full_load(self.speed)
        governed = maximum(self.demand, self.idle_gain * (self.idle_speed - self.speed)) / self.torque_scale
        wanted = fuel_rate(self.speed, clip(governed, -motoring, full), motoring)
        # Six cylinders, four strokes: three injections a revolution.
        per_time = 3.0 / (2.0 * math.pi) * maximum(self.speed, quantity(1.0, "rad/s"))
        mass = self.torque_scale * minimum(wanted / per_time, self.full_injection(self.speed))
        return {
            self.injected_mass: mass,
            self.fuel: mass * per_time,
            self.full_load_torque: self.torque_scale * full,
        }


class Combustion(EffortSource):
    """Brake torque on the crankshaft, from the map of speed and injected mass per stroke."""

    shaft = Port(Rotation)
    speed = Input("rad/s")
    injected_mass = Input("kg")
    torque_scale: Parameter = parameter("1", default=1.0, low=0.0)
    torque = table(
        "N.m",
        ("rpm", "mg"),
        [MAP_RPM, MAP_MG],
        [mapped_torque(rpm, mg) for rpm in MAP_RPM for mg in MAP_MG],
        source=MAP_SOURCE,
    )

    def effort(self) -> Expr:
        return -self.torque_scale * self.torque(self.speed, self.injected_mass / self.torque_scale)


class Accessories(EffortSource):
    """Accessories of constant power, at no more than their torque at a lowest speed."""

    shaft = Port(Rotation)
    speed = Input("rad/s")
    power: Parameter = parameter("W", low=0.0)
    lowest_speed: Parameter = parameter("rad/s", default=30.0, low=0.0, status="estimated")

    def effort(self) -> Expr:
        return self.power / maximum(self.speed, self.lowest_speed)


class FuelMeter(SignalBlock):
    """The fuel used."""

    fuel = Input("kg/s")
    used = Output("kg")
    mass = State("kg")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.used: self.mass}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.mass: self.fuel}


class Engine(Component):
    """Caterpillar 3126, 330 hp: crankshaft with the converter's impeller as one inertia."""

    crankshaft = Port(Rotation)
    demand = Input("N.m")
    full_load_torque = Output("N.m")
    fuel_used = Output("kg")
    torque_scale: Parameter = parameter("1", default=1.0, low=0.0, doc="size of the engine for design studies")
    crankshaft_inertia: Parameter = parameter(
        "kg.m2", default=1.1, low=0.0, source="Chrono MTV motor shaft", status="published"
    )
    impeller_inertia: Parameter = parameter(
        "kg.m2", default=0.30, low=0.0, source="Chrono MTV input shaft; with half the oil", status="estimated"
    )
    accessory_power: Parameter = parameter(
        "W", default=5000.0, low=0.0, source="NREL ADVISOR ACC_HEAVY", status="estimated"
    )
    start_speed: Parameter = parameter("rad/s", default=700.0 * math.pi / 30.0, doc="700 rpm")

    injection = InjectionController(torque_scale=torque_scale)
    combustion = Combustion(torque_scale=torque_scale)
    accessories = Accessories(power=accessory_power)
    inertia = RotatingInertia(inertia=crankshaft_inertia + impeller_inertia, start_speed=start_speed)
    fuel_meter = FuelMeter()

    connections = (
        connect(crankshaft, combustion.shaft, accessories.shaft, inertia.shaft),
        connect(inertia.shaft.flow, injection.speed, combustion.speed, accessories.speed),
        connect(demand, injection.demand),
        connect(injection.injected_mass, combustion.injected_mass),
        connect(injection.fuel, fuel_meter.fuel),
        connect(injection.full_load_torque, full_load_torque),
        connect(fuel_meter.used, fuel_used),
    )
