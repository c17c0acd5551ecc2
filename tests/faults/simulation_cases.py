"""Faults in what is asked of a compiled model: runs, rankings, reductions, studies."""

from __future__ import annotations

import sys
from dataclasses import replace as changed
from functools import cache
from unittest.mock import patch

import propermodel as pm
from propermodel import (
    CompiledModel,
    Component,
    ConstantEffort,
    Cut,
    Domain,
    Expr,
    Inertia,
    Input,
    MultiportResistance,
    Output,
    Parameter,
    Port,
    Resistance,
    Scenario,
    SignalBlock,
    StudyOptions,
    TableValues,
    Trajectory,
    Translation,
    ZeroEffort,
    ZeroFlow,
    chain,
    compile_model,
    connect,
    elaborate,
    free,
    parameter,
    plan_reduction,
    prescribed_flow,
    rank_activity,
    repeat,
    run_study,
    simulate,
)
from propermodel.library.electrical import ConstantVoltage, CoupledInductors, Ground, IdealDiode, Resistor
from propermodel.library.mechanics.translation import ConstantVelocity
from propermodel.modelling.model import Variable
from propermodel.reduction.claim import Claim, Condition
from propermodel.reduction.ranges import ranges_of
from propermodel.simulation.stepping import Stepping
from tests.faults.case import Case
from tests.parts import Fixed, Mass, SpringDamper
from tests.reduction.rigs import listener


class Quarter(Component):
    """A body on a suspension whose foot the scenario moves."""

    road = Port(Translation)
    body = Mass(mass=250.0)
    suspension = SpringDamper(stiffness=1.0e4, damping=1.0e3)

    connections = (
        connect(road, suspension.a),
        connect(suspension.b, body.flange),
        prescribed_flow(road),
    )


class Fed(Quarter):
    """The same on a damper that gives power."""

    suspension = SpringDamper(stiffness=1.0e4, damping=-1.0e3)


class Wheel(Component):
    """Something that is not in the quarter."""

    wheel = Mass(mass=30.0)


STEP = Scenario(name="step", stop=0.5, inputs={"road.flow": 0.1})  # pyright: ignore[reportArgumentType]


@cache
def quarter() -> CompiledModel:
    return compile_model(elaborate(Quarter()))


def claimed(step: float) -> Claim:
    """That a model is like itself."""
    return Claim(
        model=quarter().model,
        removals=(),
        conditions=(Condition(scenario=changed(STEP, stop=900.0), record_every=1.0, integrals_every=1.0),),
        outputs=(),
        tolerances={},
        stepping=Stepping(pm.Method.EULER, step),
    )


def nothing_found() -> object:
    search = pm.find_proper_model(
        quarter().model, STEP, {"body.flange.flow": pm.Tolerance(largest=1e-9)}, step=1e-3, most_simulations=1
    )
    return pm.certify(search)


@cache
def run() -> Trajectory:
    return simulate(quarter(), STEP, step=1e-3, record_every=0.05)


def with_scenario(**changes: object) -> object:
    return simulate(quarter(), changed(STEP, **changes), step=1e-3)  # pyright: ignore[reportArgumentType]


def not_recorded() -> object:
    return simulate(quarter(), STEP, step=1e-3, record=["body.flange.flow"])["suspension.spring.port.effort"]


def continued_elsewhere() -> object:
    other = compile_model(elaborate(Quarter()))
    return simulate(other, changed(STEP, stop=1.0), step=1e-3, continued_from=run())


