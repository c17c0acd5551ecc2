"""What holds or pushes a frame from outside."""

from __future__ import annotations

from propermodel.library.mechanics.planar.ports import Frame
from propermodel.library.mechanics.rotation.sources import FixedShaft, TorqueSource
from propermodel.library.mechanics.translation.sources import Fixed, ForceSource
from propermodel.modelling import Component, Input, Parameter, connect, parameter


class FixedFrame(Component):
    """A frame that does not move: the ground."""

    frame = Frame.giving()
    x: Parameter = parameter("m", default=0.0)
    y: Parameter = parameter("m", default=0.0)
    angle: Parameter = parameter("rad", default=0.0)

    along = Fixed()
    upward = Fixed()
    turning = FixedShaft()

    connections = (
        connect(along.flange, frame.x),
        connect(upward.flange, frame.y),
        connect(turning.shaft, frame.angle),
        connect(x, frame.position_x),
        connect(y, frame.position_y),
        connect(angle, frame.orientation),
    )


class FrameForce(Component):
    """A force, in directions of the ground, and a torque on whatever is connected."""

    frame = Frame()
    force_x = Input("N")
    force_y = Input("N")
    torque = Input("N.m")

    along = ForceSource()
    upward = ForceSource()
    turning = TorqueSource()

    connections = (
        connect(frame.x, along.flange),
        connect(frame.y, upward.flange),
        connect(frame.angle, turning.shaft),
        connect(force_x, along.force),
        connect(force_y, upward.force),
        connect(torque, turning.torque),
    )
