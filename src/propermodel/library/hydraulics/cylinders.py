"""Pistons, cylinders and constant pumps: where pressure becomes force and torque."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.library.hydraulics.components import OilChamber
from propermodel.modelling import (
    Component,
    Hydraulic,
    Parameter,
    Port,
    Rotation,
    Transformer,
    Translation,
    connect,
    parameter,
)


class Piston(Transformer):
    """A piston that moves into its oil: F = A p, Q = A v, the oil leaves at `b`."""

    a = Port(Translation)
    b = Port(Hydraulic)
    area: Parameter = parameter("m2", low=0.0)

    def modulus(self) -> Expr:
        return self.area


class Plunger(Transformer):
    """A piston that oil pushes out: the oil enters at `a`, Q = A v, F = A p."""

    a = Port(Hydraulic)
    b = Port(Translation)
    area: Parameter = parameter("m2", low=0.0)

    def modulus(self) -> ExprLike:
        return 1.0 / self.area


class Cylinder(Component):
    """A double-acting cylinder: oil at `head` drives the rod out, in the positive direction.

    The oil of either side is compressed as at the middle of the stroke (Merritt, ch. 6).
    """

    head = Port(Hydraulic)
    rod_side = Port(Hydraulic)
    rod = Port(Translation)
    head_area: Parameter = parameter("m2", low=0.0)
    rod_side_area: Parameter = parameter("m2", low=0.0, doc="the ring around the rod")
    head_volume: Parameter = parameter("m3", low=0.0)
    rod_side_volume: Parameter = parameter("m3", low=0.0)
    bulk_modulus: Parameter = parameter("Pa", default=1.7e9, low=0.0)

    head_oil = OilChamber(volume=head_volume, bulk_modulus=bulk_modulus)
    rod_side_oil = OilChamber(volume=rod_side_volume, bulk_modulus=bulk_modulus)
    pushing = Plunger(area=head_area)
    pushed = Piston(area=rod_side_area)

    connections = (
        connect(head, head_oil.port, pushing.a),
        connect(pushing.b, rod, pushed.a),
        connect(pushed.b, rod_side_oil.port, rod_side),
    )


class FixedPump(Transformer):
    """An ideal pump or motor of constant displacement between a shaft and a line: Q = D w, T = D p."""

    a = Port(Rotation)
    b = Port(Hydraulic)
    displacement: Parameter = parameter("m3/rad", low=0.0)

    def modulus(self) -> Expr:
        return self.displacement
