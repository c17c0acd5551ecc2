"""Faults in the structure of a bond graph: causality and equations."""

from __future__ import annotations

import sys
from unittest.mock import patch

import propermodel as pm
from propermodel import (
    Component,
    FlowSource,
    Gyrator,
    Inertia,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    SignalBlock,
    Translation,
    ZeroEffort,
    compile_model,
    connect,
    elaborate,
    parameter,
)
from propermodel.compiler import compile_quietly
from tests.faults.case import Case, warned
from tests.parts import (
    Capacitor,
    Fixed,
    Flywheel,
    Force,
    Gear,
    Ground,
    Mass,
    Resistor,
    Spring,
    Torque,
    Velocity,
    Voltage,
)


def compiled(component: Component) -> object:
    return compile_model(elaborate(component))


class TwoVoltages(Component):
    mains = Voltage(voltage=230.0)
    battery = Voltage(voltage=12.0)
    lamp = Resistor(resistance=10.0)
    ground = Ground()

    connections = (
        connect(mains.a, battery.a, lamp.a),
        connect(mains.b, battery.b, lamp.b, ground.pin),
    )


class TwoVelocities(Component):
    road = Velocity(velocity=1.0)
    shaker = Velocity(velocity=2.0)
    mass = Mass(mass=1.0)

    connections = (connect(road.flange, shaker.flange, mass.flange),)


class OneWay(Resistance):
    """A law that cannot be inverted: the same force at both signs of the slip."""

    port = Port(Translation)
    force: Parameter = parameter("N", default=1.0)
    width: Parameter = parameter("m/s", default=0.1)

    def effort(self, flow):
        return self.force * pm.tanh(flow / self.width)


class OnlyForces(Component):
    """Every part at the junction gives a force, none its velocity."""

    push = Force(force=1.0)
    brake = OneWay()

    connections = (connect(push.flange, brake.port),)


class ShortedSource(Component):
    wall = Fixed()
    road = Velocity(velocity=1.0)

    connections = (connect(wall.flange, road.flange),)


class Oscillator(Component):
    mass = Mass(mass=1.0)
    spring = Spring(stiffness=1.0)
    wall = Fixed()

    connections = (connect(mass.flange, spring.a), connect(spring.b, wall.flange))


class TwoRooms(Component):
    """Two oscillators that nothing couples."""

    left_mass = Mass(mass=1.0)
    left_spring = Spring(stiffness=4.0)
    left_wall = Fixed()
    right = Oscillator()

    connections = (connect(left_mass.flange, left_spring.a), connect(left_spring.b, left_wall.flange))


class Gearbox(Component):
    """Two pairs of gears between the same two shafts."""

    back: Parameter = parameter("1", default=0.5)

    drive = Torque(torque=1.0)
    input, output = Flywheel(inertia=1.0), Flywheel(inertia=2.0)
    first = Gear(ratio=2.0)
    second = Gear(ratio=back)

    connections = (
        connect(drive.shaft, input.shaft, first.a, second.b),
        connect(first.b, second.a, output.shaft),
    )


def shifted(back: float) -> object:
    """A run with another ratio on the way back than the model has."""
    scenario = pm.Scenario(parameters={"back": back})  # pyright: ignore[reportArgumentType]
    return pm.simulate(compile_quietly(elaborate(Gearbox(back=3.0))), scenario)


class Carried(Component):
    shaker = Velocity(velocity=1.0)
    load = Mass(mass=1.0)

    connections = (connect(shaker.flange, load.flange),)


class Charged(Component):
    battery = Voltage(voltage=12.0)
    capacitor = Capacitor(capacitance=1e-3)
    ground = Ground()

    connections = (connect(battery.a, capacitor.a), connect(battery.b, capacitor.b, ground.pin))


