"""Laws of the shelves against the formulas of their sources, with plain numbers."""

from __future__ import annotations

import math

import pytest

from propermodel.expressions.core import as_expr, substitute
from propermodel.library import control, electrical, hydraulics, thermal
from propermodel.library.mechanics import rotation, translation
from propermodel.modelling import evaluate
from tests.library.laws import law_value, output_values, value_of


def test_a_diode_is_shockleys_and_goes_on_straight():
    diode = electrical.Diode(saturation_current=1e-9, thermal_voltage=0.025, leakage=0.0, knee=0.7)
    assert evaluate(diode.flow, 0.6) == pytest.approx(1e-9 * (math.exp(24.0) - 1.0))
    assert evaluate(diode.flow, -5.0) == pytest.approx(-1e-9)
    slope = evaluate(diode.flow, 1.1) - evaluate(diode.flow, 0.9)
    assert slope == pytest.approx(0.2 * 1e-9 * math.exp(28.0) / 0.025)


def test_coupled_coils_invert_their_inductances():
    coils = electrical.CoupledInductors(primary_inductance=4.0, secondary_inductance=1.0, mutual_inductance=1.5)
    first, second = 0.5, -0.25  # currents
    flux = {"primary_flux": 4.0 * first + 1.5 * second, "secondary_flux": 1.5 * first + 1.0 * second}
    assert value_of(coils.energy(), coils, **flux) == pytest.approx(
        0.5 * (4.0 * first**2 + 2 * 1.5 * first * second + 1.0 * second**2)
    )


@pytest.mark.parametrize(
    ("storage", "law", "at"),
    [
        (translation.HardeningSpring(stiffness=10.0, cubic_stiffness=300.0), "effort", 0.2),
        (translation.ElasticStop(stiffness=1e4, gap=0.01), "effort", 0.03),
        (translation.ElasticStop(stiffness=1e4, gap=0.01), "effort", -0.03),
        (rotation.GravityPendulum(mass=2.0, length=0.3), "effort", 1.2),
        (hydraulics.GasAccumulator(gas_volume=1e-3, precharge=5e6, exponent=1.2), "effort", 4e-4),
    ],
)
def test_the_law_of_a_storage_is_the_slope_of_its_energy(storage, law, at):
    h = 1e-6 * abs(at)
    slope = (evaluate(storage.energy, at + h) - evaluate(storage.energy, at - h)) / (2 * h)
    assert evaluate(getattr(storage, law), at) == pytest.approx(slope, rel=1e-6, abs=1e-9)


def test_a_pendulum_weighs():
    assert evaluate(rotation.GravityPendulum(mass=2.0, length=0.5, gravity=10.0).effort, math.pi / 6) == pytest.approx(
        5.0
    )


def test_a_weight_pulls_down_and_counts_against_the_source():
    assert (
        value_of(translation.Weight(mass=3.0, gravity=10.0).effort(), translation.Weight(mass=3.0, gravity=10.0))
        == 30.0
    )


def test_an_accumulator_doubles_its_pressure_at_half_its_gas():
    vessel = hydraulics.GasAccumulator(gas_volume=2e-3, precharge=5e6, exponent=1.4)
    assert evaluate(vessel.effort, 1e-3) == pytest.approx(5e6 * 2.0**1.4 - 101325.0)
    assert evaluate(vessel.effort, 0.0) == pytest.approx(5e6 - 101325.0)


def test_friction_rises_towards_rest():
    bearing = rotation.StribeckFriction(coulomb=1.0, breakaway=1.6, stribeck_speed=2.0, damping=0.1, width=0.01)
    assert evaluate(bearing.effort, 20.0) == pytest.approx(1.0 + 2.0)
    assert evaluate(bearing.effort, -2.0) == pytest.approx(-(1.0 + 0.6 / math.e + 0.2))
    assert evaluate(bearing.effort, 0.0) == 0.0


def test_a_clutch_carries_friction_times_force():
    clutch = rotation.SlippingClutch(friction=0.3, mean_radius=0.1, faces=2.0)
    assert law_value(clutch.effort, 50.0, normal_force=1000.0) == pytest.approx(60.0)


def test_a_pipe_is_hagen_poiseuilles():
    pipe = hydraulics.LaminarLine(diameter=0.01, length=2.0, viscosity=1e-3)
    assert evaluate(pipe.effort, 1e-5) == pytest.approx(8 * 1e-3 * 2.0 * 1e-5 / (math.pi * 0.005**4))


def test_oil_in_a_line_has_mass():
    column = hydraulics.OilInertia(length=2.0, area=1e-4, density=900.0)
    assert evaluate(column.momentum, 1e-3) == pytest.approx(900.0 * 2.0 / 1e-4 * 1e-3)


def test_a_tank_weighs_on_its_bottom():
    tank = hydraulics.LevelTank(area=0.5, density=1000.0, gravity=10.0)
    assert evaluate(tank.effort, 1.0) == pytest.approx(2e4)


