"""The folder of a study: everything in it is plain data or a picture, and says its version."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from propermodel.diagnostics import Path, parse_path
from propermodel.modelling.documents import write_model, write_scenario
from propermodel.reduction.certificate_files import write_certificate
from propermodel.report.certify import certify_study
from propermodel.report.page import write_page
from propermodel.report.page_data import page_data, subject_of_study
from propermodel.report.study import ReductionStudy, StudySoFar
from propermodel.report.summary import write_outputs, write_ranking, write_summary
from propermodel.simulation.storage import save_trajectory
from propermodel.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class WrittenFile:
    """A file of a study and what it is for."""

    name: str
    meaning: str


def write_study(study: ReductionStudy, folder: FilePath) -> tuple[dict[str, Any], tuple[WrittenFile, ...]]:
    """Write all files of a study into a folder; gives the summary and what was written, in reading order."""
    from propermodel.report.figures import write_figures

    folder.mkdir(parents=True, exist_ok=True)
    summary = write_summary(study, folder / "summary.json")
    write_ranking(study.reduction, folder / "ranking.csv")
    write_outputs(study, folder / "outputs.csv")
    figures = write_figures(study, folder)
    certified = certify_study(study)
    write_certificate(certified, folder)
    write_page(page_data(subject_of_study(study, certified.certificate)), folder / "report.html")
    write_scenario(study.reduced.scenario, folder / "reduced_scenario.json")
    save_trajectory(study.full, folder / "full.npz", only=_worth_keeping(study, study.full))
    save_trajectory(study.reduced, folder / "reduced.npz", only=_worth_keeping(study, study.reduced))
    return summary, (
        WrittenFile("report.html", "everything of this study in one page, to be mailed and opened anywhere"),
        *(WrittenFile(figure.name, figure.meaning) for figure in figures),
        WrittenFile("summary.json", "the numbers of the study"),
        WrittenFile("ranking.csv", "activity and decision of every element"),
        WrittenFile("outputs.csv", "outputs of both models over time"),
        WrittenFile("certificate.json", "what the reduced model rests on; propermodel verify repeats it"),
        WrittenFile("full_model.json", "the full model"),
        WrittenFile("reduced_model.json", "the reduced model, to be run and reduced further"),
        WrittenFile("scenario.json", "the scenario of the full model"),
        WrittenFile("reduced_scenario.json", "the scenario of the reduced model"),
        WrittenFile("full.npz", "states, outputs and ranked elements over time, full model"),
        WrittenFile("reduced.npz", "states, outputs and ranked elements over time, reduced model"),
    )


def _worth_keeping(study: ReductionStudy, run: Trajectory) -> tuple[Path, ...]:
    """States, compared outputs, totals, what panels show, and effort and flow at the ports of ranked elements."""
    system = run.compiled.system
    shown = (parse_path(series.path) for panel in study.options.panels for series in panel.series)
    ports = (bond / variable for row in system.rows for bond in row.bonds for variable in ("effort", "flow"))
    wanted = (*study.compared, *study.options.totals.values(), *shown, *(state.path for state in system.states), *ports)
    return tuple(path for path in dict.fromkeys(wanted) if path in run)


def write_incomplete(so_far: StudySoFar, folder: FilePath) -> tuple[str, ...]:
    """Write what a study made before it stopped; gives the names of the files."""
    folder.mkdir(parents=True, exist_ok=True)
    names: list[str] = []
    for name, run in so_far.runs.items():
        save_trajectory(run, folder / f"{name}.npz")
        names.append(f"{name}.npz")
    if so_far.reduction is not None:
        write_ranking(so_far.reduction, folder / "ranking.csv")
        write_model(
            so_far.runs["full"].compiled.model.without(so_far.reduction.removals), folder / "reduced_model.json"
        )
        names += ["ranking.csv", "reduced_model.json"]
    return tuple(names)
