"""The runs that `propermodel rank` ranks: of each scenario, and again at finer steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import typer

from propermodel.cli.faults import FAULTS_FOUND, INTERRUPTED, print_diagnostics

if TYPE_CHECKING:
    from propermodel.analysis.windows import Window, Windows
    from propermodel.catalogue.subject import Subject
    from propermodel.compiler import CompiledModel
    from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True)
class RankedRuns:
    """A run of each scenario, and the same at finer steps where a check was asked for."""

    runs: tuple[Trajectory, ...]
    refined: tuple[Trajectory, ...] | None


def runs_of(
    compiled: CompiledModel,
    subjects: Sequence[Subject],
    window: Window | None,
    windows: Windows | None,
    refine: bool,
) -> RankedRuns:
    """Run a model through the scenarios of all subjects; a run that fails ends the command with its fault.

    Raises:
        ReductionError: the windows are none of these runs.
    """
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.rank_windows import period_of_windows
    from propermodel.diagnostics import SimulationError
    from propermodel.report.options import StudyOptions
    from propermodel.report.study import StudySoFar

    subject, scenarios = subjects[0], [each.scenario for each in subjects]
    options = StudyOptions(
        method=subject.method,
        step=subject.step,
        jacobian_every=subject.jacobian_every,
        step_tolerance=subject.tolerance,
    )
    options = replace(options, integral_period=period_of_windows(options, scenarios, window, windows))
    runs: list[Trajectory] = []
    refined: list[Trajectory] = []
    with ProgressBars() as bars:
        for each in scenarios:
            so_far = StudySoFar()
            try:
                runs.append(so_far.run("full", compiled, each, options, bars))
                if refine:
                    refined.append(so_far.refine(runs[-1], options, bars))
            except SimulationError as error:
                if not so_far.runs:
                    raise
                print_diagnostics(error.diagnostics)
                raise typer.Exit(INTERRUPTED if so_far.was_interrupted else FAULTS_FOUND) from None
    return RankedRuns(tuple(runs), tuple(refined) or None)
