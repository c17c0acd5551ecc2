"""Driving and driven parts: found, cut one way, and run apart."""

from __future__ import annotations

import json

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.diagnostics import ReductionError, parse_path
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    Cut,
    Prescribe,
    ZeroEffort,
    connect,
    elaborate,
)
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import TableValues, Variable
from propermodel.reduction.part_runs import part_model, simulate_parts
from propermodel.reduction.partition import Role, partition
from propermodel.reduction.plan import plan_reduction
from tests.physics.systems import Shaking, eigenvalues, run, system
from tests.reduction.failure_modes.test_whole_models import sensing
from tests.reduction.rigs import listener, quarter_car


def passenger(mass: float = 0.02) -> Component:
    """An oscillator that carries a much lighter one, with another lighter one upon it."""
    shaker, ground = Shaking(velocity=1.0, frequency=1.3), Fixed()
    link, mass_, spring, damper = Spring(stiffness=300.0), Mass(mass=5.0), Spring(stiffness=200.0), Damper(damping=4.0)
    soft, small, loss = Spring(stiffness=400.0 * mass), Mass(mass=mass), Damper(damping=2.0 * mass)
    softer, tiny = Spring(stiffness=0.05 * mass), Mass(mass=0.01 * mass)
    return system(
        connect(shaker.flange, link.a),
        connect(link.b, mass_.flange, spring.a, damper.a, soft.a, loss.a),
        connect(spring.b, damper.b, ground.flange),
        connect(soft.b, loss.b, small.flange, softer.a),
        connect(softer.b, tiny.flange),
        shaker=shaker,
        ground=ground,
        link=link,
        mass=mass_,
        spring=spring,
        damper=damper,
        soft=soft,
        small=small,
        loss=loss,
        softer=softer,
        tiny=tiny,
    )


OUTPUTS = ("mass.flange.flow", "small.flange.flow", "tiny.flange.flow")


@pytest.fixture(scope="module")
def full():
    return run(passenger(), 6.0, step=1e-3, every=3e-3)


@pytest.fixture(scope="module")
def parts(full):
    return partition(full, tolerance=0.05, outputs=OUTPUTS)


def part_of(found, row):
    return next(part for part in found.parts if parse_path(row) in part.rows)


def test_what_is_light_is_driven_and_what_is_heavy_drives(parts):
    heavy, light, lightest = (part_of(parts, row) for row in ("mass", "small", "tiny"))
    assert (heavy.role, light.role, lightest.role) == (Role.DRIVING, Role.BETWEEN, Role.DRIVEN)
    assert {"link", "mass", "spring", "damper"} <= set(map(str, heavy.rows))
    assert heavy.number < light.number < lightest.number
    assert [part.stage for part in (heavy, light, lightest)] == [0, 1, 2]
    assert [tuple(map(str, part.outputs)) for part in (heavy, light, lightest)] == [(o,) for o in OUTPUTS]


def test_every_cut_is_small_where_it_is_made_and_measured(full, parts):
    for cut in parts.cuts:
        assert cut.share <= 0.05
        alone = run(full.compiled.model.without([cut.removal]), 6.0, step=1e-3, every=3e-3)
        errors = [np.sqrt(np.mean((alone[o] - full[o]) ** 2)) / np.ptp(full[o]) for o in OUTPUTS]
        assert cut.error == pytest.approx(max(errors), rel=0.02)
    assert max(output.rms for output in parts.comparison.outputs) < 0.05


def test_with_cuts_the_spectrum_is_that_of_the_parts(full, parts):
    # What is driven does not act back: the matrix is block triangular, its eigenvalues those of the parts alone.
    together = eigenvalues(full.compiled.model.without(parts.removals))
    alone = np.concatenate([eigenvalues(part_model(parts, part.number)) for part in parts.parts])
    assert np.allclose(np.sort_complex(together), np.sort_complex(alone), rtol=1e-6, atol=1e-6)
    assert not np.allclose(np.sort_complex(together), np.sort_complex(eigenvalues(full.compiled)), rtol=1e-4, atol=1e-4)


def test_parts_run_one_after_the_other_with_the_same_answer(full, parts):
    runs = simulate_parts(parts, full)
    together = {output.path: output.rms for output in parts.comparison.outputs}
    assert {error.path for error in runs.errors} == set(together)
    for error in runs.errors:
        assert error.rms == pytest.approx(together[error.path], abs=2e-4)
    states = sum(len(r.compiled.system.states) for r in runs.runs.values())
    assert states == len(full.compiled.system.states)


