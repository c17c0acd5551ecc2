"""A network as an ordinary model of the package, with its scenario."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import propermodel as pm
from benchmarks.galleries.march import at_rest
from benchmarks.galleries.network import GROUND, Coupling, Element, Field, Kind, Law, Network, Output, Place
from propermodel.library.electrical import Capacitor, Ground, Inductor, Resistor
from propermodel.library.electrical.machines import ElectromechanicalConversion, VoiceCoil
from propermodel.library.hydraulics.components import Leakage, LineResistance, OilChamber
from propermodel.library.hydraulics.lines import OilInertia
from propermodel.library.hydraulics.sources import OpenTank
from propermodel.library.mechanics.rotation import (
    CoulombFriction,
    FixedShaft,
    Gear,
    QuadraticTorque,
    RollingWheel,
    RotatingInertia,
    RotationalDamper,
    TorsionSpring,
)
from propermodel.library.mechanics.translation import (
    Damper,
    DegressiveDamper,
    Fixed,
    Friction,
    HardeningSpring,
    Mass,
    QuadraticDrag,
    Spring,
)

_DENSITY = 870.0  # of the oil whose inertia is asked for, kg/m3
_AREA = 1e-4  # of its line, m2
_BULK_MODULUS = 1.7e9  # of the oil in chambers, Pa

_DOMAINS: Mapping[Field, Any] = {
    Field.TRANSLATION: pm.Translation,
    Field.ROTATION: pm.Rotation,
    Field.ELECTRICAL: pm.Electrical,
    Field.HYDRAULIC: pm.Hydraulic,
}


class Arm(pm.Transformer):
    """A rotating body lifts one of two flanges against the other: v_u - v_w = arm * omega."""

    a = pm.Port(pm.Rotation)
    u = pm.Port(pm.Translation)
    w = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation, between=(u, w))
    arm: pm.Parameter = pm.parameter("m")

    def modulus(self) -> pm.Expr:
        return self.arm


class Pump(pm.Transformer):
    """A pump or motor of constant displacement without losses."""

    a = pm.Port(pm.Rotation)
    b = pm.Port(pm.Hydraulic)
    displacement: pm.Parameter = pm.parameter("m3/rad")

    def modulus(self) -> pm.Expr:
        return self.displacement


class Piston(pm.Transformer):
    """A piston without losses: F = A p, Q = A v."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Hydraulic)
    area: pm.Parameter = pm.parameter("m2")

    def modulus(self) -> pm.Expr:
        return self.area


def model_of(network: Network) -> pm.Model:
    """The model: the same elements under the same names, prescribed ports for the drives."""
    parts: dict[str, Any] = {}
    at: dict[tuple[Field, str], list[Any]] = {}

    def join(place: Place, ports: tuple[Any, ...]) -> None:
        for node, port in zip((place.a, place.b), ports, strict=False):
            at.setdefault((place.field, node), []).append(port)

    for element in network.elements:
        parts[element.name], ports = _part(element)
        join(element.place, ports)
    for coupling in network.couplings:
        parts[coupling.name], first, second = _two_port(coupling)
        join(coupling.first, first)
        join(coupling.second, second)
    connections: list[Any] = []
    for drive in network.drives:
        field = network.nodes[drive.node]
        port = parts[drive.name] = pm.Port(_DOMAINS[field])
        at[field, drive.node].append(port)
        prescribed = pm.prescribed_effort if drive.half.value == "effort" else pm.prescribed_flow
        connections.append(prescribed(port))
    for field in {field for field, node in at if node == GROUND}:
        name = f"{field.value}_ground"
        parts[name], port = _ground(field)
        at[field, GROUND].append(port)
    connections += [pm.connect(*ports) for ports in at.values()]
    made = type("System", (pm.Component,), {"__doc__": network.name, **parts, "connections": tuple(connections)})
    return pm.elaborate(made(), name=network.name)


def scenario_of(network: Network) -> pm.Scenario:
    """The scenario: drives, and the equilibrium that the network begins in."""
    instants, stored = network.instants, at_rest(network)[1]
    inputs: dict[pm.Path, float | pm.TableValues] = {}
    for drive in network.drives:
        path = pm.Path((drive.name, drive.half.value))
        values = drive.values
        inputs[path] = pm.table_values([instants], values) if isinstance(values, np.ndarray) else values
    initial: dict[pm.Path, float] = {}
    if network.is_biased:
        for number, element in enumerate(network.elements):
            if element.kind is not Kind.RESISTANCE:
                what = "displacement" if element.kind is Kind.COMPLIANCE else "momentum"
                initial[pm.Path((element.name, what))] = float(stored[number])
    return pm.Scenario(name="driven", stop=network.stop, inputs=inputs, initial=initial)


def observable(network: Network, output: Output) -> pm.Path:
    """The path of an output."""
    return port_of(network.elements[network.number(output.element)]) / output.half.value


def port_of(element: Element) -> pm.Path:
    """The port at which an element takes its power."""
    one_sided = {Field.TRANSLATION: "flange", Field.ROTATION: "shaft"}
    is_drag = element.law is Law.QUADRATIC or (element.law is Law.FRICTION and element.place.field is Field.ROTATION)
    is_body = (element.kind is Kind.INERTIA or is_drag) and element.place.field in one_sided
    return pm.Path((element.name, one_sided[element.place.field] if is_body else "port"))


