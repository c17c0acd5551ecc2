"""Joints between frames: they let frame `b` move against frame `a`, and give where it is.

A tree of joints from the ground outwards has the joints' own displacements as coordinates. Where a mechanism closes
back on itself, `ClosingRevolute` joins two frames that are both given; the force in it is found, not given by a law.
"""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.expressions import Expr, cos, sin
from propermodel.library.mechanics.planar.ports import Frame, Point
from propermodel.library.mechanics.rotation.sensors import NoTorque, RotationSensor
from propermodel.library.mechanics.translation.sensors import MotionSensor, NoForce, Odometer
from propermodel.library.mechanics.translation.sources import Fixed
from propermodel.modelling import (
    Component,
    Input,
    KinematicTransformer,
    Output,
    Parameter,
    Port,
    Rotation,
    Translation,
    ZeroJunction,
    bond,
    connect,
    parameter,
)


class FreeMotion(Component):
    """No joint at all: the frame moves as it likes, and this tells where it is."""

    b = Frame.giving()
    start_x: Parameter = parameter("m", default=0.0)
    start_y: Parameter = parameter("m", default=0.0)
    start_angle: Parameter = parameter("rad", default=0.0)

    along = MotionSensor(start=start_x)
    upward = MotionSensor(start=start_y)
    turning = RotationSensor(start=start_angle)

    connections = (
        connect(b.x, along.flange),
        connect(b.y, upward.flange),
        connect(b.angle, turning.shaft),
        connect(along.position, b.position_x),
        connect(upward.position, b.position_y),
        connect(turning.angle, b.orientation),
    )


class ActuatedRevolute(Component):
    """A hinge whose axis may be driven, sprung or braked: `axis` turns with frame `b` against frame `a`."""

    a = Frame()
    b = Frame.giving()
    axis = Port(Rotation)
    angle = Output("rad")
    speed = Output("rad/s")
    start_angle: Parameter = parameter("rad", default=0.0)

    total = ZeroJunction()
    motion = RotationSensor(start=start_angle)

    connections = (
        connect(a.x, b.x),
        connect(a.y, b.y),
        connect(axis, motion.shaft),
        bond(a.angle, total),
        bond(axis, total),
        bond(total, b.angle),
        connect(motion.angle, angle),
        connect(motion.speed, speed),
        connect(a.position_x, b.position_x),
        connect(a.position_y, b.position_y),
        connect(a.orientation + motion.angle, b.orientation),
    )


class Revolute(Component):
    """A hinge without torque: frame `b` turns against frame `a`."""

    a = Frame()
    b = Frame.giving()
    angle = Output("rad")
    speed = Output("rad/s")
    start_angle: Parameter = parameter("rad", default=0.0)

    joint = ActuatedRevolute(start_angle=start_angle)
    end = NoTorque()

    connections = (
        connect(a, joint.a),
        connect(joint.b, b),
        connect(joint.axis, end.shaft),
        connect(joint.angle, angle),
        connect(joint.speed, speed),
    )


class Slide(KinematicTransformer):
    """How far point `b` is from point `a`, along a direction and across it; the direction turns with `angle`."""

    a = Point()
    angle = Port(Rotation)
    b = Point()
    along = Port(Translation)
    gap = Port(Translation)
    x_a = Input("m")
    y_a = Input("m")
    orientation = Input("rad")
    x_b = Input("m")
    y_b = Input("m")
    direction: Parameter = parameter("rad", default=0.0)

    def known(self) -> Mapping[Expr, Expr]:
        return {
            self.a.x.displacement: self.x_a,
            self.a.y.displacement: self.y_a,
            self.angle.displacement: self.orientation,
            self.b.x.displacement: self.x_b,
            self.b.y.displacement: self.y_b,
        }

    def positions(self) -> Mapping[Expr, Expr]:
        x = self.b.x.displacement - self.a.x.displacement
        y = self.b.y.displacement - self.a.y.displacement
        angle = self.angle.displacement + self.direction
        return {
            self.along.displacement: cos(angle) * x + sin(angle) * y,
            self.gap.displacement: cos(angle) * y - sin(angle) * x,
        }