class Drag(Resistance):
    """Turbulent drag: the force grows with the square of the speed."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    linear: Parameter = parameter("N.s/m", default=1.0)
    square: Parameter = parameter("N.s2/m2", default=1.0)

    def effort(self, flow: Expr) -> Expr:
        return flow * (self.linear + self.square * abs(flow))


class Rung(Component):
    """Drag to the next rung and to the ground."""

    a = Port(Translation)
    b = Port(Translation)
    along, across, ground = Drag(), Drag(), Fixed()
    connections = (connect(a, along.a), connect(b, along.b, across.a), connect(across.b, ground.flange))


class Ladder(Component):
    """Dampers without a mass between them."""

    end = Port(Translation)
    mass = Mass(mass=1.0)
    rungs = repeat(25, Rung())
    connections = (connect(mass.flange, rungs[0].a), *chain(rungs, "b", "a"), connect(rungs[24].b, end), free(end))


def without_sundials() -> object:
    # A module that is None cannot be imported.
    with patch.dict(sys.modules, {"sksundae.cvode": None}):
        return simulate(quarter(), STEP, method=pm.Method.CVODE)


def large_block() -> object:
    return simulate(compile_model(elaborate(Ladder())), Scenario(stop=0.1), method=pm.Method.ROS2)


class Rectified(Component):
    """A resistor behind an ideal diode."""

    source = ConstantVoltage(voltage=1.0)
    switch = IdealDiode()
    load = Resistor(resistance=1.0)
    ground = Ground()
    connections = (
        connect(source.p, switch.a),
        connect(switch.b, load.a),
        connect(source.n, load.b, ground.pin),
    )


def sensitivities_with_switches() -> object:
    compiled = compile_model(elaborate(Rectified()))
    return pm.sensitivities(compiled, Scenario(stop=0.1), parameters=["load.resistance"])


class Squared(SignalBlock):
    speed = Input("m/s")
    more = Output("m/s")

    def outputs(self):
        return {self.more: self.speed * self.speed / pm.quantity(1.0, "m/s") + pm.quantity(1.0, "m/s")}


class Unsolvable(Component):
    """A signal that is one more than its own square: no number is."""

    square = Squared()
    connections = (connect(square.more, square.speed),)


def not_converged() -> object:
    return simulate(compile_model(elaborate(Unsolvable())), Scenario(stop=0.1), step=1e-3)


class Relativistic(Inertia):
    """Momentum without bound, at speeds below that of light: given the speed, the law has an end."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", default=1.0)
    light: Parameter = parameter("m/s", default=1.0)

    def flow(self, momentum):
        ratio = momentum / (self.mass * self.light)
        return momentum / self.mass / pm.sqrt(1.0 + ratio * ratio)

    def momentum(self, flow):
        ratio = flow / self.light
        return self.mass * flow / pm.sqrt(1.0 - ratio * ratio)

    def energy(self, momentum):
        ratio = momentum / (self.mass * self.light)
        return self.mass * self.light**2.0 * (pm.sqrt(1.0 + ratio * ratio) - 1.0)


class Welded(Component):
    slow = Mass(mass=1.0)
    fast = Relativistic()
    connections = (connect(slow.flange, fast.flange),)


def too_fast() -> object:
    start = {"slow.momentum": 1.5, "fast.momentum": 0.0}  # 1.5 m/s, faster than light here
    return simulate(compile_model(elaborate(Welded())), Scenario(stop=0.1, initial=start), step=1e-3)  # pyright: ignore[reportArgumentType]


class PseudoHeat(Domain):
    name = "pseudo heat"
    effort, effort_unit = "temperature", "K"
    flow, flow_unit = "heat flow", "W"
    displacement_unit, momentum_unit = "J", "K.s"
    shared = pm.Thermal.shared
    is_true = False


class HeatSource(pm.EffortSource):
    """Grows warm with a force."""

    port = Port(PseudoHeat)
    force = pm.Input("N")

    def effort(self):
        return pm.quantity(20.0, "K") + pm.quantity(1.0, "K/N") * self.force


class Wall(Resistance):
    port = Port(PseudoHeat)
    resistance: Parameter = parameter("K/W", default=2.0)

    def effort(self, flow):
        return self.resistance * flow


class Warmed(Quarter):
    stove = HeatSource()
    wall = Wall()
    connections = (
        *Quarter.connections,
        connect(stove.port, wall.port),
        connect(Quarter.body.flange.effort, stove.force),
    )