def _part(element: Element) -> tuple[pm.Component, tuple[Any, ...]]:
    """The component of an element, and its ports in order."""
    if element.law is not Law.LINEAR:
        return _bent_part(element)
    value = element.value
    match element.place.field, element.kind:
        case Field.TRANSLATION, Kind.RESISTANCE:
            part = Damper(damping=value)
        case Field.TRANSLATION, Kind.COMPLIANCE:
            part = Spring(stiffness=value)
        case Field.TRANSLATION, Kind.INERTIA:
            body = Mass(mass=value)
            return body, (body.flange,)
        case Field.ROTATION, Kind.RESISTANCE:
            part = RotationalDamper(damping=value)
        case Field.ROTATION, Kind.COMPLIANCE:
            part = TorsionSpring(stiffness=value)
        case Field.ROTATION, Kind.INERTIA:
            rotor = RotatingInertia(inertia=value)
            return rotor, (rotor.shaft,)
        case Field.ELECTRICAL, Kind.RESISTANCE:
            part = Resistor(resistance=value)
        case Field.ELECTRICAL, Kind.COMPLIANCE:
            part = Capacitor(capacitance=1.0 / value)
        case Field.ELECTRICAL, Kind.INERTIA:
            part = Inductor(inductance=value)
        case Field.HYDRAULIC, Kind.RESISTANCE:
            part = Leakage(conductance=1.0 / value)
        case Field.HYDRAULIC, Kind.COMPLIANCE:
            chamber = OilChamber(volume=_BULK_MODULUS / value, bulk_modulus=_BULK_MODULUS)
            return chamber, (chamber.port,)
        case Field.HYDRAULIC, Kind.INERTIA:
            part = OilInertia(length=value * _AREA / _DENSITY, area=_AREA, density=_DENSITY)
    return part, (part.a, part.b)


def _bent_part(element: Element) -> tuple[pm.Component, tuple[Any, ...]]:
    """The same of an element that is not linear."""
    value, scale = element.value, element.scale
    match element.place.field, element.law:
        case Field.TRANSLATION, Law.HARDENING:
            part = HardeningSpring(stiffness=value, cubic_stiffness=value / scale**2)
        case Field.TRANSLATION, Law.SATURATING:
            part = DegressiveDamper(
                damping=value, degressivity_compression=1.0 / scale, degressivity_rebound=1.0 / scale
            )
        case Field.TRANSLATION, Law.FRICTION:
            part = Friction(force=value * scale, width=scale)
        case Field.TRANSLATION, Law.QUADRATIC:
            drag = QuadraticDrag(drag_area=2.0 * value / scale, air_density=1.0)
            return drag, (drag.flange,)
        case Field.ROTATION, Law.FRICTION:
            friction = CoulombFriction(torque=value * scale, width=scale)
            return friction, (friction.shaft,)
        case Field.ROTATION, Law.QUADRATIC:
            fan = QuadraticTorque(nominal_torque=value * scale, nominal_speed=scale)
            return fan, (fan.shaft,)
        case Field.HYDRAULIC, Law.QUADRATIC:
            part = LineResistance(resistance=value / scale)
        case field, law:
            raise NotImplementedError(f"no part in {field} has a {law} law")
    return part, (part.a, part.b)


def _two_port(coupling: Coupling) -> tuple[pm.Component, tuple[Any, ...], tuple[Any, ...]]:
    """The component of a coupling, and its ports at either place."""
    modulus = coupling.modulus
    match coupling.first.field, coupling.second.field:
        case Field.ROTATION, Field.ROTATION:
            part = Gear(ratio=1.0 / modulus)
        case Field.ROTATION, Field.TRANSLATION if coupling.second.b:
            arm = Arm(arm=modulus)
            return arm, (arm.a,), (arm.u, arm.w)
        case Field.ROTATION, Field.TRANSLATION:
            part = RollingWheel(radius=modulus)
        case Field.ROTATION, Field.HYDRAULIC:
            part = Pump(displacement=modulus)
        case Field.TRANSLATION, Field.HYDRAULIC:
            part = Piston(area=modulus)
        case Field.ELECTRICAL, Field.ROTATION:
            part = ElectromechanicalConversion(constant=modulus)
        case Field.ELECTRICAL, Field.TRANSLATION:
            coil = VoiceCoil(constant=modulus)
            return coil, (coil.pin_a, coil.pin_b), (coil.b,)
        case first, second:
            raise NotImplementedError(f"no part couples {first} with {second}")
    return part, (part.a,), (part.b,)


def _ground(field: Field) -> tuple[pm.Component, Any]:
    match field:
        case Field.TRANSLATION:
            fixed = Fixed()
            return fixed, fixed.flange
        case Field.ROTATION:
            shaft = FixedShaft()
            return shaft, shaft.shaft
        case Field.ELECTRICAL:
            ground = Ground()
            return ground, ground.pin
        case Field.HYDRAULIC:
            tank = OpenTank()
            return tank, tank.port
