"""The truck in a world frame: hills reach the body through the tyres.

Gravity acts downwards, springs carry the truck, and a road of any slope is a lever under each tyre: the ground rises
with slope times speed, and what presses on it pushes back along the way. Nothing else knows of hills, so the vertical
motion carries the slope to the engine.
"""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, sqrt
from propermodel.library.mechanics.translation import Projection, Spring
from propermodel.library.vehicle.axle import Axle
from propermodel.library.vehicle.chassis import Chassis
from propermodel.library.vehicle.road import Road
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.library.vehicle.tyre import NormalLoad, Tyre
from propermodel.modelling import (
    EffortSource,
    Input,
    Parameter,
    Port,
    Transformer,
    Translation,
    bond,
    connect,
    parameter,
)


class Weight(EffortSource):
    """Gravity, downwards."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", low=0.0)
    gravity: Parameter = parameter("m/s2", default=9.81)

    def effort(self) -> Expr:
        return self.mass * self.gravity


class Slope(Transformer):
    """The ground under a tyre rises with slope times the speed along the way."""

    a = Port(Translation)
    b = Port(Translation)
    slope = Input("1")

    def modulus(self) -> Expr:
        return self.slope


class HillyRoad(Road):
    """The same road; the slope under each axle has the hills in it."""

    def outputs(self) -> dict[Expr, ExprLike]:
        grade = self.grade(self.position)
        places = {
            self.front_slope: self.position + self.front_ahead,
            self.rear_front_slope: self.position + self.rear_front_ahead,
            self.rear_rear_slope: self.position + self.rear_rear_ahead,
        }
        return {
            self.sine_slope: grade / sqrt(1.0 + grade * grade),
            self.rolling_coefficient: self.rolling_resistance(self.position),
            **{output: self.roughness(place) + self.grade(place) for output, place in places.items()},
        }


class StandingTyre(Tyre):
    """A tyre that carries its load, on a road that may rise."""

    road = Slope()
    spring = Spring(stiffness=Tyre.stiffness, start_compression=Tyre.static_load / Tyre.stiffness)
    load = NormalLoad(static_load=0.0)

    connections = (
        connect(Tyre.along, road.a, Tyre.slip.b),
        connect(road.b, spring.a, Tyre.damper.a),
        connect(spring.b, Tyre.damper.b, Tyre.upward),
        connect(Tyre.wheel, Tyre.contact.a, Tyre.rolling.shaft),
        connect(Tyre.contact.b, Tyre.slip.a),
        connect(Tyre.road_slope, road.slope),
        connect(Tyre.along.flow, Tyre.slip.speed),
        connect(spring.port.effort + Tyre.damper.port.effort, load.deviation),
        connect(load.load, Tyre.slip.load, Tyre.rolling.load, Tyre.normal_load),
        connect(Tyre.rolling_coefficient, Tyre.rolling.coefficient),
    )


class StandingAxle(Axle):
    """An axle that carries its share of the body, and its own weight."""

    suspension_load: Parameter = parameter("N", low=0.0, doc="on both springs, at rest")

    weight = Weight(mass=Axle.mass, gravity=Axle.gravity)
    spring = Spring(stiffness=Axle.suspension_stiffness, start_compression=suspension_load / Axle.suspension_stiffness)
    tyre = StandingTyre(static_load=Axle.static_load, radius=Axle.wheel_radius)

    connections = (
        connect(Axle.slide.point, Axle.forward_mass.flange, Axle.gyrator.a, Axle.frame.forward),
        connect(Axle.vertical_mass.flange, Axle.gyrator.b, Axle.frame.vertical, spring.a, Axle.shock_absorber.a),
        connect(spring.b, Axle.shock_absorber.b, Axle.mount.point),
        connect(Axle.body_forward, Axle.slide.base),
        connect(Axle.body_vertical, Axle.mount.base),
        connect(Axle.pitch, Axle.slide.rotation, Axle.mount.rotation),
        connect(
            Axle.cg_height - spring.port.displacement + suspension_load / Axle.suspension_stiffness, Axle.slide.arm
        ),
        connect(Axle.ahead, Axle.mount.arm),
        connect(Axle.pitch_rate, Axle.gyrator.pitch_rate),
        connect(Axle.sine_pitch, Axle.frame.sine),
        connect(Axle.cosine_pitch, Axle.frame.cosine),
        connect(Axle.frame.along, tyre.along),
        connect(Axle.frame.upward, weight.flange, tyre.upward),
        connect(Axle.road_slope, tyre.road_slope),
        connect(Axle.rolling_coefficient, tyre.rolling_coefficient),
        connect(tyre.normal_load, Axle.normal_load),
        connect(Axle.wheel.shaft, tyre.wheel),
        bond(Axle.wheel.shaft, Axle.against_body),
        bond(Axle.pitch, Axle.against_body),
        bond(Axle.against_body, Axle.brake.shaft),
        connect(Axle.prop_shaft, Axle.final_drive.a),
        connect(Axle.final_drive.b, Axle.brake.shaft),
        connect(Axle.brake_pedal, Axle.brake.pedal),
    )


class StandingChassis(Chassis):
    """The chassis in a world frame: velocities along and upwards, and a pitch angle that has the slope in it."""

    road = HillyRoad(
        front_ahead=Chassis.cg_position,
        rear_front_ahead=Chassis.cg_position - Chassis.rear_front_position,
        rear_rear_ahead=Chassis.cg_position - Chassis.rear_rear_position,
    )
    along_path = Projection()  # upwards
    weight = Weight(mass=Chassis.sprung_mass, gravity=Chassis.gravity)
    front_axle = StandingAxle(
        mass=Chassis.front_axle_mass,
        ahead=Chassis.cg_position,
        cg_height=Chassis.cg_height,
        gravity=Chassis.gravity,
        wheel_radius=Chassis.wheel_radius,
        final_drive_ratio=Chassis.final_drive_ratio,
        brake_torque=Chassis.brake_torque,
        static_load=Chassis.front_suspension_load + Chassis.front_axle_mass * Chassis.gravity,
        suspension_stiffness=Chassis.front_stiffness,
        suspension_damping=Chassis.front_damping,
        suspension_load=Chassis.front_suspension_load,
    )
    rear_front_axle = StandingAxle(
        mass=Chassis.rear_axle_mass,
        ahead=Chassis.cg_position - Chassis.rear_front_position,
        cg_height=Chassis.cg_height,
        gravity=Chassis.gravity,
        wheel_radius=Chassis.wheel_radius,
        final_drive_ratio=Chassis.final_drive_ratio,
        brake_torque=Chassis.brake_torque,
        static_load=Chassis.rear_suspension_load + Chassis.rear_axle_mass * Chassis.gravity,
        suspension_stiffness=Chassis.rear_stiffness,
        suspension_damping=Chassis.rear_damping,
        suspension_load=Chassis.rear_suspension_load,
    )
    rear_rear_axle = StandingAxle(
        mass=Chassis.rear_axle_mass,
        ahead=Chassis.cg_position - Chassis.rear_rear_position,
        cg_height=Chassis.cg_height,
        gravity=Chassis.gravity,
        wheel_radius=Chassis.wheel_radius,
        final_drive_ratio=Chassis.final_drive_ratio,
        brake_torque=Chassis.brake_torque,
        static_load=Chassis.rear_suspension_load + Chassis.rear_axle_mass * Chassis.gravity,
        suspension_stiffness=Chassis.rear_stiffness,
        suspension_damping=Chassis.rear_damping,
        suspension_load=Chassis.rear_suspension_load,
    )

    connections = (
        connect(
            Chassis.body.forward,
            Chassis.drag.flange,
            along_path.first,
            front_axle.body_forward,
            rear_front_axle.body_forward,
            rear_rear_axle.body_forward,
        ),
        connect(
            Chassis.body.vertical,
            along_path.second,
            front_axle.body_vertical,
            rear_front_axle.body_vertical,
            rear_rear_axle.body_vertical,
        ),
        connect(Chassis.body.pitch, front_axle.pitch, rear_front_axle.pitch, rear_rear_axle.pitch),
        connect(along_path.along, weight.flange),
        connect(front_axle.prop_shaft, Chassis.front_shaft),
        connect(rear_front_axle.prop_shaft, Chassis.rear_front_shaft),
        connect(rear_rear_axle.prop_shaft, Chassis.rear_rear_shaft),
        # Attitude.
        connect(
            Chassis.body.pitch.flow,
            Chassis.pitch_angle.speed,
            front_axle.pitch_rate,
            rear_front_axle.pitch_rate,
            rear_rear_axle.pitch_rate,
        ),
        connect(Chassis.pitch_angle.angle, Chassis.attitude.angle),
        connect(
            Chassis.attitude.cosine,
            along_path.second_share,
            front_axle.cosine_pitch,
            rear_front_axle.cosine_pitch,
            rear_rear_axle.cosine_pitch,
        ),
        connect(
            Chassis.attitude.sine,
            along_path.first_share,
            front_axle.sine_pitch,
            rear_front_axle.sine_pitch,
            rear_rear_axle.sine_pitch,
        ),
        # Place and road.
        connect(Chassis.body.forward.flow, Chassis.speed),
        connect(Chassis.body.forward_mass.flange.effort / Chassis.sprung_mass, Chassis.acceleration),
        connect(
            Chassis.attitude.cosine * Chassis.body.forward.flow - Chassis.attitude.sine * Chassis.body.vertical.flow,
            Chassis.odometer.velocity,
        ),
        connect(Chassis.odometer.position, road.position),
        connect(
            road.sine_slope,
            front_axle.sine_slope,
            rear_front_axle.sine_slope,
            rear_rear_axle.sine_slope,
            Chassis.sine_slope,
        ),
        connect(
            road.rolling_coefficient,
            front_axle.rolling_coefficient,
            rear_front_axle.rolling_coefficient,
            rear_rear_axle.rolling_coefficient,
            Chassis.rolling_coefficient,
        ),
        connect(road.front_slope, front_axle.road_slope),
        connect(road.rear_front_slope, rear_front_axle.road_slope),
        connect(road.rear_rear_slope, rear_rear_axle.road_slope),
        connect(Chassis.brake_pedal, front_axle.brake_pedal, rear_front_axle.brake_pedal, rear_rear_axle.brake_pedal),
    )


class HybridTruckInWorldFrame(HybridTruck):
    """The hybrid truck on a chassis that hills reach through the tyres."""

    chassis = StandingChassis(sprung_mass=HybridTruck.sprung_mass)