def pseudo_bonds() -> object:
    return rank_activity(simulate(compile_model(elaborate(Warmed())), STEP, step=1e-3))


def unknown_domain() -> object:
    return rank_activity(simulate(compile_model(elaborate(Warmed())), STEP, step=1e-3), among="tru")


def at_rest() -> object:
    return rank_activity(simulate(quarter(), Scenario(stop=0.1), step=1e-3))


def part_that_listens() -> object:
    full = simulate(compile_model(elaborate(listener())), Scenario(stop=6.0), step=1e-3, record_every=3e-3)
    return pm.part_model(pm.partition(full, tolerance=0.05), 2)


def stopped() -> Trajectory:
    return simulate(quarter(), changed(STEP, stop=2000.0), step=0.5, method=pm.Method.EULER, record_every=1.0)


def incomplete_study() -> object:
    return run_study(quarter().model, changed(STEP, stop=2000.0), StudyOptions(step=0.5, method=pm.Method.EULER))


def planned(**options: object) -> pm.Reduction:
    ranking = rank_activity(run())
    return plan_reduction(quarter(), run(), ranking, **options)  # pyright: ignore[reportArgumentType]


def without(*removals: pm.Removal) -> object:
    return compile_model(quarter().model.without(removals))


class Throttle(Resistance):
    """Something whose force rises with the power 0.7 of the speed: its slope is infinite at rest."""

    flange = Port(Translation)

    def effort(self, flow: Expr) -> Expr:
        return pm.quantity(1.0, "N") * (abs(flow) / pm.quantity(1.0, "m/s")) ** 0.7


class Throttled(Quarter):
    """A quarter car with a throttle in which nothing ever moves."""

    still = ConstantVelocity(velocity=0.0)
    throttle = Throttle()
    skyhook = SpringDamper(stiffness=1.0, damping=1.0)
    connections = (
        *Quarter.connections,
        connect(still.flange, throttle.flange, skyhook.a),
        connect(skyhook.b, Quarter.body.flange),
    )


def infinite_slope() -> object:
    compiled = pm.compile_model(pm.elaborate(Throttled()))
    return pm.predict_errors(simulate(compiled, STEP, step=1e-3), ["body.flange.flow"])


class Coupling(MultiportResistance):
    """A field: two dampers that act on each other."""

    a = Port(Translation)
    b = Port(Translation)
    damping: Parameter = parameter("N.s/m", default=1.0)

    def laws(self):
        return (
            {
                self.a.effort: self.damping * (self.a.flow + 0.5 * self.b.flow),
                self.b.effort: self.damping * (self.b.flow + 0.5 * self.a.flow),
            },
        )


class Coupled(Component):
    one = Mass(mass=1.0)
    two = Mass(mass=1.0)
    field = Coupling()
    connections = (connect(one.flange, field.a), connect(two.flange, field.b))


def partial_field() -> object:
    return compile_model(elaborate(Coupled()).without([ConstantEffort(pm.Path(("field", "a")), 0.0)]))


class CoilPair(Component):
    """Two coils with a coupling of one."""

    coils = CoupledInductors(primary_inductance=4.0, secondary_inductance=1.0, mutual_inductance=2.0)
    first = Resistor(resistance=1.0)
    second = Resistor(resistance=1.0)
    ground = Ground()
    connections = (
        connect(coils.primary_a, first.a),
        connect(coils.secondary_a, second.a),
        connect(coils.primary_b, coils.secondary_b, first.b, second.b, ground.pin),
    )


def fully_coupled() -> object:
    return simulate(compile_model(elaborate(CoilPair())), Scenario(stop=1.0))


SPRING = pm.Path(("suspension", "spring", "port"))
BODY = pm.Path(("body", "flange"))

