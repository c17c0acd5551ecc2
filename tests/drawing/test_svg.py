"""Drawings without a browser."""

from pathlib import Path as FilePath
from threading import Thread
from xml.etree import ElementTree

import pytest

from propermodel import compile_model
from propermodel.diagnostics import Path
from propermodel.drawing.depict import depict
from propermodel.drawing.javascript import DrawingError
from propermodel.drawing.picture import Picture, PictureNode
from propermodel.drawing.svg import to_svg
from tests.cli.commands import MODEL, succeed
from tests.drawing.pictures import MODELS, ROOT

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def quarter() -> Picture:
    return depict(compile_model(MODELS["quarter_car"]()))


def classed(drawing: str, name: str) -> list[ElementTree.Element]:
    root = ElementTree.fromstring(drawing)
    return [element for element in root.iter() if name in element.get("class", "").split()]


def test_every_bond_has_its_half_arrow_and_its_stroke_at_the_right_end(quarter: Picture):
    drawing = to_svg(quarter, depth=9)
    bonds = {bond.get("data-bond"): bond for bond in classed(drawing, "bond")}
    assert set(bonds) == {str(bond.name) for bond in quarter.bonds}
    for bond in quarter.bonds:
        parts = {part.get("class", "").split(" ")[0]: part for part in bonds[str(bond.name)]}
        assert "barb" in parts
        assert parts["stroke"].get("data-end") == ("head" if bond.effort_into == bond.head else "tail")


def test_closed_groups_stand_for_what_is_in_them(quarter: Picture):
    drawing = to_svg(quarter, depth=0)
    assert [group.get("data-group") for group in classed(drawing, "closed")] == ["suspension", "tyre"]
    assert "suspension.spring" not in {node.get("data-id") for node in classed(drawing, "node")}
    opened = to_svg(quarter, depth=0, open=["tyre"])
    assert [group.get("data-group") for group in classed(opened, "closed")] == ["suspension"]
    assert "tyre.spring" in {node.get("data-id") for node in classed(opened, "node")}


def test_a_file_needs_nothing_else(quarter: Picture):
    drawing = to_svg(quarter)
    for word in ("href", "url(", "<script", "<style", "@import"):
        assert word not in drawing


def test_every_thread_can_draw(quarter: Picture):
    found: list[str] = []
    threads = [Thread(target=lambda: found.append(to_svg(quarter))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [to_svg(quarter)] * 2


def test_signals_and_legend_by_choice(quarter: Picture):
    assert len(classed(to_svg(quarter), "signal")) == len(quarter.signals) == 1
    bare = to_svg(quarter, signals=False, legend=False)
    assert classed(bare, "signal") == []
    assert classed(bare, "legend") == []


def test_an_empty_model_is_an_empty_page():
    lonely = Picture(
        name="lonely",
        groups=(Path(),),
        nodes=(PictureNode(path=Path(("m",)), kind="I", group=Path()),),
        bonds=(),
        signals=(),
    )
    assert len(classed(to_svg(lonely), "node")) == 1


def test_a_group_that_does_not_exist_is_told(quarter: Picture):
    with pytest.raises(DrawingError, match="no group 'tire' to open"):
        to_svg(quarter, open=["tire"])


def test_the_command_writes_a_file(tmp_path: FilePath):
    file = tmp_path / "graphs" / "quarter.svg"
    printed = succeed("draw", MODEL, "-o", file, "--activity", "--until", 0.5, "--step", 0.001, "--depth", 5)
    assert file.as_posix() in printed.replace("\n", "")
    text = file.read_text(encoding="utf-8")
    assert "of the total" in text
    assert "% of the activity" in text


def test_pictures_of_the_documentation_are_drawn_by_this_code(quarter: Picture):
    drawn = (ROOT / "docs" / "images" / "quarter_car_graph.svg").read_text(encoding="utf-8")
    assert drawn == to_svg(quarter, depth=9) + "\n"
