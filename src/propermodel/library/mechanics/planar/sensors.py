"""Sensors of frames; they take no power."""

from __future__ import annotations

from propermodel.library.mechanics.planar.ports import Frame
from propermodel.library.mechanics.rotation.sensors import NoTorque
from propermodel.library.mechanics.translation.sensors import NoForce
from propermodel.modelling import Component, Output, connect


class FrameSensor(Component):
    """Position and velocity of a frame as seen from the ground."""

    frame = Frame()
    x = Output("m")
    y = Output("m")
    angle = Output("rad")
    velocity_x = Output("m/s")
    velocity_y = Output("m/s")
    angular_velocity = Output("rad/s")

    along = NoForce()
    upward = NoForce()
    turning = NoTorque()

    connections = (
        connect(frame.x, along.flange),
        connect(frame.y, upward.flange),
        connect(frame.angle, turning.shaft),
        connect(frame.position_x, x),
        connect(frame.position_y, y),
        connect(frame.orientation, angle),
        connect(along.flange.flow, velocity_x),
        connect(upward.flange.flow, velocity_y),
        connect(turning.shaft.flow, angular_velocity),
    )