class HardMass(Inertia):
    """Momentum that saturates: the law has no inverse."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", default=1.0)
    scale: Parameter = parameter("N.s", default=1.0)

    def flow(self, momentum):
        return self.scale / self.mass * pm.tanh(momentum / self.scale)

    def energy(self, momentum):
        return self.scale * self.scale / self.mass * (momentum / self.scale) ** 2.0


class NoInverse(Component):
    road = Velocity(velocity=1.0)
    mass = HardMass()

    connections = (connect(road.flange, mass.flange),)


class BouncingMass(Mass):
    """A mass that bounces off something."""

    def events(self):
        return (pm.when(self.flange.flow < 0.0, {self.flange.momentum: -self.flange.momentum}),)


class DrivenBouncer(Component):
    road = Velocity(velocity=1.0)
    mass = BouncingMass(mass=1.0)

    connections = (connect(road.flange, mass.flange),)


class Stopper(Resistance):
    """A damper that stops dead what has become slow."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m", default=1.0)
    slow: Parameter = parameter("m/s", default=0.1)

    def effort(self, flow):
        return self.damping * flow

    def events(self):
        return (pm.when(self.port.flow < self.slow, restitution=0.0),)


class StoppedSpring(Component):
    spring = Spring(stiffness=10.0)
    stopper = Stopper()
    left = Fixed()
    right = Fixed()

    connections = (
        connect(left.flange, spring.a),
        connect(spring.b, stopper.a),
        connect(stopper.b, right.flange),
    )


class Turned(Gyrator):
    a = Port(Translation)
    b = Port(Translation)
    ratio: Parameter = parameter("N.s/m", default=2.0)

    def modulus(self):
        return self.ratio


class Ring(Component):
    """A gyrator that is joined with itself: what it asks of the one junction cannot be had."""

    push = Force(force=1.0)
    gyrator = Turned()

    connections = (connect(push.flange, gyrator.a, gyrator.b),)


class Shaker(FlowSource):
    flange = Port(Translation)

    def flow(self):
        return pm.quantity(1.0, "m/s") * pm.sin(pm.time / pm.quantity(1.0, "s"))


class Yielding(FlowSource):
    """Moves as fast as a force that it is told asks for."""

    flange = Port(Translation)
    force = Input("N")
    mobility: Parameter = parameter("m/(N.s)", default=1.0)

    def flow(self):
        return self.mobility * self.force


class Reacting(Component):
    """The speed of one driven mass is made from the reaction of another."""

    shaker = Shaker()
    one = Mass(mass=1.0)
    mover = Yielding()
    two = Mass(mass=1.0)

    connections = (
        connect(shaker.flange, one.flange),
        connect(mover.flange, two.flange),
        connect(one.flange.effort, mover.force),
    )


class More(SignalBlock):
    speed = Input("m/s")
    more = Output("m/s")

    def outputs(self):
        return {self.more: self.speed + pm.quantity(1.0, "m/s")}


class SelfFed(Component):
    """A signal that is one more than itself."""

    add = More()

    connections = (connect(add.more, add.speed),)


class Drag(Resistance):
    port = Port(Translation)
    size: Parameter = parameter("N.s2/m2", default=1.0)

    def effort(self, flow):
        return self.size * flow * abs(flow)


class Dragged(Component):
    mass = Mass(mass=1.0)
    air = Drag()

    connections = (connect(mass.flange, air.port),)


class Read(Dragged):
    """A signal reads the speed of a mass, which a reduction leaves without anything that decides it."""

    add = More()

    connections = (*Dragged.connections, connect(Dragged.mass.flange.flow, add.speed))


def unfrozen() -> object:
    ends = (("mass", "flange"), ("air", "port"))
    return compile_model(elaborate(Read()).without([ZeroEffort(pm.Path(end)) for end in ends]))


def dragged() -> pm.CompiledModel:
    return compile_model(elaborate(Dragged()))


def without_sympy() -> object:
    """SymPy as if it were not installed."""
    with patch.dict(sys.modules, {"sympy": None}):
        return pm.state_equations(dragged()).to_sympy()


