"""Faults in rankings."""

from __future__ import annotations

from dataclasses import replace as changed

import propermodel as pm
from propermodel import (
    Domain,
    Parameter,
    Port,
    Resistance,
    Scenario,
    Trajectory,
    compile_model,
    connect,
    elaborate,
    parameter,
    rank_activity,
    simulate,
)
from tests.faults.case import Case
from tests.faults.quarter import STEP, Quarter, quarter, run
from tests.parts import SpringDamper


class Fed(Quarter):
    """The same on a damper that gives power."""

    suspension = SpringDamper(stiffness=1.0e4, damping=-1.0e3)


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


def stopped() -> Trajectory:
    return simulate(quarter(), changed(STEP, stop=2000.0), step=0.5, method=pm.Method.EULER, record_every=1.0)


CASES = (
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
)
