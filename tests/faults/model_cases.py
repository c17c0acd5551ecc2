"""Faults in the description of a model: names, units, values, ports, laws."""

from __future__ import annotations

from dataclasses import replace as changed
from typing import Any

import propermodel as pm
from propermodel import (
    Compliance,
    Component,
    Domain,
    Input,
    Output,
    Parameter,
    Port,
    Resistance,
    SignalBlock,
    Translation,
    compile_model,
    connect,
    elaborate,
    parameter,
)
from propermodel.expressions.interpret import interpret
from propermodel.expressions.units import parse_quantity
from propermodel.modelling.elaborate import find_part
from tests.faults.case import Case
from tests.parts import Fixed, Flywheel, Mass, Spring


def made(parts: dict[str, Any], *connections: Any) -> type[Component]:
    """A component class from a dictionary of its parts."""
    return type("Rig", (Component,), {**parts, "connections": connections})


class Rig(Component):
    mass = Mass(mass=1.0)
    spring = Spring(stiffness=100.0)
    wall = Fixed()

    connections = (connect(mass.flange, spring.a), connect(spring.b, wall.flange))


class Bouncing(Mass):
    """A mass that changes what belongs to something else."""

    def events(self):
        return (pm.when(self.flange.flow < 0.0, {self.flange.flow: 0.0}),)


def event_of_something_else() -> object:
    return elaborate(Bouncing(mass=1.0))


def force_of_a_mass_that_moves() -> object:
    follower = Mass(mass=2.0)
    wiring = pm.activated_bond(Rig.mass.flange, follower.flange, carries="effort")
    rig = made(
        {"mass": Rig.mass, "spring": Rig.spring, "wall": Rig.wall, "follower": follower}, *Rig.connections, wiring
    )
    return compile_model(elaborate(rig()))


def speed_for_a_shaft() -> object:
    wheel = Flywheel(inertia=1.0)
    wiring = pm.activated_bond(Rig.mass.flange, wheel.shaft, carries="flow")
    rig = made({"mass": Rig.mass, "spring": Rig.spring, "wall": Rig.wall, "wheel": wheel}, *Rig.connections, wiring)
    return compile_model(elaborate(rig()))


def carries_a_voltage() -> object:
    return pm.activated_bond(Rig.mass.flange, Rig.spring.a, carries="voltage")  # pyright: ignore[reportArgumentType]


# -- names ----------------------------------------------------------------------------------------------


def unknown_parameter() -> object:
    return Spring(stifness=100.0)  # pyright: ignore[reportCallIssue]


def unknown_part() -> object:
    return pm.replace(Rig(), sprung=Spring(stiffness=1.0))


def replaced_by_a_number() -> object:
    return pm.replace(Rig(), spring=3.0)


def two_names() -> object:
    spring = Spring(stiffness=1.0)
    return type("Twice", (Component,), {"left": spring, "right": spring})


def reserved_name() -> object:
    class Train(Component):
        path = Mass(mass=1.0)

    return Train()


def unknown_path() -> object:
    return find_part(elaborate(Rig()), pm.Path(("sprng",)))


def foreign_reference() -> object:
    stranger = Mass(mass=1.0)

    class Foreign(Component):
        mass = Mass(mass=1.0)
        connections = (connect(mass.flange, stranger.flange),)

    return elaborate(Foreign())


def unknown_signal() -> object:
    model = elaborate(Rig())
    link = pm.modelling.model.SignalLink(value=pm.time, targets=(pm.Path(("wall", "velocity")),))
    definition = changed(model.root.definition, connections=(*model.root.definition.connections, link))
    return compile_model(changed(model, root=changed(model.root, definition=definition)))


def inconsistent() -> object:
    class Wired(Component):
        mass = Mass(mass=1.0)
        connections = (connect(mass.flange), pm.free(mass.flange))

    return elaborate(Wired())


def connected_parts() -> object:
    return connect(Mass(mass=1.0), Mass(mass=2.0))  # pyright: ignore[reportCallIssue, reportArgumentType]


def bonded_part() -> object:
    class Bonded(Component):
        mass = Mass(mass=1.0)
        node = pm.OneJunction()
        connections = (pm.bond(node, mass),)  # pyright: ignore[reportArgumentType]

    return elaborate(Bonded())


# -- ports and domains ----------------------------------------------------------------------------------


def unconnected_port() -> object:
    class Loose(Component):
        mass = Mass(mass=1.0)
        spring = Spring(stiffness=100.0)
        connections = (connect(mass.flange, spring.a),)

    return compile_model(elaborate(Loose()))


def open_port() -> object:
    class Opened(Component):
        flange = Port(Translation)
        mass = Mass(mass=1.0)
        connections = (connect(flange, mass.flange),)

    return compile_model(elaborate(Opened()))


