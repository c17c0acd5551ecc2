"""The study of the truck on the first two minutes of its mission: ranking, plan, reduced model."""

from __future__ import annotations

import ast
import re
from pathlib import Path as FilePath

import pytest

import propermodel
from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Method, compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling import elaborate
from propermodel.reduction.plan import plan_reduction
from propermodel.simulation.simulate import simulate

FUEL = "engine.fuel_meter.mass"
SETTINGS = {"method": Method.SEMI_IMPLICIT, "step": 2e-4, "record_every": 0.1}


@pytest.fixture(scope="module")
def truck():
    return compile_model(elaborate(HybridTruck()))


@pytest.fixture(scope="module")
def two_minutes():
    return mission("fmtv_mixed", until=120.0)


@pytest.fixture(scope="module")
def full(truck, two_minutes):
    return simulate(truck, two_minutes, **SETTINGS)


@pytest.fixture(scope="module")
def reduction(truck, full):
    return plan_reduction(truck, full, rank_activity(full), threshold=0.99, protected=["chassis.speed", FUEL])


@pytest.fixture(scope="module")
def reduced(truck, reduction):
    return compile_model(truck.model.without(reduction.removals))


def test_every_energy_element_has_its_row(full):
    assert len(rank_activity(full).rows) == 57


def test_dependent_storage_is_found_without_help(truck):
    assert {str(path) for path in truck.system.causal.derivative} == {
        "transmission.inertia.turbine",
        "hydraulics.pump_motor.rotating_group",
        "chassis.front_axle.forward_mass",
        "chassis.rear_front_axle.forward_mass",
        "chassis.rear_rear_axle.forward_mass",
    }


def test_the_run_is_complete_and_its_energy_balances(full):
    assert full.ending.is_complete
    assert full.notes == ()  # the declared starts agree
    assert energy_balance(full).relative_residual < 1e-4


def test_the_forward_motion_of_the_body_is_the_most_active(full):
    assert str(rank_activity(full).rows[0].path) == "chassis.body.forward_mass"


def test_the_plan_takes_out_what_the_study_took_out_by_hand(reduction):
    gone = {str(d.row.path) for d in reduction.removed}
    assert "chassis.body.inertia" in gone
    assert "chassis.body.vertical_mass" in gone
    for axle in ("front_axle", "rear_front_axle", "rear_rear_axle"):
        for part in ("spring", "shock_absorber", "vertical_mass", "tyre.spring", "tyre.damper"):
            assert f"chassis.{axle}.{part}" in gone
    for part in ("reservoir", "reservoir_line", "reservoir_wall", "accumulator_line"):
        assert f"hydraulics.{part}" in gone
    assert {"output_shaft.spring", "output_shaft.damper"} <= gone
    assert {"chassis.body.forward_mass", "engine.inertia", "chassis.drag", "converter"}.isdisjoint(gone)


def test_the_reduced_truck_is_smaller_and_uses_the_same_fuel(truck, full, reduced, two_minutes):
    assert len(reduced.system.states) < 0.5 * len(truck.system.states)
    answer = simulate(reduced, two_minutes, record=[FUEL], **SETTINGS)
    assert answer.ending.is_complete
    assert answer.at_end(FUEL) == pytest.approx(full.at_end(FUEL), rel=0.005)


# -- no special cases --------------------------------------------------------------------------------------------

ROOT = FilePath(propermodel.__file__).parent
NAMES = ROOT / "catalogue" / "named.py"  # of what comes with the package
GENERAL = sorted(f for f in ROOT.rglob("*.py") if f.relative_to(ROOT).parts[0] not in ("library", "cli") and f != NAMES)
OF_THE_TRUCK = ("truck", "axle", "tyre", "engine")
EXECUTION_ENGINE = "_engine"  # of LLVM


def words_of(file: FilePath) -> list[str]:
    """Names and texts of a module, without its docstrings."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    texts = {id(n.body[0].value) for n in ast.walk(tree) if isinstance(n, documented) and ast.get_docstring(n)}
    found: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in texts:
            found.append(node.value)
        found += [str(getattr(node, key)) for key in ("id", "name", "attr", "arg", "module") if hasattr(node, key)]
    return found


@pytest.mark.parametrize("file", GENERAL, ids=lambda f: str(f.relative_to(ROOT)))
def test_nothing_outside_the_library_knows_a_truck(file):
    words = [word for text in words_of(file) if text != EXECUTION_ENGINE for word in re.split(r"[^a-z]+", text.lower())]
    assert [word for word in words if word.removesuffix("s") in OF_THE_TRUCK] == []