class ActuatedPrismatic(Component):
    """A slide whose axis may be driven, sprung or braked: `axis` moves with frame `b` against frame `a`.

    The direction is fixed in frame `a`. Its guide is a closure: the force across it is found, so that no position of
    the slide is singular. `start_orientation` is that of frame `a`; the start is a guess, as of every closed loop.
    """

    a = Frame()
    b = Frame.giving()
    axis = Port(Translation)
    position = Output("m")
    direction: Parameter = parameter("rad", default=0.0, doc="in frame a, from its x axis")
    start_position: Parameter = parameter("m", default=0.0)
    start_orientation: Parameter = parameter("rad", default=0.0)

    slide = Slide(direction=direction)
    guide = Fixed()
    from_a_x = Odometer(start=start_position * cos(direction + start_orientation))
    from_a_y = Odometer(start=start_position * sin(direction + start_orientation))

    connections = (
        connect(a.x, slide.a.x),
        connect(a.y, slide.a.y),
        connect(b.x, slide.b.x),
        connect(b.y, slide.b.y),
        connect(a.angle, b.angle, slide.angle),
        connect(slide.along, axis),
        connect(slide.gap, guide.flange),
        connect(slide.b.x.flow - slide.a.x.flow, from_a_x.velocity),
        connect(slide.b.y.flow - slide.a.y.flow, from_a_y.velocity),
        connect(a.position_x, slide.x_a),
        connect(a.position_y, slide.y_a),
        connect(a.orientation, slide.orientation, b.orientation),
        connect(a.position_x + from_a_x.position, slide.x_b, b.position_x),
        connect(a.position_y + from_a_y.position, slide.y_b, b.position_y),
        connect(
            cos(a.orientation + direction) * from_a_x.position + sin(a.orientation + direction) * from_a_y.position,
            position,
        ),
    )


class Prismatic(Component):
    """A slide without friction: frame `b` moves against frame `a` along a direction that is fixed in `a`."""

    a = Frame()
    b = Frame.giving()
    position = Output("m")
    direction: Parameter = parameter("rad", default=0.0, doc="in frame a, from its x axis")
    start_position: Parameter = parameter("m", default=0.0)
    start_orientation: Parameter = parameter("rad", default=0.0)

    joint = ActuatedPrismatic(direction=direction, start_position=start_position, start_orientation=start_orientation)
    end = NoForce()

    connections = (
        connect(a, joint.a),
        connect(joint.b, b),
        connect(joint.axis, end.flange),
        connect(joint.position, position),
    )


class PointGap(KinematicTransformer):
    """How far point `b` is from point `a`, in x and y."""

    a = Point()
    b = Point()
    gap = Point()
    x_a = Input("m")
    y_a = Input("m")
    x_b = Input("m")
    y_b = Input("m")

    def known(self) -> Mapping[Expr, Expr]:
        return {
            self.a.x.displacement: self.x_a,
            self.a.y.displacement: self.y_a,
            self.b.x.displacement: self.x_b,
            self.b.y.displacement: self.y_b,
        }

    def positions(self) -> Mapping[Expr, Expr]:
        return {
            self.gap.x.displacement: self.b.x.displacement - self.a.x.displacement,
            self.gap.y.displacement: self.b.y.displacement - self.a.y.displacement,
        }


class ClosingRevolute(Component):
    """A hinge without torque that closes a loop: it takes the positions of both its frames."""

    a = Frame()
    b = Frame()

    between = PointGap()
    along = Fixed()
    upward = Fixed()
    end_a = NoTorque()
    end_b = NoTorque()

    connections = (
        connect(a.x, between.a.x),
        connect(a.y, between.a.y),
        connect(b.x, between.b.x),
        connect(b.y, between.b.y),
        connect(a.angle, end_a.shaft),
        connect(b.angle, end_b.shaft),
        connect(along.flange, between.gap.x),
        connect(upward.flange, between.gap.y),
        connect(a.position_x, between.x_a),
        connect(a.position_y, between.y_a),
        connect(b.position_x, between.x_b),
        connect(b.position_y, between.y_b),
    )