@pytest.mark.parametrize(
    "valve",
    [
        hydraulics.CheckValve(conductance=1e-9, opening_pressure=1e5, width=1e3, leakage=0.0),
        hydraulics.ReliefValve(conductance=1e-9, set_pressure=1e5, width=1e3, leakage=0.0),
    ],
)
def test_a_valve_opens_at_its_pressure(valve):
    assert evaluate(valve.flow, 0.0) == 0.0
    assert evaluate(valve.flow, 3e5) == pytest.approx(1e-9 * 2e5, rel=1e-4)
    assert abs(evaluate(valve.flow, 5e4)) < 1e-8
    assert -1e-8 < evaluate(valve.flow, -1e7) <= 0.0
    below, above = (evaluate(valve.flow, p) for p in (9e4, 1.1e5))
    assert below < above


def test_a_metering_edge_is_a_sharp_orifice_above_its_transition():
    edge = hydraulics.MeteringOrifice(area=1e-5, discharge=0.6, density=800.0, transition_pressure=1e3)
    assert law_value(edge.flow, 4e6, opening=0.5) == pytest.approx(0.6 * 0.5e-5 * math.sqrt(2 * 4e6 / 800.0), rel=1e-6)
    assert law_value(edge.flow, -4e6, opening=0.5) == pytest.approx(-0.6 * 0.5e-5 * 100.0, rel=1e-6)
    assert law_value(edge.flow, 0.0, opening=1.0) == 0.0


def heat_of(element, given, a, b):
    """Heat in at `a` and at `b`, W: entropy flow times absolute temperature."""
    (laws,) = element.laws()
    numbers = {element.a.effort: as_expr(a), element.b.effort: as_expr(b)}
    entropy = [
        value_of(substitute(as_expr(laws[port.flow]), numbers), element, **given) for port in (element.a, element.b)
    ]
    return entropy[0] * (a + 300.0), entropy[1] * (b + 300.0)


@pytest.mark.parametrize(
    ("element", "given", "expected"),
    [
        (thermal.Conduction(conductance=5.0), {}, 5.0 * 60.0),
        (thermal.Convection(), {"conductance": 7.0}, 7.0 * 60.0),
        (
            thermal.Radiation(area=2.0, emissivity=0.8),
            {},
            5.670374419e-8 * 0.8 * 2.0 * ((300.0 + 80.0) ** 4 - (300.0 + 20.0) ** 4),
        ),
    ],
)
def test_heat_that_leaves_arrives(element, given, expected):
    left, arrived = heat_of(element, given, 80.0, 20.0)
    assert left == pytest.approx(expected)
    assert arrived == pytest.approx(-expected)


def test_signal_sources():
    def at(block, seconds):
        (value,) = output_values(block, block.outputs(), time=seconds).values()
        return value

    assert at(control.Constant(value=3.0), 1.0) == 3.0
    assert [at(control.Step(at=1.0, before=-1.0, after=2.0), t) for t in (0.9, 1.0, 1.1)] == [-1.0, 2.0, 2.0]
    ramp = control.Ramp(before=1.0, after=3.0, begin=1.0, end=2.0)
    assert [at(ramp, t) for t in (0.0, 1.5, 5.0)] == [1.0, 2.0, 3.0]
    sine = control.Sine(amplitude=2.0, frequency=0.5, phase=0.1, offset=1.0)
    assert at(sine, 0.3) == pytest.approx(1.0 + 2.0 * math.sin(math.pi * 0.3 + 0.1))
    wave = control.SquareWave(frequency=2.0, duty=0.25, low=-1.0, high=1.0)
    assert [at(wave, t) for t in (0.0, 0.1, 0.2, 0.51)] == [1.0, 1.0, -1.0, 1.0]


def test_signal_blocks():
    zone = control.DeadZone(low=-1.0, high=2.0)
    assert [output_values(zone, zone.outputs(), signal=s)["result"] for s in (-3.0, 0.5, 5.0)] == [-2.0, 0.0, 3.0]
    pid = control.PID(proportional_gain=2.0, integral_gain=3.0, derivative_gain=0.1, filter_time=0.5)
    given = {"setpoint": 1.0, "measurement": 0.4, "integral": 0.25, "lagged": 0.1}
    assert output_values(pid, pid.outputs(), **given)["command"] == pytest.approx(1.2 + 0.25 - 0.1 * 0.3 / 0.5)
    rates = output_values(pid, pid.derivatives(), **given)
    assert rates == pytest.approx({"integral": 1.8, "lagged": 0.6})
    lag = control.SecondOrder(natural_frequency=10.0, damping_ratio=0.5)
    rates = output_values(lag, lag.derivatives(), signal=1.0, value=0.2, rate=3.0)
    assert rates == pytest.approx({"value": 3.0, "rate": 100.0 * 0.8 - 2 * 0.5 * 10.0 * 3.0})
    hold = control.SampleHold()
    assert output_values(hold, hold.step(), signal=4.0)["result"] == 4.0


def test_gears_and_pistons_by_their_moduli():
    assert evaluate_modulus(hydraulics.Piston(area=2e-3)) == pytest.approx(2e-3)
    assert evaluate_modulus(hydraulics.Plunger(area=2e-3)) == pytest.approx(500.0)
    assert evaluate_modulus(hydraulics.FixedPump(displacement=3e-6)) == pytest.approx(3e-6)
    assert evaluate_modulus(electrical.IdealTransformer(ratio=10.0)) == pytest.approx(10.0)
    assert evaluate_modulus(electrical.VoiceCoil(constant=7.0)) == pytest.approx(7.0)


def evaluate_modulus(component) -> float:
    return value_of(component.modulus(), component)
