"""Pages for the tests in a browser, and what Python says that they must show.

`python -m tests.browser.pages` writes them to `out/browser`.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace

import numpy as np

from propermodel.analysis.activity import rank_activity
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import compile_model
from propermodel.drawing.depict import depict
from propermodel.report.certify import certify_study
from propermodel.report.options import StudyOptions
from propermodel.report.page import write_page
from propermodel.report.page_data import page_data, subject_of_study
from propermodel.report.study import ReductionStudy, run_study
from tests.drawing.pictures import ROOT
from tests.examples.test_notebooks import code_cells, run_cell

FOLDER = ROOT / "out" / "browser"
NOTEBOOK = ROOT / "docs" / "notebooks" / "suspension.ipynb"


def quarter_car() -> ReductionStudy:
    subject = load_subject(str(ROOT / "examples" / "quarter_car.py"))
    return run_study(subject.model, subject.scenario, StudyOptions(threshold=0.97, step=1e-3, speed_repeats=0))


def truck() -> ReductionStudy:
    subject = load_subject("truck")
    options = StudyOptions(
        outputs=subject.outputs,
        totals=subject.totals,
        panels=subject.panels,
        step=1e-3,
        method=subject.method,
        speed_repeats=0,
    )
    return run_study(subject.model, replace(subject.scenario, stop=20.0), options)


def _window(study: ReductionStudy) -> dict[str, object]:
    """A ranking of the middle of a run, between instants that the page has too."""
    times = study.full.integral_times
    first, last = float(times[len(times) // 3]), float(times[2 * len(times) // 3])
    ranking = rank_activity(study.full, window=(first, last))
    return {"from": first, "to": last, "rows": [(str(row.path), row.activity) for row in ranking.rows]}


def write(name: str, study: ReductionStudy) -> None:
    """One page with its expectations."""
    write_page(page_data(subject_of_study(study, certify_study(study).certificate)), FOLDER / f"{name}.html")
    picture = depict(study.reduced_model)
    thresholds = [round(float(t), 4) for t in np.linspace(0.5, 1.0, 26)]
    expected = {
        "nodes": len(picture.nodes),
        "strokes": {str(bond.name): "head" if bond.effort_into == bond.head else "tail" for bond in picture.bonds},
        "kept": [(threshold, len(study.ranking.kept_by(threshold))) for threshold in thresholds],
        "gone": {str(node.path): node.gone.sign for node in picture.nodes if node.gone is not None},
        "outputs": [str(path) for path in study.compared],
        "window": _window(study),
    }
    (FOLDER / f"{name}.json").write_text(json.dumps(expected), encoding="utf-8")


def write_notebook() -> None:
    """A notebook of the documentation, executed, as an HTML page with nothing around it; and its model's picture."""
    from nbconvert.exporters import HTMLExporter
    from nbconvert.preprocessors import ExecutePreprocessor

    exporter = HTMLExporter(template_name="basic")
    exporter.register_preprocessor(ExecutePreprocessor(timeout=120), enabled=True)
    with tempfile.TemporaryDirectory() as folder:
        body, _ = exporter.from_filename(str(NOTEBOOK), resources={"metadata": {"path": folder}})
    (FOLDER / "notebook.html").write_text(f"<!doctype html><meta charset=utf-8>{body}", encoding="utf-8")
    names: dict[str, object] = {"__name__": "notebook"}
    for cell in code_cells(NOTEBOOK)[:2]:
        run_cell("".join(cell["source"]), NOTEBOOK.name, names)
    picture = depict(compile_model(names["model"]))
    (FOLDER / "notebook.json").write_text(json.dumps(picture.document()), encoding="utf-8")


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    write_notebook()
    write("quarter_car", quarter_car())
    write("truck", truck())
