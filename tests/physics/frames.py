"""Mechanisms built of bodies, bars and joints with frames."""

from __future__ import annotations

import propermodel as pm
from propermodel.library.mechanics.planar import (
    ActuatedPrismatic,
    ActuatedRevolute,
    Body,
    ClosingRevolute,
    FixedFrame,
    FixedTranslation,
    FrameForce,
    FrameSensor,
    FreeMotion,
    LineSpringDamper,
    Prismatic,
    Revolute,
)
from propermodel.library.mechanics.rotation import TorqueSource
from propermodel.library.mechanics.translation import Damper, Fixed, Spring


class Pendulum(pm.Component):
    """A body at the end of a bar."""

    ground = FixedFrame(x=1.0, y=2.0)
    hinge = Revolute()
    bar = FixedTranslation(x=0.8)
    bob = Body(mass=2.0, rotational_inertia=0.1)
    sensor = FrameSensor()

    connections = (
        pm.connect(ground.frame, hinge.a),
        pm.connect(hinge.b, bar.a),
        pm.connect(bar.b, bob.frame, sensor.frame),
    )


class DoublePendulum(pm.Component):
    """A second bar hinged to the end of the first."""

    ground = FixedFrame()
    upper_hinge = Revolute(start_angle=0.5)
    upper_bar = FixedTranslation(x=0.8)
    upper = Body(mass=2.0, rotational_inertia=0.1)
    lower_hinge = Revolute(start_angle=-0.7)
    lower_bar = FixedTranslation(x=0.6)
    lower = Body(mass=1.0, rotational_inertia=0.05)

    connections = (
        pm.connect(ground.frame, upper_hinge.a),
        pm.connect(upper_hinge.b, upper_bar.a),
        pm.connect(upper_bar.b, upper.frame, lower_hinge.a),
        pm.connect(lower_hinge.b, lower_bar.a),
        pm.connect(lower_bar.b, lower.frame),
    )


class DoublePendulumFromBelow(pm.Component):
    """The same, declared and wired from its free end."""

    lower = Body(mass=1.0, rotational_inertia=0.05)
    lower_bar = FixedTranslation(x=0.6)
    lower_hinge = Revolute(start_angle=-0.7)
    upper = Body(mass=2.0, rotational_inertia=0.1)
    upper_bar = FixedTranslation(x=0.8)
    upper_hinge = Revolute(start_angle=0.5)
    ground = FixedFrame()

    connections = (
        pm.connect(lower.frame, lower_bar.b),
        pm.connect(lower_bar.a, lower_hinge.b),
        pm.connect(lower_hinge.a, upper.frame, upper_bar.b),
        pm.connect(upper_bar.a, upper_hinge.b),
        pm.connect(upper_hinge.a, ground.frame),
    )


class PendulumOnCart(pm.Component):
    """A pendulum on a cart that slides along a slope."""

    slope: pm.Parameter = pm.parameter("rad", default=0.4)

    ground = FixedFrame()
    slide = Prismatic(direction=slope, start_position=0.3)
    cart = Body(mass=3.0, rotational_inertia=1.0)
    hinge = Revolute(start_angle=-1.0)
    bar = FixedTranslation(x=0.8)
    bob = Body(mass=2.0, rotational_inertia=0.1)

    connections = (
        pm.connect(ground.frame, slide.a),
        pm.connect(slide.b, cart.frame, hinge.a),
        pm.connect(hinge.b, bar.a),
        pm.connect(bar.b, bob.frame),
    )


class Slider(pm.Component):
    """A body that slides down a slope."""

    slope: pm.Parameter = pm.parameter("rad", default=0.5)

    ground = FixedFrame()
    slide = Prismatic(direction=slope)
    body = Body(mass=3.0, rotational_inertia=1.0)

    connections = (pm.connect(ground.frame, slide.a), pm.connect(slide.b, body.frame))


class BeadInTube(pm.Component):
    """A bead slides in a tube that turns freely; a spring and a damper hold it."""

    stiffness: pm.Parameter = pm.parameter("N/m", default=0.0)
    damping: pm.Parameter = pm.parameter("N.s/m", default=0.0)

    ground = FixedFrame()
    hinge = Revolute(start_angle=0.3)
    tube = Body(mass=1.0, rotational_inertia=0.1, gravity=0.0)
    slide = ActuatedPrismatic(start_position=0.2, start_orientation=0.3)
    bead = Body(mass=0.5, rotational_inertia=0.01, gravity=0.0)
    spring = Spring(stiffness=stiffness)
    damper = Damper(damping=damping)
    end = Fixed()

    connections = (
        pm.connect(ground.frame, hinge.a),
        pm.connect(hinge.b, tube.frame, slide.a),
        pm.connect(slide.b, bead.frame),
        pm.connect(slide.axis, spring.a, damper.a),
        pm.connect(spring.b, damper.b, end.flange),
    )


