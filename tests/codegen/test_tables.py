"""Tables: what is accepted, and what is answered inside, outside and at the points of their grids."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.machine import Method, TableData
from propermodel.codegen.program import Extrapolation, TableSlot
from propermodel.codegen.tables import check_table
from propermodel.diagnostics import Path
from propermodel.expressions.core import lookup, slope
from tests.codegen.programs import Draft

BACKENDS = pytest.mark.parametrize("backend", Backend)
GRID = [-1.0, -0.5, 0.0, 0.5, 1.0]
VALUES = [0.3, -0.2, 0.7, 0.1, -0.4]
OTHER = [0.0, 1.0, 2.0]
SHEET = np.sin(np.arange(15.0)).reshape(5, 3)
PLACES = [-np.inf, -1e9, -3.0, -1.0, -0.75, -0.5, -1e-12, 0.0, 0.2, 0.5, 0.9999, 1.0, 1.7, 1e9, np.inf]


def answers(
    backend: Backend, extrapolation: Extrapolation, is_uniform: bool, coordinates: list[tuple[float, float]]
) -> np.ndarray:
    """For each pair of coordinates: value and slope in one dimension, value and both slopes in two."""
    draft = Draft()
    line = draft.table("line", [GRID], VALUES, extrapolation, is_uniform)
    sheet = draft.table("sheet", [GRID, OTHER], SHEET, extrapolation, is_uniform)
    for i in range(len(coordinates)):
        x, y = draft.state(f"x{i}"), draft.state(f"y{i}")
        for signal in (
            lookup(line, x),
            slope(line, 0, x),
            lookup(sheet, x, y),
            slope(sheet, 0, x, y),
            slope(sheet, 1, x, y),
        ):
            draft.signal(signal)
    memory = draft.memory()
    memory.state[:] = np.array(coordinates).ravel()
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    return machine.observe(memory).reshape(-1, 5)


@pytest.mark.parametrize("is_uniform", [False, True])
@BACKENDS
def test_inside_the_answer_is_the_linear_interpolation(backend: Backend, is_uniform: bool) -> None:
    random = np.random.default_rng(1)
    points = [(float(x), float(y)) for x, y in zip(random.uniform(-1, 1, 40), random.uniform(0, 2, 40), strict=True)]
    found = answers(backend, Extrapolation.HOLD, is_uniform, points)
    np.testing.assert_allclose(found[:, 0], np.interp([x for x, _ in points], GRID, VALUES), atol=1e-15)
    expected = RegularGridInterpolator((np.array(GRID), np.array(OTHER)), SHEET)(points)
    np.testing.assert_allclose(found[:, 2], expected, atol=1e-14)


@pytest.mark.parametrize("is_uniform", [False, True])
@BACKENDS
def test_a_held_table_keeps_its_last_values_without_slope(backend: Backend, is_uniform: bool) -> None:
    found = answers(backend, Extrapolation.HOLD, is_uniform, [(x, 2.0) for x in PLACES])
    np.testing.assert_allclose(found[:, 0], np.interp(PLACES, GRID, VALUES), atol=1e-15)
    slopes = np.diff(VALUES) / 0.5
    inside = np.searchsorted(GRID, PLACES, side="right")
    # At a point of the grid the slope is that of the cell to its right, beyond the last point none.
    expected = [slopes[i - 1] if 0 < i < 5 else 0.0 for i in inside]
    np.testing.assert_allclose(found[:, 1], expected, atol=1e-15)
    np.testing.assert_allclose(found[:, 2], np.interp(PLACES, GRID, SHEET[:, 2]), atol=1e-15)
    np.testing.assert_array_equal(found[:, 4], 0.0)


@pytest.mark.parametrize("is_uniform", [False, True])
@BACKENDS
def test_a_continued_table_goes_on_with_its_last_slopes(backend: Backend, is_uniform: bool) -> None:
    found = answers(backend, Extrapolation.LINEAR, is_uniform, [(-3.0, -1.0), (3.0, 4.0)])
    np.testing.assert_allclose(found[:, 0], [0.3 + 2.0 * 1.0, -0.4 - 2.0 * 1.0])
    np.testing.assert_allclose(found[:, 1], [-1.0, -1.0])

    def corner(i: int, j: int, x: float, y: float) -> float:
        a, b = (SHEET[i, j] + (SHEET[i, j + 1] - SHEET[i, j]) * (y - OTHER[j]) for i in (i, i + 1))
        return a + (b - a) * (x - GRID[i]) / 0.5

    np.testing.assert_allclose(found[:, 2], [corner(0, 0, -3.0, -1.0), corner(3, 1, 3.0, 4.0)], rtol=1e-13)


@pytest.mark.parametrize("extrapolation", Extrapolation)
@BACKENDS
def test_computed_and_searched_cells_are_the_same(backend: Backend, extrapolation: Extrapolation) -> None:
    places = [(x, y) for x in PLACES[1:-1] for y in (-1.0, 0.0, 1.0, 1.5, 2.0, 9.0)]
    found = [answers(backend, extrapolation, is_uniform, places) for is_uniform in (False, True)]
    np.testing.assert_array_equal(found[0], found[1])


@pytest.mark.parametrize("is_uniform", [False, True])
@BACKENDS
def test_not_a_number_is_answered_with_not_a_number(backend: Backend, is_uniform: bool) -> None:
    found = answers(backend, Extrapolation.HOLD, is_uniform, [(np.nan, 0.5), (0.2, np.nan)])
    assert np.isnan(found[0, [0, 2]]).all()
    assert np.isnan(found[1, 2])


@BACKENDS
def test_a_single_point_is_a_constant(backend: Backend) -> None:
    draft = Draft()
    x = draft.state("x", 7.0)
    for extrapolation in Extrapolation:
        for is_uniform in (False, True):
            table = draft.table(f"{extrapolation}{is_uniform}", [[2.0]], [3.0], extrapolation, is_uniform)
            draft.signal(lookup(table, x) + slope(table, 0, x))
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    assert machine.observe(draft.memory()).tolist() == [3.0] * 4


@pytest.mark.parametrize(
    ("grids", "values", "message"),
    [
        (([0.0, 1.0], [0.0, 1.0]), np.zeros((2, 2)), "has 1 coordinates, but 2 grids are given"),
        (([0.0, 2.0, 1.0],), [1.0, 2.0, 3.0], "grid 0 must grow, but 1.0 follows 2.0"),
        (([0.0, np.nan],), [1.0, 2.0], "grid 0 has a number that is not finite"),
        (([0.0, 1.0],), [1.0, 2.0, 3.0], r"needs values of shape \(2,\), not \(3,\)"),
        (([0.0, 1.0],), [1.0, np.inf], "has a value that is not finite"),
        (([0.0, 1.0, 3.0],), [1.0, 2.0, 3.0], "grid 0 must be equidistant, but its gaps are 1.0 to 2.0"),
        (([],), [], "grid 0 must be a list of numbers"),
    ],
)
def test_data_that_do_not_fit_are_refused_by_the_table_s_name(grids: object, values: object, message: str) -> None:
    slot = TableSlot(Path(("engine", "map")), 1, Extrapolation.HOLD, is_uniform=True)
    data = TableData(tuple(np.array(grid) for grid in grids), np.array(values))  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=rf"table 'engine.map'.*{message}"):
        check_table(slot, data)


@BACKENDS
def test_another_table_needs_no_other_machine(backend: Backend) -> None:
    draft = Draft()
    x = draft.state("x", 0.25)
    draft.signal(lookup(draft.table("line", [[0.0, 1.0]], [0.0, 1.0]), x))
    machine = build_machine(draft.program(), Method.EULER, backend=backend)
    memory = draft.memory()
    assert machine.observe(memory).tolist() == [0.25]
    memory.tables = (TableData((np.array([0.0, 0.1, 0.5]),), np.array([1.0, 2.0, 6.0])),)
    assert machine.observe(memory)[0] == pytest.approx(3.5)
