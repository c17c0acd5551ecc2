"""The account of causality: what a teacher would say, and paths that can be followed with a finger."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from propermodel.catalogue.finding import load_subject
from propermodel.causality.causal import CausalGraph
from propermodel.causality.report import WIDTH, CausalReport, explain_causality
from propermodel.compiler import compile_model
from propermodel.diagnostics import Path, parse_path
from propermodel.equations.system import BlockKind
from propermodel.modelling import Component, elaborate
from propermodel.modelling.model import Resistive, Variable
from tests import textbooks

EXAMPLES = sorted((FilePath(__file__).parents[2] / "examples").glob("*.py"))
MODELS = [
    textbooks.SeriesCircuit,
    textbooks.Motor,
    textbooks.GearedInertias,
    textbooks.WheatstoneBridge,
    textbooks.QuarterCar,
    textbooks.Cylinder,
]


def report_of(component: Component) -> CausalReport:
    return explain_causality(compile_model(elaborate(component)))


def elements(*names: str) -> set[Path]:
    return {parse_path(name) for name in names}


def test_the_geared_inertias_step_by_step():
    assert (
        report_of(textbooks.GearedInertias()).explanation()
        == """\
causality of geared_inertias, assigned step by step

1. Se drive prescribes the torque (effort) of bond 1.
2. I pinion takes integral causality: what it stores sets the angular velocity (flow) of bond 2.
   - 1-junction drive.shaft has its angular velocity (flow) from bond 2 and gives it to bond 3.
   - TF gear lets the stroke pass to bond 4.
   - 1-junction bearing.shaft has its angular velocity (flow) from bond 4 and gives it to bonds 5,
     6. I wheel must set the torque (effort): derivative causality, dependent storage. R bearing
     answers with the torque (effort).

storage: 1 integral (state), 1 derivative (dependent)
dependent storage I wheel follows from
  I pinion -f2-> 1-junction drive.shaft -f3-> TF gear -f4-> 1-junction bearing.shaft -f5-> I wheel
algebraic loops: none
zero-order causal paths: none
(-e1-> and -f1-> are the effort and the flow of bond 1)"""
    )


def test_the_table_of_the_bridge_and_its_loops():
    assert (
        report_of(textbooks.WheatstoneBridge()).text()
        == """\
causality of wheatstone_bridge
bond  effort set by              flow set by                order  because
   1  0 source.pin               1 upper_left.difference        2  junction, after source
   2  1 upper_left.difference    0 galvanometer.a               8  junction, after upper_left
   3  R upper_left               1 upper_left.difference        7  chosen, either fits
   4  0 source.pin               1 upper_right.difference       3  junction, after source
   5  1 upper_right.difference   0 galvanometer.b              11  junction, after upper_right
   6  R upper_right              1 upper_right.difference      10  chosen, either fits
   7  0 galvanometer.a           1 galvanometer.difference      5  junction, after galvanometer
   8  0 galvanometer.b           1 galvanometer.difference      6  junction, after galvanometer
   9  1 galvanometer.difference  I galvanometer                 4  integral causality
  10  Se source                  0 source.pin                   1  source
  11  0 galvanometer.a           R lower_left                   9  junction, after upper_left
  12  0 galvanometer.b           R lower_right                 12  junction, after upper_right

storage: 1 integral (state), 0 derivative (dependent)
algebraic loops: 2
  R upper_left -e3-> 1-junction upper_left.difference -e2-> 0-junction galvanometer.a -e11-> R
    lower_left -f11-> 0-junction galvanometer.a -f2-> 1-junction upper_left.difference -f3-> R
    upper_left; gain of R upper_left, R lower_left
  R upper_right -e6-> 1-junction upper_right.difference -e5-> 0-junction galvanometer.b -e12-> R
    lower_right -f12-> 0-junction galvanometer.b -f5-> 1-junction upper_right.difference -f6-> R
    upper_right; gain of R upper_right, R lower_right
zero-order causal paths (no state on them): 6
  R lower_left -f11-> 0-junction galvanometer.a -f2-> 1-junction upper_left.difference -f3-> R
    upper_left
  R lower_right -f12-> 0-junction galvanometer.b -f5-> 1-junction upper_right.difference -f6-> R
    upper_right
  R upper_left -e3-> 1-junction upper_left.difference -e2-> 0-junction galvanometer.a -e11-> R
    lower_left
  Se source -e10-> 0-junction source.pin -e1-> 1-junction upper_left.difference -e2-> 0-junction
    galvanometer.a -e11-> R lower_left
  R upper_right -e6-> 1-junction upper_right.difference -e5-> 0-junction galvanometer.b -e12-> R
    lower_right
  Se source -e10-> 0-junction source.pin -e4-> 1-junction upper_right.difference -e5-> 0-junction
    galvanometer.b -e12-> R lower_right
(-e1-> and -f1-> are the effort and the flow of bond 1)"""
    )


def test_the_bridge_step_by_step():
    steps = report_of(textbooks.WheatstoneBridge()).explanation().split("\n\n")[1]
    assert (
        steps
        == """\
1. Se source prescribes the voltage (effort) of bond 10.
   - 0-junction source.pin has its voltage (effort) from bond 10 and gives it to bonds 1, 4.
2. I galvanometer takes integral causality: what it stores sets the current (flow) of bond 9.
   - 1-junction galvanometer.difference has its current (flow) from bond 9 and gives it to bonds 7,
     8.
