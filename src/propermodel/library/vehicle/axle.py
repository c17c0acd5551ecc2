"""A driven axle on the pitch plane: a rigid body that slides on the vertical axis of the vehicle's body."""

from __future__ import annotations

from propermodel.expressions import Expr, tanh
from propermodel.library.mechanics.planar import EulerGyrator, PlanarFrame
from propermodel.library.mechanics.rotation import LossyGear, RotatingInertia, ViscousFriction
from propermodel.library.mechanics.translation import DegressiveDamper, Lever, Mass, Spring
from propermodel.library.vehicle.tyre import Tyre
from propermodel.modelling import (
    Component,
    EffortSource,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    Translation,
    ZeroJunction,
    bond,
    connect,
    parameter,
)


class Gravity(EffortSource):
    """Gravity along the path, -m g sin(slope)."""

    flange = Port(Translation)
    sine_slope = Input("1")
    mass: Parameter = parameter("kg", low=0.0)
    gravity: Parameter = parameter("m/s2", default=9.81)

    def effort(self) -> Expr:
        return self.mass * self.gravity * self.sine_slope


class BrakeLining(Resistance):
    """Dry friction in proportion to the pedal, T = b T_max tanh(omega / width)."""

    shaft = Port(Rotation)
    pedal = Input("1")
    torque: Parameter = parameter("N.m", low=0.0, doc="at full pedal")
    width: Parameter = parameter("rad/s", default=0.1, low=0.0, status="estimated")

    def effort(self, flow: Expr) -> Expr:
        return self.pedal * self.torque * tanh(flow / self.width)


class Brake(Component):
    """Coulomb friction of the linings and viscous drag of linings and bearings: one energy element."""

    energy_group = True

    shaft = Port(Rotation)
    pedal = Input("1")
    torque: Parameter = parameter("N.m", low=0.0, doc="Coulomb torque at full pedal")
    drag: Parameter = parameter(
        "N.m.s/rad", default=0.5, low=0.0, source="5 % of the rolling resistance torque", status="estimated"
    )

    lining = BrakeLining(torque=torque)
    viscous = ViscousFriction(damping=drag)

    connections = (
        connect(shaft, lining.shaft, viscous.shaft),
        connect(pedal, lining.pedal),
    )


class Axle(Component):
    """An axle with suspension, wheels, tyres, brakes and final drive; both sides lumped.

    Its forward speed is u + q (z_cg - s), with suspension compression s, and its mass also feels the turning frame.
    Brakes and final drive act between wheels and body, so they see the wheel speed against the body, omega + q.
    """

    body_forward = Port(Translation)
    body_vertical = Port(Translation)
    pitch = Port(Rotation)
    prop_shaft = Port(Rotation)
    sine_pitch = Input("1")
    cosine_pitch = Input("1")
    pitch_rate = Input("rad/s")
    sine_slope = Input("1")
    road_slope = Input("1")
    rolling_coefficient = Input("1")
    brake_pedal = Input("1")
    normal_load = Output("N")
    mass: Parameter = parameter("kg", low=0.0, doc="unsprung, with wheels")
    ahead: Parameter = parameter("m", doc="distance ahead of the centre of gravity of the sprung mass")
    cg_height: Parameter = parameter("m", doc="of the sprung mass above the wheel centres")
    static_load: Parameter = parameter("N", low=0.0, doc="on the ground")
    gravity: Parameter = parameter("m/s2", default=9.81)
    suspension_stiffness: Parameter = parameter("N/m", low=0.0)
    suspension_damping: Parameter = parameter("N.s/m", low=0.0, doc="slope at zero speed")
    degressivity_compression: Parameter = parameter(
        "s/m", default=3.0, low=0.0, source="Project Chrono MTV", status="published"
    )
    degressivity_rebound: Parameter = parameter(
        "s/m", default=1.0, low=0.0, source="Project Chrono MTV", status="published"
    )
    wheel_inertia: Parameter = parameter(
        "kg.m2", default=61.0, low=0.0, source="Project Chrono MTV, 2 x (29.5 + 0.6 + 0.4)", status="published"
    )
    wheel_radius: Parameter = parameter("m", low=0.0, doc="effective rolling radius")
    brake_torque: Parameter = parameter("N.m", low=0.0, doc="Coulomb torque at full pedal")
    final_drive_ratio: Parameter = parameter("1", low=0.0)
    final_drive_efficiency: Parameter = parameter("1", default=0.95, low=0.0, high=1.0, status="estimated")

    forward_mass = Mass(mass=mass)
    vertical_mass = Mass(mass=mass)
    gyrator = EulerGyrator(mass=mass)
    slide = Lever()
    mount = Lever()
    spring = Spring(stiffness=suspension_stiffness)
    shock_absorber = DegressiveDamper(
        damping=suspension_damping,
        degressivity_compression=degressivity_compression,
        degressivity_rebound=degressivity_rebound,
    )
    frame = PlanarFrame()
    weight = Gravity(mass=mass, gravity=gravity)
    wheel = RotatingInertia(inertia=wheel_inertia)
    tyre = Tyre(static_load=static_load, radius=wheel_radius)
    brake = Brake(torque=brake_torque)
    final_drive = LossyGear(ratio=final_drive_ratio, efficiency=final_drive_efficiency)
    against_body = ZeroJunction()

    connections = (
        # The axle's own motion in the frame of the body, and its ties to the body.
        connect(slide.point, forward_mass.flange, gyrator.a, frame.forward),
        connect(vertical_mass.flange, gyrator.b, frame.vertical, spring.a, shock_absorber.a),
        connect(spring.b, shock_absorber.b, mount.point),
        connect(body_forward, slide.base),
        connect(body_vertical, mount.base),
        connect(pitch, slide.rotation, mount.rotation),
        connect(cg_height - spring.port.displacement, slide.arm),
        connect(ahead, mount.arm),
        connect(pitch_rate, gyrator.pitch_rate),
        # The tyre acts along and across the path.
        connect(sine_pitch, frame.sine),
        connect(cosine_pitch, frame.cosine),
        connect(frame.along, weight.flange, tyre.along),
        connect(frame.upward, tyre.upward),
        connect(sine_slope, weight.sine_slope),
        connect(road_slope, tyre.road_slope),
        connect(rolling_coefficient, tyre.rolling_coefficient),
        connect(tyre.normal_load, normal_load),
        # Wheels, and what turns or holds them against the body.
        connect(wheel.shaft, tyre.wheel),
        bond(wheel.shaft, against_body),
        bond(pitch, against_body),
        bond(against_body, brake.shaft),
        connect(prop_shaft, final_drive.a),
        connect(final_drive.b, brake.shaft),
        connect(brake_pedal, brake.pedal),
    )
