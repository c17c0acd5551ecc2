"""A removal is the limit of a parameter: the reduced model has the finite eigenvalues of the full one driven there."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations, permutations

import numpy as np
import pytest

from propermodel.diagnostics import parse_path
from propermodel.library.mechanics.translation import Damper, Spring
from propermodel.modelling import Component, Removal, ZeroEffort, ZeroFlow, elaborate
from tests.physics.systems import close, compiled, eigenvalues, run
from tests.reduction.rigs import driveline, ladder, quarter_car, two_masses


def no_effort(*bonds: str) -> list[Removal]:
    return [ZeroEffort(parse_path(bond)) for bond in bonds]


def no_flow(*bonds: str) -> list[Removal]:
    return [ZeroFlow(parse_path(bond)) for bond in bonds]


def finite(values: np.ndarray, bound: float = 1e5) -> np.ndarray:
    """Eigenvalues below a bound, without the zeros of coordinates that nothing depends on any more."""
    return np.array([v for v in values if 1e-4 < abs(v) < bound])


def assert_same_spectrum(found: np.ndarray, expected: np.ndarray, tolerance: float = 1e-5) -> None:
    assert len(found) == len(expected), (found, expected)
    rest = list(expected)
    for value in found:
        nearest = min(rest, key=lambda other: abs(other - value))
        assert abs(nearest - value) <= tolerance * max(abs(value), 1.0), (found, expected)
        rest.remove(nearest)


SMALL = 1e-10

LIMITS: list[tuple[str, object, list[Removal], Mapping[str, float]]] = [
    ("wheel without mass", quarter_car, no_effort("wheel.flange"), {"wheel.mass": SMALL}),
    ("wheel held", quarter_car, no_flow("wheel.flange"), {"wheel.mass": 1e15}),
    ("body held", quarter_car, no_flow("body.flange"), {"body.mass": 1e15}),
    ("no tyre damper", quarter_car, no_effort("tyre.damper.port"), {"tyre.damper.damping": 0.0}),
    ("no suspension spring", quarter_car, no_effort("suspension.spring.port"), {"suspension.spring.stiffness": 0.0}),
    ("no suspension damper", quarter_car, no_effort("suspension.damper.port"), {"suspension.damper.damping": 0.0}),
    ("rigid tyre", quarter_car, no_flow("tyre.spring.port"), {"tyre.spring.stiffness": 1e13}),
    ("rigid suspension", quarter_car, no_flow("suspension.spring.port"), {"suspension.spring.stiffness": 1e13}),
    ("locked damper", quarter_car, no_flow("suspension.damper.port"), {"suspension.damper.damping": 1e12}),
    (
        "wheel without mass or damper",
        quarter_car,
        no_effort("wheel.flange", "tyre.damper.port"),
        {"wheel.mass": SMALL, "tyre.damper.damping": 0.0},
    ),
    ("engine without inertia", driveline, no_effort("engine.shaft"), {"engine.inertia": SMALL}),
    ("pinion without inertia", driveline, no_effort("pinion.shaft"), {"pinion.inertia": 0.0}),
    ("load without inertia", driveline, no_effort("load.shaft"), {"load.inertia": SMALL}),
    ("rigid shaft", driveline, no_flow("shaft.spring.port"), {"shaft.spring.stiffness": 1e12}),
    ("shaft without damping", driveline, no_effort("shaft.damper.port"), {"shaft.damper.damping": 0.0}),
    ("no bearing", driveline, no_effort("bearing.shaft"), {"bearing.damping": 0.0}),
    (
        "load alone on the shaft",
        driveline,
        no_effort("engine.shaft", "pinion.shaft"),
        {"engine.inertia": SMALL, "pinion.inertia": SMALL},
    ),
    ("no first capacitor", ladder, no_flow("c1.port"), {"c1.capacitance": 1e-12}),
    ("no second capacitor", ladder, no_flow("c2.port"), {"c2.capacitance": 1e-12}),
    ("no first coil", ladder, no_effort("l1.port"), {"l1.inductance": 1e-12}),
    ("no second coil", ladder, no_effort("l2.port"), {"l2.inductance": 1e-12}),
    ("no first resistor", ladder, no_effort("r1.port"), {"r1.resistance": 0.0}),
    ("load taken off", ladder, no_flow("load.port"), {"load.resistance": 1e12}),
    ("load shorted", ladder, no_effort("load.port"), {"load.resistance": 1e-9}),
    ("capacitor as a source of nothing", ladder, no_effort("c1.port"), {"c1.capacitance": 1e12}),
    ("no capacitors", ladder, no_flow("c1.port", "c2.port"), {"c1.capacitance": 1e-9, "c2.capacitance": 1e-9}),
]


@pytest.mark.parametrize(("make", "removals", "parameters"), [x[1:] for x in LIMITS], ids=[x[0] for x in LIMITS])
def test_a_removal_is_the_limit_of_a_parameter(make, removals, parameters):
    reduced = compiled(elaborate(make()).without(removals))
    limit = eigenvalues(make(), parameters=parameters)
    assert_same_spectrum(finite(eigenvalues(reduced)), finite(limit))


def test_a_trajectory_follows_the_limit_too():
    removals = no_effort("wheel.flange", "tyre.damper.port")
    reduced = run(elaborate(quarter_car()).without(removals), 1.0, step=1e-4)
    full = run(quarter_car(), 1.0, step=1e-5, parameters={"wheel.mass": 2e-2, "tyre.damper.damping": 0.0})
    for path in ("body.flange.flow", "suspension.a.effort", "suspension.spring.port.displacement", "tyre.b.flow"):
        close(reduced[path], full[path], 1e-3)


def test_what_was_removed_can_still_be_observed():
    full = run(quarter_car(), 1.0, step=1e-5, parameters={"wheel.mass": 2e-2})
    reduced = run(elaborate(quarter_car()).without(no_effort("wheel.flange")), 1.0, step=1e-4)
    close(reduced["wheel.flange.flow"], full["wheel.flange.flow"], 1e-3)
    assert reduced["wheel.flange.effort"] == pytest.approx(0.0)
    rigid = run(elaborate(quarter_car()).without(no_flow("suspension.spring.port")), 1.0, step=1e-4)
    close(rigid["body.flange.flow"], rigid["wheel.flange.flow"], 1e-12)
    # A rigid link still passes its force: what the body needs.
    close(rigid["suspension.b.effort"], -rigid["body.flange.effort"], 1e-12)


# -- parallel parts ------------------------------------------------------------------------------------------

SUBSETS = [c for n in range(1, 5) for c in combinations(range(4), n)]


def between(indices) -> Component:
    fresh = [Spring(stiffness=30.0), Damper(damping=2.0), Spring(stiffness=70.0), Damper(damping=0.5)]
    return two_masses(*(fresh[n] for n in indices))


@pytest.mark.parametrize("gone", SUBSETS, ids=str)
def test_any_subset_of_parallel_parts_can_go(gone):
    left = [n for n in range(4) if n not in gone]
    model = elaborate(between(range(4)))
    at_once = compiled(model.without(no_effort(*(f"p{n}.port" for n in gone))))
    expected = eigenvalues(between(left)) if left else eigenvalues(between(range(4)), parameters=NOTHING)
    assert_same_spectrum(finite(eigenvalues(at_once)), finite(expected))


NOTHING = {"p0.stiffness": 0.0, "p1.damping": 0.0, "p2.stiffness": 0.0, "p3.damping": 0.0}


@pytest.mark.parametrize("order", list(permutations((0, 1, 2))), ids=str)
def test_the_order_of_removals_does_not_matter(order):
    model = elaborate(between(range(4)))
    for n in order:
        model = model.without(no_effort(f"p{n}.port"))
        compiled(model)
    assert_same_spectrum(finite(eigenvalues(model)), finite(eigenvalues(between([3]))))


@pytest.mark.parametrize("gone", SUBSETS, ids=str)
def test_locking_any_of_parallel_parts_locks_them_all(gone):
    model = elaborate(between(range(4))).without(no_flow(*(f"p{n}.port" for n in gone)))
    # Both masses on the holder.
    m, k, c = 5.0, 40.0, 1.0
    assert_same_spectrum(finite(eigenvalues(model)), np.roots([m, c, k]))


@pytest.mark.parametrize(("stays_soft", "locked"), list(permutations(range(3), 2)))
def test_a_part_may_go_and_another_lock_in_either_order(stays_soft, locked):
    first = [*no_effort(f"p{stays_soft}.port"), *no_flow(f"p{locked}.port")]
    for removals in (first, first[::-1]):
        assert_same_spectrum(
            finite(eigenvalues(elaborate(between(range(4))).without(removals))), np.roots([5.0, 1.0, 40.0])
        )


def test_a_reduced_model_can_be_reduced_again():
    model = elaborate(quarter_car())
    once = model.without(no_effort("tyre.damper.port"))
    twice = once.without(no_effort("wheel.flange"))
    together = model.without(no_effort("tyre.damper.port", "wheel.flange"))
    assert_same_spectrum(eigenvalues(twice), eigenvalues(together), 1e-12)
    assert twice.removals == together.removals
    both = (run(m, 0.5, step=1e-4) for m in (twice, together))
    one, other = (r["body.flange.flow"] for r in both)
    assert one.tobytes() == other.tobytes()


def test_the_parameters_of_what_stays_can_still_be_set():
    model = elaborate(quarter_car()).without(no_effort("wheel.flange"))

    light = eigenvalues(model, parameters={"body.mass": 600.0})
    full = eigenvalues(quarter_car(), parameters={"body.mass": 600.0, "wheel.mass": SMALL})
    assert_same_spectrum(finite(light), finite(full))
