"""The cells of the notebooks run in order, what stands at their ends shows itself, and no outputs are kept.

`make docs` runs the same notebooks in a kernel and fails where one of them does.
"""

from __future__ import annotations

import ast
import json
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


def code_cells(notebook: Path) -> list[dict[str, object]]:
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


def run_cell(text: str, place: str, names: dict[str, object]) -> object:
    """Run a cell; the value of its last line where that is an expression that a notebook shows."""
    tree = ast.parse(text, place)
    last = tree.body[-1]
    if isinstance(last, ast.Expr) and not text.rstrip().endswith(";"):
        tree.body.pop()
        exec(compile(tree, place, "exec"), names)
        return eval(compile(ast.Expression(last.value), place, "eval"), names)
    exec(compile(tree, place, "exec"), names)
    return None


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "notebook"}
    shown = []
    with mpl.rc_context({"backend": "agg"}):
        for number, cell in enumerate(code_cells(notebook)):
            answer = run_cell("".join(cell["source"]), f"{notebook.name}, cell {number}", names)
            if answer is not None:
                shown.append(answer)
        plt.close("all")
    assert shown
    for answer in shown:
        assert answer._repr_html_()


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_kept_without_outputs(notebook: Path):
    for cell in code_cells(notebook):
        assert cell["outputs"] == []
        assert cell["execution_count"] is None
