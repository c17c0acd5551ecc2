"""The Python that does what a page did."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from propermodel.catalogue.named import NAMED_MODELS, Target
from propermodel.catalogue.subject import Subject
from propermodel.compiler import Method
from propermodel.diagnostics import Path
from propermodel.simulation.choosing import AUTO, Choice
from propermodel.studio.orders import ReductionOrder, RunOrder
from propermodel.studio.run_task import Periods, ordered_subject, periods_of


@dataclass(frozen=True, kw_only=True)
class Steps:
    """What a script does beside opening a model."""

    is_run: bool
    plotted: tuple[Path, ...] = ()  # signals of the run
    threshold: float | None = None  # of a ranking of the run
    reduction: ReductionOrder | None = None  # of the run
    outputs: tuple[Path, ...] = ()  # that the reduction protects and compares


def script(order: RunOrder, steps: Steps) -> str:
    """A script that opens a model, and runs, plots, ranks and reduces it as a page did.

    Raises:
        ProperModelError: the order does not fit the model.
    """
    subject = ordered_subject(order)
    periods = periods_of(subject)
    imports, opened = _opening(order)
    lines = [*opened, *_changes(subject, order), "", "compiled = pm.compile_model(model)"]
    if steps.is_run:
        lines += [f"run = {_simulation('compiled', 'scenario', subject, periods)}", "print(run)"]
    else:
        lines.append("print(pm.state_equations(compiled).text())")
    if steps.plotted:
        imports.add("import matplotlib.pyplot as plt")
        lines += ["", f"run.plot({_texts(steps.plotted)})", "plt.show()"]
    if steps.threshold is not None:
        kept = f"[str(row.path) for row in ranking.kept_by({steps.threshold!r})]"
        lines += ["", "ranking = pm.rank_activity(run)", "print(ranking)", f"print({kept})"]
    if steps.reduction is not None:
        imports.add("from propermodel.reduction.fitting import fitting_scenario")
        lines += ["", *_reduction(steps.reduction, steps.outputs, subject, periods)]
    if any(line.startswith("scenario = replace(") for line in lines):
        imports.add("from dataclasses import replace")
    head = f'"""{subject.name}, as the studio has it; run it in the folder that the studio serves."""'
    return "\n".join([head, "", *_imports({*imports, "import propermodel as pm"}), "", *lines]) + "\n"


def _imports(lines: set[str]) -> list[str]:
    """Imports in the order of the style guide: the standard library, other packages, this one."""
    groups = [
        sorted(line for line in lines if "dataclasses" in line),
        sorted(line for line in lines if "matplotlib" in line),
        sorted((line for line in lines if "propermodel" in line), key=lambda line: (line.startswith("from"), line)),
    ]
    return [line for group in groups if group for line in (*group, "")][:-1]


def _texts(paths: tuple[Path, ...]) -> str:
    return repr([str(path) for path in paths])


def _opening(order: RunOrder) -> tuple[set[str], list[str]]:
    """Imports and lines that make `model` and `scenario`."""
    if order.model in NAMED_MODELS:
        entry = NAMED_MODELS[order.model]
        names = entry.scenarios
        if not order.scenario or order.scenario in names:
            given = names[order.scenario] if order.scenario else next(iter(names.values()))
            lines = [f"model = pm.elaborate({_call(entry.component)})", f"scenario = {_call(given)}"]
            return {_import(entry.component), _import(given)}, lines
    if order.model.endswith(".json") and (not order.scenario or order.scenario.endswith(".json")):
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
    window = "" if order.begin is None and order.end is None else f", window={_window(order, subject, periods)!r}"
    words = ["compiled", "run", "ranking", f"threshold={order.threshold!r}", f"protected={_texts(outputs)}"]
    words += [f"keep={_texts(order.keep)}"] if order.keep else []
    words += [f"release={_texts(order.go)}"] if order.go else []
    return [
        f"ranking = pm.rank_activity(run{window})",
        "reduction = pm.plan_reduction(\n    " + ",\n    ".join(words) + ",\n)",
        "print(reduction)",
        "reduced = pm.compile_model(model.without(reduction.removals))",
        f"again = {_simulation('reduced', 'fitting_scenario(reduced, scenario)', subject, periods)}",
        f"print(pm.compare(run, again, {_texts(outputs)}))",
    ]
