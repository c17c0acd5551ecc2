"""A reduction in a worker: planned on a recorded run, its model run beside it, certified and written as a page."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.comparison import compare
from propermodel.catalogue.named import NAMED_MODELS
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import Path, parse_path
from propermodel.reduction.certificate_files import write_certificate
from propermodel.reduction.claim import Condition
from propermodel.reduction.fitting import fitting_scenario
from propermodel.reduction.plan import Reduction, plan_reduction
from propermodel.report.certify import certify_reduction
from propermodel.report.page import write_page
from propermodel.report.page_data import PageSubject, page_data
from propermodel.report.panels import Panel
from propermodel.report.plain import finite
from propermodel.report.run_data import Fate
from propermodel.report.speed import measure_speed
from propermodel.report.study import most_active
from propermodel.simulation.reopening import reopened
from propermodel.simulation.simulate import simulate
from propermodel.simulation.storage import load_trajectory
from propermodel.simulation.trajectory import Trajectory
from propermodel.studio.orders import REDUCTION_ORDER, ReductionOrder, read_order_data
from propermodel.studio.run_task import result_of, teller
from propermodel.studio.store import PAGE_FILE, REPORT_FILE, RUN_FILE
from propermodel.studio.worker import Control

Json = Any
Window = tuple[float, float]

REPEATS = 3  # of each model, to measure how much faster the reduced one is


@dataclass(frozen=True)
class _Shown:
    """What a named model has beside its equations: totals and panels."""

    totals: Mapping[str, Path] = field(default_factory=dict[str, Path])
    panels: tuple[Panel, ...] = ()


def reduce(arguments: Json, control: Control) -> Json:
    """Make the reduction that was ordered.

    Raises:
        ProperModelError: it cannot be made as it was ordered.
    """
    order = read_order_data(REDUCTION_ORDER, arguments["order"])
    folder = FilePath(arguments["folder"])
    control.say({"stage": "opening the full run"})
    full = reopened(load_trajectory(FilePath(arguments["full"]) / RUN_FILE))
    outputs = tuple(parse_path(text) for text in arguments["outputs"])
    shown = _shown(arguments["model"])
    window = _window(full, order)
    control.say({"stage": "planning"})
    ranking = rank_activity(full, window=window)
    reduction = plan_reduction(
        full.compiled,
        full,
        ranking,
        threshold=order.threshold,
        protected=tuple(dict.fromkeys((*outputs, *shown.totals.values()))),
        keep=order.keep,
        release=order.go,
    )
    reduced_model = compile_quietly(full.compiled.model.without(reduction.removals))
    condition = _condition(full)
    reduced = simulate(
        reduced_model,
        fitting_scenario(reduced_model, full.scenario),
        method=full.method,
        step=full.step,
        jacobian_every=full.jacobian_every,
        tolerance=full.tolerance,
        record_every=condition.record_every,
        integrals_every=condition.integrals_every,
        record_to=folder / RUN_FILE,
        progress=teller(control, "running the reduced model"),
    )
    compared = tuple(path for path in outputs if path in full and path in reduced)
    compared = compared or most_active(ranking, full, reduced)
    if not reduced.ending.is_complete:
        return result_of(reduced, compared)
    control.say({"stage": "certifying"})
    certified = certify_reduction(reduction, full, reduced, condition, compared, window)
    write_certificate(certified, folder)
    control.say({"stage": "measuring speed"})
    speed = measure_speed(full, reduced, compared, REPEATS)
    page = page_data(
        PageSubject(
            certificate=certified.certificate,
            full=full,
            reduced=reduced,
            ranking=ranking,
            fates={d.row.path: Fate(d.verdict.value, d.meaning, d.reason) for d in reduction.decisions},
            threshold=order.threshold,
            outputs=compared,
            totals=shown.totals,
            panels=shown.panels,
            facts=(("faster", f"{speed.ratio:.2f} times", "same method and step"),),
            notes=reduction.notes,
            removals=reduction.removals,
        )
    )
    write_page(page, folder / REPORT_FILE)
    text = json.dumps(finite(page), allow_nan=False, separators=(",", ":"))
    (folder / PAGE_FILE).write_text(text, encoding="utf-8")
    return {**result_of(reduced, compared), "summary": _summary(reduction, full, reduced, compared, page["facts"])}


def _window(full: Trajectory, order: ReductionOrder) -> Window | None:
    """The window that was ordered, its ends moved to where integrals were kept; None for the whole run."""
    times = full.integral_times
    begin = times[0] if order.begin is None else times[int(np.argmin(np.abs(times - order.begin)))]
    end = times[-1] if order.end is None else times[int(np.argmin(np.abs(times - order.end)))]
    return None if (begin, end) == (times[0], times[-1]) else (float(begin), float(end))


def _condition(full: Trajectory) -> Condition:
    """How the full run was recorded: with equal periods, as the studio makes them."""
    return Condition(
        scenario=full.scenario,
        record_every=_period(full, full.time),
        integrals_every=_period(full, full.integral_times),
    )


def _period(full: Trajectory, times: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """The period of rows, without those that events have added."""
    length = full.ending.time - full.scenario.start
    steps = np.diff(times)
    usual = float(np.median(steps[steps > 0.0]))
    return length / max(1, round(length / usual))


def _shown(model: str) -> _Shown:
    entry = NAMED_MODELS.get(model)
    if entry is None:
        return _Shown()
    return _Shown({name: parse_path(path) for name, path in entry.totals.items()}, entry.panels)


def _summary(
    reduction: Reduction, full: Trajectory, reduced: Trajectory, compared: tuple[Path, ...], facts: list[Json]
) -> list[Json]:
    """What is told of a reduction in a list: the facts of its page, and the error of every output."""
    errors = compare(full, reduced, compared).outputs
    return [
        {"name": "rows gone", "value": f"{len(reduction.removed)} of {len(reduction.decisions)}", "note": ""},
        *facts,
        *({"name": str(e.path), "value": f"{e.rms:.2%}", "note": "rms / range"} for e in errors),
    ]
