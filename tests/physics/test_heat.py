"""Heat on true and pseudo bonds: RS elements keep energy, converters join the two worlds, balances stay apart."""

from __future__ import annotations

import numpy as np
import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend
from propermodel.diagnostics import DocumentError, ModelError
from propermodel.library import pseudo_thermal as pseudo
from propermodel.library import thermal
from propermodel.library.electrical import CurrentSource, Ground
from propermodel.library.mechanics.rotation import FixedShaft, RotatingInertia
from propermodel.library.mechanics.translation import Fixed, Mass
from propermodel.modelling import (
    Component,
    Electrical,
    Gyrator,
    Input,
    MultiportCompliance,
    Parameter,
    Port,
    PseudoThermal,
    State,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.documents import from_document, to_document
from tests.physics.systems import close, compiled, run, system

BACKENDS = list(Backend)


# -- true bonds ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_motion_of_a_braked_mass_is_found_again_as_heat(backend: Backend):
    mass, brake = Mass(mass=2.0, start_velocity=30.0), thermal.HeatingDamper(damping=4.0)
    body, wall = thermal.HeatCapacity(capacity=5.0), Fixed()
    model = system(
        connect(mass.flange, brake.a),
        connect(brake.b, wall.flange),
        connect(brake.heat, body.port),
        mass=mass,
        brake=brake,
        body=body,
        wall=wall,
    )
    r = run(model, 2.0, backend=backend, step=2e-3)
    v = 30.0 * np.exp(-2.0 * r.time)
    close(r["mass.flange.flow"], v, 1e-9)
    close(r["body.port.effort"], (900.0 - v * v) / 5.0, 1e-8)
    # What is dissipated is what the heat can no longer do: ambient temperature times the entropy made.
    made = 5.0 * np.log1p((900.0 - v[-1] ** 2) / 5.0 / 300.0)
    balance = energy_balance(r)
    assert balance.dissipated == pytest.approx(300.0 * made, rel=1e-4)
    assert balance.relative_residual < 1e-4


def test_friction_heats_what_it_touches():
    shaft, bearing = RotatingInertia(inertia=0.5, start_speed=40.0), thermal.HeatingFriction(damping=0.1)
    body, frame = thermal.HeatCapacity(capacity=8.0), FixedShaft()
    model = system(
        connect(shaft.shaft, bearing.a),
        connect(bearing.b, frame.shaft),
        connect(bearing.heat, body.port),
        shaft=shaft,
        bearing=bearing,
        body=body,
        frame=frame,
    )
    r = run(model, 30.0, step=1e-2)
    assert r.at_end("body.port.effort") == pytest.approx(0.25 * 1600.0 * (1.0 - np.exp(-12.0)) / 8.0, rel=1e-7)


class Wall(Component):
    """Two layers without storage between a hot room and ambient: the temperature between them is sought."""

    temperature = Input("K")

    room = thermal.TemperatureSource()
    inner = thermal.Conduction(conductance=2.0)
    outer = thermal.Conduction(conductance=6.0)
    outside = thermal.Ambient()

    connections = (
        connect(temperature, room.temperature),
        connect(room.port, inner.a),
        connect(inner.b, outer.a),
        connect(outer.b, outside.port),
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_layers_of_a_wall_share_the_heat(backend: Backend):
    r = run(Wall(), 1.0, step=0.1, backend=backend, inputs={"temperature": 80.0})
    # Q = 80 / (1/2 + 1/6) = 120 W; the middle is 20 K above ambient.
    assert r.at_end("outer.a.effort") == pytest.approx(20.0, rel=1e-9)
    assert r.at_end("inner.a.flow") == pytest.approx(120.0 / 380.0, rel=1e-9)
    assert r.at_end("inner.b.flow") == pytest.approx(-120.0 / 320.0, rel=1e-9)
    assert r.at_end("outer.b.flow") == pytest.approx(-120.0 / 300.0, rel=1e-9)


class Warmed(Component):
    heat_flow = Input("W")

    source = thermal.HeatFlowSource()
    body = thermal.HeatCapacity(capacity=50.0)

    connections = (connect(heat_flow, source.heat_flow), connect(source.port, body.port))


def test_a_heat_flow_warms_a_body_by_its_capacity():
    r = run(Warmed(), 10.0, step=1e-2, inputs={"heat_flow": 200.0})
    close(r["body.port.effort"], 4.0 * r.time, 1e-9)


# -- pseudo bonds -------------------------------------------------------------------------------------------


class Heater(Component):
    """A current through a resistor that heats a body on pseudo bonds."""

    current = Input("A")

    supply = CurrentSource()
    resistor = pseudo.ResistorHeat(resistance=3.0)
    ground = Ground()
    body = pseudo.HeatStore(capacity=20.0, start_temperature=290.0)
    wall = pseudo.ThermalConductor(conductance=4.0)
    meter = pseudo.HeatFlowSensor()
    thermometer = pseudo.TemperatureSensor()
    room = pseudo.FixedTemperature(temperature=290.0)

    connections = (
        connect(current, supply.current),
        connect(supply.pin, resistor.a),
        connect(resistor.b, ground.pin),
        connect(resistor.heat, body.port, wall.a, thermometer.port),
        connect(wall.b, meter.a),
        connect(meter.b, room.port),
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_heater_on_pseudo_bonds(backend: Backend):
    r = run(Heater(), 10.0, step=1e-2, backend=backend, inputs={"current": 2.0})
    rise = 3.0 * (1.0 - np.exp(-0.2 * r.time))
    close(r["thermometer.temperature"], 290.0 + rise, 1e-9)
    close(r["meter.heat_flow"], 4.0 * rise, 1e-8)
    assert r.unit("supply.pin.power") == "W"
    assert r.unit("body.port.power") == r.unit("body.energy") == r.unit("body.port.work") == ""


def test_true_and_pseudo_bonds_are_balanced_apart():
    r = run(Heater(), 10.0, step=1e-2, inputs={"current": 2.0})
    balance = energy_balance(r)
    assert balance.supplied == pytest.approx(120.0, rel=1e-9)
    assert balance.converted == pytest.approx(120.0, rel=1e-9)
    assert (balance.stored, balance.dissipated) == (0.0, 0.0)
    assert balance.relative_residual < 1e-12
    (own,) = balance.pseudo.values()
    # The product of temperature and heat flow: C (T^2 - T_0^2) / 2 is stored, G times the square of the rise passes.
    rise = 3.0 * (1.0 - np.exp(-2.0))
    assert own.stored == pytest.approx(10.0 * ((290.0 + rise) ** 2 - 290.0**2), rel=1e-6)
    assert own.relative_residual < 1e-6
    assert {str(path) for path, _ in own.sources} == {"resistor", "room"}
    assert str(balance).splitlines()[1].startswith("balance of pseudo bonds (pseudo_thermal): sources ")


def test_a_converter_is_ranked_by_its_true_bonds_only():
    r = run(Heater(), 10.0, step=1e-2, inputs={"current": 2.0})
    (row,) = rank_activity(r, among="true").rows
    assert (str(row.path), row.activity) == ("resistor", pytest.approx(120.0, rel=1e-9))
    assert {str(row.path) for row in rank_activity(r, among="pseudo_thermal").rows} == {"body", "wall"}


def test_true_heat_passes_into_a_graph_of_heat_flows():
    body, port = thermal.HeatCapacity(capacity=20.0, start_temperature=360.0), pseudo.TrueThermalPort()
    wall, room = pseudo.ThermalResistor(resistance=0.25), pseudo.FixedTemperature(temperature=280.0)
    model = system(
        connect(body.port, port.entropy),
        connect(port.heat, wall.a),
        connect(wall.b, room.port),
        body=body,
        port=port,
        wall=wall,
        room=room,
    )
    r = run(model, 10.0, step=1e-2)
    close(r["port.heat.effort"], 280.0 + 80.0 * np.exp(-0.2 * r.time), 1e-8)
    balance = energy_balance(r)
    assert balance.converted == pytest.approx(-balance.stored, rel=1e-6)


def test_dampers_and_friction_convert_as_well():
    mass, brake = Mass(mass=2.0, start_velocity=30.0), pseudo.DamperHeat(damping=4.0)
    shaft, bearing = RotatingInertia(inertia=0.5, start_speed=40.0), pseudo.FrictionHeat(damping=0.1)
    body, wall, frame = pseudo.HeatStore(capacity=5.0), Fixed(), FixedShaft()
    model = system(
        connect(mass.flange, brake.a),
        connect(brake.b, wall.flange),
        connect(shaft.shaft, bearing.a),
        connect(bearing.b, frame.shaft),
        connect(brake.heat, bearing.heat, body.port),
        mass=mass,
        brake=brake,
        shaft=shaft,
        bearing=bearing,
        body=body,
        wall=wall,
        frame=frame,
    )
    r = run(model, 40.0, step=1e-2)
    assert r.at_end("body.port.effort") == pytest.approx(293.15 + (900.0 + 400.0) / 5.0, rel=1e-7)


def test_surfaces_radiate_until_their_temperatures_agree():
    one, other = pseudo.HeatStore(capacity=1.0, start_temperature=900.0), pseudo.HeatStore(capacity=3.0)
    gap = pseudo.ThermalRadiation(area=0.1)
    r = run(system(connect(one.port, gap.a), connect(gap.b, other.port), one=one, other=other, gap=gap), 1.0)
    source = pseudo.PrescribedTemperature()
    assert r.at_start("gap.a.flow") == pytest.approx(5.670374419e-9 * (900.0**4 - 293.15**4), rel=1e-9)
    close(r["one.port.displacement"] + r["other.port.displacement"], np.full(len(r.time), 900.0 + 3.0 * 293.15))
    assert type(source).__name__ == "PrescribedTemperature"


# -- what is refused ----------------------------------------------------------------------------------------


class Peltier(Gyrator):
    a = Port(Electrical)
    b = Port(PseudoThermal)
    seebeck: Parameter = parameter("V/W", default=1.0)

    def modulus(self):
        return self.seebeck


class Crystal(MultiportCompliance):
    pin = Port(Electrical)
    heat = Port(PseudoThermal)
    charge = State("C")
    content = State("J")

    def energy(self):
        return self.charge * self.pin.effort


@pytest.mark.parametrize("part", [Peltier(), Crystal()], ids=["two-port", "field"])
def test_an_element_that_is_no_converter_is_not_on_both(part: Component):
    with pytest.raises(ModelError, match="model/pseudo-domain"):
        elaborate(system(part=part))


def test_a_document_cannot_join_them_either():
    document = to_document(elaborate(Heater()))
    assert from_document(document) == elaborate(Heater())
    for definition in document["definitions"]:
        definition.get("behaviour", {}).pop("converts", None)
    with pytest.raises(DocumentError, match="does not convert"):
        from_document(document)


def test_a_connection_does_not_join_them():
    resistor, body = pseudo.ResistorHeat(resistance=1.0), thermal.HeatCapacity(capacity=1.0)
    with pytest.raises(ModelError, match=r"different domains \(pseudo_thermal, thermal\)"):
        elaborate(system(connect(resistor.heat, body.port), resistor=resistor, body=body))  # pyright: ignore[reportArgumentType, reportCallIssue]


def test_a_model_on_true_bonds_has_no_pseudo_balance():
    r = run(Warmed(), 1.0, inputs={"heat_flow": 1.0})
    assert energy_balance(r).pseudo == {}
    assert compiled(Warmed()).graph.domains["thermal"].is_true
