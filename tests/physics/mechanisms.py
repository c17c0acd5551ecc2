"""Mechanisms that close kinematic loops, built from masses and geometry."""

from __future__ import annotations

import propermodel as pm
from propermodel.library.mechanics.planar import (
    FixedPoint,
    FourBarLinkage,
    Link,
    PinnedRod,
    PointMass,
    SliderCrankLinkage,
)
from propermodel.library.mechanics.rotation import RotatingInertia, TorqueSource, ViscousFriction
from propermodel.library.mechanics.translation import Fixed, Mass, MotionSensor, Spring

GRAVITY = 9.80665


class CartesianPendulum(pm.Component):
    """A point mass that moves in x and y, held at its distance from the origin."""

    mass: pm.Parameter = pm.parameter("kg", default=2.0)
    length: pm.Parameter = pm.parameter("m", default=1.0)

    bob = PointMass(mass=mass)
    rod = PinnedRod(length=length)
    hinge = Fixed()

    connections = (pm.connect(bob.point, rod.point), pm.connect(rod.excess, hinge.flange))


class DoublePendulum(pm.Component):
    """A second bob on a rod that hangs on the first."""

    upper = PointMass(mass=2.0)
    lower = PointMass(mass=1.0)
    first = PinnedRod(length=1.0)
    second = Link(length=0.5, start_x=1.0, start_angle=0.5)
    hinge = Fixed()

    connections = (
        pm.connect(upper.point, first.point, second.a),
        pm.connect(lower.point, second.b),
        pm.connect(hinge.flange, first.excess, second.excess),
    )


class SliderCrank(pm.Component):
    """A crank with a flywheel, a rod that turns, and a piston."""

    torque = pm.Input("N.m")

    motor = TorqueSource()
    wheel = RotatingInertia(inertia=0.02)
    rod = RotatingInertia(inertia=0.001)
    bearing = ViscousFriction(damping=0.05)
    linkage = SliderCrankLinkage(radius=0.05, length=0.15, start_crank=0.3, start_rod=-0.05)
    guide = Fixed()
    piston = Mass(mass=2.0)

    connections = (
        pm.connect(torque, motor.torque),
        pm.connect(motor.shaft, wheel.shaft, bearing.shaft, linkage.crank),
        pm.connect(rod.shaft, linkage.rod),
        pm.connect(linkage.slider, piston.flange),
        pm.connect(linkage.gap_y, guide.flange),
    )


class LightRodSliderCrank(pm.Component):
    """A crank and a piston on a rod without mass."""

    wheel = RotatingInertia(inertia=0.02, start_speed=20.0)
    linkage = SliderCrankLinkage(radius=0.05, length=0.15)
    end = pm.Port(pm.Rotation)
    guide = Fixed()
    piston = Mass(mass=2.0)

    connections = (
        pm.connect(wheel.shaft, linkage.crank),
        pm.connect(end, linkage.rod),
        pm.free(end),
        pm.connect(linkage.slider, piston.flange),
        pm.connect(linkage.gap_y, guide.flange),
    )


class FourBar(pm.Component):
    """A crank that turns all the way round, a coupler and a rocker."""

    crank = RotatingInertia(inertia=0.1)
    coupler = RotatingInertia(inertia=0.2)
    rocker = RotatingInertia(inertia=0.3)
    loop = FourBarLinkage(crank_length=0.2, coupler_length=0.5, rocker_length=0.4, base=0.5)
    base = FixedPoint()

    connections = (
        pm.connect(crank.shaft, loop.crank),
        pm.connect(coupler.shaft, loop.coupler),
        pm.connect(rocker.shaft, loop.rocker),
        pm.connect(base.point, loop.gap),
    )


class Sum(pm.KinematicTransformer):
    """Two displacements that add up."""

    first = pm.Port(pm.Translation)
    second = pm.Port(pm.Translation)
    total = pm.Port(pm.Translation)

    def positions(self):
        return {self.total.displacement: self.first.displacement + self.second.displacement}


class SumWithAHeldInput(pm.Component):
    """A mass on a spring, behind a mechanism whose other input does not move."""

    total = Sum()
    base = Fixed()
    mass = Mass(mass=2.0, start_velocity=1.0)
    spring = Spring(stiffness=50.0)
    wall = Fixed()

    connections = (
        pm.connect(base.flange, total.first),
        pm.connect(mass.flange, total.second),
        pm.connect(total.total, spring.a),
        pm.connect(spring.b, wall.flange),
    )


class Follower(pm.KinematicTransformer):
    """The slope of x^2, with x from outside."""

    x = pm.Port(pm.Translation)
    y = pm.Port(pm.Translation)
    place = pm.Input("m")
    scale: pm.Parameter = pm.parameter("1/m", default=0.5)

    def known(self):
        return {self.x.displacement: self.place}

    def positions(self):
        return {self.y.displacement: self.scale * self.x.displacement * self.x.displacement}


class MassOnParabola(pm.Component):
    """A mass that moves in x drives another in y; a sensor tells where it is."""

    mover = Mass(mass=2.0, start_velocity=1.0)
    sensor = MotionSensor(start=0.3)
    follower = Follower()
    lifted = Mass(mass=3.0)

    connections = (
        pm.connect(mover.flange, sensor.flange, follower.x),
        pm.connect(follower.y, lifted.flange),
        pm.connect(sensor.position, follower.place),
    )
