"""Mechanisms in the plane: geometry without mass, and point masses to hang on it.

Angles count from the x axis towards the y axis. An output named `gap`, `gap_y` or `excess` is a closure: its
displacement is zero where the loop closes, so fix it. Hang masses on what they move: an inertia on each angle, a mass
on each point.
"""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.expressions import Expr, cos, sin, sqrt
from propermodel.library.mechanics.planar.ports import Point
from propermodel.library.mechanics.translation.components import Mass
from propermodel.library.mechanics.translation.sources import Fixed, Weight
from propermodel.modelling import (
    Component,
    KinematicTransformer,
    Parameter,
    Port,
    Rotation,
    Translation,
    connect,
    parameter,
)


class PointMass(Component):
    """A mass that moves in the plane under its weight, y upward."""

    point = Point()
    mass: Parameter = parameter("kg", low=0.0)

    along = Mass(mass=mass)
    upward = Mass(mass=mass)
    weight = Weight(mass=mass)

    connections = (connect(point.x, along.flange), connect(point.y, upward.flange, weight.flange))


class FixedPoint(Component):
    """A point that does not move."""

    point = Point()

    along = Fixed()
    upward = Fixed()

    connections = (connect(along.flange, point.x), connect(upward.flange, point.y))


class PinnedRod(KinematicTransformer):
    """A rod without mass between the origin and a point: how much farther than its length the point is."""

    point = Point()
    excess = Port(Translation)
    length: Parameter = parameter("m", low=0.0)
    start_angle: Parameter = parameter("rad", default=0.0)

    def positions(self) -> Mapping[Expr, Expr]:
        x, y = self.point.x.displacement, self.point.y.displacement
        return {self.excess.displacement: sqrt(x * x + y * y) - self.length}

    def starts(self) -> Mapping[Expr, Expr]:
        return {
            self.point.x.displacement: self.length * cos(self.start_angle),
            self.point.y.displacement: self.length * sin(self.start_angle),
        }


class Link(KinematicTransformer):
    """A rod without mass between two points: how much farther than its length they are from each other.

    The first point starts at the origin, the second at the length along the angle `start_angle`.
    """

    a = Point()
    b = Point()
    excess = Port(Translation)
    length: Parameter = parameter("m", low=0.0)
    start_x: Parameter = parameter("m", default=0.0)
    start_y: Parameter = parameter("m", default=0.0)
    start_angle: Parameter = parameter("rad", default=0.0)

    def positions(self) -> Mapping[Expr, Expr]:
        x = self.b.x.displacement - self.a.x.displacement
        y = self.b.y.displacement - self.a.y.displacement
        return {self.excess.displacement: sqrt(x * x + y * y) - self.length}

    def starts(self) -> Mapping[Expr, Expr]:
        return {
            self.a.x.displacement: self.start_x,
            self.a.y.displacement: self.start_y,
            self.b.x.displacement: self.start_x + self.length * cos(self.start_angle),
            self.b.y.displacement: self.start_y + self.length * sin(self.start_angle),
        }


class Arm(KinematicTransformer):
    """The end of a bar that turns about the origin."""

    angle = Port(Rotation)
    point = Point()
    length: Parameter = parameter("m", low=0.0)
    start_angle: Parameter = parameter("rad", default=0.0)

    def positions(self) -> Mapping[Expr, Expr]:
        angle = self.angle.displacement
        return {
            self.point.x.displacement: self.length * cos(angle),
            self.point.y.displacement: self.length * sin(angle),
        }

    def starts(self) -> Mapping[Expr, Expr]:
        return {self.angle.displacement: self.start_angle}


class SliderCrankLinkage(KinematicTransformer):
    """A crank and a connecting rod: the slider at the end of the rod moves along x, its guide holds `gap_y`."""

    crank = Port(Rotation)
    rod = Port(Rotation)
    slider = Port(Translation)
    gap_y = Port(Translation)
    radius: Parameter = parameter("m", low=0.0)
    length: Parameter = parameter("m", low=0.0)
    start_crank: Parameter = parameter("rad", default=0.0)
    start_rod: Parameter = parameter("rad", default=0.0, doc="a guess is enough: the closed loop decides")

    def positions(self) -> Mapping[Expr, Expr]:
        crank, rod = self.crank.displacement, self.rod.displacement
        return {
            self.slider.displacement: self.radius * cos(crank) + self.length * cos(rod),
            self.gap_y.displacement: self.radius * sin(crank) + self.length * sin(rod),
        }

    def starts(self) -> Mapping[Expr, Expr]:
        return {self.crank.displacement: self.start_crank, self.rod.displacement: self.start_rod}


class FourBarLinkage(KinematicTransformer):
    """Crank, coupler and rocker between two hinges on the x axis, `base` apart; fix the gap to close it."""

    crank = Port(Rotation)
    coupler = Port(Rotation)
    rocker = Port(Rotation)
    gap = Point()
    crank_length: Parameter = parameter("m", low=0.0)
    coupler_length: Parameter = parameter("m", low=0.0)
    rocker_length: Parameter = parameter("m", low=0.0)
    base: Parameter = parameter("m", low=0.0)
    start_crank: Parameter = parameter("rad", default=0.0)
    start_coupler: Parameter = parameter("rad", default=0.5, doc="a guess is enough: the closed loop decides")
    start_rocker: Parameter = parameter("rad", default=1.0, doc="a guess is enough: the closed loop decides")

    def positions(self) -> Mapping[Expr, Expr]:
        crank, coupler, rocker = self.crank.displacement, self.coupler.displacement, self.rocker.displacement
        a, b, c = self.crank_length, self.coupler_length, self.rocker_length
        return {
            self.gap.x.displacement: a * cos(crank) + b * cos(coupler) - c * cos(rocker) - self.base,
            self.gap.y.displacement: a * sin(crank) + b * sin(coupler) - c * sin(rocker),
        }

    def starts(self) -> Mapping[Expr, Expr]:
        return {
            self.crank.displacement: self.start_crank,
            self.coupler.displacement: self.start_coupler,
            self.rocker.displacement: self.start_rocker,
        }