CASES = (
    Case(
        code="simulation/singular-field",
        run=fully_coupled,
        names=("coils", "primary and secondary", "mutual_inductance = 2 H"),
        at="coils = CoupledInductors(",
        cure="transformer",
    ),
    Case(code="simulation/window", run=lambda: with_scenario(stop=0.0), names=("step", "0"), cure="later stop"),
    Case(
        code="simulation/step",
        run=lambda: simulate(quarter(), STEP, step=0.0),
        names=("0.0 s",),
        cure="step well below",
    ),
    Case(
        code="simulation/tolerance",
        run=lambda: simulate(quarter(), STEP, tolerance=0.0),
        names=("0.0",),
        cure="share of each state",
    ),
    Case(
        code="simulation/nothing-to-plot",
        run=lambda: simulate(quarter(), STEP).plot(["body.flange.flow"] * 2, axes=[None]),
        names=("2 observables", "1 were given"),
        cure="axes that another plot",
    ),
    Case(
        code="simulation/sundials",
        run=without_sundials,
        names=("cvode", "not installed"),
        cure="pip install 'propermodel[sundials]'",
    ),
    Case(
        code="simulation/large-block",
        run=large_block,
        names=("25 unknowns", "rungs[1].along", "24"),
        cure="use rk4",
    ),
    Case(
        code="simulation/condition",
        run=lambda: simulate(quarter(), STEP, until="body.flange.flow <"),
        names=("body.flange.flow <", "a number or a name was expected"),
        cure="compare names of the model",
    ),
    Case(
        code="simulation/until",
        run=lambda: simulate(quarter(), STEP, until=Wheel().wheel.flange.flow > 1.0),
        names=("wheel.flange.flow",),
        cure="body.flange.flow",
    ),
    Case(
        code="simulation/unknown-parameter",
        run=lambda: with_scenario(parameters={"body.mas": 1.0}),
        names=("body.mas",),
        cure="did you mean 'body.mass'?",
    ),
    Case(
        code="simulation/parameter-range",
        run=lambda: with_scenario(parameters={"body.mass": float("nan")}),
        names=("body.mass", "nan"),
        cure="finite",
    ),
    Case(
        code="simulation/unknown-input",
        run=lambda: with_scenario(inputs={"road.flw": 1.0}),
        names=("road.flw", "step"),
        cure="did you mean 'road.flow'?",
    ),
    Case(
        code="simulation/unknown-initial",
        run=lambda: with_scenario(initial={"body.momentun": 1.0}),
        names=("body.momentun", "step"),
        cure="did you mean 'body.momentum'?",
    ),
    Case(
        code="simulation/table-shape",
        run=lambda: with_scenario(inputs={"road.flow": TableValues(((0.0, 1.0), (0.0, 1.0)), (0.0,) * 4)}),
        names=("road.flow", "1 coordinate"),
        cure="same kind of grid",
    ),
    Case(
        code="simulation/unknown-observable",
        run=lambda: run()["body.flange.flw"],
        names=("body.flange.flw",),
        cure="did you mean 'body.flange.flow'?",
    ),
    Case(
        code="simulation/not-recorded", run=not_recorded, names=("suspension.spring.port.effort",), cure="record=[...]"
    ),
    Case(
        code="simulation/unknown-bond",
        run=lambda: run().power_index(pm.Path(("body", "flang"))),
        names=("body.flang",),
        cure="did you mean 'body.flange'?",
    ),
    Case(
        code="simulation/not-finite",
        run=lambda: with_scenario(initial={"body.momentum": float("nan")}),
        names=("step", "body.momentum", "nan"),
        cure="finite start",
    ),
    Case(
        code="simulation/period",
        run=lambda: simulate(quarter(), STEP, step=1e-3, record_every=0.0),
        names=("0 s",),
        cure="record_every=",
    ),
    Case(
        code="simulation/record-to",
        run=lambda: simulate(quarter(), STEP, step=1e-3, record_to="nowhere/run.npz"),
        names=("nowhere/run.npz", "No such file"),
        cure="folder that exists",
    ),
    Case(code="simulation/not-converged", run=not_converged, names=("square", "0 s"), cure="laws around this loop"),
    Case(code="simulation/start", run=too_fast, names=("fast.momentum",), cure="starts that agree"),
    Case(code="simulation/continue", run=continued_elsewhere, cure="compile"),
    Case(code="activity/none", run=at_rest, names=("scenario",), cure="inputs"),
    Case(
        code="activity/unknown-domain",
        run=unknown_domain,
        names=("tru",),
        cure="did you mean 'true'?",
    ),
    Case(code="activity/pseudo-bonds", run=pseudo_bonds, names=("pseudo heat",), cure="entropy flow"),
    Case(
        code="activity/incomplete",
        run=lambda: rank_activity(stopped()),
        names=("stopped at", "suspension.spring.port"),
        cure="a smaller step",
    ),
    Case(
        code="activity/window",
        run=lambda: rank_activity(run(), windows=[(2.0, 1.0)]),
        names=("2 to 1 s",),
        cure="begin first",
    ),
    Case(
        code="activity/coarse",
        run=lambda: rank_activity(run(), windows=[(0.0, 0.2)]),
        names=("0.2 s", "every 0.5 s"),
        cure="integrals_every=0.2",
    ),
    Case(code="activity/runs", run=lambda: rank_activity([]), names=("0 runs",), cure="at least one run"),
    Case(
        code="activity/no-storage",
        run=lambda: pm.measure_about(quarter(), STEP, of=["bodi"]),
        names=("bodi",),
        cure="did you mean 'body'?",
    ),
    Case(
        code="activity/frequencies",
        run=lambda: pm.rank_frequencies(quarter(), STEP, [0.0, 1.0]),
        names=("frequencies",),
        cure="numpy.geomspace",
    ),
    Case(
        code="activity/spectrum",
        run=lambda: pm.rank_frequencies(quarter(), STEP, [1.0], spectrum={"road.flow": (1.0, 2.0)}),
        names=("road.flow",),
        cure="one for each frequency",
    ),
    Case(
        code="activity/unstable",
        run=lambda: pm.rank_frequencies(compile_model(elaborate(Fed())), STEP, [1.0]),
        names=("fed", "2 1/s"),
        cure="a stable point",
    ),
    Case(
        code="activity/unknown-row",
        run=lambda: rank_activity(run()).row(pm.Path(("bdy",))),
        names=("bdy",),
        cure="did you mean 'body'?",
    ),
    Case(
        code="activity/recorded",
        run=lambda: pm.rank_recorded(
            {"time_s": (0.0, 1.0, 2.0), "force [N]": (0.0, 1.0, 2.0)},
            {"spring": pm.RecordedElement(ports=(("force", "force"),))},
        ),
        names=("'force' in N",),
        cure="its own flow",
    ),
    Case(code="activity/reader", run=lambda: pm.rank_recorded("run.mat", {}), names=("run.mat",), cure=".parquet"),
    Case(
        code="reduction/cut",
        run=lambda: without(Cut(SPRING, Variable.EFFORT)),
        names=("suspension.spring.port", "effort", "1-junction"),
        at="spring = Spring(stiffness=stiffness)",
        cure="driven by its flow",
    ),
    Case(
        code="reduction/results-file",
        run=lambda: pm.find_proper_model(elaborate(Quarter()), STEP, {"body.flange.flow": 0.01}, results=__file__),
        names=("simulation_cases.py", "no file of a search"),
        cure="name another file",
    ),
    Case(
        code="reduction/no-element",
        run=lambda: without(ConstantEffort(pm.Path((*SPRING[:2], "difference_ring2", "carried")), 0.0)),
        names=("suspension.spring.difference_ring2.carried",),
        cure="the bond of an element",
    ),
    Case(
        code="simulation/designs",
        run=lambda: pm.designs(pm.Scenario(), {"body.mass": [1.0, 2.0], "tyre.stiffness": [1.0, 2.0, 3.0]}),
        names=("2 of body.mass", "3 of tyre.stiffness"),
        cure="one value for each design",
    ),
    Case(
        code="simulation/sensitivities",
        run=sensitivities_with_switches,
        names=("ideal switches", "switch"),
        cure="differences of two runs",
    ),
    Case(code="reduction/threshold", run=lambda: planned(threshold=99.0), names=("99",), cure="0.99"),
    Case(
        code="reduction/unknown-output",
        run=lambda: planned(protected=["body.flange.flw"]),
        names=("body.flange.flw",),
        cure="did you mean 'body.flange.flow'?",
    ),
    Case(
        code="reduction/merge",
        run=lambda: without(pm.Merge(SPRING, pm.Path(("body", "flange")))),
        names=("suspension.spring.port", "body.flange"),
        at="spring",
        cure="find_merges",
    ),
    Case(
        code="reduction/part-signals",
        run=part_that_listens,
        names=("part 2", "mass"),
        cure="with all cuts",
    ),
    Case(
        code="reduction/runs",
        run=lambda: plan_reduction(quarter(), [], rank_activity(run())),
        names=("quarter",),
        cure="the runs through several scenarios",
    ),
    Case(
        code="reduction/unknown-row",
        run=lambda: planned().explain("bodi"),
        names=("bodi",),
        cure="did you mean 'body'?",
    ),
    Case(code="reduction/prediction", run=infinite_slope, names=("throttle",), cure="by simulation"),
    Case(
        code="reduction/tolerances",
        run=lambda: pm.find_proper_model(elaborate(Quarter()), STEP, {}),
        names=("a scenario", "tolerances"),
        cure="find_proper_model(model, scenario,",
    ),
    Case(
        code="reduction/tolerance",
        run=lambda: pm.find_proper_model(elaborate(Quarter()), STEP, {"body.flange.flow": 0.0}),
        names=("above zero",),
        cure="Tolerance(final=0.01)",
    ),
    Case(
        code="reduction/not-recovered",
        run=lambda: simulate(
            compile_model(quarter().model.without([ZeroEffort(SPRING)])), STEP, step=1e-3, record_every=0.05
        )["suspension.spring.energy"],
        names=("suspension.spring.energy", "no effort at suspension.spring.port"),
        cure="suspension.spring.port.flow",
    ),
    Case(
        code="reduction/nothing-found",
        run=nothing_found,
        names=("quarter",),
        cure="certify(search, candidate)",
    ),
    Case(
        code="reduction/ranges",
        run=lambda: ranges_of(claimed(step=1e-3), {"suspension.spring.stifness": 0.1}),
        names=("suspension.spring.stifness",),
        cure="did you mean 'suspension.spring.stiffness'?",
    ),
    Case(
        code="reduction/incomplete",
        run=lambda: claimed(step=0.3).pairs(),
        names=("quarter", "step"),
        cure="with the step",
    ),
    Case(
        code="reduction/undefined-feature",
        run=lambda: pm.find_proper_model(elaborate(Quarter()), STEP, {"body.flange.flow": pm.Tolerance(settling=0.1)}),
        names=("body.flange.flow", "settling", "still moves when the run ends"),
        cure="another feature",
    ),
    Case(
        code="reduction/constant-output",
        run=lambda: pm.predict_errors(run(), ["body.flange.flow", "road.flow"]),
        names=("road.flow",),
        cure="an output that moves",
    ),
    Case(
        code="reduction/unknown-removal",
        run=lambda: without(ZeroEffort(pm.Path(("suspension", "spring", "prt")))),
        names=("suspension.spring.prt",),
        cure="did you mean 'suspension.spring.port'?",
    ),
    Case(
        code="reduction/removed-twice",
        run=lambda: without(ZeroEffort(SPRING), ZeroFlow(SPRING)),
        names=("suspension.spring.port", "2 times"),
        cure="keep one",
    ),
    Case(
        code="reduction/partial-field",
        run=partial_field,
        names=("field", "field.b"),
        at="field = Coupling()",
        cure="every port of a field",
    ),
    Case(code="study/incomplete", run=incomplete_study, names=("suspension.spring.port",), cure="smaller step"),
)
