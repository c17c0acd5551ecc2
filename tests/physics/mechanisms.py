"""Mechanisms that close kinematic loops, built from masses and geometry."""

from __future__ import annotations

import propermodel as pm
from propermodel.library.mechanics.translation import Fixed, Mass, Weight

GRAVITY = 9.80665


class Distance(pm.KinematicTransformer):
    """How much farther than its length a point is from the origin."""

    x = pm.Port(pm.Translation)
    y = pm.Port(pm.Translation)
    excess = pm.Port(pm.Translation)
    length: pm.Parameter = pm.parameter("m", default=1.0, low=0.0)

    def positions(self) -> dict[pm.Expr, pm.Expr]:
        x, y = self.x.displacement, self.y.displacement
        return {self.excess.displacement: pm.sqrt(x * x + y * y) - self.length}

    def starts(self) -> dict[pm.Expr, pm.Expr]:
        return {self.x.displacement: self.length}


class CartesianPendulum(pm.Component):
    """A point mass that moves in x and y, held at its distance from the origin."""

    mass: pm.Parameter = pm.parameter("kg", default=2.0)
    length: pm.Parameter = pm.parameter("m", default=1.0)

    along = Mass(mass=mass)
    upward = Mass(mass=mass)
    weight = Weight(mass=mass)
    rod = Distance(length=length)
    hinge = Fixed()

    connections = (
        pm.connect(along.flange, rod.x),
        pm.connect(upward.flange, weight.flange, rod.y),
        pm.connect(rod.excess, hinge.flange),
    )
