"""Activity from frequency responses, against closed forms, quadrature, sampling, and long simulations."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from examples import quarter_car
from propermodel.analysis.frequency_ranking import mean_absolute_power
from propermodel.library.electrical import CoupledInductors, Ground, Resistor, VoltageSource
from propermodel.library.mechanics.translation import Damper, Fixed, ForceSource, Mass, Spring
from tests.physics.systems import scenario, system

Q = pm.quantity


def path(text: str) -> pm.Path:
    return pm.Path(tuple(text.split(".")))


# -- the mean of an absolute power -------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [0.0, 0.4, 1.2, math.pi / 2.0, 2.5, math.pi])
def test_phasors_give_the_mean_over_a_period(phase: float):
    effort, flow = 3.0, 2.0 * np.exp(1j * phase)
    x = np.linspace(0.0, 2.0 * math.pi, 400001)
    power = np.real(effort * np.exp(1j * x)) * np.real(flow * np.exp(1j * x))
    values = np.array([effort, flow])
    covariance = 0.5 * np.real(np.outer(values, values.conj()))
    assert mean_absolute_power(covariance, np.ones(1)) == pytest.approx(float(np.mean(np.abs(power))), rel=1e-5)


def test_several_ports_give_the_mean_of_their_powers_together():
    # The same phasors at two ports: the powers add up before the absolute value is taken.
    first, second = (3.0, 2.0 * np.exp(0.7j)), (1.5 * np.exp(-0.3j), -2.5 * np.exp(1.9j))
    x = np.linspace(0.0, 2.0 * math.pi, 400001)
    wave = np.exp(1j * x)
    power = sum(np.real(e * wave) * np.real(f * wave) for e, f in (first, second))
    values = np.array([first[0], second[0], first[1], second[1]])
    covariance = 0.5 * np.real(np.outer(values, values.conj()))
    assert mean_absolute_power(covariance, np.ones(2)) == pytest.approx(float(np.mean(np.abs(power))), rel=1e-5)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_normal_variables_give_the_mean_of_samples(count: int):
    generator = np.random.default_rng(count)
    root = generator.normal(size=(2 * count, 2 * count)) * np.repeat([1e4, 1e-5], count)[:, np.newaxis]
    signs = np.array([1.0, -1.0, 1.0])[:count]
    samples = root @ generator.normal(size=(2 * count, 2_000_000))
    powers = signs @ (samples[:count] * samples[count:])
    expected = float(np.mean(np.abs(powers)))
    assert mean_absolute_power(root @ root.T, signs) == pytest.approx(expected, rel=4e-3)


def test_a_resistance_has_the_mean_of_its_losses():
    assert mean_absolute_power(np.array([[9.0, 3.0], [3.0, 1.0]]), np.ones(1)) == pytest.approx(3.0, rel=1e-12)
    assert mean_absolute_power(np.zeros((2, 2)), np.ones(1)) == 0.0


# -- models ------------------------------------------------------------------------------------------------


class Oscillator(pm.Component):
    force = pm.Input("N")
    push, mass, spring = ForceSource(), Mass(mass=2.0), Spring(stiffness=50.0)
    damper, ground = Damper(damping=3.0), Fixed()
    connections = (
        pm.connect(force, push.force),
        pm.connect(push.flange, mass.flange, spring.a, damper.a),
        pm.connect(spring.b, damper.b, ground.flange),
    )


def oscillator() -> pm.CompiledModel:
    return pm.compile_model(pm.elaborate(Oscillator()))


def test_harmonic_indices_are_those_of_the_closed_form():
    # On a common flow of amplitude v: I m v^2 w / pi, C k v^2 / (pi w), R d v^2 / 2, as means.
    omegas = np.array([2.0, 5.0, 9.0])
    ranking = pm.rank_frequencies(oscillator(), scenario(1.0, inputs={"force": 0.0}), omegas)
    for part, w in zip(ranking.parts, omegas, strict=True):
        expected = {"mass": 2.0 * w / math.pi, "spring": 50.0 / (math.pi * w), "damper": 1.5}
        for name, value in expected.items():
            assert part.index(path(name)) == pytest.approx(value / sum(expected.values()), rel=1e-9)
    assert [part.name for part in ranking.parts] == ["0.3183 Hz", "0.7958 Hz", "1.432 Hz"]
    assert ranking.rows[0].largest_index == max(part.index(ranking.rows[0].path) for part in ranking.parts)


def test_a_frequency_agrees_with_a_long_run_at_that_frequency():
    car = pm.compile_model(pm.elaborate(quarter_car.QuarterCar()))
    run = pm.simulate(
        car, pm.Scenario(stop=12.0), method=pm.Method.RK4, step=5e-4, record_every=1.0, integrals_every=1.0
    )
    settled = pm.rank_activity(run, window=(8.0, 12.0))
    # Waves of 0.2 m/s at 1 Hz: of variance 0.02.
    found = pm.rank_frequencies(car, pm.Scenario(stop=1.0), [2.0 * math.pi], inputs=["road"], spectrum={"road": 0.02})
    for row in found.rows:
        expected = settled.row(row.path)
        assert row.index == pytest.approx(expected.index, rel=2e-3)
        assert row.activity == pytest.approx(expected.activity / 4.0, rel=2e-3)
    assert found.discretisation is None
    assert found.datums == ("efforts and flows: deviations from the start of scenario scenario",)


def test_a_spectrum_agrees_with_a_long_random_run():
    # A force of many sines whose amplitudes follow 1 / (1 + (w / 4)^2), with random phases: normal in the limit.
    lines, spacing = 240, 0.05
    omegas = spacing * (np.arange(lines) + 0.5)
    density = 4.0 / (1.0 + (omegas / 4.0) ** 2)
    phases = np.random.default_rng(5).uniform(0.0, 2.0 * math.pi, lines)
    time = np.arange(0.0, 2.0 * math.pi / spacing * 8.0 + 20.0, 0.02)
    force = np.sqrt(2.0 * density * spacing) @ np.cos(np.outer(omegas, time) + phases[:, np.newaxis])
    table = pm.TableValues((tuple(time.tolist()),), tuple(force.tolist()))
    run = pm.simulate(
        oscillator(),
        scenario(float(time[-1]), inputs={"force": table}),
        method=pm.Method.RK4,
        step=0.02,
        record_every=20.0,
        integrals_every=20.0,
    )
    end = float(run.integral_times[-1])
    measured = pm.rank_activity(run, window=(20.0, end))
    fine = np.linspace(omegas[0] - 0.5 * spacing + 1e-6, omegas[-1], 1000)
    found = pm.rank_frequencies(
        oscillator(),
        scenario(1.0, inputs={"force": 0.0}),
        fine,
        spectrum={"force": lambda w: 4.0 / (1.0 + (w / 4.0) ** 2)},
    )
    for row in found.rows:
        assert row.index == pytest.approx(measured.row(row.path).index, rel=0.02)
        assert row.activity == pytest.approx(measured.row(row.path).activity / (end - 20.0), rel=0.05)
    assert found.discretisation is not None
    assert found.discretisation.largest_change_points < 0.01


class Coils(pm.Component):
    """A field of two ports between a supply and a load."""

    voltage = pm.Input("V")
    supply, winding, load, ground = VoltageSource(), Resistor(resistance=2.0), Resistor(resistance=5.0), Ground()
    coils = CoupledInductors(primary_inductance=20e-3, secondary_inductance=5e-3, mutual_inductance=8e-3)
    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, winding.a),
        pm.connect(winding.b, coils.primary_a),
        pm.connect(coils.secondary_a, load.a),
        pm.connect(coils.primary_b, coils.secondary_b, load.b, ground.pin),
    )


def test_a_field_counts_its_ports_together():
    compiled = pm.compile_model(pm.elaborate(Coils()))
    omega = 300.0
    time = np.arange(0.0, 0.5, 1e-5)
    table = pm.TableValues((tuple(time.tolist()),), tuple(np.sin(omega * time).tolist()))
    period = 2.0 * math.pi / omega
    run = pm.simulate(
        compiled,
        scenario(20.0 * period, inputs={"voltage": table}),
        method=pm.Method.RK4,
        step=1e-5,
        record_every=period,
        integrals_every=period,
    )
    settled = pm.rank_activity(run, window=(10.0 * period, 20.0 * period))
    found = pm.rank_frequencies(compiled, scenario(1.0, inputs={"voltage": 0.0}), [omega], spectrum={"voltage": 0.5})
    coils, expected = found.row(path("coils")), settled.row(path("coils"))
    assert coils.activity == pytest.approx(expected.activity / (10.0 * period), rel=1e-3)
    assert coils.sum_over_ports == pytest.approx(expected.sum_over_ports / (10.0 * period), rel=1e-3)
    assert coils.activity < 0.9 * coils.sum_over_ports


def test_what_little_moves_at_keeps_nothing_and_what_any_frequency_needs_stays():
    car = pm.compile_model(pm.elaborate(quarter_car.QuarterCar()))
    omegas = np.geomspace(1.0, 400.0, 60)
    every = pm.rank_frequencies(car, pm.Scenario(stop=1.0), omegas)
    calm = pm.rank_frequencies(car, pm.Scenario(stop=1.0), omegas, spectrum={"road": lambda w: 1e-2 * (w < 20.0)})
    assert not any(part.is_idle for part in every.parts)
    assert [part.is_idle for part in calm.parts] == [w >= 20.0 for w in omegas]
    assert every.row(path("tyre.damper")).largest_index > 10.0 * calm.row(path("tyre.damper")).largest_index
    assert len(calm.kept_by(0.99)) < len(every.kept_by(0.99))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"omega": [2.0, 1.0]}, "the frequencies to rank do not grow from above zero"),
        ({"omega": [1.0], "spectrum": {"force": -1.0}}, "the spectrum of force is negative, not finite, or of another"),
        ({"omega": [1.0], "inputs": ["force", "push"]}, "nothing says how much each input moves: force, push"),
    ],
)
def test_what_cannot_be_ranked_is_refused(given, message: str):
    with pytest.raises(pm.ProperModelError, match=message):
        pm.rank_frequencies(oscillator(), scenario(1.0, inputs={"force": 0.0}), **given)


class Feeding(pm.Resistance):
    """Gives power, the more the faster."""

    flange = pm.Port(pm.Translation)
    gain: pm.Parameter = pm.parameter("N.s/m")

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return -self.gain * flow


def fed(gain: float) -> pm.CompiledModel:
    mass, spring, feeding = Mass(mass=2.0), Spring(stiffness=50.0), Feeding(gain=gain)
    push, ground = ForceSource(), Fixed()
    model = system(
        pm.connect(Q(0.0, "N"), push.force),
        pm.connect(push.flange, mass.flange, spring.a, feeding.flange),
        pm.connect(spring.b, ground.flange),
        push=push,
        mass=mass,
        spring=spring,
        feeding=feeding,
        ground=ground,
    )
    return pm.compile_model(pm.elaborate(model))


def test_an_unstable_point_has_no_steady_answer():
    with pytest.raises(pm.ProperModelError, match=r"a mode grows with 0\.75 1/s, so that there is no steady answer"):
        pm.rank_frequencies(fed(3.0), scenario(1.0), [1.0], inputs=["push"])


def test_a_mode_that_grows_slowly_beside_all_frequencies_is_told():
    slow = pm.rank_frequencies(fed(0.04), scenario(1.0), [2.0, 9.0], inputs=["push"])
    assert slow.notes[1].startswith("a mode grows with 0.01 1/s, slowly beside these frequencies")
    still = pm.rank_frequencies(fed(0.0), scenario(1.0), [2.0, 9.0], inputs=["push"])
    assert len(still.notes) == 1
    for row in slow.rows[:2]:
        assert row.activity == pytest.approx(still.row(row.path).activity, rel=1e-2)
