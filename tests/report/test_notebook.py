"""What a notebook shows."""

import sys
from dataclasses import replace
from unittest.mock import patch
from xml.etree import ElementTree

import matplotlib as mpl
import pytest

import propermodel as pm
from propermodel.presentation import notebook_html
from propermodel.report.study import ReductionStudy
from tests.browser.pages import quarter_car


@pytest.fixture(scope="module")
def study() -> ReductionStudy:
    return quarter_car()


def shown(thing: object) -> ElementTree.Element:
    """What a notebook gets of a thing, which must be well formed and need nothing else."""
    text = getattr(thing, "_repr_html_")()  # noqa: B009
    assert text is not None
    for word in ("<script", "href", "url("):
        assert word not in text
    return ElementTree.fromstring(f"<div>{text}</div>")


def words(element: ElementTree.Element) -> str:
    return " ".join(element.itertext())


def test_a_model_shows_its_bond_graph(study: ReductionStudy):
    for thing in (study.full.compiled.model, study.reduced.compiled):
        drawn = shown(thing)
        nodes = [e for e in drawn.iter() if "node" in e.get("class", "").split()]
        assert any(e.get("data-id") == "body" for e in nodes)


def test_without_the_drawing_engine_a_model_shows_its_text(study: ReductionStudy):
    with patch.dict(sys.modules, {"quickjs": None}):
        # A module that is None counts as not there.
        assert notebook_html(study.full.compiled.model) is None


def test_a_run_shows_its_signals(study: ReductionStudy):
    table = shown(study.full)
    assert study.full.ending.message in words(table)
    lines = [e for e in table.iter() if e.tag.endswith("polyline")]
    assert 0 < len(lines) <= 12
    assert f"and {len(study.full.paths) - 12} more" in words(table)


def test_a_ranking_shows_rows_in_order(study: ReductionStudy):
    text = words(shown(study.ranking))
    places = [text.index(f"{row.index:.3%}") for row in study.ranking.rows]
    assert places == sorted(places)


def test_a_reduction_a_comparison_and_a_search_are_tables(study: ReductionStudy):
    assert "no effort" in words(shown(study.reduction))
    assert "body.flange.flow" in words(shown(study.comparison))
    model, scenario = study.full.compiled.model, study.full.scenario
    search = pm.find_proper_model(model, scenario, {"body.flange.flow": 0.05}, step=1e-3)
    assert "recommended" in words(shown(search))


def test_names_are_text(study: ReductionStudy):
    run = replace(study.full, scenario=replace(study.full.scenario, name="<b>bold</b>"))
    assert "<b>bold" not in str(notebook_html(run))


def test_observables_are_drawn_in_usual_units(study: ReductionStudy):
    with mpl.rc_context({"backend": "agg"}):
        import matplotlib.pyplot as plt

        axes = study.full.plot(["tyre.spring.port.effort", "body.flange.flow"])
        assert [one.get_title(loc="left") for one in axes] == ["tyre.spring.port.effort", "body.flange.flow"]
        again = study.reduced.plot(["tyre.spring.port.effort", "body.flange.flow"], axes=axes)
        assert again == axes
        assert all(len(one.lines) == 2 for one in axes)
        scale = {"N": 1.0, "kN": 1e-3}[axes[0].get_ylabel()]
        assert axes[0].lines[0].get_ydata() == pytest.approx(study.full["tyre.spring.port.effort"] * scale)
        plt.close("all")
