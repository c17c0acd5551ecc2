"""Models that the tests of reduction take apart."""

from __future__ import annotations

from propermodel.expressions import Expr
from propermodel.library.mechanics.rotation import Gear, RotatingInertia, RotationalSpringDamper, ViscousFriction
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, SpringDamper
from propermodel.modelling import Component, Input, Port, Resistance, Translation, connect, quantity
from tests.parts import Capacitor, Coil, Ground, Resistor, Voltage
from tests.physics.systems import Drive, Push, Shaking, system


def quarter_car(velocity: float = 0.3, frequency: float = 2.0) -> Component:
    road, wheel, body = Shaking(velocity=velocity, frequency=frequency), Mass(mass=80.0), Mass(mass=1200.0)
    tyre, suspension = SpringDamper(stiffness=2.4e5, damping=1.5e2), SpringDamper(stiffness=2.0e4, damping=1.5e3)
    return system(
        connect(road.flange, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange),
        road=road,
        tyre=tyre,
        wheel=wheel,
        suspension=suspension,
        body=body,
    )


def driveline() -> Component:
    """Engine, gear, soft shaft and load with a bearing."""
    drive = Drive(torque=5.0)
    engine = RotatingInertia(inertia=0.2)
    gear = Gear(ratio=2.0)
    pinion = RotatingInertia(inertia=0.05)
    shaft = RotationalSpringDamper(stiffness=300.0, damping=1.0)
    load = RotatingInertia(inertia=1.5)
    bearing = ViscousFriction(damping=0.4)
    return system(
        connect(drive.shaft, engine.shaft, gear.a),
        connect(gear.b, pinion.shaft, shaft.a),
        connect(shaft.b, load.shaft, bearing.shaft),
        drive=drive,
        engine=engine,
        gear=gear,
        pinion=pinion,
        shaft=shaft,
        load=load,
        bearing=bearing,
    )


def ladder() -> Component:
    """Two sections of a line with a load."""
    source, ground = Voltage(voltage=10.0), Ground()
    r1, l1, c1 = Resistor(resistance=1.0), Coil(inductance=0.1), Capacitor(capacitance=1e-2)
    r2 = Resistor(resistance=2.0)
    l2 = Coil(inductance=0.2)
    c2 = Capacitor(capacitance=2e-2)
    load = Resistor(resistance=50.0)
    return system(
        connect(source.a, r1.a),
        connect(r1.b, l1.a),
        connect(l1.b, c1.a, r2.a),
        connect(r2.b, l2.a),
        connect(l2.b, c2.a, load.a),
        connect(c1.b, c2.b, load.b, source.b, ground.pin),
        source=source,
        ground=ground,
        r1=r1,
        l1=l1,
        c1=c1,
        r2=r2,
        l2=l2,
        c2=c2,
        load=load,
    )


def two_masses(*between: Component) -> Component:
    """A mass on parallel parts on a mass, with one more spring to a wall."""
    left, right, wall = Mass(mass=2.0, start_velocity=1.0), Mass(mass=3.0), Fixed()
    holder = SpringDamper(stiffness=40.0, damping=1.0)
    parts = {f"p{n}": part for n, part in enumerate(between)}
    return system(
        connect(left.flange, *(part.a for part in between)),
        connect(right.flange, holder.a, *(part.b for part in between)),
        connect(holder.b, wall.flange),
        left=left,
        right=right,
        wall=wall,
        holder=holder,
        **parts,
    )


def preloaded() -> Component:
    """A heavy body stands on a stiff spring, while a small shaker works hard next to it."""
    weight = Push(force=-9810.0)
    body = Mass(mass=1000.0)
    spring = Spring(stiffness=1e6, start_compression=-9.81e-3)
    ground = Fixed()
    damper = Damper(damping=1e4)
    shaker = Shaking(velocity=3.0, frequency=3.0)
    link = Spring(stiffness=500.0)
    small = Mass(mass=1.0)
    brake = Damper(damping=10.0)
    return system(
        connect(weight.flange, body.flange, spring.a, damper.a, brake.b),
        connect(spring.b, damper.b, ground.flange),
        connect(shaker.flange, link.a),
        connect(link.b, small.flange, brake.a),
        weight=weight,
        body=body,
        spring=spring,
        ground=ground,
        damper=damper,
        shaker=shaker,
        link=link,
        small=small,
        brake=brake,
    )


class Listening(Resistance):
    """A damper that follows the velocity of something else."""

    a, b = Port(Translation), Port(Translation)
    port = Port(Translation, between=(a, b))
    heard = Input("m/s")

    def effort(self, flow: Expr) -> Expr:
        return quantity(0.05, "N.s/m") * (1.0 + abs(self.heard) / quantity(1.0, "m/s")) * flow


def listener() -> Component:
    """A light mass on a busy one, held by a damper that listens to the busy one."""
    shaker, link, mass, spring = (
        Shaking(velocity=1.0, frequency=1.3),
        Spring(stiffness=300.0),
        Mass(mass=5.0),
        Spring(stiffness=200.0),
    )
    ground, hanger, soft, small = Fixed(), Listening(), Spring(stiffness=8.0), Mass(mass=0.02)
    return system(
        connect(shaker.flange, link.a),
        connect(link.b, mass.flange, spring.a, hanger.a, soft.a),
        connect(spring.b, ground.flange),
        connect(hanger.b, soft.b, small.flange),
        connect(mass.flange.flow, hanger.heard),
        shaker=shaker,
        link=link,
        mass=mass,
        spring=spring,
        ground=ground,
        hanger=hanger,
        soft=soft,
        small=small,
    )
