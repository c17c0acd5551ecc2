"""Faults in reductions and studies."""

from __future__ import annotations

from dataclasses import replace as changed

import propermodel as pm
from propermodel import (
    Component,
    ConstantEffort,
    Cut,
    Expr,
    MultiportResistance,
    Parameter,
    Port,
    Resistance,
    Scenario,
    StudyOptions,
    Translation,
    ZeroEffort,
    ZeroFlow,
    compile_model,
    connect,
    elaborate,
    parameter,
    plan_reduction,
    rank_activity,
    run_study,
    simulate,
)
from propermodel.library.mechanics.translation import ConstantVelocity
from propermodel.modelling.model import Variable
from propermodel.reduction.claim import Claim, Condition
from propermodel.reduction.ranges import ranges_of
from propermodel.simulation.stepping import Stepping
from tests.faults.case import Case
from tests.faults.quarter import STEP, Quarter, quarter, run
from tests.parts import Mass, SpringDamper
from tests.reduction.rigs import listener


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


def part_that_listens() -> object:
    full = simulate(compile_model(elaborate(listener())), Scenario(stop=6.0), step=1e-3, record_every=3e-3)
    return pm.part_model(pm.partition(full, tolerance=0.05), 2)


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


SPRING = pm.Path(("suspension", "spring", "port"))


CASES = (
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
        names=("reduction_cases.py", "no file of a search"),
        cure="name another file",
    ),
    Case(
        code="reduction/no-element",
        run=lambda: without(ConstantEffort(pm.Path((*SPRING[:2], "difference_ring2", "carried")), 0.0)),
        names=("suspension.spring.difference_ring2.carried",),
        cure="the bond of an element",
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