def test_a_heavy_passenger_is_no_passenger():
    found = partition(run(passenger(mass=2.0), 6.0, step=1e-3, every=3e-3), tolerance=0.05)
    assert part_of(found, "mass").number == part_of(found, "small").number
    assert part_of(found, "tiny").role is Role.DRIVEN


def test_the_body_of_the_car_at_ten_hertz_is_driven():
    r = run(quarter_car(velocity=0.3, frequency=10.0), 2.0, step=5e-4, every=1e-3)
    found = partition(r, tolerance=0.05, outputs=["body.flange.effort", "tyre.spring.port.effort"])
    (cut,) = found.cuts
    assert cut.removal == Cut(parse_path("body.flange"), Variable.EFFORT)
    assert cut.share == pytest.approx(0.0206, rel=0.05)
    assert found.parts[1].rows == (parse_path("body"),)
    assert [part.number for part in found.needed] == [1, 2]
    only_tyre = partition(r, tolerance=0.05, outputs=["tyre.spring.port.effort"])
    assert [part.number for part in only_tyre.needed] == [1]  # the body could go


def test_signals_that_lead_back_hold_parts_together():
    r = run(sensing(share=5.0), 4.0, step=1e-3, every=2e-3)
    found = partition(r, tolerance=0.1)
    # The feeler hardly acts on the mass; but the damper listens to it.
    assert part_of(found, "feeler").number == part_of(found, "damper").number


def test_a_partition_is_plain_data_and_reads_well(parts):
    document = json.loads(json.dumps(parts.document(), allow_nan=False))
    assert document["parts"][0]["role"] == "driving"
    assert {cut["passes_on"] for cut in document["cuts"]} <= {"effort", "flow"}
    text = str(parts)
    assert "part 1, driving" in text
    assert "from part 1 to part 2, but not back" in text


def test_a_prescribed_bond_is_an_input_of_the_scenario_and_of_the_document():
    model = elaborate(quarter_car()).without([Prescribe(parse_path("body.flange"), Variable.EFFORT)])
    assert from_document(to_document(model)) == model
    steady = TableValues(((0.0, 1.0),), (1200.0, 1200.0))
    r = run(model, 0.5, step=1e-3, inputs={"body.flange.effort": steady})
    assert r.at_end("body.flange.flow") == pytest.approx(0.5)  # 1200 N on 1200 kg for half a second


def test_a_cut_between_junctions_is_driven_by_the_one_that_shares_the_variable(full, parts):
    cut = next(cut for cut in parts.cuts if cut.driving == 1)
    bond = full.compiled.graph.normal.bonds[cut.removal.bond]
    assert not bond.head.port
    assert not bond.tail.port
    r = run(full.compiled.model.without([cut.removal]), 6.0, step=1e-3, every=3e-3)
    alone = system(
        connect((shaker := Shaking(velocity=1.0, frequency=1.3)).flange, (link := Spring(stiffness=300.0)).a),
        connect(
            link.b,
            (mass := Mass(mass=5.0)).flange,
            (spring := Spring(stiffness=200.0)).a,
            (damper := Damper(damping=4.0)).a,
        ),
        connect(spring.b, damper.b, (ground := Fixed()).flange),
        shaker=shaker,
        link=link,
        mass=mass,
        spring=spring,
        damper=damper,
        ground=ground,
    )
    # What drives moves as if the passengers were not there.
    assert np.allclose(r["mass.flange.flow"], run(alone, 6.0, step=1e-3, every=3e-3)["mass.flange.flow"], atol=1e-12)


def test_an_output_that_does_not_exist_is_told(full):
    with pytest.raises(ReductionError, match=r"the output 'mass\.flange\.speed' does not exist"):
        partition(full, outputs=["mass.flange.speed"])


def test_parts_that_read_signals_of_others_are_not_run_apart():
    r = run(listener(), 6.0, step=1e-3, every=3e-3)
    found = partition(r, tolerance=0.05, outputs=["small.flange.flow"])
    assert part_of(found, "small").role is Role.DRIVEN
    assert found.comparison.outputs[0].rms < 0.02  # with its cuts the model runs as one
    with pytest.raises(ReductionError, match="part 2 reads signals of other parts, at mass"):
        simulate_parts(found, r)


def test_driven_parts_without_outputs_are_what_a_plan_may_drop(full):
    reduction = plan_reduction(full.compiled, full, rank_activity(full), threshold=0.99, tolerance=0.05)
    gone = {str(d.row.path) for d in reduction.removed}
    assert "tiny" in gone
    assert ZeroEffort(parse_path("mass.flange")) not in reduction.removals