def wrong_domain() -> object:
    class Mixed(Component):
        mass = Mass(mass=1.0)
        wheel = Flywheel(inertia=1.0)
        connections = (connect(mass.flange, wheel.shaft),)  # pyright: ignore[reportArgumentType, reportCallIssue]

    return elaborate(Mixed())


def domains_bonded() -> object:
    class Mixed(Component):
        node = pm.OneJunction()
        mass = Mass(mass=1.0)
        wheel = Flywheel(inertia=1.0)
        connections = (pm.bond(wheel.shaft, node), pm.bond(node, mass.flange))

    return compile_model(elaborate(Mixed()))


def misspelt_port() -> object:
    class Rig(Component):
        mass, spring, wall = Mass(mass=1.0), Spring(stiffness=1.0), Fixed()
        connections = (
            connect(spring.b, wall.flange),
            connect(mass.flnge, spring.a),  # pyright: ignore[reportAttributeAccessIssue]
        )

    return Rig()


def misspelt_in_a_law() -> object:
    class Drag(Resistance):
        port = Port(Translation)
        damping: Parameter = parameter("N.s/m", default=1.0)

        def effort(self, flow):
            return self.dampign * flow  # pyright: ignore[reportAttributeAccessIssue]

    return elaborate(Drag())


def misspelt_observable() -> object:
    return Rig().mass.flange.flw  # pyright: ignore[reportAttributeAccessIssue]


def misspelt_in_a_chain() -> object:
    first, second = Spring(stiffness=1.0), Spring(stiffness=1.0)
    return pm.chain([first, second], "bb", "a")


def two_domains() -> object:
    class Other(Domain):
        name = "translation"
        effort, effort_unit = "pull", "N"
        flow, flow_unit = "velocity", "m/s"
        displacement_unit, momentum_unit = "m", "N.s"
        shared = Translation.shared

    class Rope(Resistance):
        port = Port(Other)

        def effort(self, flow):
            return pm.quantity(1.0, "N.s/m") * flow

    class Both(Component):
        mass = Mass(mass=1.0)
        rope = Rope()

    return elaborate(Both())


def two_ports_for_one() -> object:
    class Branch(Resistance):
        a = Port(Translation)
        b = Port(Translation)

        def effort(self, flow):
            return flow

    class Uses(Component):
        branch = Branch()

    return elaborate(Uses())


# -- laws -----------------------------------------------------------------------------------------------


class LawlessSpring(Compliance):
    port = Port(Translation)
    stiffness: Parameter = parameter("N/m", default=1.0)


def law_missing() -> object:
    return elaborate(made({"spring": LawlessSpring()})())


class HeatTransformer(pm.Transformer):
    a = Port(pm.Electrical)
    b = Port(pm.PseudoThermal)
    ratio: Parameter = parameter("V/K", default=1.0)

    def modulus(self):
        return self.ratio


def pseudo_transformer() -> object:
    return elaborate(made({"heater": HeatTransformer()})())


class PushingDamper(Resistance):
    port = Port(Translation)
    force: Parameter = parameter("N", default=1.0)

    def residual(self, effort, flow):
        return effort - self.force


class InertDamper(PushingDamper):
    preference = pm.Preference.DERIVATIVE

    def residual(self, effort, flow):
        return effort / self.force - flow / pm.quantity(1.0, "m/s")


def wrong_preference() -> object:
    return elaborate(made({"damper": InertDamper()})())


def implicit_law_of_a_source() -> object:
    return elaborate(made({"damper": PushingDamper()})())


class WrongSpring(Compliance):
    port = Port(Translation)
    stiffness: Parameter = parameter("N/m", default=1.0)

    def effort(self, displacement):  # not N/m but N
        return self.stiffness


def wrong_dimension() -> object:
    return elaborate(made({"spring": WrongSpring()})())


class BrokenSpring(Compliance):
    port = Port(Translation)

    def effort(self, displacement):
        return displacement.squared()


def unreadable_law() -> object:
    return elaborate(made({"spring": BrokenSpring()})())


class Hesitant(Resistance):
    port = Port(Translation)
    damping: Parameter = parameter("N.s/m", default=1.0)

    def effort(self, flow):
        if flow > 0.0:  # no truth value
            return self.damping * flow
        return 0.0


def truth_value() -> object:
    return elaborate(made({"damper": Hesitant()})())


def no_value() -> object:
    return interpret(pm.time * 2.0)


# -- parameters and units -------------------------------------------------------------------------------


def missing_parameter() -> object:
    return elaborate(made({"mass": Mass()})())  # pyright: ignore[reportCallIssue]


class Limited(Component):
    share: Parameter = parameter("1", low=0.0, high=1.0)


def parameter_range() -> object:
    return elaborate(made({"part": Limited(share=1.5)})())


