"""Methods of others against textbook answers, and all of them beside this package's on one model."""

from __future__ import annotations

import csv
import json
import math
from functools import cache
from pathlib import Path as FilePath

import numpy as np
import pytest

import propermodel as pm
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import parse_path
from propermodel.library.mechanics.translation import Damper, Fixed, HardeningSpring, Mass, Spring
from propermodel.reduction.methods.activity import by_activity
from propermodel.reduction.methods.backward import by_measured_error
from propermodel.reduction.methods.compare import METHODS, MethodComparison, compare_methods
from propermodel.reduction.methods.correlation import by_energy_correlation, directions_of
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.deduction import by_frequency_response, by_spectral_radius, highest_frequency
from propermodel.reduction.methods.projection import balance, by_balanced_truncation, by_modal_truncation
from propermodel.reduction.methods.relative import by_relative_activity
from propermodel.reduction.methods.workbench import Workbench
from propermodel.report.methods import write_comparison
from tests.cli import quarter_car as driven
from tests.physics.systems import SinePush

SETTINGS = {"method": pm.Method.RODAS, "step_tolerance": 1e-6}


class Carriages(pm.Component):
    """Two carriages on a stiff coupling, pulled slowly against a soft spring."""

    engine = SinePush(force=100.0, frequency=0.2)
    first = Mass(mass=3.0)
    second = Mass(mass=1.0)
    coupling = Spring(stiffness=4.0e4)
    buffer = Damper(damping=20.0)
    soft = Spring(stiffness=40.0)
    drag = Damper(damping=8.0)
    ground = Fixed()

    connections = (
        pm.connect(ground.flange, soft.a, drag.a),
        pm.connect(soft.b, drag.b, first.flange, coupling.a, buffer.a, engine.flange),
        pm.connect(coupling.b, buffer.b, second.flange),
    )


PULLED = pm.Scenario(name="pulled", stop=20.0)
OUTPUT = parse_path("second.flange.flow")


def bench_of(component: pm.Component, scenario: pm.Scenario, *outputs: str, threshold: float = 0.99) -> Workbench:
    period = scenario.stop / 1000.0
    run = pm.simulate(
        pm.compile_model(pm.elaborate(component)),
        scenario,
        method=pm.Method.RODAS,
        tolerance=1e-6,
        record_every=period,
        integrals_every=scenario.stop,
    )
    paths = [parse_path(output) for output in outputs]
    return Workbench(run, paths, record_every=period, tolerance=0.02, threshold=threshold)


@cache
def carriages() -> Workbench:
    return bench_of(Carriages(), PULLED, str(OUTPUT))


def gone(curve: Curve) -> dict[str, type[pm.Removal]]:
    assert curve.chosen is not None
    return {str(removal.bond): type(removal) for removal in curve.chosen.removals}


def test_mora_keeps_rows_up_to_its_threshold_and_deletes_the_rest_by_position():
    bench = carriages()
    curve = by_activity(bench)
    ranking = pm.rank_activity(bench.run)
    kept = {str(row.path) for row in ranking.kept_by(0.99)}
    assert gone(curve).keys() == {f"{row.path}.port" for row in ranking.rows if str(row.path) not in kept}
    # The coupling sits with its damper at a 1-junction of their own, between two bodies: no effort, so it is cut.
    assert gone(curve)["coupling.port"] is pm.ZeroEffort
    assert curve.chosen is not None
    assert curve.chosen.error > 0.1  # the second carriage is lost: nothing tests what is small there
    assert curve.models[0].rows == 6


def test_relative_activity_holds_a_junction_whose_bond_is_small_beyond():
    # The stiff coupling carries the force, so it is great beside its damper; its flow is small beside the carriages'.
    curve = by_relative_activity(carriages())
    rigid = next(model for model in curve.models if any(r.bond == parse_path("coupling.port") for r in model.removals))
    assert pm.ZeroFlow(parse_path("coupling.port")) in rigid.removals
    best = curve.smallest_within(0.02)
    assert best is not None
    assert (best.rows, best.states) == (4, 2)


