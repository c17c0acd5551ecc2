"""`python -m benchmarks.reduction_figures`: the pictures of `docs/reduction.md`, from the models of its tests.

Every panel runs a full model, what plain MORA leaves of it, and what is kept here.
"""
# pyright: basic

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from propermodel.analysis.activity import rank_activity
from propermodel.compiler import Method, compile_model
from propermodel.diagnostics import parse_path
from propermodel.library.vehicle.mission import GRADE, mission
from propermodel.library.vehicle.world_frame import HybridTruckInWorldFrame
from propermodel.modelling import ZeroEffort, ZeroFlow, elaborate
from propermodel.modelling.model import TableValues
from propermodel.reduction.partition import partition
from propermodel.reduction.plan import plan_reduction
from propermodel.report.figures import BLUE, DARK, GREEN, GREY, VERMILION
from propermodel.simulation.simulate import simulate
from tests.physics.systems import run
from tests.reduction.failure_modes.plain import plain_mora
from tests.reduction.failure_modes.test_conventions import carried
from tests.reduction.failure_modes.test_time_and_scenarios import SPEED, SPINNING, controlled, flywheel
from tests.reduction.rigs import preloaded, quarter_car
from tests.reduction.test_partition import OUTPUTS, passenger

IMAGES = Path(__file__).parents[1] / "docs" / "images"
FULL = {"color": DARK, "lw": 2.6, "alpha": 0.35, "label": "full"}
PLAIN = {"color": VERMILION, "lw": 1.1, "label": "plain MORA"}
OURS = {"color": BLUE, "lw": 1.1, "ls": "--", "label": "kept here"}
# Legends stand on what is drawn, and must be read all the same.
LEGEND = {"framealpha": 0.85, "edgecolor": "none"}


def main() -> None:
    """Draw all pictures."""
    plt.rcParams.update({"font.size": 8.5, "axes.titlesize": 9, "axes.titlelocation": "left"})
    plt.rcParams.update(
        {"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#E2E2E2"}
    )
    failure_modes()
    parts()


def failure_modes() -> None:
    """Six panels of `reduction_failure_modes.png`."""
    figure, axes = plt.subplots(3, 2, figsize=(8.6, 8.4), layout="constrained")
    preload(axes[0, 0])
    which_zero(axes[0, 1])
    stability(axes[1, 0])
    drift(axes[1, 1])
    frames(axes[2, 0])
    hill(axes[2, 1])
    figure.savefig(IMAGES / "reduction_failure_modes.png", dpi=110)


def preload(axes) -> None:
    """A body that stands on a spring without moving."""
    full = run(preloaded(), 2.0, step=5e-4, every=2e-3)
    model = full.compiled.model
    reduction = plan_reduction(full.compiled, full, rank_activity(full), threshold=0.95, tolerance=0.2)
    axes.plot(full.time, full["body.flange.flow"], **FULL)
    plain = run(model.without(plain_mora(full, 0.95)), 2.0, step=5e-4, every=2e-3)
    axes.plot(plain.time, plain["body.flange.flow"], **PLAIN)
    ours = run(model.without(reduction.removals), 2.0, step=5e-4, every=2e-3)
    axes.plot(ours.time, ours["body.flange.flow"], **OURS)
    axes.set(title="1  A preload does no work", xlabel="s", ylabel="velocity of the body, m/s")
    axes.legend(**LEGEND)


def which_zero(axes) -> None:
    """The body of a car at 10 Hz: the element is idle, but not every replacement is."""
    full = run(quarter_car(0.3, 10.0), 2.0, step=2e-4, every=1e-3)
    model, output = full.compiled.model, "tyre.a.effort"
    last = full.time > 1.7
    axes.plot(full.time[last], full[output][last] / 1e3, **FULL)
    for removal, style in (
        (ZeroEffort(parse_path("body.flange")), {**PLAIN, "label": "without its mass (no effort)"}),
        (ZeroFlow(parse_path("body.flange")), {**OURS, "label": "held (no flow)"}),
    ):
        r = run(model.without([removal]), 2.0, step=2e-4, every=1e-3)
        axes.plot(r.time[last], r[output][last] / 1e3, **style)
    axes.set(title="Which zero? A body with 0.3 % of the activity", xlabel="s", ylabel="force of the tyre, kN")
    axes.legend(**LEGEND, loc="lower left", fontsize=7.5)


def stability(axes) -> None:
    """A stiff link between a force and the velocity that it brakes."""
    full = run(controlled(at_far_mass=True), 1.8, step=5e-5, every=5e-4)
    rigid = run(full.compiled.model.without(plain_mora(full)), 1.8, step=5e-4, every=5e-4)
    output = "far.flange.flow"
    axes.plot(full.time, full[output], **{**FULL, "lw": 0.7, "alpha": 0.8, "label": "full"})
    axes.plot(rigid.time, rigid[output], **{**PLAIN, "label": "plain MORA: rigid link"})
    axes.set(title="3  A stiff link that destabilises: refused", xlabel="s", ylabel="velocity, m/s")
    axes.legend(**LEGEND)


