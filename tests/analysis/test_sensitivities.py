"""Sensitivities against closed forms, of what is asked for in every form, and what is said where there are none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import propermodel as pm
from propermodel.diagnostics import SimulationError
from propermodel.expressions.core import Op
from propermodel.library.electrical import Capacitor, ConstantVoltage, Ground, Resistor
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring, Weight
from tests.examples.runs import run_of
from tests.parts import Lever

VOLTAGE, RESISTANCE, CAPACITANCE, STOP = 10.0, 2e3, 1e-6, 3e-3


class Charging(pm.Component):
    """A capacitor that a battery charges through a resistor of twice a half."""

    half: pm.Parameter = pm.parameter("kOhm", default=1.0)
    idle: pm.Parameter = pm.parameter("kg", default=1.0)

    battery = ConstantVoltage(voltage=VOLTAGE)
    resistor = Resistor(resistance=2.0 * half)
    capacitor = Capacitor(capacitance=CAPACITANCE, start_voltage=1.0)
    ground = Ground()
    connections = (
        pm.connect(battery.p, resistor.a),
        pm.connect(resistor.b, capacitor.a),
        pm.connect(battery.n, capacitor.b, ground.pin),
    )


class Oscillator(pm.Component):
    """A mass on a spring, pushed at the start."""

    mass = Mass(mass=2.0, start_velocity=1.0)
    spring = Spring(stiffness=50.0)
    wall = Fixed()
    connections = (pm.connect(mass.flange, spring.a), pm.connect(spring.b, wall.flange))


class Levered(pm.Component):
    """Two masses on a lever, of which one follows the other; they are declared to start with speeds of their own."""

    ratio: pm.Parameter = pm.parameter("1", default=3.0)

    near = Mass(mass=2.0, start_velocity=1.0)
    lever = Lever(ratio=ratio)
    far = Mass(mass=0.5)
    damper = Damper(damping=4.0)
    wall = Fixed()
    connections = (
        pm.connect(near.flange, lever.a, damper.a),
        pm.connect(lever.b, far.flange),
        pm.connect(damper.b, wall.flange),
    )


def charged(**options: object) -> pm.Sensitivities:
    names = {
        "parameters": ["half", "resistor.resistance", "capacitor.capacitance", "battery.voltage", "idle"],
        "outputs": ["capacitor.port.effort", "resistor.port.power", "resistor.port.work", "battery.port.activity"],
        "method": pm.Method.RK4,
        "step": 1e-5,
        "record_every": 3e-4,
    }
    scenario = pm.Scenario(name="charge", stop=STOP)
    return pm.sensitivities(pm.compile_model(pm.elaborate(Charging())), scenario, **{**names, **options})  # pyright: ignore[reportArgumentType]


def decay(time: np.ndarray | float) -> np.ndarray:
    return np.exp(-np.asarray(time) / (RESISTANCE * CAPACITANCE))


def test_a_charging_capacitor_has_the_derivatives_of_its_closed_form():
    found = charged()
    time, gap = found.time, VOLTAGE - 1.0
    by_resistance = -gap * time / (RESISTANCE**2 * CAPACITANCE) * decay(time)
    by_capacitance = -gap * time / (RESISTANCE * CAPACITANCE**2) * decay(time)
    assert found.values("capacitor.port.effort") == pytest.approx(VOLTAGE - gap * decay(time), rel=1e-9)
    assert found["capacitor.port.effort", "resistor.resistance"] == pytest.approx(by_resistance, rel=1e-7, abs=1e-12)
    assert found["capacitor.port.effort", "half"] == pytest.approx(2.0 * by_resistance, rel=1e-7, abs=1e-12)
    assert found["capacitor.port.effort", "capacitor.capacitance"] == pytest.approx(by_capacitance, rel=1e-7, abs=1e-6)
    assert found["capacitor.port.effort", "battery.voltage"] == pytest.approx(1.0 - decay(time), rel=1e-8, abs=1e-12)


def test_powers_work_and_activity_have_the_derivatives_of_their_closed_forms():
    found = charged()
    gap, ends = VOLTAGE - 1.0, float(decay(STOP))
    current = gap / RESISTANCE * decay(found.time)
    by_voltage = 2.0 * current * decay(found.time)
    assert found["resistor.port.power", "battery.voltage"] == pytest.approx(by_voltage, rel=1e-8)
    # The heat is C gap^2 / 2 (1 - exp(-2 t / RC)), the supply V C gap (1 - exp(-t / RC)).
    heat = CAPACITANCE * gap * (1.0 - ends**2)
    assert found.at_end("resistor.port.work", "battery.voltage") == pytest.approx(heat, rel=1e-6)
    assert found.work("resistor", "battery.voltage") == pytest.approx(heat, rel=1e-6)
    assert found.work("resistor", "battery.voltage", relative=True) == pytest.approx(2.0 * VOLTAGE / gap, rel=1e-6)
    supply = CAPACITANCE * (2.0 * VOLTAGE - 1.0) * (1.0 - ends)
    assert found.at_end("battery.port.activity", "battery.voltage") == pytest.approx(supply, rel=1e-6)
    assert found["battery.port.activity", "battery.voltage"][-1] == pytest.approx(supply, rel=1e-6)


def test_the_frequency_of_a_mass_on_a_spring_moves_with_both():
    compiled = pm.compile_model(pm.elaborate(Oscillator()))
    found = pm.sensitivities(
        compiled,
        pm.Scenario(stop=2.0),
        parameters=["mass.mass", "spring.stiffness", "mass.start_velocity"],
        outputs=["mass.flange.flow"],
        method=pm.Method.RK4,
        step=1e-3,
        record_every=0.05,
    )
    frequency = math.sqrt(50.0 / 2.0)
    moved = -np.sin(frequency * found.time) * found.time  # derivative of cos(w t) with respect to w
    close = {"rel": 1e-7, "abs": 1e-9}
    assert found["mass.flange.flow", "mass.mass"] == pytest.approx(moved * -frequency / 4.0, **close)
    assert found["mass.flange.flow", "spring.stiffness"] == pytest.approx(moved * frequency / 100.0, **close)
    assert found["mass.flange.flow", "mass.start_velocity"] == pytest.approx(np.cos(frequency * found.time), **close)


def test_starts_that_meet_are_differentiated_with_the_meeting():
    compiled = pm.compile_model(pm.elaborate(Levered()))
    found = pm.sensitivities(
        compiled,
        pm.Scenario(stop=0.5),
        parameters=["ratio", "near.start_velocity"],
        outputs=["near.flange.flow"],
        method=pm.Method.RK4,
        step=1e-3,
    )
    # The lever shares the momentum of the near mass out: v = 2 kg 1 m/s / (2 kg + ratio^2 0.5 kg).
    inertia = 2.0 + 0.5 * 3.0**2
    assert found.values("near.flange.flow")[0] == pytest.approx(2.0 / inertia)
    assert found["near.flange.flow", "ratio"][0] == pytest.approx(-2.0 * 3.0 / inertia**2, rel=1e-9)
    assert found["near.flange.flow", "near.start_velocity"][0] == pytest.approx(2.0 / inertia, rel=1e-9)
    assert "by differences of the start" in str(found)


def test_indices_change_by_the_quotient_rule_and_keep_their_sum():
    found = charged()
    indices = found.indices
    assert indices.values.sum() == pytest.approx(1.0)
    assert np.abs(indices.slopes.sum(axis=0) * found.parameter_values).max() < 1e-12
    distance = 1e-4
    plus, minus = (_index_with(VOLTAGE + d) for d in (distance, -distance))
    assert found.index("resistor", "battery.voltage") == pytest.approx((plus - minus) / (2.0 * distance), rel=1e-6)


def _index_with(voltage: float) -> float:
    compiled = pm.compile_model(pm.elaborate(Charging()))
    scenario = pm.Scenario(stop=STOP, parameters={pm.Path(("battery", "voltage")): voltage})
    run = pm.simulate(compiled, scenario, method=pm.Method.RK4, step=1e-5)
    return pm.rank_activity(run).row(pm.Path(("resistor",))).index


def test_what_a_scenario_gives_follows_no_other_parameter():
    scenario = pm.Scenario(stop=STOP, parameters={pm.Path(("resistor", "resistance")): RESISTANCE})
    compiled = pm.compile_model(pm.elaborate(Charging()))
    found = pm.sensitivities(compiled, scenario, parameters=["half"], outputs=["capacitor.port.effort"], step=1e-5)
    assert not found["capacitor.port.effort", "half"].any()


def test_parameters_without_effect_are_pointed_out():
    found = charged()
    assert "idle has no effect: nothing that is simulated depends on it" in found.notes
    assert not found["capacitor.port.effort", "idle"].any()


def test_the_table_reads_in_si():
    text = str(charged(parameters=["half"], outputs=["capacitor.port.effort"]))
    lines = text.splitlines()
    assert lines[0] == "charging, scenario charge: completed to 0.003 s"
    assert lines[1].split() == ["at", "the", "end", "value", "with", "respect", "to", "derivative", "relative"]
    assert lines[2].split()[:4] == ["capacitor.port.effort", "7.9918", "V", "half"]
    assert "V per kg.m2/(A2.s3)" in lines[2]
    assert lines[3].split()[0:2] == ["activity", "index"]
    assert any(line.startswith("  resistor") for line in lines[4:])


def test_everything_goes_to_xarray():
    found = charged()
    data = found.to_xarray()
    assert dict(data.sizes) == {"time": 11, "output": 4, "parameter": 5, "row": 2}
    one = data["d output"].sel(output="capacitor.port.effort", parameter="half")
    assert (one.values == found["capacitor.port.effort", "half"]).all()
    relative = data["relative activity"].sel(row="resistor", parameter="battery.voltage")
    assert float(relative) == pytest.approx(found.activity("resistor", "battery.voltage", relative=True))


class Vertical(pm.Resistance):
    """A friction whose force grows with a vertical tangent."""

    port = pm.Port(pm.Translation)
    factor: pm.Parameter = pm.parameter("N", default=1.0)

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return self.factor * pm.sign(flow) * (abs(flow) / pm.quantity(1.0, "m/s")) ** 0.25


class Sliding(pm.Component):
    """A mass that slides to rest, or does not move."""

    mass = Mass(mass=1.0)
    slide = Vertical()
    connections = (pm.connect(mass.flange, slide.port),)


def test_a_run_that_fails_says_which_derivative_is_none():
    compiled = pm.compile_model(pm.elaborate(Sliding()))
    found = pm.sensitivities(compiled, pm.Scenario(stop=1.0), parameters=["mass.start_velocity", "slide.factor"])
    assert found.ending.status.value == "failed"
    assert "the derivative of the state mass.momentum with respect to mass.start_velocity" in found.ending.message
    assert np.isnan(found.row_work.slopes).all()
    assert str(found).endswith(found.ending.message)


def test_a_bounce_moves_and_turns_the_derivatives():
    run, _ = run_of("bouncing_ball")
    parameters = ["sensor.start", "ball.restitution", "weight.gravity"]
    found = pm.sensitivities(
        run.compiled,
        replace(run.scenario, stop=1.0),
        parameters=parameters,
        outputs=["sensor.position", "ball.flange.flow", "ball.flange.work"],
        method=pm.Method.RK4,
        step=0.01,
        record_every=0.05,
    )
    (_, share, gravity), height = found.parameter_values, 1.0
    hit, speed = math.sqrt(2.0 * height / gravity), math.sqrt(2.0 * height * gravity)
    after = found.time > hit
    time = found.time[after] - hit
    flow = share * speed - gravity * time
    assert found.values("ball.flange.flow")[after] == pytest.approx(flow, rel=1e-9)
    close = {"rel": 1e-8, "abs": 1e-10}
    by_share = speed * time
    by_height = share * gravity / speed * time - flow / speed
    assert found["sensor.position", "ball.restitution"][after] == pytest.approx(by_share, **close)
    assert found["sensor.position", "sensor.start"][after] == pytest.approx(by_height, **close)
    rate = share * height / speed - hit / 2.0 - time
    assert found["ball.flange.flow", "weight.gravity"][after] == pytest.approx(rate, **close)
    # What weight and floor have done is what the ball has: its energy now less what the bounce took.
    lost = 0.5 * 0.2 * speed**2 * (1.0 - share**2)
    energy = 0.5 * 0.2 * found.values("ball.flange.flow")[-1] ** 2
    assert found.value_at_end("ball.flange.work") == pytest.approx(energy + lost, rel=1e-6)
    slope = 0.2 * flow[-1] * speed - 0.2 * speed**2 * share
    assert found.at_end("ball.flange.work", "ball.restitution") == pytest.approx(slope, rel=1e-6)


class Late(pm.SignalBlock):
    """Notices a signal that jumps over a level."""

    level: pm.Parameter = pm.parameter("1", default=0.5)
    noticed = pm.Output("1")
    held = pm.Discrete("1")

    def outputs(self):
        return {self.noticed: self.held}

    def events(self):
        signal = pm.where(pm.time > pm.quantity(0.05, "s"), 1.0, 0.0)
        return (pm.when(signal > self.level, {self.held: 1.0}),)


class Noticing(pm.Component):
    """A mass that is pushed, and a block that notices something else."""

    mass = Mass(mass=1.0, start_velocity=1.0)
    late = Late()
    damper = Damper(damping=1.0)
    wall = Fixed()
    connections = (pm.connect(mass.flange, damper.a), pm.connect(damper.b, wall.flange))


def test_the_instant_of_a_jump_over_a_level_has_no_derivative():
    compiled = pm.compile_model(pm.elaborate(Noticing()))
    found = pm.sensitivities(compiled, pm.Scenario(stop=0.1), parameters=["late.level"], step=1e-3)
    assert found.ending.status.value == "failed"
    assert "at an event: the instant at which late acts has no derivative" in found.ending.message


class Hanging(pm.Component):
    """A mass that hangs on a spring."""

    mass = Mass(mass=2.0)
    weight = Weight(mass=2.0)
    spring = Spring(stiffness=50.0)
    damper = Damper(damping=1.0)
    frame = Fixed()
    connections = (
        pm.connect(mass.flange, weight.flange, spring.b, damper.b),
        pm.connect(frame.flange, spring.a, damper.a),
    )


def test_an_equilibrium_moves_with_its_parameters():
    found = pm.sensitivities(
        pm.compile_model(pm.elaborate(Hanging())),
        pm.Scenario(stop=0.1),
        parameters=["spring.stiffness"],
        outputs=["spring.port.displacement"],
        step=1e-3,
        start="equilibrium",
    )
    slope = -found.values("spring.port.displacement") / 50.0
    assert found["spring.port.displacement", "spring.stiffness"] == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("buck_converter", {}, "has ideal switches, which change its equations: switch, diode"),
        ("cruise_control", {"parameters": ["controller.period"]}, "it sets the sample period of controller"),
        ("quarter_car", {"parameters": []}, "no parameter is given"),
        ("quarter_car", {"method": pm.Method.RODAS}, "rodas chooses its steps by their error"),
        ("quarter_car", {"parameters": ["body.mas"]}, "the model has no parameter 'body.mas'"),
        ("quarter_car", {"outputs": ["body.flange.flw"]}, "the model has no observable 'body.flange.flw'"),
        ("quarter_car", {"step": 0.0}, "it must be positive"),
    ],
)
def test_what_has_no_derivative_is_refused_by_name(name: str, options: dict[str, object], message: str):
    run, _ = run_of(name)
    first = next(iter(run.compiled.graph.parameters))
    with pytest.raises(SimulationError, match=message):
        pm.sensitivities(run.compiled, run.scenario, **{"parameters": [first], **options})  # pyright: ignore[reportArgumentType]


def test_names_that_were_not_asked_for_are_no_answers():
    found = charged(parameters=["half"], outputs=["capacitor.port.effort"])
    with pytest.raises(SimulationError, match="is no output of these sensitivities"):
        found.values("resistor.port.effort")
    with pytest.raises(SimulationError, match="is no parameter of these sensitivities"):
        found.at_end("capacitor.port.effort", "idle")
    with pytest.raises(SimulationError, match="is no row of the ranking"):
        found.activity("battery", "half")


def test_parameters_that_fill_several_groups_of_lanes_have_the_answers_they_have_alone():
    run, _ = run_of("quarter_car")
    constants = [str(path) for path, p in run.compiled.graph.parameters.items() if p.value.op is Op.CONSTANT]
    assert len(constants) > 8
    outputs = ["body.flange.flow", "tyre.spring.port.activity"]

    def asked(parameters: list[str]) -> pm.Sensitivities:
        scenario = replace(run.scenario, stop=1.0)
        options = {"method": pm.Method.RK4, "step": 1e-3}
        return pm.sensitivities(run.compiled, scenario, parameters=parameters, outputs=outputs, **options)  # pyright: ignore[reportArgumentType]

    together = asked(constants)
    for name in (constants[0], constants[-1]):
        alone = asked([name])
        for output in outputs:
            assert together[output, name] == pytest.approx(alone[output, name], rel=1e-9, abs=1e-12)
        assert together.index("body", name) == pytest.approx(alone.index("body", name), rel=1e-9)


def test_a_step_that_is_too_long_is_pointed_out():
    run, _ = run_of("quarter_car")
    scenario = replace(run.scenario, stop=2.0)
    found = pm.sensitivities(run.compiled, scenario, parameters=["body.mass"], method=pm.Method.RK4, step=0.1)
    assert any("is too long at the start" in note for note in found.notes)


def test_scenarios_may_change_between_calls_without_compiling():
    compiled = pm.compile_model(pm.elaborate(Oscillator()))
    first = pm.sensitivities(compiled, pm.Scenario(stop=0.1), parameters=["mass.mass"])
    other = replace(first.scenario, parameters={pm.Path(("mass", "mass")): 3.0})
    again = pm.sensitivities(compiled, other, parameters=["mass.mass"])
    assert again.statistics.build_s < 0.01
    assert first.activity("mass", "mass.mass") != again.activity("mass", "mass.mass")