def root_parameter() -> object:
    return elaborate(Mass(mass=pm.time))


class Pair(Component):
    a = Mass(mass=1.0)
    b = Mass(mass=a.mass)

    connections = (connect(a.flange, b.flange),)


def parameter_circle() -> object:
    return compile_model(elaborate(pm.replace(Pair(), a=Mass(mass=Pair.b.mass))))


def unknown_unit() -> object:
    class Odd(Component):
        length: Parameter = parameter("furlongs/fortnight-ish", default=1.0)

    return Odd


def unit_number() -> object:
    return parse_quantity("heavy", "kg")


def unit_mismatch() -> object:
    return parse_quantity("12 m", "kg")


def table_grid() -> object:
    return pm.table("N", ("m",), [[0.0, 2.0, 1.0]], [0.0, 1.0, 2.0])


def table_values() -> object:
    return pm.table("N", ("m",), [[0.0, 1.0, 2.0]], [0.0, float("nan"), 2.0])


# -- signals --------------------------------------------------------------------------------------------


class Gain(SignalBlock):
    speed = Input("m/s")
    double = Output("m/s")

    def outputs(self):
        return {self.double: 2.0 * self.speed}


def undriven_signal() -> object:
    class Idle(Rig):
        gain = Gain()

    return compile_model(elaborate(Idle()))


def driven_twice() -> object:
    class Twice(Rig):
        gain = Gain()
        connections = (
            *Rig.connections,
            connect(Rig.mass.flange.flow, gain.speed),
            connect(Rig.wall.flange.flow, gain.speed),
        )

    return compile_model(elaborate(Twice()))


