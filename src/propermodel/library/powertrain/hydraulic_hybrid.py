"""A parallel hydraulic hybrid: gearbox, variable pump/motor, accumulator, reservoir and the lines between."""

from __future__ import annotations

import math

from propermodel.expressions import Expr, ExprLike
from propermodel.library.hydraulics import GasVessel, LineResistance, PumpMotor
from propermodel.library.mechanics.rotation import Gear, TorqueGivenLoss
from propermodel.library.thermal import WallConductance
from propermodel.modelling import (
    Component,
    Input,
    Output,
    Parameter,
    Port,
    Rotation,
    SignalBlock,
    State,
    connect,
    parameter,
)


class StrokeActuator(SignalBlock):
    """Moves the displacement of the unit as a first-order lag."""

    command = Input("1")
    stroke = Output("1")
    time_constant: Parameter = parameter("s", default=0.15, low=0.0, status="estimated")
    position = State("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.stroke: self.position}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.position: (self.command - self.position) / self.time_constant}


class PumpMotorGearbox(Component):
    """The reduction from the transfer case to the unit; its loss goes by the torque at the unit's side."""

    drive = Port(Rotation)
    unit = Port(Rotation)
    torque = Input("N.m")
    ratio: Parameter = parameter("1", low=0.0)
    efficiency: Parameter = parameter("1", low=0.0, high=1.0)

    gear = Gear(ratio=ratio)
    loss = TorqueGivenLoss()

    connections = (
        connect(drive, gear.a),
        connect(gear.b, loss.shaft, unit),
        connect(torque, loss.torque),
        connect(efficiency, loss.efficiency),
    )


class HydraulicHybrid(Component):
    """A pump/motor that charges an accumulator from the driveline when braking and drives from it.

    At the start the accumulator is at its lowest working pressure, 13 MPa at 300 K, which the equation of state gives
    for `start_oil`; all other oil is in the reservoir.
    """

    drive = Port(Rotation)
    stroke_command = Input("1")
    stroke = Output("1")
    accumulator_pressure = Output("Pa")
    reservoir_pressure = Output("Pa")
    accumulator_oil = Output("m3")
    displacement: Parameter = parameter(
        "m3/rad", default=250e-6 / (2.0 * math.pi), low=0.0, source="0.74 m/s2 at 25 MPa", status="estimated"
    )
    gear_ratio: Parameter = parameter("1", default=1.25, low=0.0, source="below 2700 rpm", status="estimated")
    gear_efficiency: Parameter = parameter("1", default=0.98, low=0.0, high=1.0, status="estimated")
    rotating_inertia: Parameter = parameter("kg.m2", default=0.10, low=0.0, status="estimated")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0, status="estimated")
    ambient_pressure: Parameter = parameter("Pa", default=101325.0, source="standard atmosphere", status="published")
    accumulator_volume: Parameter = parameter("m3", default=0.120, low=0.0, status="estimated", doc="gas, no oil")
    accumulator_gas: Parameter = parameter(
        "kg", default=16.64, low=0.0, source="BWR at pre-charge, 12.5 MPa and 300 K", status="derived"
    )
    accumulator_wall_conductance: Parameter = parameter(
        "W/K", default=100.0, low=0.0, source="order of Otis' bottles without foam", status="estimated"
    )
    foam_heat_capacity: Parameter = parameter("J/K", default=0.0, low=0.0, source="Otis and Pourmovahed 1985")
    start_oil: Parameter = parameter(
        "m3", default=4.385266e-3, low=0.0, source="BWR at 13 MPa and 300 K", status="derived"
    )
    reservoir_volume: Parameter = parameter("m3", default=0.200, low=0.0, status="estimated", doc="gas, no oil")
    reservoir_gas: Parameter = parameter(
        "kg", default=0.90, low=0.0, source="ideal gas at 0.40 MPa and 300 K", status="derived"
    )
    reservoir_wall_conductance: Parameter = parameter("W/K", default=20.0, low=0.0, status="estimated")
    oil: Parameter = parameter(
        "m3", default=0.080, low=0.0, status="derived", doc="in the reservoir when the accumulator has none"
    )
    accumulator_line_resistance: Parameter = parameter(
        "Pa.s2/m6", default=1.38e9, low=0.0, source="38 mm, 2 m, loss factor 2.5, f = 0.03", status="derived"
    )
    reservoir_line_resistance: Parameter = parameter(
        "Pa.s2/m6", default=3.5e8, low=0.0, source="51 mm, 1.5 m", status="derived"
    )

    actuator = StrokeActuator()
    gearbox = PumpMotorGearbox(ratio=gear_ratio, efficiency=gear_efficiency)
    pump_motor = PumpMotor(displacement=displacement, inertia=rotating_inertia)
    accumulator_line = LineResistance(resistance=accumulator_line_resistance)
    accumulator = GasVessel(
        volume=accumulator_volume,
        gas_mass=accumulator_gas,
        start_oil=start_oil,
        liner_heat_capacity=foam_heat_capacity,
        ambient_pressure=ambient_pressure,
        ambient_temperature=ambient_temperature,
        start_temperature=ambient_temperature,
    )
    accumulator_wall = WallConductance(
        conductance=accumulator_wall_conductance, ambient_temperature=ambient_temperature
    )
    reservoir_line = LineResistance(resistance=reservoir_line_resistance)
    reservoir = GasVessel(
        volume=reservoir_volume,
        gas_mass=reservoir_gas,
        start_oil=oil - start_oil,
        ambient_pressure=ambient_pressure,
        ambient_temperature=ambient_temperature,
        start_temperature=ambient_temperature,
    )
    reservoir_wall = WallConductance(conductance=reservoir_wall_conductance, ambient_temperature=ambient_temperature)

    connections = (
        connect(drive, gearbox.drive),
        connect(gearbox.unit, pump_motor.shaft),
        connect(pump_motor.high, accumulator_line.a),
        connect(accumulator_line.b, accumulator.oil),
        connect(accumulator.wall, accumulator_wall.port),
        connect(reservoir.oil, reservoir_line.a),
        connect(reservoir_line.b, pump_motor.low),
        connect(reservoir.wall, reservoir_wall.port),
        connect(pump_motor.shaft.effort, gearbox.torque),
        connect(stroke_command, actuator.command),
        connect(actuator.stroke, pump_motor.stroke, stroke),
        connect(accumulator.oil.effort + ambient_pressure, accumulator_pressure),
        connect(reservoir.oil.effort + ambient_pressure, reservoir_pressure),
        connect(accumulator.oil.displacement, accumulator_oil),
    )
