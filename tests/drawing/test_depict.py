"""Pictures tell what the graph is: places, strokes, signals, and what is gone."""

from dataclasses import replace
from pathlib import Path as FilePath

import pytest
from typer.testing import CliRunner

import propermodel as pm
from propermodel import ConstantEffort, Freeze, Scenario, ZeroEffort, ZeroFlow, compile_model, rank_activity, simulate
from propermodel.analysis.activity import bond_activities
from propermodel.catalogue.finding import load_subject
from propermodel.cli.app import app
from propermodel.diagnostics import Path, StructureError, parse_path
from propermodel.drawing.depict import depict, depict_model
from propermodel.drawing.picture import Picture, PictureNode, Strokes
from propermodel.library.mechanics.translation import Mass, VelocitySource
from propermodel.presentation import notebook_html
from tests.drawing.pictures import FOLDER, MODELS, text_of


def node(picture: Picture, path: str) -> PictureNode:
    return next(node for node in picture.nodes if str(node.path) == path)


@pytest.mark.parametrize("name", MODELS)
def test_shared_documents_are_what_python_makes(name: str):
    assert (FOLDER / f"{name}.json").read_text(encoding="utf-8") == text_of(name)


@pytest.mark.parametrize("name", MODELS)
def test_everything_in_the_graph_is_in_the_picture(name: str):
    compiled = compile_model(MODELS[name]())
    picture = depict(compiled)
    graph = compiled.graph.normal
    paths = [node.path for node in picture.nodes]
    assert len(paths) == len(set(paths))
    assert {*graph.elements, *graph.junctions} <= set(paths)
    assert [bond.name for bond in picture.bonds] == list(graph.bonds)
    assert all(node.group in picture.groups for node in picture.nodes)
    assert all(group.parent in picture.groups for group in picture.groups if group)
    for bond in picture.bonds:
        assert bond.effort_into == compiled.system.causal.strokes[bond.name].effort_into
        assert bond.effort_into in (bond.tail, bond.head)


def test_dependent_storage_is_marked():
    compiled = compile_model(MODELS["truck"]())
    dependent = set(compiled.system.causal.derivative)
    assert dependent
    marked = {
        end
        for bond in depict(compiled).bonds
        if bond.strokes is Strokes.DEPENDENT
        for end in (bond.tail, bond.head)
        if end in compiled.graph.normal.elements
    }
    assert marked == dependent


def test_a_junction_is_in_the_group_of_the_elements_that_hang_on_it():
    picture = depict(compile_model(MODELS["truck"]()))
    # It is named after the charging pump, but inertia, combustion and accessories of the engine hang on it.
    assert node(picture, "charging_pump.shaft").group == parse_path("engine")


def test_signals_lead_from_where_information_comes_from_to_where_it_acts():
    picture = depict(compile_model(MODELS["truck"]()))
    links = {(str(link.giver), str(link.user)) for link in picture.signals}
    assert ("transmission_control", "transmission.gear") in links
    assert ("driver", "power_management") in links
    assert node(picture, "transmission.gear").kind == "MTF"
    assert node(picture, "driver").kind == "controller"
    assert node(picture, "chassis.front_axle.tyre.contact").kind == "TF"


def test_a_function_of_time_is_where_a_source_has_its_value_from():
    picture = depict(compile_model(MODELS["quarter_car"]()))
    assert [(str(link.giver), str(link.user)) for link in picture.signals] == [("waves", "road")]
    assert node(picture, "road").kind == "MSf"


def test_a_reduced_model_is_the_full_one_with_signs():
    model = MODELS["quarter_car"]()
    removals = (ZeroEffort(parse_path("wheel.flange")), ConstantEffort(parse_path("suspension.damper.port"), 12.0))
    full, reduced = depict(compile_model(model)), depict(compile_model(model.without(removals)))
    assert [node.path for node in reduced.nodes] == [node.path for node in full.nodes]
    signs = {str(node.path): node.gone.sign for node in reduced.nodes if node.gone is not None}
    assert signs == {"wheel": "e = 0", "suspension.damper": "e = const"}
    assert {str(bond.name) for bond in reduced.bonds if bond.is_gone} == {"wheel.flange", "suspension.damper.port"}


def test_what_removals_leave_idle_is_gone_too_and_frozen_signals_are_no_elements():
    subject = load_subject("truck")
    spring = parse_path("output_shaft.spring.port")
    model = subject.model.without((ZeroFlow(spring), Freeze(parse_path("transmission.to_gear"), 3.0)))
    signs = {str(node.path): node.gone.sign for node in depict(compile_model(model)).nodes if node.gone is not None}
    assert signs["output_shaft.spring"] == "f = 0"
    assert signs["output_shaft.damper"] == "idle"


def test_both_ports_of_a_store_tell_what_stands_in_their_place():
    model = MODELS["truck"]()
    oil, wall = (parse_path(f"hydraulics.reservoir.{port}") for port in ("oil", "wall"))
    reduced = compile_model(model.without((ConstantEffort(oil, 1.0e5), ZeroFlow(wall))))
    gone = node(depict(reduced), "hydraulics.reservoir").gone
    assert gone is not None
    assert gone.sign == "e = const, f = 0"


def test_activity_is_told_as_shares():
    compiled = compile_model(MODELS["quarter_car"]())
    run = simulate(compiled, Scenario(stop=1.0), step=1e-3)
    ranking = rank_activity(run)
    activity = depict(compiled, ranking, bond_activities(run)).activity
    assert activity is not None
    assert sum(activity.rows.values()) == pytest.approx(1.0)
    spring = ranking.row(Path(("tyre", "spring")))
    assert activity.rows[spring.path] == spring.index
    assert activity.bonds[parse_path("tyre.spring.port")] == pytest.approx(spring.index)


def test_a_model_without_causality_is_drawn_without_strokes():
    picture = depict_model(replace(MODELS["quarter_car"](), removals=()))
    assert picture.bonds
    assert all(bond.effort_into is None and bond.strokes is Strokes.NONE for bond in picture.bonds)


class Quarrel(pm.Component):
    """Two sources that both set the speed of one mass."""

    first = VelocitySource()
    second = VelocitySource()
    mass = Mass(mass=1.0)
    connections = (
        pm.connect(pm.quantity(1.0, "m/s"), first.velocity),
        pm.connect(pm.quantity(2.0, "m/s"), second.velocity),
        pm.connect(first.flange, second.flange, mass.flange),
    )


def test_what_contradicts_each_other_is_marked():
    model = pm.elaborate(Quarrel())
    with pytest.raises(StructureError) as failed:
        compile_model(model)
    picture = depict_model(model, failed.value.diagnostics)
    marked = {str(end) for b in picture.bonds if b.strokes is Strokes.CONFLICT for end in (b.tail, b.head)}
    assert {"first", "second"} <= marked
    assert any(bond.strokes is Strokes.NONE for bond in picture.bonds)
    text = notebook_html(model)
    assert text is not None
    assert 'class="cross"' in text


def test_the_command_draws_a_conflict_and_ends_with_its_fault(tmp_path: FilePath):
    document, drawing = tmp_path / "quarrel.json", tmp_path / "quarrel.svg"
    pm.write_model(pm.elaborate(Quarrel()), document)
    done = CliRunner().invoke(app, ["draw", str(document), "-o", str(drawing)])
    assert done.exit_code == 2
    assert "causality/conflict" in done.output
    assert 'class="cross"' in drawing.read_text(encoding="utf-8")