CASES = (
    Case(
        code="model/activated-bond",
        run=force_of_a_mass_that_moves,
        names=("mass.flange.to_follower_flange", "force", "velocity", "1-junction"),
        at="wiring = pm.activated_bond(Rig.mass.flange, follower",
        cure='carries="flow"',
    ),
    Case(
        code="model/activated-bond",
        run=speed_for_a_shaft,
        names=("mass.flange.to_wheel_shaft", "velocity of translation", "rotation"),
        at="wiring = pm.activated_bond(Rig.mass.flange, wheel",
        cure="use a sensor",
    ),
    Case(
        code="model/activated-bond",
        run=carries_a_voltage,
        names=("voltage",),
        at="pm.activated_bond(",
        cure='carries="effort" or carries="flow"',
    ),
    Case(
        code="model/event",
        run=event_of_something_else,
        names=("Bouncing", "flange.flow"),
        at="pm.when(",
        cure="own Discrete values",
    ),
    Case(
        code="model/unknown-parameter",
        run=unknown_parameter,
        names=("Spring", "stifness"),
        at="Spring(stifness",
        cure="did you mean 'stiffness'?",
    ),
    Case(
        code="model/unknown-part",
        run=unknown_part,
        names=("Rig", "sprung"),
        at="sprung=",
        cure="did you mean 'spring'?",
    ),
    Case(
        code="model/replace",
        run=replaced_by_a_number,
        names=("spring", "Rig", "float"),
        at="spring=3.0",
        cure="replace a part by a part",
    ),
    Case(
        code="model/parameter-circle",
        run=parameter_circle,
        names=("a.mass", "b.mass"),
        at="a=Mass(mass=Pair.b.mass)",
        cure="a number",
    ),
    Case(
        code="model/reserved-name",
        run=reserved_name,
        names=("Train", "path"),
        at="class Train(Component)",
        cure="choose another name",
    ),
    Case(
        code="model/two-names",
        run=two_names,
        names=("Twice", "left", "right"),
        at='type("Twice"',
        cure="make each part its own",
    ),
    Case(
        code="model/unknown-path",
        run=unknown_path,
        names=("sprng", "rig"),
        at="elaborate(Rig())",
        cure="did you mean 'spring'?",
    ),
    Case(
        code="model/foreign-reference",
        run=foreign_reference,
        names=("Foreign",),
        at="class Foreign",
        cure="direct parts",
    ),
    Case(code="model/unknown-signal", run=unknown_signal, names=("wall.velocity",), cure="no inputs"),
    Case(
        code="model/inconsistent",
        run=inconsistent,
        names=("Wired", "mass.flange"),
        at="connections = (connect(mass.flange)",
        cure="declare",
    ),
    Case(
        code="model/connect",
        run=connected_parts,
        names=("Mass, Mass",),
        at="return connect(Mass",
        cure="name a port of the part",
    ),
    Case(
        code="model/bond",
        run=bonded_part,
        names=("Bonded", "mass"),
        at="pm.bond(node, mass)",
        cure="name one of its ports",
    ),
    Case(
        code="model/unconnected-port",
        run=unconnected_port,
        names=("translation", "spring.b"),
        at="spring = Spring(",
        cure="connect it",
    ),
    Case(code="model/open-port", run=open_port, names=("flange", "opened"), at="class Opened", cure="free(flange)"),
    Case(
        code="model/domain",
        run=wrong_domain,
        names=("rotation", "translation", "mass.flange", "wheel.shaft"),
        at="connect(mass.flange, wheel.shaft)",
        cure="transducer",
    ),
    Case(
        code="model/domain",
        run=domains_bonded,
        names=("bonds join", "rotation", "translation", "node (1-junction)", "mass.flange", "wheel.shaft"),
        at="node = pm.OneJunction()",
        cure="transducer",
    ),
    Case(
        code="model/unknown-name",
        run=misspelt_port,
        names=("Mass", "flnge"),
        at="connect(mass.flnge, spring.a)",
        cure="did you mean 'flange'?",
    ),
    Case(
        code="model/unknown-name",
        run=misspelt_in_a_law,
        names=("Drag", "dampign"),
        at="return self.dampign * flow",
        cure="did you mean 'damping'?",
    ),
    Case(
        code="model/unknown-name",
        run=misspelt_observable,
        names=("a power port", "flw"),
        at="return Rig().mass.flange.flw",
        cure="did you mean 'flow'?",
    ),
    Case(
        code="model/unknown-name",
        run=misspelt_in_a_chain,
        names=("Spring", "bb"),
        at="pm.chain(",
        cure="did you mean 'b'?",
    ),
    Case(
        code="model/two-domains", run=two_domains, names=("translation",), at="port = Port(Other)", cure="another name"
    ),
    Case(code="model/ports", run=two_ports_for_one, names=("Branch", "a, b"), at="class Branch", cure="between=(a, b)"),
    Case(
        code="model/law-missing",
        run=law_missing,
        names=("LawlessSpring", "effort(displacement)"),
        at="class LawlessSpring",
        cure="define the law",
    ),
    Case(
        code="model/implicit-law",
        run=implicit_law_of_a_source,
        names=("PushingDamper.residual", "flow"),
        at="def residual(self, effort, flow)",
        cure="EffortSource",
    ),
    Case(
        code="model/pseudo-domain",
        run=pseudo_transformer,
        names=("HeatTransformer", "(a)", "(b)", "pseudo_thermal"),
        at="class HeatTransformer",
        cure="converts = True",
    ),
    Case(
        code="model/preference",
        run=wrong_preference,
        names=("InertDamper", "derivative"),
        at="class InertDamper",
        cure="Preference.EFFORT",
    ),
    Case(
        code="model/dimension",
        run=wrong_dimension,
        names=("WrongSpring.effort", "kg/s2", "N"),
        at="def effort(self, displacement):  # not N/m but N",
        cure="units of the parameters",
    ),
    Case(
        code="model/law",
        run=unreadable_law,
        names=("BrokenSpring.effort", "squared"),
        at="displacement.squared()",
        cure="a law gives an expression",
    ),
    Case(
        code="expression/truth-value",
        run=truth_value,
        names=("truth value",),
        at="if flow > 0.0",
        cure="where(condition, a, b)",
    ),
    Case(code="expression/no-value", run=no_value, names=("time",), cure="a number"),
    Case(
        code="model/missing-parameter",
        run=missing_parameter,
        names=("mass", "kg"),
        at="Mass()",
        cure="Mass(mass=...), in kg",
    ),
    Case(
        code="model/parameter-range",
        run=parameter_range,
        names=("part", "share", "1.5", "0 to 1"),
        at="Limited(share=1.5)",
        cure="inside the range",
    ),
    Case(
        code="model/root-parameter", run=root_parameter, names=("mass",), at="Mass(mass=pm.time)", cure="give a number"
    ),
    Case(code="unit/unknown", run=unknown_unit, names=("furlongs",), at="length: Parameter", cure="N.m/rad"),
    Case(code="unit/number", run=unit_number, names=("heavy",), cure="12.5 kg"),
    Case(code="unit/mismatch", run=unit_mismatch, names=("12 m", "kg"), cure="give it in kg"),
    Case(code="model/table-grid", run=table_grid, names=("growing",), at="[[0.0, 2.0, 1.0]]", cure="sort the points"),
    Case(
        code="model/table-values",
        run=table_values,
        names=("3 finite values",),
        at='float("nan")',
        cure="one finite value",
    ),
    Case(
        code="model/undriven-signal",
        run=undriven_signal,
        names=("gain.speed",),
        at="gain = Gain()",
        cure="connect a signal",
    ),
    Case(
        code="model/signal-driven-twice",
        run=driven_twice,
        names=("gain.speed",),
        at="connect(Rig.wall.flange.flow, gain.speed)",
        cure="add them in a block",
    ),
)
