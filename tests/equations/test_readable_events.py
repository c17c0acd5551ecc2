"""Events among the readable equations: what a condition makes of what it changes, in the order of the model."""

from __future__ import annotations

from matplotlib.mathtext import MathTextParser

from propermodel.compiler import compile_model
from propermodel.equations.layout import WIDTH
from propermodel.equations.readable import ReadableEquations, state_equations
from propermodel.expressions import Expr
from propermodel.library.mechanics.rotation import FixedShaft, RotatingInertia, StickingFriction
from propermodel.library.mechanics.translation import Fixed, Impact, Mass
from propermodel.modelling import (
    Compliance,
    Component,
    Parameter,
    Port,
    Translation,
    connect,
    elaborate,
    parameter,
    when,
)
from propermodel.modelling.events import When


class Ratchet(Compliance):
    """A spring that slips to its middle when it is stretched by a tooth."""

    flange = Port(Translation)
    stiffness: Parameter = parameter("N/m", default=8.0)
    tooth: Parameter = parameter("m", default=0.5)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement

    def events(self) -> tuple[When, ...]:
        return (when(self.flange.displacement > self.tooth, {self.flange.displacement: 0.5 * self.tooth}),)


class Caught(Component):
    """A mass on a ratchet."""

    mass = Mass(mass=2.0)
    ratchet = Ratchet()
    connections = (connect(mass.flange, ratchet.flange),)


class Bouncing(Component):
    """A mass that bounces off a wall."""

    mass = Mass(mass=2.0, start_velocity=1.0)
    stop = Impact(start_gap=1.0)
    wall = Fixed()
    connections = (connect(mass.flange, stop.a), connect(stop.b, wall.flange))


class Braked(Component):
    """A flywheel that dry friction stops."""

    wheel = RotatingInertia(inertia=1.0, start_speed=3.0)
    brake = StickingFriction(torque=2.0)
    frame = FixedShaft()
    connections = (connect(wheel.shaft, brake.a), connect(brake.b, frame.shaft))


def readable(component: Component) -> ReadableEquations:
    return state_equations(compile_model(elaborate(component)))


def test_a_state_becomes_what_the_event_gives_it():
    assert readable(Caught()).text().splitlines()[-2:] == [
        "when ratchet.tooth < ratchet.displacement:",
        "  ratchet.displacement = ratchet.tooth/2",
    ]


def test_an_impact_turns_the_speed_of_what_is_struck():
    text = readable(Bouncing()).text()
    assert "  contact.velocity = -stop.restitution*mass.velocity" in text.splitlines()


def test_events_are_formulas_in_every_notation():
    for component in (Caught(), Bouncing(), Braked()):
        equations = readable(component)
        assert equations.events
        parser = MathTextParser("path")
        for line in equations.markdown().splitlines():
            if line.startswith("$$") and "cases" not in line:  # which matplotlib cannot set
                parser.parse(f"${line.strip('$')}$")
            elif line.startswith("When $") and "cases" not in line:
                parser.parse(line.removeprefix("When ").removesuffix(":"))
        assert equations.latex().count("when $") == len(equations.events)
        assert all(len(line) <= WIDTH for line in equations.text().splitlines())
        assert readable(component).text() == equations.text()
        assert equations.text().count("\nwhen ") == len(equations.events)
