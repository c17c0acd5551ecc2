"""The Python that does what a page did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from propermodel.catalogue.named import NAMED_MODELS, Target
from propermodel.catalogue.subject import Subject
from propermodel.compiler import Method
from propermodel.diagnostics import Path
from propermodel.simulation.choosing import AUTO, Choice
from propermodel.studio.orders import ReductionOrder, RunOrder
from propermodel.studio.run_task import Periods, ordered_subject, periods_of

Json = Any


def script(order: RunOrder, reduction: ReductionOrder | None, outputs: tuple[Path, ...], *, is_run: bool) -> str:
    """A script that opens a model, and runs and reduces it as a job did.

    Args:
        order: The model and its run.
        reduction: The reduction of that run, if there is one.
        outputs: What the reduction protects and compares.
        is_run: Whether the model is run, or only compiled.

    Raises:
        ProperModelError: the order does not fit the model.
    """
    subject = ordered_subject(order)
    periods = periods_of(subject)
    imports, opened = _opening(order)
    lines = [*opened, *_changes(subject, order), "", "compiled = pm.compile_model(model)"]
    if is_run:
        lines += [f"run = {_simulation('compiled', 'scenario', subject, periods)}", "print(run)"]
    else:
        lines.append("print(pm.state_equations(compiled).text())")
    if reduction is not None:
        imports.add("from propermodel.reduction.fitting import fitting_scenario")
        lines += ["", *_reduction(reduction, outputs, subject, periods)]
    if any(line.startswith("scenario = replace(") for line in lines):
        imports.add("from dataclasses import replace")
    imports.add("import propermodel as pm")
    order_of = sorted(imports, key=lambda line: ("propermodel" in line, line.startswith("from propermodel"), line))
    standard = [line for line in order_of if "propermodel" not in line]
    own = [line for line in order_of if "propermodel" in line]
    head = f'"""{subject.name}, as the studio has it; run it in the folder that the studio serves."""'
    return "\n".join([head, "", *standard, *([""] if standard else []), *own, "", *lines]) + "\n"


def _opening(order: RunOrder) -> tuple[set[str], list[str]]:
    """Imports and lines that make `model` and `scenario`."""
    if order.model in NAMED_MODELS:
        entry = NAMED_MODELS[order.model]
        names = entry.scenarios
        if not order.scenario or order.scenario in names:
            given = names[order.scenario] if order.scenario else next(iter(names.values()))
            lines = [f"model = pm.elaborate({_call(entry.component)})", f"scenario = {_call(given)}"]
            return {_import(entry.component), _import(given)}, lines
    if order.model.endswith(".json") and order.scenario.endswith((".json", "")) and ":" not in order.scenario:
        scenario = f"pm.read_scenario({order.scenario!r})" if order.scenario else "pm.Scenario()"
        return set(), [f"model = pm.read_model({order.model!r})", f"scenario = {scenario}"]
    named = repr(order.model) + (f", {order.scenario!r}" if order.scenario else "")
    lines = [f"subject = load_subject({named})", "model, scenario = subject.model, subject.scenario"]
    return {"from propermodel.catalogue.finding import load_subject"}, lines


def _import(target: Target) -> str:
    return f"from {target.module} import {target.name}"


def _call(target: Target) -> str:
    return f"{target.name}({', '.join(map(repr, target.arguments))})"


def _changes(subject: Subject, order: RunOrder) -> list[str]:
    """What is changed of the scenario: its end, and parameters in SI."""
    changes = [] if order.until is None else [f"stop={order.until!r}"]
    if order.settings:
        values: Mapping[Path, float] = subject.scenario.parameters
        pairs = ", ".join(f"{str(path)!r}: {values[path]!r}" for path in order.settings)
        changes.append(f"parameters={{**scenario.parameters, {pairs}}}")
    return [f"scenario = replace(scenario, {', '.join(changes)})"] if changes else []


def _simulation(compiled: str, scenario: str, subject: Subject, periods: Periods) -> str:
    words = [compiled, scenario, f"method={_method(subject.method)}"]
    if subject.step is not None:
        words.append(f"step={subject.step!r}")
    if subject.method == AUTO or subject.method.is_adaptive:
        words.append(f"tolerance={subject.tolerance!r}")
    words += [f"record_every={periods.rows!r}", f"integrals_every={periods.integrals!r}"]
    return "pm.simulate(\n    " + ",\n    ".join(words) + ",\n)"


def _method(method: Choice) -> str:
    return f"pm.Method.{method.name}" if isinstance(method, Method) else repr(method)


def _window(order: ReductionOrder, subject: Subject, periods: Periods) -> tuple[float, float]:
    """The window, its ends moved to where integrals of power are kept."""
    start, stop = subject.scenario.start, subject.scenario.stop

    def moved(instant: float | None, otherwise: float) -> float:
        if instant is None:
            return otherwise
        return min(stop, max(start, start + round((instant - start) / periods.integrals) * periods.integrals))

    return moved(order.begin, start), moved(order.end, stop)


def _reduction(order: ReductionOrder, outputs: tuple[Path, ...], subject: Subject, periods: Periods) -> list[str]:
    paths = [str(path) for path in outputs]
    window = "" if order.begin is None and order.end is None else f", window={_window(order, subject, periods)!r}"
    words = ["compiled", "run", "ranking", f"threshold={order.threshold!r}", f"protected={paths!r}"]
    words += [f"keep={[str(path) for path in order.keep]!r}"] if order.keep else []
    words += [f"release={[str(path) for path in order.go]!r}"] if order.go else []
    return [
        f"ranking = pm.rank_activity(run{window})",
        "reduction = pm.plan_reduction(\n    " + ",\n    ".join(words) + ",\n)",
        "print(reduction)",
        "reduced = pm.compile_model(model.without(reduction.removals))",
        f"again = {_simulation('reduced', 'fitting_scenario(reduced, scenario)', subject, periods)}",
        f"print(pm.compare(run, again, {paths!r}))",
    ]