3. R upper_left may have either causality; chosen: it sets the voltage (effort) of bond 3.
   - 1-junction upper_left.difference still needs its current (flow), and only bond 2 is left to
     bring it.
   - 0-junction galvanometer.a has its voltage (effort) from bond 2 and gives it to bond 11. R
     lower_left answers with the current (flow).
4. R upper_right may have either causality; chosen: it sets the voltage (effort) of bond 6.
   - 1-junction upper_right.difference still needs its current (flow), and only bond 5 is left to
     bring it.
   - 0-junction galvanometer.b has its voltage (effort) from bond 5 and gives it to bond 12. R
     lower_right answers with the current (flow)."""
    )


def test_a_series_circuit_follows_from_its_source_and_its_coil():
    report = report_of(textbooks.SeriesCircuit())
    assert [str(step.element) for step in report.steps] == ["source", "coil"]
    setter = {str(row.bond): (str(row.sets_effort), str(row.sets_flow)) for row in report.rows}
    assert setter["coil.port"] == ("resistor.difference", "coil")
    assert setter["resistor.port"] == ("resistor", "resistor.difference")
    assert setter["capacitor.port"] == ("capacitor", "resistor.difference")
    assert not report.dependent
    assert not report.loops
    assert not report.zero_order


@pytest.mark.parametrize("component", MODELS, ids=lambda component: component.__name__)
def test_every_stroke_is_told_once_and_in_order(component: type[Component]):
    report = report_of(component())
    told: list[Path] = []
    for step in report.steps:
        told += [*step.decided, *(bond for _, bond in step.followed)]
    assert told == list(report.causal.strokes)
    assert sorted(row.order for row in report.rows) == list(range(1, len(report.rows) + 1))
    for row in report.rows:
        assert {row.sets_effort, row.sets_flow} == {
            end.owner
            for end in (
                report.causal.graph.normal.bonds[row.bond].tail,
                report.causal.graph.normal.bonds[row.bond].head,
            )
        }


@pytest.mark.parametrize("component", MODELS, ids=lambda component: component.__name__)
def test_it_can_be_projected(component: type[Component]):
    report = report_of(component())
    assert max(map(len, report.text().splitlines())) <= WIDTH
    assert max(map(len, report.explanation().splitlines())) <= WIDTH


@pytest.mark.parametrize("component", MODELS, ids=lambda component: component.__name__)
def test_loops_are_those_that_the_equations_have(component: type[Component]):
    compiled = compile_model(elaborate(component()))
    torn = [kind for block in compiled.system.solved for kind in block.kinds if kind is BlockKind.LOOP]
    assert len(explain_causality(compiled).loops) == len(torn)


def test_a_loop_closes_and_names_what_its_gain_is_made_of():
    for loop in report_of(textbooks.WheatstoneBridge()).loops:
        assert loop.path.begin == loop.path.end
        assert len(loop.path.signals) == 6
        assert set(loop.elements) in (
            elements("upper_left", "lower_left"),
            elements("upper_right", "lower_right"),
        )


def test_dependent_storage_has_its_path():
    (dependent,) = report_of(textbooks.GearedInertias()).dependent
    assert dependent.storage == parse_path("wheel")
    (path,) = dependent.paths
    assert [str(place) for place in path.places] == ["pinion", "drive.shaft", "gear", "bearing.shaft", "wheel"]
    assert {variable for _, variable in path.signals} == {Variable.FLOW}


def test_a_long_chain_is_explained():
    report = report_of(textbooks.section_chain(300))
    assert len(report.causal.integral) == 600
    assert not report.loops
    assert len(report.explanation().splitlines()) < 20 * 300


def solved_laws(causal: CausalGraph) -> set[Path]:
    """One-port resistances that must answer with what they have no law for."""
    found: set[Path] = set()
    structure = causal.graph.normal
    for bond in structure.bonds.values():
        for end in (bond.tail, bond.head):
            element = structure.elements.get(end.owner)
            if element is not None and isinstance(element.behaviour, Resistive) and len(element.ports) == 1:
                answer = Variable.FLOW if causal.receives_effort(bond, element) else Variable.EFFORT
                if answer not in {result.variable for law in element.behaviour.laws for result in law.results}:
                    found.add(element.path)
    return found


def test_what_closes_a_kinematic_loop_is_explained():
    model = load_subject(str(next(file for file in EXAMPLES if file.stem == "pendulum_on_a_rod"))).model
    report = explain_causality(compile_model(model))
    assert "closes a loop" in report.table()
    sentence = "closes a kinematic loop: the force (effort) of bond 6 keeps its flow."
    assert sentence in " ".join(report.explanation().split())
    assert "kinematic loops: 1, closed by\n  Sf held" in report.text()


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_every_example_is_explained(file: FilePath):
    compiled = compile_model(load_subject(str(file)).model)
    report = explain_causality(compiled)
    unknowns = {path for block in compiled.system.blocks for path in block.paths}
    has_loop = unknowns - set(report.causal.constraints) - solved_laws(report.causal)
    is_implicit = has_loop or any(BlockKind.LOOP in block.kinds for block in compiled.system.solved)
    # Switches that are solved together are one loop, although each has an implicit law.
    is_implicit = is_implicit or any(len(switching.unknowns) > 1 for switching in compiled.system.switching)
    assert bool(report.loops) is bool(is_implicit)
    assert max(map(len, (*report.text().splitlines(), *report.explanation().splitlines()))) <= WIDTH
    assert {item.storage for item in report.dependent} == set(report.causal.derivative)
    assert all(item.paths for item in report.dependent)
