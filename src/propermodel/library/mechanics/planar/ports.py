"""Vector ports of planar mechanics: what moves in the plane has several bonds."""

from __future__ import annotations

from propermodel.modelling import Port, Translation, VectorPort


class Point(VectorPort):
    """A point that moves in x and y."""

    x = Port(Translation)
    y = Port(Translation)
