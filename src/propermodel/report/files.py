"""The folder of a study: everything in it is plain data or a picture, and says its version."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from propermodel.modelling.documents import write_model, write_scenario
from propermodel.report.study import ReductionStudy
from propermodel.report.summary import write_outputs, write_ranking, write_summary
from propermodel.simulation.storage import save_trajectory


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
    write_ranking(study, folder / "ranking.csv")
    write_outputs(study, folder / "outputs.csv")
    write_model(study.full.compiled.model, folder / "full_model.json")
    write_model(study.reduced.compiled.model, folder / "reduced_model.json")
    write_scenario(study.full.scenario, folder / "scenario.json")
    write_scenario(study.reduced.scenario, folder / "reduced_scenario.json")
    save_trajectory(study.full, folder / "full.npz")
    save_trajectory(study.reduced, folder / "reduced.npz")
    figures = write_figures(study, folder)
    return summary, (
        *(WrittenFile(figure.name, figure.meaning) for figure in figures),
        WrittenFile("summary.json", "the numbers of the study"),
        WrittenFile("ranking.csv", "activity and decision of every element"),
        WrittenFile("outputs.csv", "outputs of both models over time"),
        WrittenFile("full_model.json", "the full model"),
        WrittenFile("reduced_model.json", "the reduced model, to be run and reduced further"),
        WrittenFile("scenario.json", "the scenario of the full model"),
        WrittenFile("reduced_scenario.json", "the scenario of the reduced model"),
        WrittenFile("full.npz", "everything that was recorded, full model"),
        WrittenFile("reduced.npz", "everything that was recorded, reduced model"),
    )
