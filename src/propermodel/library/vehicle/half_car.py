"""Half of a car: heave and pitch of the body on two gas-sprung wheels over a rough road."""

from __future__ import annotations

from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.library.mechanics.translation import Damper, GasSpring, Lever, Mass, SpringDamper
from propermodel.library.thermal import WallConductance
from propermodel.modelling import (
    Component,
    Parameter,
    Port,
    Rotation,
    Translation,
    connect,
    parameter,
    prescribed_flow,
)


class GasStrut(Component):
    """A gas spring with its wall, and a damper beside it."""

    lower = Port(Translation)
    upper = Port(Translation)
    gas_volume: Parameter = parameter("m3", default=0.8e-3, low=0.0, status="estimated")
    piston_area: Parameter = parameter("m2", default=1.2e-3, low=0.0, status="estimated")
    static_pressure: Parameter = parameter("Pa", default=3.0e6, low=0.0, status="estimated", doc="absolute")
    damping: Parameter = parameter("N.s/m", default=1500.0, low=0.0, status="estimated")
    wall_conductance: Parameter = parameter("W/K", default=1.0, low=0.0, status="estimated")

    gas = GasSpring(gas_volume=gas_volume, piston_area=piston_area, static_pressure=static_pressure)
    wall = WallConductance(conductance=wall_conductance)
    damper = Damper(damping=damping)

    connections = (
        connect(lower, gas.a, damper.a),
        connect(upper, gas.b, damper.b),
        connect(gas.wall, wall.port),
    )


class Corner(Component):
    """A wheel with its tyre, and the strut that carries the body at a point of it."""

    road = Port(Translation)
    heave = Port(Translation)
    pitch = Port(Rotation)
    arm: Parameter = parameter("m", doc="distance ahead of the centre of gravity")
    wheel_mass: Parameter = parameter("kg", default=40.0, low=0.0, status="estimated")
    tyre_stiffness: Parameter = parameter("N/m", default=2.0e5, low=0.0, status="estimated")
    tyre_damping: Parameter = parameter("N.s/m", default=150.0, low=0.0, status="estimated")

    tyre = SpringDamper(stiffness=tyre_stiffness, damping=tyre_damping)
    wheel = Mass(mass=wheel_mass)
    strut = GasStrut()
    mount = Lever()

    connections = (
        connect(road, tyre.a),
        connect(tyre.b, wheel.flange, strut.lower),
        connect(strut.upper, mount.point),
        connect(heave, mount.base),
        connect(pitch, mount.rotation),
        connect(arm, mount.arm),
    )


class HalfCar(Component):
    """Heave and pitch of a body over a rough road; the scenario gives the vertical velocity at either wheel."""

    front_road = Port(Translation)
    rear_road = Port(Translation)
    body_mass: Parameter = parameter("kg", default=600.0, low=0.0, status="estimated")
    pitch_inertia: Parameter = parameter("kg.m2", default=1000.0, low=0.0, status="estimated")
    front_arm: Parameter = parameter("m", default=1.2, low=0.0, status="estimated", doc="from the centre of gravity")
    rear_arm: Parameter = parameter("m", default=1.4, low=0.0, status="estimated", doc="from the centre of gravity")

    heave = Mass(mass=body_mass)
    pitch = RotatingInertia(inertia=pitch_inertia)
    front = Corner(arm=front_arm)
    rear = Corner(arm=-rear_arm)

    connections = (
        connect(front_road, front.road),
        connect(rear_road, rear.road),
        connect(heave.flange, front.heave, rear.heave),
        connect(pitch.shaft, front.pitch, rear.pitch),
        prescribed_flow(front_road),
        prescribed_flow(rear_road),
    )