def drift(axes) -> None:
    """A bearing that stops a wheel within hours."""
    hours = run(flywheel(1e-3), 7200.0, step=5e-2, every=20.37, initial=SPINNING)
    free = run(
        hours.compiled.model.without([ZeroEffort(parse_path("bearing.shaft"))]),
        7200.0,
        step=5e-2,
        every=20.37,
        initial=SPINNING,
    )
    width = 25
    for r, style in ((hours, FULL), (free, PLAIN)):
        smooth = np.convolve(r[SPEED], np.ones(width) / width, mode="valid")
        axes.plot(r.time[width // 2 : -(width // 2)] / 3600.0, smooth, **style)
    axes.axvspan(0.0, 20.0 / 3600.0, color=GREEN, alpha=0.6, label="the window of the ranking")
    axes.set(
        title="5  Slow drift: told, with its time constant", xlabel="h", ylabel="mean speed, rad/s", ylim=(0, None)
    )
    axes.legend(**LEGEND)


def frames(axes) -> None:
    """Shares of activity of the same masses in two frames."""
    rankings = [rank_activity(run(elaborate(carried(v)), 3.0, step=5e-4, every=1.5e-3)) for v in (0.0, 200.0)]
    rows = ["wheel", "body", "tyre.spring", "tyre.damper", "suspension.spring", "suspension.damper"]
    places = np.arange(len(rows))
    for shift, ranking, color, label in (
        (-0.2, rankings[0], BLUE, "at rest"),
        (0.2, rankings[1], VERMILION, "at 200 m/s"),
    ):
        shares = [100.0 * ranking.row(parse_path(row)).index for row in rows]
        axes.barh(places + shift, shares, height=0.38, color=color, label=f"frame {label}")
    axes.set(title="9  The frame decides what masses do", xlabel="share of activity, %", xscale="log", yticks=places)
    axes.set_yticklabels(rows)
    axes.invert_yaxis()
    axes.set_xlim(right=3e4)  # room for the legend
    axes.legend(loc="center right", **LEGEND)


def hill(axes) -> None:
    """The truck in a world frame on a hill of 6 %."""
    start = mission("fmtv_mixed", until=25.0)
    grade = TableValues(((-1e3, 15.0, 30.0, 1e6),), (0.0, 0.0, 0.06, 0.06))
    scenario = replace(start, tables={**start.tables, GRADE: grade})
    truck = compile_model(elaborate(HybridTruckInWorldFrame()))
    axles = ("front_axle", "rear_front_axle", "rear_rear_axle")
    held = [ZeroFlow(parse_path("chassis.body.vertical_mass.flange"))]
    massless = [ZeroEffort(parse_path(f"chassis.{axle}.vertical_mass.flange")) for axle in axles]
    for removals, style in (
        ([], FULL),
        (held, {**PLAIN, "label": "without vertical motion"}),
        (massless, {**OURS, "label": "axles without mass"}),
    ):
        model = compile_model(truck.model.without(removals))
        r = simulate(model, scenario, method=Method.SEMI_IMPLICIT, step=2e-4, record_every=0.05)
        axes.plot(r.time, r["chassis.speed"], **style)
    axes.set(title="Hills through the tyres: a truck before 6 %", xlabel="s", ylabel="speed, m/s")
    axes.legend(**LEGEND)


def parts() -> None:
    """Error of every cut against what its junction misses: `reduction_parts.png`."""
    figure, axes = plt.subplots(1, 2, figsize=(8.6, 3.2), layout="constrained")
    shares, errors, together = [], [], []
    masses = np.geomspace(0.005, 0.6, 9)
    for mass in masses:
        full = run(passenger(mass), 6.0, step=1e-3, every=3e-3)
        found = partition(full, tolerance=0.3, outputs=OUTPUTS)
        cut = next((cut for cut in found.cuts if cut.driving == 1), None)
        if cut is not None and cut.error is not None and found.comparison is not None:
            shares.append(cut.share)
            errors.append(cut.error)
            together.append(mass / 5.0)
    axes[0].loglog(
        100.0 * np.array(together), 100.0 * np.array(shares), "o-", color=GREY, label="left out at the junction"
    )
    axes[0].loglog(100.0 * np.array(together), 100.0 * np.array(errors), "s-", color=BLUE, label="error of the outputs")
    axes[0].set(title="A passenger on an oscillator, cut one way", xlabel="its mass, % of its carrier's", ylabel="%")
    axes[0].legend(**LEGEND)
    full = run(quarter_car(0.3, 10.0), 2.0, step=5e-4, every=1e-3)
    found = partition(full, tolerance=0.05)
    cut = run(full.compiled.model.without(found.removals), 2.0, step=5e-4, every=1e-3)
    last = full.time > 1.5
    axes[1].plot(full.time[last], full["body.flange.effort"][last], **FULL)
    axes[1].plot(cut.time[last], cut["body.flange.effort"][last], **{**OURS, "label": "body driven one way"})
    axes[1].set(title="A driven body keeps its output", xlabel="s", ylabel="force on the body, N")
    axes[1].legend(**LEGEND)
    figure.savefig(IMAGES / "reduction_parts.png", dpi=110)


if __name__ == "__main__":
    main()
