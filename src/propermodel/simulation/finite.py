"""Numbers that a run cannot start with: infinite ones, what is no number at all, and steps that lead nowhere."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from propermodel.diagnostics import NO_SOURCE, Diagnostic, Path, Source
from propermodel.modelling.model import Scenario, TableValues
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.table_store import TableStore


def faults_of_settings(
    scenario: Scenario, stepping: Stepping, record_every: float, integrals_every: float
) -> Iterator[Diagnostic]:
    """A window, step, tolerance or period that no run can have."""
    if not -math.inf < scenario.start < scenario.stop < math.inf:
        yield Diagnostic(
            "simulation/window",
            f"scenario '{scenario.name}' goes from {scenario.start:g} s to {scenario.stop:g} s; it must end after its "
            "start, both at finite times",
            help="give it a later stop: Scenario(stop=...)",
        )
    yield from stepping.faults()
    if not (record_every > 0.0 and integrals_every > 0.0):
        yield Diagnostic(
            "simulation/period",
            f"rows are kept every {record_every:g} s, and integrals every {integrals_every:g} s; both must be positive",
            help="give the period of recording in seconds: simulate(..., record_every=0.1)",
        )


def faults_of_scenario(scenario: Scenario, store: TableStore) -> Iterator[Diagnostic]:
    """The inputs, tables and initial values of a scenario that are not finite."""
    for path, given in (*scenario.inputs.items(), *scenario.tables.items()):
        numbers = store.get(given).wrong if isinstance(given, TableValues) else (given,)
        wrong = [number for number in numbers if not math.isfinite(number)]
        if wrong:
            yield _not_finite(
                f"scenario '{scenario.name}' gives '{path}' the value {wrong[0]:g}",
                "give finite numbers; a sample that is missing is best left out, as inputs are linear in between",
            )
    for path, value in scenario.initial.items():
        if not math.isfinite(value):
            yield _not_finite(
                f"scenario '{scenario.name}' gives '{path}' the start {value:g}",
                "give it a finite start, or none: the model then has its own",
            )


def faults_of_values(what: str, values: Iterable[tuple[Path, float, Source]]) -> Iterator[Diagnostic]:
    """The parameters or states whose value at the start is not finite."""
    for path, value, source in values:
        if not math.isfinite(value):
            yield _not_finite(
                f"the {what} '{path}' is {value:g} at the start",
                "look at what it is computed from: a division by zero, or the root of a negative number?",
                source,
            )


def _not_finite(text: str, help: str, source: Source = NO_SOURCE) -> Diagnostic:
    return Diagnostic("simulation/not-finite", f"{text}, which is no finite number", source=source, help=help)
