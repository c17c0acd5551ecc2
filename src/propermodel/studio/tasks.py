"""What a worker can be asked to do."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path as FilePath
from typing import Any

from propermodel.catalogue.finding import load_subject, scenario_names
from propermodel.compiler import compile_quietly
from propermodel.diagnostics import parse_path
from propermodel.equations.readable import state_equations
from propermodel.report.plain import finite
from propermodel.studio.model_sheet import model_sheet
from propermodel.studio.orders import REDUCTION_ORDER, RUN_ORDER, read_order_data
from propermodel.studio.run_task import run
from propermodel.studio.scenario_sheet import scenario_sheet
from propermodel.studio.script import Steps, script
from propermodel.studio.worker import Control

Json = Any


def do(task: str, arguments: Json, control: Control) -> bytes:
    """Do a task and give its answer as JSON.

    Raises:
        ProperModelError: what was asked for cannot be done.
    """
    return json.dumps(finite(TASKS[task](arguments, control)), allow_nan=False, separators=(",", ":")).encode()


def _model(arguments: Json, _: Control) -> Json:
    text = arguments["model"]
    subject = load_subject(text)
    return {"sheet": model_sheet(text, subject, scenario_names(text)), "files": _files()}


def _equations(arguments: Json, _: Control) -> Json:
    lines = state_equations(compile_quietly(load_subject(arguments["model"]).model)).text().splitlines()
    return {"sheet": {"lines": lines}, "files": _files()}


def _scenario(arguments: Json, _: Control) -> Json:
    return {"sheet": scenario_sheet(load_subject(arguments["model"], arguments["scenario"])), "files": _files()}


def _files() -> list[str]:
    """The Python files of the folder that were run: an answer holds until one of them changes."""
    root = FilePath.cwd()
    files = {FilePath(f) for m in list(sys.modules.values()) if (f := getattr(m, "__file__", None)) is not None}
    return sorted(str(file) for file in files if file.is_relative_to(root))


def _script(arguments: Json, _: Control) -> Json:
    reduction = arguments["reduction"]
    steps = Steps(
        is_run=arguments["is_run"],
        plotted=tuple(map(parse_path, arguments["signals"])),
        threshold=arguments["threshold"],
        reduction=None if reduction is None else read_order_data(REDUCTION_ORDER, reduction),
        outputs=tuple(map(parse_path, arguments["outputs"])),
    )
    return {"sheet": script(read_order_data(RUN_ORDER, arguments["order"]), steps), "files": _files()}


def _activity(arguments: Json, control: Control) -> Json:
    from propermodel.studio.activity_task import activity

    return activity(arguments, control)


def _compare(arguments: Json, control: Control) -> Json:
    from propermodel.studio.activity_task import compare

    return compare(arguments, control)


def _reduce(arguments: Json, control: Control) -> Json:
    from propermodel.studio.reduce_task import reduce

    return reduce(arguments, control)


# What reduces imports much more than what runs, so it is imported where it is asked for.
TASKS: Mapping[str, Callable[[Json, Control], Json]] = {
    "model": _model,
    "equations": _equations,
    "scenario": _scenario,
    "run": run,
    "script": _script,
    "activity": _activity,
    "compare": _compare,
    "reduce": _reduce,
}
