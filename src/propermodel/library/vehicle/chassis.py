"""Body, three axles and road of a 6x6 truck of the FMTV family, on the pitch plane."""

from __future__ import annotations

from propermodel.library.mechanics.planar import PlanarBody, Sines
from propermodel.library.mechanics.rotation.sensors import AngleCounter
from propermodel.library.mechanics.translation import Projection, QuadraticDrag
from propermodel.library.mechanics.translation.sensors import Odometer
from propermodel.library.vehicle.axle import Axle, Gravity
from propermodel.library.vehicle.road import Road
from propermodel.modelling import Component, Input, Output, Parameter, Port, Rotation, connect, parameter

LEAF_SPRINGS = "Project Chrono MTV leaf spring axles"


class Chassis(Component):
    """A loaded M1083: sprung body with three degrees of freedom on three axles.

    Longitudinal positions are behind the front axle, heights above the wheel centres. Velocities are those of the
    body's own frame; gravity and tyres act along and across the path, so the pitch angle turns them into it.
    """

    front_shaft = Port(Rotation)
    rear_front_shaft = Port(Rotation)
    rear_rear_shaft = Port(Rotation)
    brake_pedal = Input("1")
    speed = Output("m/s")
    acceleration = Output("m/s2")
    sine_slope = Output("1")
    rolling_coefficient = Output("1")
    sprung_mass: Parameter = parameter("kg", default=11300.0, low=0.0, source="total less axles", status="derived")
    front_axle_mass: Parameter = parameter("kg", default=1000.0, low=0.0, source="Project Chrono MTV", status="derived")
    rear_axle_mass: Parameter = parameter("kg", default=1100.0, low=0.0, source="Project Chrono MTV", status="derived")
    pitch_inertia: Parameter = parameter(
        "kg.m2", default=39000.0, low=0.0, source="Project Chrono MTV with a payload block", status="derived"
    )
    cg_position: Parameter = parameter("m", default=2.75, source="Project Chrono MTV with payload", status="derived")
    cg_height: Parameter = parameter("m", default=0.99, source="Project Chrono MTV with payload", status="derived")
    rear_front_position: Parameter = parameter("m", default=3.40, source="Project Chrono MTV", status="published")
    rear_rear_position: Parameter = parameter("m", default=4.80, source="Project Chrono MTV", status="published")
    gravity: Parameter = parameter("m/s2", default=9.81)
    drag_area: Parameter = parameter(
        "m2", default=5.0, low=0.0, source="2.438 m x 2.83 m less ground gap, C_d about 0.8", status="estimated"
    )
    air_density: Parameter = parameter("kg/m3", default=1.20, low=0.0, status="estimated")
    wheel_radius: Parameter = parameter(
        "m", default=0.580, low=0.0, source="R_0 - deflection / 3; in speed and torque", status="derived"
    )
    final_drive_ratio: Parameter = parameter(
        "1", default=7.8, low=0.0, source="bevel 3.9 (Chrono 7.81), hub reduction 2.0", status="published"
    )
    brake_torque: Parameter = parameter(
        "N.m", default=15000.0, low=0.0, source="Project Chrono MTV, 2 x 7500", status="published"
    )
    front_stiffness: Parameter = parameter("N/m", default=2.053e5, low=0.0, source=LEAF_SPRINGS, status="published")
    rear_stiffness: Parameter = parameter("N/m", default=7.340e5, low=0.0, source=LEAF_SPRINGS, status="published")
    front_damping: Parameter = parameter(
        "N.s/m", default=3.4e4, low=0.0, source=LEAF_SPRINGS + ", to 0.6 of critical", status="derived"
    )
    rear_damping: Parameter = parameter(
        "N.s/m", default=4.0e4, low=0.0, source=LEAF_SPRINGS + ", to 0.4 of critical", status="derived"
    )
    # Moment balance about the front axle, the load of the bogie shared equally.
    rear_suspension_load: Parameter = parameter(
        "N", default=sprung_mass * gravity * cg_position / (rear_front_position + rear_rear_position), status="derived"
    )
    front_suspension_load: Parameter = parameter(
        "N", default=sprung_mass * gravity - 2.0 * rear_suspension_load, status="derived"
    )

    road = Road(
        front_ahead=cg_position,
        rear_front_ahead=cg_position - rear_front_position,
        rear_rear_ahead=cg_position - rear_rear_position,
    )
    body = PlanarBody(mass=sprung_mass, pitch_inertia=pitch_inertia)
    drag = QuadraticDrag(drag_area=drag_area, air_density=air_density)
    along_path = Projection()
    weight = Gravity(mass=sprung_mass, gravity=gravity)
    pitch_angle = AngleCounter()
    attitude = Sines()
    odometer = Odometer()
    front_axle = Axle(
        mass=front_axle_mass,
        ahead=cg_position,
        cg_height=cg_height,
        gravity=gravity,
        wheel_radius=wheel_radius,
        final_drive_ratio=final_drive_ratio,
        brake_torque=brake_torque,
        static_load=front_suspension_load + front_axle_mass * gravity,
        suspension_stiffness=front_stiffness,
        suspension_damping=front_damping,
    )
    rear_front_axle = Axle(
        mass=rear_axle_mass,
        ahead=cg_position - rear_front_position,
        cg_height=cg_height,
        gravity=gravity,
        wheel_radius=wheel_radius,
        final_drive_ratio=final_drive_ratio,
        brake_torque=brake_torque,
        static_load=rear_suspension_load + rear_axle_mass * gravity,
        suspension_stiffness=rear_stiffness,
        suspension_damping=rear_damping,
    )
    rear_rear_axle = Axle(
        mass=rear_axle_mass,
        ahead=cg_position - rear_rear_position,
        cg_height=cg_height,
        gravity=gravity,
        wheel_radius=wheel_radius,
        final_drive_ratio=final_drive_ratio,
        brake_torque=brake_torque,
        static_load=rear_suspension_load + rear_axle_mass * gravity,
        suspension_stiffness=rear_stiffness,
        suspension_damping=rear_damping,
    )

    connections = (
        connect(
            body.forward,
            drag.flange,
            along_path.first,
            front_axle.body_forward,
            rear_front_axle.body_forward,
            rear_rear_axle.body_forward,
        ),
        connect(
            body.vertical,
            along_path.second,
            front_axle.body_vertical,
            rear_front_axle.body_vertical,
            rear_rear_axle.body_vertical,
        ),
        connect(body.pitch, front_axle.pitch, rear_front_axle.pitch, rear_rear_axle.pitch),
        connect(along_path.along, weight.flange),
        connect(front_axle.prop_shaft, front_shaft),
        connect(rear_front_axle.prop_shaft, rear_front_shaft),
        connect(rear_rear_axle.prop_shaft, rear_rear_shaft),
        # Attitude.
        connect(
            body.pitch.flow,
            pitch_angle.speed,
            front_axle.pitch_rate,
            rear_front_axle.pitch_rate,
            rear_rear_axle.pitch_rate,
        ),
        connect(pitch_angle.angle, attitude.angle),
        connect(
            attitude.cosine,
            along_path.first_share,
            front_axle.cosine_pitch,
            rear_front_axle.cosine_pitch,
            rear_rear_axle.cosine_pitch,
        ),
        connect(-attitude.sine, along_path.second_share),
        connect(attitude.sine, front_axle.sine_pitch, rear_front_axle.sine_pitch, rear_rear_axle.sine_pitch),
        # Place and road.
        connect(body.forward.flow, speed),
        connect(body.forward_mass.flange.effort / sprung_mass, acceleration),
        connect(weight.flange.flow, odometer.velocity),
        connect(odometer.position, road.position),
        connect(
            road.sine_slope,
            weight.sine_slope,
            front_axle.sine_slope,
            rear_front_axle.sine_slope,
            rear_rear_axle.sine_slope,
            sine_slope,
        ),
        connect(
            road.rolling_coefficient,
            front_axle.rolling_coefficient,
            rear_front_axle.rolling_coefficient,
            rear_rear_axle.rolling_coefficient,
            rolling_coefficient,
        ),
        connect(road.front_slope, front_axle.road_slope),
        connect(road.rear_front_slope, rear_front_axle.road_slope),
        connect(road.rear_rear_slope, rear_rear_axle.road_slope),
        connect(brake_pedal, front_axle.brake_pedal, rear_front_axle.brake_pedal, rear_rear_axle.brake_pedal),
    )
