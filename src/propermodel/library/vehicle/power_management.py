"""Power management, sampled at 100 Hz; all gains estimated.

Braking: pump first, friction brakes for the rest. Driving: motor first, engine for the rest. The accumulator may run
from full to empty.
"""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, maximum, minimum, tanh, where
from propermodel.library.hydraulics import UnitFriction
from propermodel.modelling import Controller, Discrete, Input, Output, Parameter, parameter, quantity


def satur(value: ExprLike) -> Expr:
    """The value held between 0 and 1."""
    return clip(value, 0.0, 1.0)


class EngineManagement(Controller):
    """Driving by the engine and braking by friction alone: the conventional truck."""

    wish = Input("N.m")
    standstill = Input("1")
    engine_speed = Input("rad/s")
    full_load_torque = Input("N.m")
    torque_ratio = Input("1")
    clutch_closed = Input("1")
    ratio = Input("1")
    gear_efficiency = Input("1")
    output_speed = Input("rad/s")
    engine_demand = Output("N.m", start=-1e6)
    brake_pedal = Output("1", start=0.6)
    throttle = Output("1")
    braking = Discrete("1", start=1.0)
    brake_torque: Parameter = parameter("N.m", low=0.0, doc="Coulomb torque of an axle at full pedal")
    final_drive_ratio: Parameter = parameter("1", low=0.0)
    churning_damping: Parameter = parameter("N.m.s/rad", low=0.0)
    charging_torque: Parameter = parameter("N.m", low=0.0)
    accessory_power: Parameter = parameter("W", low=0.0)
    accessory_speed: Parameter = parameter("rad/s", low=0.0)
    least_full_load: Parameter = parameter("N.m", default=50.0, low=0.0, status="estimated")
    to_braking: Parameter = parameter("N.m", default=-60.0, status="estimated", doc="wish below which braking begins")
    to_driving: Parameter = parameter("N.m", default=-10.0, status="estimated", doc="wish above which driving begins")
    standing_pedal: Parameter = parameter("1", default=0.6, low=0.0, high=1.0, status="estimated")
    overrun_demand: Parameter = parameter("N.m", default=-1e6, doc="below any motoring torque: fuel is cut")

    def step(self) -> dict[Expr, ExprLike]:
        return self.commands(quantity(0.0, "N.m"))

    def commands(self, unit_torque: Expr) -> dict[Expr, ExprLike]:
        """What engine and brakes do beside a torque that something else gives at the transfer case."""
        standing = self.standstill > 0.5
        wish = self.wish
        braking = self.is_braking()
        rest = (wish - unit_torque) / (self.ratio * self.gear_efficiency)
        pedal = satur((unit_torque - wish) * self.final_drive_ratio / (3.0 * self.brake_torque))
        return {
            self.braking: where(braking, 1.0, 0.0),
            self.engine_demand: where(braking, self.overrun_demand, self.engine_torque(rest)),
            self.brake_pedal: where(standing, self.standing_pedal, where(braking, pedal, 0.0)),
            self.throttle: where(braking, 0.0, self.throttle_position()),
        }

    def is_braking(self) -> Expr:
        """Whether the present wish is one to brake; between two thresholds the mode stays."""
        brakes = where(self.wish < self.to_braking, 1.0, where(self.wish > self.to_driving, 0.0, self.braking))
        return (self.standstill > 0.5) | (brakes > 0.5)

    def converter_ratio(self) -> Expr:
        """Torque ratio of the converter, 1 when locked."""
        return where(self.clutch_closed > 0.5, 1.0, self.torque_ratio)

    def auxiliary_torque(self) -> Expr:
        """What charging pump and accessories take from the crankshaft."""
        return self.charging_torque + self.accessory_power / maximum(self.engine_speed, self.accessory_speed)

    def engine_torque(self, rest: Expr) -> Expr:
        """Engine torque for a torque at the gear's input."""
        turbine = rest + self.churning_damping * self.ratio * self.output_speed
        return where(turbine > 0.0, turbine / self.converter_ratio(), turbine) + self.auxiliary_torque()

    def throttle_position(self) -> Expr:
        """The wish as a share of full load, the motor's part included: what the shift schedule reads."""
        share = self.wish / (self.ratio * self.gear_efficiency * self.converter_ratio())
        return satur((share + self.auxiliary_torque()) / maximum(self.full_load_torque, self.least_full_load))