def test_uncorrelated_energies_are_directions_of_their_own():
    t = np.linspace(0.0, 1.0, 1001)
    weights = np.full(len(t), 1.0 / len(t))
    signals = np.array([3.0 * np.sin(2.0 * math.pi * t), np.cos(2.0 * math.pi * t)])
    found = directions_of(signals, weights)
    assert found.strengths == pytest.approx([4.5, 0.5], rel=5e-3)
    assert np.abs(found.parts) == pytest.approx(np.eye(2), abs=1e-2)
    # The first alone is 90 % of all strength.
    assert found.importance(0.85) == pytest.approx([1.0, 0.0], abs=1e-2)
    assert found.importance(0.99) == pytest.approx([0.75, 0.25], abs=1e-2)


def test_energies_that_move_together_are_one_direction():
    t = np.linspace(0.0, 1.0, 1001)
    signal = np.sin(2.0 * math.pi * t)
    found = directions_of(np.array([signal, -2.0 * signal]), np.full(len(t), 1.0 / len(t)))
    assert found.strengths[1] <= 1e-12 * found.strengths[0]
    assert found.importance(0.9) == pytest.approx([1.0 / 3.0, 2.0 / 3.0])
    assert by_energy_correlation(carriages()).models[0].error == 0.0


def controllable() -> tuple[FloatArray, FloatArray, FloatArray]:
    """1 / ((s + 1) (s + 10)): slow and fast poles in parallel, x' = diag(-1, -10) x + (1, 1) u, y = (x_1 - x_2) / 9."""
    return np.diag([-1.0, -10.0]), np.ones((2, 1)), np.array([[1.0, -1.0]]) / 9.0


def test_hankel_singular_values_of_two_poles():
    # Both Gramians in closed form: P_ij = b_i b_j / (p_i + p_j), Q_ij = c_i c_j / (p_i + p_j).
    A, B, C = controllable()
    sums = np.array([[2.0, 11.0], [11.0, 20.0]])
    reached, seen = 1.0 / sums, (C.T @ C) / sums
    expected = np.sqrt(np.sort(np.linalg.eigvals(reached @ seen).real)[::-1])
    found = balance(A, B, C)
    assert found.values == pytest.approx(expected, rel=1e-9)
    # Balanced means that both Gramians are the same diagonal matrix.
    for a, b in ((found.A, found.B @ found.B.T), (found.A.T, found.C.T @ found.C)):
        assert a @ np.diag(found.values) + np.diag(found.values) @ a.T + b == pytest.approx(np.zeros((2, 2)), abs=1e-12)


def test_truncation_errs_by_at_most_twice_the_values_left_out():
    # Glover (1984): the largest error over all frequencies.
    rng = np.random.default_rng(3)
    raw = rng.normal(size=(6, 6))
    A = raw - (np.max(np.linalg.eigvals(raw).real) + 0.3) * np.eye(6)
    B, C = rng.normal(size=(6, 1)), rng.normal(size=(1, 6))
    found = balance(A, B, C)
    s = 1j * np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 300)])

    def gain(a: FloatArray, b: FloatArray, c: FloatArray) -> np.ndarray:
        return np.array([(c @ np.linalg.solve(x * np.eye(len(a)) - a, b))[0, 0] for x in s])

    for r in (2, 4):
        error = np.max(np.abs(gain(A, B, C) - gain(found.A[:r, :r], found.B[:r], found.C[:, :r])))
        assert 0.0 < error <= 2.0 * np.sum(found.values[r:]) * (1.0 + 1e-9)


def test_projections_begin_at_the_run_and_end_at_nothing():
    bench = carriages()
    balanced, modal = by_balanced_truncation(bench), by_modal_truncation(bench)
    for curve in (balanced, modal):
        assert not curve.not_applied
        assert curve.models[0].states == 4
        assert curve.models[0].error < 1e-3
        assert all(model.rows is None for model in curve.models)
        # Both carriages move as one: two states say it all.
        best = curve.smallest_within(0.01)
        assert best is not None
        assert best.states == 2