class FourBar(pm.Component):
    """Crank, coupler and rocker with masses at their ends, closed by a hinge."""

    ground = FixedFrame()
    crank_hinge = Revolute(start_angle=1.0)
    crank = FixedTranslation(x=0.2)
    crank_body = Body(mass=1.0, rotational_inertia=0.1)
    coupler_hinge = Revolute(start_angle=-0.5)
    coupler = FixedTranslation(x=0.5)
    coupler_body = Body(mass=0.5, rotational_inertia=0.2)
    base = FixedFrame(x=0.5)
    rocker_hinge = Revolute(start_angle=1.4)
    rocker = FixedTranslation(x=0.4)
    rocker_body = Body(mass=0.7, rotational_inertia=0.3)
    pin = ClosingRevolute()

    connections = (
        pm.connect(ground.frame, crank_hinge.a),
        pm.connect(crank_hinge.b, crank.a),
        pm.connect(crank.b, crank_body.frame, coupler_hinge.a),
        pm.connect(coupler_hinge.b, coupler.a, coupler_body.frame),
        pm.connect(coupler.b, pin.a),
        pm.connect(base.frame, rocker_hinge.a),
        pm.connect(rocker_hinge.b, rocker.a, rocker_body.frame),
        pm.connect(rocker.b, pin.b),
    )


class ThrownBody(pm.Component):
    """A body in the air; a sensor follows a point of it."""

    motion = FreeMotion(start_x=1.0, start_y=2.0, start_angle=0.5)
    body = Body(
        mass=2.0, rotational_inertia=0.3, start_velocity_x=3.0, start_velocity_y=4.0, start_angular_velocity=5.0
    )
    arm = FixedTranslation(x=0.2, y=0.1)
    sensor = FrameSensor()

    connections = (pm.connect(motion.b, body.frame, arm.a), pm.connect(arm.b, sensor.frame))


class PushedBody(pm.Component):
    """A body without weight, pushed and turned at a point beside its centre of gravity."""

    force_x = pm.Input("N")
    force_y = pm.Input("N")
    torque = pm.Input("N.m")

    motion = FreeMotion()
    body = Body(mass=2.0, rotational_inertia=0.3, gravity=0.0)
    arm = FixedTranslation(x=0.2, y=0.1)
    push = FrameForce()

    connections = (
        pm.connect(motion.b, body.frame, arm.a),
        pm.connect(arm.b, push.frame),
        pm.connect(force_x, push.force_x),
        pm.connect(force_y, push.force_y),
        pm.connect(torque, push.torque),
    )


class Satellite(pm.Component):
    """Two bodies without weight turn against each other about a motor between their centres."""

    torque = pm.Input("N.m")

    motion = FreeMotion()
    body = Body(mass=2.0, rotational_inertia=0.3, gravity=0.0)
    hinge = ActuatedRevolute()
    wheel = Body(mass=1.0, rotational_inertia=0.1, gravity=0.0)
    motor = TorqueSource()

    connections = (
        pm.connect(motion.b, body.frame, hinge.a),
        pm.connect(hinge.b, wheel.frame),
        pm.connect(hinge.axis, motor.shaft),
        pm.connect(torque, motor.torque),
    )


class ElasticPendulum(pm.Component):
    """A body on a spring from a fixed point; it does not turn with the spring."""

    damping: pm.Parameter = pm.parameter("N.s/m", default=0.0)

    ground = FixedFrame(x=0.5, y=2.0)
    rope = LineSpringDamper(stiffness=80.0, length=1.0, damping=damping)
    motion = FreeMotion(start_x=1.7, start_y=1.6)
    bob = Body(mass=2.0, rotational_inertia=0.1)

    connections = (
        pm.connect(ground.frame, rope.a),
        pm.connect(motion.b, rope.b, bob.frame),
    )


class LoopOnSpring(pm.Component):
    """Three bars in a loop, and a spring across it, which starts stretched as the loop closes."""

    ground = FixedFrame()
    first_hinge = Revolute(start_angle=0.8)
    first = FixedTranslation(x=1.0)
    first_body = Body(mass=1.0, rotational_inertia=0.1)
    base = FixedFrame(x=1.2)
    second_hinge = Revolute(start_angle=2.2)
    second = FixedTranslation(x=1.0)
    second_body = Body(mass=1.0, rotational_inertia=0.1)
    middle_hinge = Revolute(start_angle=-0.7)
    middle = FixedTranslation(x=0.3)
    middle_body = Body(mass=1.0, rotational_inertia=0.1)
    pin = ClosingRevolute()
    spring = LineSpringDamper(stiffness=30.0, length=0.2)

    connections = (
        pm.connect(ground.frame, first_hinge.a, spring.a),
        pm.connect(first_hinge.b, first.a),
        pm.connect(first.b, first_body.frame, middle_hinge.a),
        pm.connect(middle_hinge.b, middle.a),
        pm.connect(middle.b, middle_body.frame, pin.a),
        pm.connect(base.frame, second_hinge.a),
        pm.connect(second_hinge.b, second.a),
        pm.connect(second.b, second_body.frame, pin.b, spring.b),
    )