class HybridManagement(EngineManagement):
    """Pump before friction brakes, motor before engine."""

    speed = Input("m/s")
    stroke = Input("1")
    accumulator_pressure = Input("Pa")
    reservoir_pressure = Input("Pa")
    accumulator_oil = Input("m3")
    stroke_command = Output("1")
    displacement: Parameter = parameter("m3/rad", low=0.0)
    gear_ratio: Parameter = parameter("1", low=0.0, doc="from the transfer case to the unit")
    unit_efficiency: Parameter = parameter("1", low=0.0, high=1.0, doc="of the gearbox to the unit")
    viscous: Parameter = parameter("Pa.s", low=0.0, doc="coefficient times viscosity")
    coulomb: Parameter = parameter("1", low=0.0)
    hydrodynamic: Parameter = parameter("kg/m3", low=0.0, doc="coefficient times density")
    isolation_width: Parameter = parameter("1", low=0.0)
    speed_width: Parameter = parameter("rad/s", low=0.0)
    lowest_pressure: Parameter = parameter(
        "Pa", default=13e6, low=0.0, source="just above pre-charge", status="estimated"
    )
    lowest_pressure_fade: Parameter = parameter("Pa", default=0.5e6, low=0.0, status="estimated")
    lowest_oil: Parameter = parameter("m3", default=1e-3, low=0.0, status="estimated")
    lowest_oil_fade: Parameter = parameter("m3", default=3e-3, low=0.0, status="estimated")
    highest_pressure: Parameter = parameter(
        "Pa", default=35e6, low=0.0, source="Eaton HLA, 5000 psi", status="published"
    )
    highest_pressure_margin: Parameter = parameter("Pa", default=0.3e6, low=0.0, status="estimated")
    highest_pressure_fade: Parameter = parameter("Pa", default=1e6, low=0.0, status="estimated")
    pump_speed: Parameter = parameter("m/s", default=0.9, low=0.0, source="Eaton HLA, 2 mph", status="published")
    pump_speed_fade: Parameter = parameter("m/s", default=0.6, low=0.0, status="estimated")
    motor_torque: Parameter = parameter("N.m", default=20.0, low=0.0, status="estimated")
    motor_torque_fade: Parameter = parameter("N.m", default=40.0, low=0.0, status="estimated")

    def step(self) -> dict[Expr, ExprLike]:
        moving = where(self.is_braking(), self.pump_stroke(), -self.motor_stroke())
        commands = self.commands(self.unit_torque())
        return {**commands, self.stroke_command: where(self.standstill > 0.5, 0.0, moving)}

    def friction(self) -> UnitFriction:
        """The friction of the unit."""
        return UnitFriction(
            displacement=self.displacement,
            viscous=self.viscous,
            coulomb=self.coulomb,
            hydrodynamic=self.hydrodynamic,
        )

    def unit_speed(self) -> Expr:
        """Speed of the unit."""
        return self.output_speed / self.gear_ratio

    def pressure(self) -> Expr:
        """Pressure across the unit, the lines ignored."""
        return self.accumulator_pressure - self.reservoir_pressure

    def unit_torque(self) -> Expr:
        """The torque that the unit gives at the transfer case with its present stroke, positive when driving."""
        speed, friction = self.unit_speed(), self.friction()
        valve = minimum(1.0, abs(self.stroke) / self.isolation_width)
        loss = friction.viscous_torque(speed) + valve * friction.pressure_torque(self.pressure())
        loss = loss + abs(self.stroke) * friction.hydrodynamic_torque(speed)
        shaft = self.stroke * self.displacement * self.pressure() + loss * tanh(speed / self.speed_width)
        kept = where(shaft < 0.0, self.unit_efficiency, 1.0 / self.unit_efficiency)
        return -shaft / self.gear_ratio * kept

    def motor_stroke(self) -> Expr:
        """The stroke that gives the wish alone, as far as pressure and oil last."""
        speed, friction = self.unit_speed(), self.friction()
        loss = friction.viscous_torque(speed) + self.displacement * self.coulomb * self.pressure()
        slope = self.displacement * self.pressure() - friction.hydrodynamic_torque(speed)
        wanted = satur((self.wish * self.gear_ratio / self.unit_efficiency + loss) / slope)
        charged = satur((self.accumulator_pressure - self.lowest_pressure) / self.lowest_pressure_fade)
        filled = satur((self.accumulator_oil - self.lowest_oil) / self.lowest_oil_fade)
        return minimum(wanted, charged * filled) * satur((self.wish - self.motor_torque) / self.motor_torque_fade)

    def pump_stroke(self) -> Expr:
        """The stroke that brakes as wished, as far as the accumulator takes it and the truck is fast enough."""
        speed, friction = self.unit_speed(), self.friction()
        loss = friction.viscous_torque(speed) + self.displacement * self.coulomb * self.pressure()
        slope = self.displacement * self.pressure() + friction.hydrodynamic_torque(speed)
        wanted = satur((-self.wish * self.gear_ratio * self.unit_efficiency - loss) / slope)
        full = self.highest_pressure - self.highest_pressure_margin
        room = satur((full - self.accumulator_pressure) / self.highest_pressure_fade)
        return wanted * room * satur((self.speed - self.pump_speed) / self.pump_speed_fade)
