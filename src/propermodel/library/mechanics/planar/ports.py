"""Vector ports of planar mechanics: what moves in the plane has several bonds."""

from __future__ import annotations

from propermodel.modelling import Input, Port, Rotation, Translation, VectorPort


class Point(VectorPort):
    """A point that moves in x and y."""

    x = Port(Translation)
    y = Port(Translation)


class Frame(VectorPort):
    """A point of a rigid body: its bonds in x, y and angle, and where it is.

    Efforts are forces along x and y of the ground and a torque. Positions go outwards from the ground: a fixed frame, a
    joint and a bar give the position of their frame `b`, and whatever is joined with it takes it.
    """

    x = Port(Translation)
    y = Port(Translation)
    angle = Port(Rotation)
    position_x = Input("m")
    position_y = Input("m")
    orientation = Input("rad")
