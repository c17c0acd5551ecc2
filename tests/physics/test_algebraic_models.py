"""Models without a state: compiled, run, balanced, ranked and saved like any other."""

from __future__ import annotations

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend, Method
from propermodel.diagnostics import ReductionError
from propermodel.library.electrical import CurrentSource, Ground, Resistor, VoltageSource
from propermodel.modelling import Component, Input, TableValues, connect
from propermodel.simulation.simulate import simulate
from propermodel.simulation.storage import load_trajectory, save_trajectory
from tests.physics.systems import compiled, run, scenario, system

RAMP = TableValues(((0.0, 1.0),), (0.0, 10.0))


class Ladder(Component):
    """A voltage on three resistors, with a current drawn at the node between them."""

    voltage = Input("V")
    current = Input("A")

    supply = VoltageSource()
    load = CurrentSource()
    first = Resistor(resistance=2.0)
    second = Resistor(resistance=3.0)
    third = Resistor(resistance=6.0)
    ground = Ground()

    connections = (
        connect(voltage, supply.voltage),
        connect(current, load.current),
        connect(supply.pin, first.a),
        connect(first.b, second.a, third.a, load.pin),
        connect(second.b, third.b, ground.pin),
    )


@pytest.mark.parametrize("method", list(Method))
@pytest.mark.parametrize("backend", list(Backend))
def test_a_resistive_network_follows_its_sources(backend: Backend, method: Method):
    made = compiled(Ladder(), backend)
    assert made.system.states == ()
    r = run(made, 1.0, step=0.01, method=method, inputs={"voltage": RAMP, "current": 1.5})
    # (u - v) / 2 + 1.5 = v / 3 + v / 6.
    u = 10.0 * r.time
    v = 0.5 * u + 1.5
    assert np.allclose(r["second.port.effort"], v, rtol=0.0, atol=1e-12)
    assert np.allclose(r["first.port.flow"], (u - v) / 2.0, rtol=0.0, atol=1e-12)
    balance = energy_balance(r)
    assert balance.stored == 0.0
    assert balance.relative_residual < 1e-12
    # The mean of u^2 is 100/3, of u 5: the sources give u (u - v) / 2 and 1.5 v.
    if method is Method.RK4:
        assert balance.dissipated == pytest.approx(0.5 * (0.5 * 100.0 / 3.0 - 1.5 * 5.0) + 1.5 * (2.5 + 1.5), rel=1e-9)


def test_a_model_without_states_is_ranked_and_saved(tmp_path):
    r = run(Ladder(), 1.0, step=0.01, inputs={"voltage": RAMP})
    ranking = rank_activity(r)
    # Without the current source: 2 Ohm carry i, 3 and 6 Ohm 2/3 and 1/3 of it.
    assert {str(row.path): round(row.index, 9) for row in ranking.rows} == {
        "first": 0.5,
        "second": round(1.0 / 3.0, 9),
        "third": round(1.0 / 6.0, 9),
    }
    save_trajectory(r, tmp_path / "run.npz")
    stored = load_trajectory(tmp_path / "run.npz")
    assert np.array_equal(stored["first.port.flow"], r["first.port.flow"])


def test_a_run_without_states_goes_on():
    made = compiled(Ladder())
    given = {"voltage": RAMP, "current": 1.5}
    whole = run(made, 1.0, step=0.01, inputs=given)
    half = run(made, 0.5, step=0.01, inputs=given)
    rest = simulate(made, scenario(1.0, inputs=given), method=Method.RK4, step=0.01, continued_from=half)
    assert rest.at_end("third.port.flow") == whole.at_end("third.port.flow")


@pytest.mark.parametrize("backend", list(Backend))
def test_a_model_without_sources_and_states_is_at_rest(backend: Backend):
    one, other, ground = Resistor(resistance=1.0), Resistor(resistance=2.0), Ground()
    model = system(connect(one.a, other.a), connect(one.b, other.b, ground.pin), one=one, other=other, ground=ground)
    r = run(model, 1.0, backend=backend)
    assert set(r["one.port.effort"]) == set(r["other.port.flow"]) == {0.0}
    assert energy_balance(r).supplied == 0.0
    with pytest.raises(ReductionError, match="nothing is active"):
        rank_activity(r)
