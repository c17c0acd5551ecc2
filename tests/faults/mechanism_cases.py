"""Faults in mechanisms: geometry that says too little, loops that cannot close, constraints that depend on others."""

from __future__ import annotations

from collections.abc import Mapping

import propermodel as pm
from propermodel.library.mechanics.planar import FixedPoint, FourBarLinkage, PinnedRod, PointMass
from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.library.mechanics.translation import Fixed, Mass
from tests.faults.case import Case


class Stuck(pm.KinematicTransformer):
    """A lever that forgets its input."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation)

    def positions(self) -> Mapping[pm.Expr, pm.Expr]:
        return {self.b.displacement: pm.quantity(1.0, "m")}


class LeverRig(pm.Component):
    """A mass on each side of it."""

    lever = Stuck()
    first = Mass(mass=1.0)
    second = Mass(mass=1.0)

    connections = (pm.connect(first.flange, lever.a), pm.connect(lever.b, second.flange))


class FarBase(pm.Component):
    """Bars that cannot reach from one hinge to the other."""

    crank = RotatingInertia(inertia=0.1)
    coupler = RotatingInertia(inertia=0.2)
    rocker = RotatingInertia(inertia=0.3)
    loop = FourBarLinkage(crank_length=0.2, coupler_length=0.5, rocker_length=0.4, base=3.0)
    hinges = FixedPoint()

    connections = (
        pm.connect(crank.shaft, loop.crank),
        pm.connect(coupler.shaft, loop.coupler),
        pm.connect(rocker.shaft, loop.rocker),
        pm.connect(hinges.point, loop.gap),
    )


class TwoRods(pm.Component):
    """A bob on two equal rods with the same hinge."""

    bob = PointMass(mass=2.0)
    rod = PinnedRod(length=1.0)
    other = PinnedRod(length=1.0)
    hinge = Fixed()

    connections = (
        pm.connect(bob.point, rod.point, other.point),
        pm.connect(rod.excess, other.excess, hinge.flange),
    )


def started(component: pm.Component) -> object:
    """A run of a mechanism."""
    return pm.simulate(pm.compile_model(pm.elaborate(component)), pm.Scenario(stop=0.1))


CASES = (
    Case(
        code="model/positions",
        run=lambda: pm.elaborate(LeverRig()),
        names=("Stuck", "'b'", "depends on no input"),
        at="def positions(self)",
        cure="in the displacements of the others",
    ),
    Case(
        code="simulation/open-loop",
        run=lambda: started(FarBase()),
        names=("loop.at_gap_x.held", "is open by -2"),
        at="loop = FourBarLinkage",
        cure="check the lengths",
    ),
    Case(
        code="simulation/singular-mechanism",
        run=lambda: started(TwoRods()),
        names=("rod.at_excess.held", "other.at_excess.held"),
        at="rod = PinnedRod",
        cure="stated twice",
    ),
)
