"""Six systems that every textbook has, in the parts of the library."""

from __future__ import annotations

from propermodel.expressions import Expr
from propermodel.library.electrical import (
    Capacitor,
    DCMotor,
    Ground,
    Inductor,
    Resistor,
    VoltageSource,
)
from propermodel.library.hydraulics import Leakage, OilChamber, OpenTank, VolumeFlowSource
from propermodel.library.mechanics.rotation import Gear, RotatingInertia, TorqueSource, ViscousFriction
from propermodel.library.mechanics.translation import Damper, Fixed, ForceSource, Mass, Spring, SpringDamper
from propermodel.modelling import (
    Component,
    Hydraulic,
    Input,
    Parameter,
    Port,
    Transformer,
    Translation,
    chain,
    connect,
    parameter,
    prescribed_flow,
    repeat,
)


class SeriesCircuit(Component):
    """A source, a resistor, a coil and a capacitor in one loop."""

    voltage = Input("V")
    source = VoltageSource()
    resistor = Resistor(resistance=10.0)
    coil = Inductor(inductance=0.1)
    capacitor = Capacitor(capacitance=1e-3)
    ground = Ground()

    connections = (
        connect(voltage, source.voltage),
        connect(source.pin, resistor.a),
        connect(resistor.b, coil.a),
        connect(coil.b, capacitor.a),
        connect(capacitor.b, ground.pin),
    )


class Motor(Component):
    """A direct-current motor at a voltage, with a load torque."""

    voltage = Input("V")
    torque = Input("N.m")
    source = VoltageSource()
    motor = DCMotor(resistance=1.0, inductance=0.01, constant=0.1, inertia=0.02, friction=0.001)
    load = TorqueSource()

    connections = (
        connect(voltage, source.voltage),
        connect(torque, load.torque),
        connect(source.pin, motor.pin),
        connect(motor.shaft, load.shaft),
    )


class GearedInertias(Component):
    """Two inertias that a gear joins rigidly: one of them is dependent storage."""

    torque = Input("N.m")
    drive = TorqueSource()
    pinion = RotatingInertia(inertia=0.5)
    gear = Gear(ratio=3.0)
    wheel = RotatingInertia(inertia=4.0)
    bearing = ViscousFriction(damping=0.2)

    connections = (
        connect(torque, drive.torque),
        connect(drive.shaft, pinion.shaft, gear.a),
        connect(gear.b, wheel.shaft, bearing.shaft),
    )


class WheatstoneBridge(Component):
    """Four resistors around a galvanometer, which has a resistance and an inductance."""

    voltage = Input("V")
    source = VoltageSource()
    upper_left = Resistor(resistance=100.0)
    upper_right = Resistor(resistance=110.0)
    lower_left = Resistor(resistance=120.0)
    lower_right = Resistor(resistance=130.0)
    galvanometer = Inductor(inductance=0.5)
    ground = Ground()

    connections = (
        connect(voltage, source.voltage),
        connect(source.pin, upper_left.a, upper_right.a),
        connect(upper_left.b, lower_left.a, galvanometer.a),
        connect(upper_right.b, lower_right.a, galvanometer.b),
        connect(lower_left.b, lower_right.b, ground.pin),
    )


class QuarterCar(Component):
    """Body on a suspension on a wheel on a tyre; the road moves the tyre."""

    road = Port(Translation)
    body = Mass(mass=1200.0)
    wheel = Mass(mass=80.0)
    suspension = SpringDamper(stiffness=2.0e4, damping=1.5e3)
    tyre = Spring(stiffness=2.4e5)

    connections = (
        connect(road, tyre.a),
        connect(tyre.b, wheel.flange, suspension.a),
        connect(suspension.b, body.flange),
        prescribed_flow(road),
    )


class Piston(Transformer):
    """Pressure on an area pushes outwards."""

    a = Port(Translation)
    b = Port(Hydraulic)
    area: Parameter = parameter("m2", low=0.0)

    def modulus(self) -> Expr:
        return -self.area


class Cylinder(Component):
    """A pump fills a chamber that leaks; its piston pushes a mass against a damper."""

    flow = Input("m3/s")
    pump = VolumeFlowSource()
    chamber = OilChamber(volume=1e-3)
    leakage = Leakage(conductance=1e-12)
    tank = OpenTank()
    piston = Piston(area=2e-3)
    load = Mass(mass=50.0)
    damper = Damper(damping=300.0)
    frame = Fixed()

    connections = (
        connect(flow, pump.volume_flow),
        connect(pump.port, chamber.port, leakage.a, piston.b),
        connect(leakage.b, tank.port),
        connect(piston.a, load.flange, damper.a),
        connect(damper.b, frame.flange),
    )


class Section(Component):
    """A mass on a spring and damper."""

    a = Port(Translation)
    b = Port(Translation)
    coupling = SpringDamper(stiffness=1e4, damping=10.0)
    mass = Mass(mass=1.0)

    connections = (connect(a, coupling.a), connect(coupling.b, mass.flange, b))


def section_chain(number: int) -> Component:
    """Sections one after the other from a wall to a force."""
    sections = repeat(number, Section())
    wall, push, force = Fixed(), ForceSource(), Input("N")
    connections = (
        connect(force, push.force),
        connect(wall.flange, sections[0].a),
        *chain(sections, "b", "a"),
        connect(sections[-1].b, push.flange),
    )
    body = {"force": force, "wall": wall, "push": push, "sections": sections, "connections": connections}
    return type("SectionChain", (Component,), body)()
