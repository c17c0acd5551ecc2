"""`python -m benchmarks.sensitivity`: how much the widths that smooth the truck's laws decide its answers.

The hybrid truck drives the first 700 s of the mixed mission (the city and half a minute of highway) with each width
halved and doubled, all else as declared. A run is compared with the reference at its own step, so that a difference is
that of the width alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

from propermodel import ActivityRanking, CompiledModel, Path, compile_model, elaborate, rank_activity, simulate
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck

FUEL = "engine.fuel_meter.mass"
USUAL, FINE, FINEST = 2e-4, 1e-4, 5e-5  # steps, s


@dataclass(frozen=True, slots=True)
class Trial:
    """A value of a width, with a step below its limit of stability."""

    value: float
    step: float = USUAL


@dataclass(frozen=True, slots=True)
class Width:
    """A width: what it smooths, a pattern of the parameters that hold it, its default and what is tried."""

    name: str
    pattern: str
    default: float
    unit: str
    trials: tuple[Trial, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """What a run gives: fuel in kg, and the ranking."""

    fuel: float
    ranking: ActivityRanking


# Slip and dry brakes make the fastest eigenvalue at a stand, a slipping clutch that in second gear: where one of their
# widths is halved the eigenvalue about doubles, and the step must follow.
WIDTHS = (
    Width(
        "slip speed floor v_s0",
        "chassis.*_axle.tyre.slip.speed_floor",
        1.0,
        "m/s",
        (Trial(0.3, FINEST), Trial(0.5, FINE), Trial(2.0)),
    ),
    Width("dry brake w_b", "chassis.*_axle.brake.lining.width", 0.1, "rad/s", (Trial(0.05, FINE), Trial(0.2))),
    Width("rolling resistance v_rr", "chassis.*_axle.tyre.rolling.width", 0.1, "m/s", (Trial(0.05), Trial(0.2))),
    Width("loss of all gears P_0", "*.loss.width", 100.0, "W", (Trial(50.0), Trial(200.0))),
    Width("lock-up clutch", "converter.clutch.width", 2.0, "rad/s", (Trial(1.0, FINE), Trial(4.0))),
    Width("charging pump", "charging_pump.width", 1.0, "rad/s", (Trial(0.5), Trial(2.0))),
    Width("isolation of the unit s_0", "hydraulics.*.isolation_width", 0.02, "", (Trial(0.01), Trial(0.04))),
    Width(
        "friction of the unit w_PM", "hydraulics.pump_motor.torque_loss.width", 1.0, "rad/s", (Trial(0.5), Trial(2.0))
    ),
    # No widths, but thresholds and gains of rules that act where a law is smoothed.
    Width("closing slip", "transmission_control.closing_slip", 0.3, "rad/s", (Trial(0.15), Trial(0.6), Trial(2.0))),
    Width("idle governor k_id", "engine.injection.idle_gain", 60.0, "N m s/rad", (Trial(30.0), Trial(120.0))),
)


def drive(truck: CompiledModel, until: float, step: float, parameters: Mapping[Path, float] | None = None) -> Answer:
    """Drive the start of the mission with some parameters changed."""
    scenario = replace(mission("fmtv_mixed", until=until), parameters=parameters or {})
    run = simulate(truck, scenario, step=step, record=[])
    return Answer(run.at_end(FUEL), rank_activity(run))


def changed(truck: CompiledModel, width: Width, value: float) -> dict[Path, float]:
    """The value for all parameters that hold a width."""
    return {path: value for path in truck.graph.parameters if fnmatchcase(str(path), width.pattern)}


def largest_change(ranking: ActivityRanking, reference: ActivityRanking) -> tuple[float, Path]:
    """The largest change of an index, in points, and its row."""
    changes = [(100.0 * (row.index - reference.row(row.path).index), row.path) for row in ranking.rows]
    return max(changes, key=lambda change: abs(change[0]))


def line(width: Width, trial: Trial, answer: Answer, reference: Answer) -> str:
    """A row of the table."""
    points, row = largest_change(answer.ranking, reference.ranking)
    fuel = 100.0 * (answer.fuel / reference.fuel - 1.0)
    total = 100.0 * (answer.ranking.total / reference.ranking.total - 1.0)
    default = f"{width.default:g} {width.unit}".strip()
    return (
        f"| {width.name} | `{width.pattern}` | {default} | {trial.value:g} | {1e3 * trial.step:g} "
        f"| {fuel:+.3f} | {points:+.3f} ({row}) | {total:+.3f} |"
    )


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--until", type=float, default=700.0, help="end of the drive, s (default: 700)")
    until: float = options.parse_args().until
    truck = compile_model(elaborate(HybridTruck()))
    references = {step: drive(truck, until, step) for step in (USUAL, FINE, FINEST)}
    for step, answer in references.items():
        print(f"step {1e3 * step:g} ms: fuel {answer.fuel:.6f} kg, activity {1e-6 * answer.ranking.total:.5f} MJ")
    print("\n| width | parameter | default | tried | step, ms | fuel, % | largest change of an index | activity, % |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for width in WIDTHS:
        for trial in width.trials:
            answer = drive(truck, until, trial.step, changed(truck, width, trial.value))
            print(line(width, trial, answer, references[trial.step]), flush=True)


if __name__ == "__main__":
    main()