def test_deduction_leaves_the_fast_mode_out():
    bench = carriages()
    by_radius, by_response = by_spectral_radius(bench), by_frequency_response(bench)
    assert 2.0 * math.pi * 0.2 <= highest_frequency(bench) < 10.0
    # The coupling's mode is at sqrt(k / m_1 + k / m_2), far beyond what the pull holds; that of the soft spring below.
    for curve in (by_radius, by_response):
        assert curve.chosen is not None
        assert "coupling.port" in gone(curve)
        assert curve.models[0].error < 1e-6


def test_backward_elimination_takes_the_cheapest_removal_each_time():
    bench = carriages()
    curve = by_measured_error(bench)
    errors = [bench.measure([way]).error for row in bench.rows for name in row.bonds for way in _both(name)]
    assert curve.models[1].error == min(errors)
    assert [model.rows for model in curve.models] == sorted((m.rows for m in curve.models), reverse=True)


def _both(name: pm.Path) -> tuple[pm.Removal, pm.Removal]:
    return pm.ZeroEffort(name), pm.ZeroFlow(name)


class Hard(pm.Component):
    """A mass on a spring that stiffens."""

    push = SinePush(force=20.0, frequency=0.5)
    mass = Mass(mass=1.0)
    spring = HardeningSpring(stiffness=20.0, cubic_stiffness=100.0)
    damper = Damper(damping=2.0)
    ground = Fixed()
    connections = (
        pm.connect(ground.flange, spring.a, damper.a),
        pm.connect(spring.b, damper.b, mass.flange, push.flange),
    )


@pytest.mark.parametrize(
    "reduce", [by_spectral_radius, by_frequency_response, by_balanced_truncation, by_modal_truncation]
)
def test_methods_for_linear_models_say_where_they_do_not_apply(reduce):
    curve = reduce(bench_of(Hard(), pm.Scenario(name="pushed", stop=8.0), "mass.flange.flow"))
    assert curve.models == ()
    assert "it is a method for linear models, and this run is none: the linear model at its start differs by" in (
        curve.not_applied
    )


@cache
def compared() -> MethodComparison:
    return compare_methods(
        pm.elaborate(driven.QuarterCar()),
        driven.waves(4.0),
        ["body.flange.flow"],
        tolerance=0.05,
        methods=[method for method in METHODS if method is not by_measured_error],
        **SETTINGS,
    )


def test_no_other_method_with_elements_gets_smaller():
    found = compared()
    ours = found.curves[0].smallest_within(0.05)
    assert ours is not None
    assert ours == found.curves[0].chosen
    for curve in found.curves[1:]:
        best = curve.smallest_within(0.05)
        assert best is None or best.rows is None or best.rows >= ours.rows
    text = str(found)
    assert "predicted and verified" in text
    assert "balanced truncation" in text


def test_what_cannot_be_compared_is_refused():
    model = pm.elaborate(driven.QuarterCar())
    for outputs, message in (([], "no outputs were given"), (["nothing.effort"], "does not exist")):
        with pytest.raises(pm.ProperModelError, match=message):
            compare_methods(model, driven.waves(), outputs)
    pushed = pm.Scenario(name="pushed", stop=40.0)
    with pytest.raises(pm.ProperModelError, match="did not reach its end"):
        compare_methods(
            pm.elaborate(Hard()), pushed, ["mass.flange.flow"], method=pm.Method.EULER, step=1.0, record_every=1.0
        )


def test_a_comparison_is_written_as_figure_table_and_data(tmp_path: FilePath):
    found = compared()
    assert [figure.name for figure in write_comparison(found, tmp_path)] == [
        "methods.png",
        "methods.csv",
        "methods.json",
    ]
    data = json.loads((tmp_path / "methods.json").read_text())
    assert (data["format"], data["version"]) == ("propermodel-method-comparison", 1)
    assert [method["method"] for method in data["methods"]] == [curve.method for curve in found.curves]
    with (tmp_path / "methods.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(curve.models) for curve in found.curves)
    first = next(row for row in rows if row["is_chosen"] == "1")
    assert first["method"] == "predicted and verified"
    assert float(first["error_rms_over_range"]) <= 0.05
    assert (tmp_path / "methods.png").stat().st_size > 10_000
