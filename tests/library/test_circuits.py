"""Parts of the electrical shelf in circuits, against what textbooks say of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propermodel as pm
from propermodel.expressions.core import as_expr, substitute
from propermodel.library.electrical import (
    Capacitor,
    Conductor,
    ConstantCurrent,
    ConstantVoltage,
    CurrentControlledCurrent,
    CurrentControlledVoltage,
    FieldEffectTransistor,
    Ground,
    IdealGyrator,
    Potentiometer,
    Resistor,
    SaturatingInductor,
    VoltageControlledCurrent,
    VoltageControlledVoltage,
    ZenerDiode,
)
from tests.library.laws import value_of


def at_start(component: pm.Component, *names: str, **inputs: float) -> list[float]:
    """What a circuit does at its first instant."""
    scenario = pm.Scenario(stop=1e-6, inputs=dict(inputs))
    run = pm.simulate(pm.compile_model(pm.elaborate(component)), scenario, step=1e-6)
    return [float(run[name][0]) for name in names]


class Divider(pm.Component):
    """A battery on a potentiometer."""

    position = pm.Input("1")

    battery = ConstantVoltage(voltage=12.0)
    divider = Potentiometer(resistance=1000.0)
    load = Conductor(conductance=1e-3)
    ground = Ground()

    connections = (
        pm.connect(battery.p, divider.a),
        pm.connect(divider.wiper, load.a),
        pm.connect(battery.n, divider.b, load.b, ground.pin),
        pm.connect(position, divider.position),
    )


def test_a_loaded_potentiometer_divides_less():
    (voltage,) = at_start(Divider(), "load.port.effort", position=0.4)
    upper, lower = 400.0, 1.0 / (1.0 / 600.0 + 1e-3)
    assert voltage == pytest.approx(12.0 * lower / (upper + lower), rel=1e-12)


def controlled(kind: type[pm.Component], **values: float) -> pm.Component:
    """2 mA through 1000 Ohm into the control pins, 500 Ohm at the output."""

    class Amplifier(pm.Component):
        """A source that another voltage or current controls."""

        feed = ConstantCurrent(current=2e-3)
        shunt = Resistor(resistance=1000.0)
        source = kind(**values)
        load = Resistor(resistance=500.0)
        ground = Ground()

        connections = (
            pm.connect(feed.p, shunt.a),
            *(
                (pm.connect(shunt.b, source.in_a), pm.connect(source.in_b, feed.n, ground.pin))
                if issubclass(kind, (CurrentControlledVoltage, CurrentControlledCurrent))
                else (pm.connect(feed.p, source.in_a), pm.connect(shunt.b, source.in_b, feed.n, ground.pin))
            ),
            pm.connect(source.out_a, load.a),
            pm.connect(source.out_b, load.b, ground.pin),
        )

    return Amplifier()


@pytest.mark.parametrize(
    ("kind", "values", "expected"),
    [
        (VoltageControlledVoltage, {"gain": 5.0}, 5.0 * 2.0),
        (VoltageControlledCurrent, {"transconductance": 0.01}, -0.01 * 2.0 * 500.0),
        (CurrentControlledVoltage, {"transresistance": 300.0}, 300.0 * 2e-3),
        (CurrentControlledCurrent, {"gain": 7.0}, -7.0 * 2e-3 * 500.0),
    ],
)
def test_controlled_sources(kind, values, expected):
    voltage, felt = at_start(controlled(kind, **values), "load.port.effort", "shunt.port.effort")
    assert voltage == pytest.approx(expected, rel=1e-12)
    assert felt == pytest.approx(2.0, rel=1e-12)  # it takes no power from what it feels


class Gyrated(pm.Component):
    """A capacitor seen through a gyrator."""

    feed = ConstantCurrent(current=1e-3)
    gyrator = IdealGyrator(resistance=1e3)
    capacitor = Capacitor(capacitance=1e-6)
    load = Resistor(resistance=100.0)
    ground = Ground()

    connections = (
        pm.connect(feed.p, gyrator.primary_a, load.a),
        pm.connect(gyrator.secondary_a, capacitor.a),
        pm.connect(feed.n, load.b, gyrator.primary_b, gyrator.secondary_b, capacitor.b, ground.pin),
    )


def test_a_gyrator_makes_a_coil_of_a_capacitor():
    run = pm.simulate(
        pm.compile_model(pm.elaborate(Gyrated())), pm.Scenario(stop=0.02), step=1e-5, method=pm.Method.RK4
    )
    inductance = 1e3**2 * 1e-6
    expected = 1e-3 * 100.0 * np.exp(-run.time * 100.0 / inductance)
    np.testing.assert_allclose(run["load.port.effort"], expected, rtol=1e-8)


@pytest.mark.parametrize(("gate", "saturated"), [(2.0, True), (6.0, False)])
def test_a_field_effect_transistor_is_a_current_source_or_a_resistor(gate: float, saturated: bool):
    class Switch(pm.Component):
        """A transistor pulls a resistor down."""

        supply = ConstantVoltage(voltage=10.0)
        control = ConstantVoltage(voltage=gate)
        resistor = Resistor(resistance=100.0)
        transistor = FieldEffectTransistor(threshold=1.0, transconductance=0.04)
        ground = Ground()

        connections = (
            pm.connect(supply.p, resistor.a),
            pm.connect(resistor.b, transistor.drain),
            pm.connect(control.p, transistor.gate),
            pm.connect(transistor.source, supply.n, control.n, ground.pin),
        )

    current, drain = at_start(Switch(), "resistor.port.flow", "transistor.channel.effort")
    over = gate - 1.0
    assert (drain > over) == saturated
    assert current == pytest.approx(0.02 * over**2 if saturated else 0.04 * (over - drain / 2) * drain, rel=1e-9)
    assert drain == pytest.approx(10.0 - 100.0 * current, rel=1e-9)


def test_a_field_effect_transistor_works_backward():
    transistor = FieldEffectTransistor(threshold=1.0, transconductance=0.04)
    (laws,) = transistor.laws()
    law = laws[transistor.channel.flow]

    def current(gate: float, drain: float) -> float:
        at = {transistor.control.effort: as_expr(gate), transistor.channel.effort: as_expr(drain)}
        return value_of(substitute(as_expr(law), at), transistor)

    # Seen from the other end the gate lies at 3 + 0.5 V.
    assert current(3.0, -0.5) == pytest.approx(-current(3.5, 0.5))


class Regulated(pm.Component):
    """A Zener diode holds the voltage of a load."""

    supply = ConstantVoltage(voltage=12.0)
    series = Resistor(resistance=470.0)
    zener = ZenerDiode(breakdown_voltage=5.1, leakage=0.0)
    load = Resistor(resistance=1000.0)
    ground = Ground()

    connections = (
        pm.connect(supply.p, series.a),
        pm.connect(series.b, zener.b, load.a),
        pm.connect(supply.n, zener.a, load.b, ground.pin),
    )


def test_a_zener_diode_holds_its_voltage():
    voltage, current = at_start(Regulated(), "load.port.effort", "zener.port.flow")
    assert voltage == pytest.approx(5.1 + 0.02585 * math.log(-current / 1e-9), rel=1e-6)
    assert -current == pytest.approx((12.0 - voltage) / 470.0 - voltage / 1000.0, rel=1e-9)


class Saturated(pm.Component):
    """A battery on a coil with iron."""

    battery = ConstantVoltage(voltage=5.0)
    coil = SaturatingInductor(inductance=0.1, saturation=0.5)
    ground = Ground()

    connections = (pm.connect(battery.p, coil.a), pm.connect(battery.n, coil.b, ground.pin))


def test_a_coil_with_iron_takes_twice_the_current_at_saturation():
    run = pm.simulate(
        pm.compile_model(pm.elaborate(Saturated())), pm.Scenario(stop=0.1), step=1e-4, method=pm.Method.RK4
    )
    assert run["coil.port.flow"][-1] == pytest.approx(2.0 * 0.5 / 0.1, rel=1e-9)
    assert pm.energy_balance(run).relative_residual < 1e-9
