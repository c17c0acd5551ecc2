"""The judge of the galleries knows what the package knows, by other means; searches are compared with all subsets."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

import propermodel as pm
from benchmarks.conditions import conditions
from benchmarks.galleries.bent import draw_bent_gallery
from benchmarks.galleries.cases import cases_of, clear_of_borders, forecast_of
from benchmarks.galleries.exhaustion import Choice, Exhaustion, Meaning, exhaust
from benchmarks.galleries.families import FAMILIES, draw_gallery
from benchmarks.galleries.judge import Lines, respond
from benchmarks.galleries.march import GIVEN_UP, exhaust_bent, run_bent
from benchmarks.galleries.models import model_of, observable, port_of, scenario_of
from benchmarks.galleries.network import INTERVALS, Element, Half, Law, Network
from benchmarks.galleries.page import write_page
from benchmarks.galleries.summary import tally

ALL = {network.name: network for network in draw_gallery(2 * len(FAMILIES))}
BENT = {network.name: network for network in draw_bent_gallery(11)}


def run_of(network: Network, model: pm.Model) -> pm.Trajectory:
    return pm.simulate(
        pm.compile_model(model),
        scenario_of(network),
        method=pm.Method.RODAS,
        tolerance=1e-7,
        record_every=network.stop / INTERVALS,
    )


def removal_of(element: Element, choice: Choice) -> pm.Removal:
    port, is_effort = port_of(element), choice.half is Half.EFFORT
    if choice.meaning is Meaning.CONSTANT:
        return (pm.ConstantEffort if is_effort else pm.ConstantFlow)(port, choice.value)
    return (pm.ZeroEffort if is_effort else pm.ZeroFlow)(port)


@pytest.mark.parametrize(
    "name", ["half_car_2", "motor_with_a_load_2", "hydrostatic_drive_with_a_load_1", "loudspeaker_1"]
)
def test_full_networks_respond_as_their_models_do(name: str):
    network = ALL[name]
    response, run = respond(network), run_of(network, model_of(network))
    count = len(network.elements)
    found = Lines(network.stop).instants(response.moved) + response.equilibrium[:, np.newaxis]
    for number, element in enumerate(network):
        for half, values in ((Half.EFFORT, found[number]), (Half.FLOW, found[count + number])):
            expected = run[port_of(element) / half.value]
            size = np.sqrt(np.mean((expected - expected[0]) ** 2)) + 1e-3 * np.max(np.abs(expected))
            assert np.sqrt(np.mean((values - expected) ** 2)) <= 0.01 * size, (element.name, half)


@pytest.mark.parametrize("name", ["quarter_car_with_weight_1", "driveline_1", "hydraulic_circuit_under_pressure_1"])
def test_smaller_networks_change_outputs_as_smaller_models_do(name: str):
    network = ALL[name]
    truth, model = exhaust(network), model_of(network)
    full, outputs = run_of(network, model), [observable(network, output) for output in network.outputs]
    asked = [network.number(output.element) for output in network.outputs]
    is_asked = np.any(truth.meanings[:, asked] == Meaning.CONSTANT, axis=1)  # then it is no observable any more
    near = np.flatnonzero((truth.worst > 1e-3) & (truth.worst < 0.3) & ~is_asked)
    for row in np.random.default_rng(1).choice(near, 8, replace=False):
        removals = [
            removal_of(element, choices[meaning])
            for element, choices, meaning in zip(network, truth.choices, truth.meanings[row], strict=True)
            if meaning
        ]
        found = pm.compare(full, run_of(network, model.without(removals)), outputs)
        for output, expected in zip(found.outputs, truth.errors[row], strict=True):
            assert output.rms == pytest.approx(expected, rel=5e-3, abs=2e-4), removals


def test_what_is_left_out_has_no_solution_or_one_that_others_have_too():
    """One constraint stated twice is no fault if it is the same: then another way to remove the same gives the same."""
    network = ALL["translational_chain_1"]
    truth, model, outputs = exhaust(network), model_of(network), [observable(network, o) for o in network.outputs]
    solved = {tuple(row) for row in truth.meanings.tolist()}
    every = list(itertools.product(*(range(len(choices)) for choices in truth.choices)))
    assert truth.tried == len(every) > len(solved) > 0.3 * len(every)
    full = run_of(network, model)
    for meanings in np.random.default_rng(2).permutation([m for m in every if m not in solved])[:25]:
        removals = [
            removal_of(element, choices[meaning])
            for element, choices, meaning in zip(network, truth.choices, meanings, strict=True)
            if meaning
        ]
        try:
            found = pm.compare(full, run_of(network, model.without(removals)), outputs)
        except pm.ProperModelError:
            continue
        twins = truth.errors[np.all((truth.meanings == 0) == (meanings == 0), axis=1)]
        assert np.min(np.max(np.abs(twins - [output.rms for output in found.outputs]), axis=1)) < 2e-3


def test_the_smallest_model_of_all_subsets_is_found():
    network = ALL["driveline_on_a_slope_1"]
    truth = exhaust(network)
    for case in cases_of(network, truth, (0.01, 0.05)):
        assert case.missed == 0
        assert case.error <= 1.0
        assert case.judged == pytest.approx(case.error, rel=0.01)
        assert case.simulations <= 5 * case.elements
        assert len(case.best) == case.optimum >= 2


@pytest.mark.parametrize(
    "name",
    [
        "bent_quarter_car_1",
        "bent_geared_rotors_1",
        "bent_hydraulic_circuit_1",
        "bent_quarter_car_with_weight_1",
        "bent_driveline_on_a_slope_1",
        "bent_motor_with_a_load_1",
    ],
)
def test_bent_networks_respond_as_their_models_do(name: str):
    network = BENT[name]
    assert any(element.law is not Law.LINEAR for element in network)
    run, found, count = run_of(network, model_of(network)), run_bent(network), len(network.elements)
    for output in network.outputs:
        expected = run[observable(network, output)]
        values = found[network.number(output.element) + (count if output.half is Half.FLOW else 0)]
        assert np.sqrt(np.mean((values - expected) ** 2)) <= 2e-3 * np.ptp(expected)


@pytest.mark.parametrize("name", ["bent_quarter_car_with_weight_1", "bent_hydraulic_circuit_under_pressure_1"])
def test_smaller_bent_networks_that_carry_a_load_change_outputs_as_smaller_models_do(name: str):
    network = BENT[name]
    truth, model = exhaust_bent(network), model_of(network)
    full, outputs = run_of(network, model), [observable(network, output) for output in network.outputs]
    asked = [network.number(output.element) for output in network.outputs]
    is_asked = np.any(truth.meanings[:, asked] == Meaning.CONSTANT, axis=1)
    near = np.flatnonzero((truth.worst > 1e-3) & (truth.worst < 0.1) & ~is_asked)
    assert len(near) >= 3
    for row in np.random.default_rng(1).choice(near, min(5, len(near)), replace=False):
        removals = [
            removal_of(element, choices[meaning])
            for element, choices, meaning in zip(network, truth.choices, truth.meanings[row], strict=True)
            if meaning
        ]
        found = pm.compare(full, run_of(network, model.without(removals)), outputs)
        for output, expected in zip(found.outputs, truth.errors[row], strict=True):
            assert output.rms == pytest.approx(expected, rel=0.02, abs=2e-4), removals


@pytest.mark.parametrize("name", ["hydraulic_circuit_1", "hydraulic_circuit_under_pressure_1"])
def test_both_judges_agree_on_a_linear_network(name: str):
    network = ALL[name]
    exact, stepped = exhaust(network), exhaust_bent(network)
    assert {tuple(row) for row in exact.meanings.tolist()} == {tuple(row) for row in stepped.meanings.tolist()}
    for meanings, errors in zip(stepped.meanings, stepped.errors, strict=True):
        expected = exact.at(meanings)
        assert expected is not None
        if np.all(np.isfinite(errors)):
            assert errors == pytest.approx(expected, rel=0.02, abs=2e-4)
        else:
            assert np.max(expected) > 0.95 * GIVEN_UP


def case(**given: object) -> dict[str, object]:
    usual: dict[str, object] = {"system": "a_1", "family": "a", "elements": 8, "is_biased": False, "tolerance": 0.01}
    usual |= {"optimum": 3, "found": 3, "missed": 0, "error": 0.5, "judged": 0.5, "simulations": 4, "exhaustive": 1000}
    return usual | {"removals": ["x no flow"], "best": ["x no flow"], "best_error": 0.9} | given


def test_the_page_tells_misses(tmp_path: Path):
    cases = [case(), case(tolerance=0.02, missed=2, found=1, simulations=12), case(missed=-1, found=4)]
    found = tally(cases)
    assert (found.cases, found.optimum, found.smaller, found.one_more, found.two_more, found.outside) == (
        3,
        2,
        1,
        0,
        1,
        0,
    )
    assert (found.simulations, found.most_each, found.largest_share) == (4.0, 1.5, 0.012)
    forecast = {
        "predicted": [1.0, 2.0, 3.0],
        "true": [1.0, 2.0, 4.0],
        "activity": [3.0, 2.0, 1.0],
        "ratios": [1.0, 0.4],
    }
    data = {"linear": {"cases": cases, "forecasts": [forecast]}, "command": "make", "conditions": conditions()}
    write_page(data, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text()
    assert "| all | 3 | 66.7% | 0 | 1 | 0 |" in text
    assert "| `a_1` | 2.00% | 1 | 3 | x no flow | x no flow | 0.90 |" in text
    assert "| predicted error | 1.000 | 1.000 | 50.0% |" in text
    assert "| activity | -1.000 |" in text
    assert "not linear" not in text


def test_predictions_are_compared_with_what_is_true():
    network = ALL["motor_1"]
    forecast = forecast_of(network, exhaust(network))
    assert set(forecast.elements) == {element.name for element in network}
    assert np.all(np.abs(np.log(forecast.ratios)) < np.log(2.0))
    assert sum(forecast.activity) == pytest.approx(1.0)


def test_tolerances_keep_off_errors_that_decide():
    errors = np.array([[0.0], [0.0101], [0.03]])
    meanings = np.array([[0, 0], [1, 0], [1, 1]], dtype=np.int8)
    truth = Exhaustion(meanings, errors, ((), ()), 9)
    assert clear_of_borders(truth, 0.02) == 0.02
    assert clear_of_borders(truth, 0.01) * 0.98 > 0.0101
    assert truth.most_removed(0.02) == 1


def test_galleries_follow_from_their_seed():
    first, again, other = draw_gallery(3), draw_gallery(3), draw_gallery(3, seed=2)
    assert [n.elements for n in first] == [n.elements for n in again]
    assert [n.elements for n in first] != [n.elements for n in other]