CASES = (
    Case(
        code="equations/event",
        run=lambda: compiled(DrivenBouncer()),
        names=("mass.momentum", "dependent"),
        at="pm.when(",
        cure="put a compliance in between",
    ),
    Case(
        code="equations/impulse",
        run=lambda: compiled(StoppedSpring()),
        names=("stopper", "acts on no state", "is struck"),
        at="pm.when(",
        cure="put an inertia where it strikes",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(TwoVoltages()),
        names=("two effort sources", "voltage", "mains", "battery"),
        at="battery = Voltage(",
        cure="put a resistance or inertia between them, or make one of them a flow source",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(TwoVelocities()),
        names=("two flow sources", "velocity", "road", "shaker", "1-junction"),
        at="shaker = Velocity(",
        cure="put a compliance between them, or make one of them an effort source",
    ),
    Case(
        code="causality/conflict",
        run=lambda: compiled(OnlyForces()),
        names=("nothing sets the velocity", "push", "port.effort only, which is flat from 10 to 100 m/s"),
        at="brake = OneWay()",
        cure="an inertia",
    ),
    Case(
        code="structure/source-shorted",
        run=lambda: compiled(ShortedSource()),
        names=("road", "flow"),
        at="road = Velocity",
        cure="take one of the two away",
    ),
    Case(
        code="causality/no-inverse",
        run=lambda: compiled(NoInverse()),
        names=("mass", "inverted: it is flat from 100 to 1000 N.s", "road"),
        at="mass = HardMass()",
        cure="momentum(flow)",
    ),
    Case(
        code="causality/transformer-loop",
        run=lambda: compiled(Gearbox()),
        names=("first and second", "share the torque", "second  has the modulus 0.5"),
        at="first = Gear(",
        cure="leave one of them out",
    ),
    Case(
        code="causality/transformer-loop",
        run=lambda: shifted(0.5),
        names=("first and second", "share the torque", "second  has the modulus 0.5"),
        at="first = Gear(",
        cure="leave one of them out",
    ),
    Case(
        code="causality/transformer-lock",
        run=lambda: warned(Gearbox(back=3.0)),
        names=("first and second", "ratio 6, not 1", "the angular velocity can only be 0", "second  has the modulus 3"),
        at="second = Gear(",
        cure="multiply to 1",
    ),
    Case(
        code="causality/undetermined",
        run=lambda: compiled(Ring()),
        names=("gyrator.a", "1-junction", "push.flange"),
        at="connections = (connect(push.flange, gyrator.a",
        cure="a storage, a source or a resistance",
    ),
    Case(
        code="equations/impulsive",
        run=lambda: warned(Carried()),
        names=("nothing but shaker", "the velocity of load", "its force is an impulse"),
        at="load = Mass(",
        cure="a compliance between them",
    ),
    Case(
        code="equations/impulsive",
        run=lambda: warned(Charged()),
        names=("nothing but battery", "the voltage of capacitor", "its current is an impulse"),
        at="battery = Voltage(",
        cure="a resistance between them",
    ),
    Case(
        code="equations/index",
        run=lambda: compiled(Reacting()),
        names=("two", "one.flange"),
        at="two = Mass(",
        cure="a compliance",
    ),
    Case(
        code="equations/singular", run=lambda: compiled(SelfFed()), names=("add",), cure="feeds itself without a delay"
    ),
    Case(code="equations/undefined", run=unfrozen, names=("mass.flange.flow", "add"), cure="freeze the signal"),
    Case(
        code="equations/nonlinear",
        run=lambda: pm.symbolic_matrices(dragged()),
        names=("mass.velocity",),
        cure="linearise",
    ),
    Case(
        code="equations/unknown-output",
        run=lambda: pm.state_equations(dragged(), outputs=["mass.flange.flw"]),
        names=("mass.flange.flw",),
        cure="did you mean 'mass.flange.flow'?",
    ),
    Case(
        code="structure/disconnected",
        run=lambda: warned(TwoRooms()),
        names=("two parts", "left", "with left_spring, left_wall", "right", "stands alone"),
        at="right = Oscillator()",
        cure="connect them where they should meet",
    ),
    Case(code="equations/no-sympy", run=without_sympy, names=("SymPy",), cure="propermodel[symbolic]"),
)
