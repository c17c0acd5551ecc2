"""Faults in the wiring of vector ports."""

from __future__ import annotations

import propermodel as pm
from tests.faults.case import Case
from tests.parts import Fixed, Flywheel


class Point(pm.VectorPort):
    """A point that moves in x and y."""

    x = pm.Port(pm.Translation)
    y = pm.Port(pm.Translation)


class Frame(Point):
    """A point that turns, too."""

    angle = pm.Port(pm.Rotation)


class Pin(pm.Component):
    """A point that stands still."""

    point = Point()
    held = Fixed()

    connections = (pm.connect(held.flange, point.x, point.y),)


class Plate(pm.Component):
    """Something that turns about a pin."""

    frame = Frame()
    inertia = Flywheel(inertia=0.1)
    held = Fixed()

    connections = (pm.connect(frame.angle, inertia.shaft), pm.connect(held.flange, frame.x, frame.y))


class PlateOnPin(pm.Component):
    """A frame joined with a point."""

    pin = Pin()
    plate = Plate()

    connections = (pm.connect(pin.point, plate.frame),)


CASES = (
    Case(
        code="model/vector-port",
        run=lambda: pm.elaborate(PlateOnPin()),
        names=("pin.point", "plate.frame", "has x (translation), y (translation), angle (rotation)"),
        at="pm.connect(pin.point, plate.frame)",
        cure="name those that are meant",
    ),
)
