"""The report: one file, complete, with what the study found."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from propermodel.reduction.certificate_files import write_certificate
from propermodel.report.buckets import extremes, packed
from propermodel.report.certify import certify_study
from propermodel.report.page import page_text, write_page
from propermodel.report.page_data import page_data, subject_of_certified, subject_of_study
from propermodel.report.study import ReductionStudy
from tests.browser.pages import quarter_car
from tests.cli.commands import succeed


@pytest.fixture(scope="module")
def study() -> ReductionStudy:
    return quarter_car()


@pytest.fixture(scope="module")
def text(study: ReductionStudy, tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("page") / "report.html"
    write_page(page_data(subject_of_study(study, certify_study(study).certificate)), file)
    return file.read_text(encoding="utf-8")


def test_the_file_asks_for_nothing_from_elsewhere(text: str):
    assert "default-src 'none'" in text
    assert not re.search(r"<(script|img|link|iframe)[^>]*(src|href)=", text)
    assert len(text.encode()) < 2_000_000


def test_the_data_in_the_file_are_those_of_the_study(text: str, study: ReductionStudy):
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    data = json.loads(found[1])
    assert [row["path"] for row in data["rows"]] == [str(row.path) for row in study.ranking.rows]
    assert [row["verdict"] for row in data["rows"]] == [d.verdict.value for d in study.reduction.decisions]
    assert data["facts"][1]["value"] == "4 → 3"
    assert data["picture"]["activity"]["total"] == study.ranking.total
    assert data["balances"]["full"]["supplied"] == pytest.approx(study.full_balance.supplied)


def test_text_of_a_model_cannot_end_the_data(study: ReductionStudy, tmp_path: Path):

    data = page_data(subject_of_study(study, certify_study(study).certificate))
    text = page_text({**data, "model": "</script><script>alert(1)</script>"})
    assert "<script>alert" not in text
    assert "&lt;/script&gt;" in text  # in the title


def test_a_peak_of_one_row_survives():
    time = np.linspace(0.0, 10.0, 10_001)
    values = np.zeros_like(time)
    values[4321] = 7.0
    found = extremes(time, values, np.linspace(0.0, 10.0, 51))
    assert found.max() == 7.0
    assert len(found) == 100


def test_intervals_without_rows_are_interpolated():
    found = extremes(np.array([0.0, 10.0]), np.array([0.0, 20.0]), np.linspace(0.0, 10.0, 5))
    assert found[2:6] == pytest.approx([5.0, 10.0, 10.0, 15.0])


def test_packed_values_are_little_endian_and_gaps_are_nan():

    values = np.frombuffer(base64.b64decode(packed(np.array([1.5, np.inf]))), dtype="<f4")
    assert values[0] == 1.5
    assert np.isnan(values[1])


def test_a_certificate_is_enough_for_a_page(study: ReductionStudy):
    certified = certify_study(study)
    data = page_data(subject_of_certified(certified))
    whole = page_data(subject_of_study(study, certified.certificate))
    assert data["facts"][:2] == whole["facts"][:2]
    assert data["picture"] == whole["picture"]
    assert [row["verdict"] for row in data["rows"]] == [row["verdict"] for row in whole["rows"]]
    assert data["outputs"] == whole["outputs"]
    assert data["tried"] is None


def test_the_command_writes_the_page_of_a_folder(study: ReductionStudy, tmp_path: Path):
    write_certificate(certify_study(study), tmp_path)
    printed = succeed("report", tmp_path, "-o", tmp_path / "page.html")
    assert "needs nothing else" in printed
    assert "default-src 'none'" in (tmp_path / "page.html").read_text(encoding="utf-8")
