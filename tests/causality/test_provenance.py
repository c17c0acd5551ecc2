"""Every stroke knows who forced it: sources, laws, storage, fields, implicit laws, mechanisms, activated bonds."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

import propermodel as pm
from propermodel.catalogue.finding import load_subject
from propermodel.causality.causal import CausalGraph, Why
from propermodel.diagnostics import parse_path
from propermodel.library.electrical import (
    Capacitor,
    CoupledInductors,
    CurrentSource,
    Ground,
    Resistor,
    VoltageSource,
)

EXAMPLES = sorted((FilePath(__file__).parents[2] / "examples").glob("*.py"))
FOLLOWS = {Why.JUNCTION, Why.TWO_PORT, Why.REMAINING}


def causality(component: pm.Component) -> CausalGraph:
    return pm.compile_model(pm.elaborate(component)).system.causal


def reason(causal: CausalGraph, bond: str) -> tuple[Why, str]:
    stroke = causal.strokes[parse_path(bond)]
    return stroke.why, str(stroke.cause)


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_a_stroke_is_decided_at_its_element_or_follows_from_one(file: FilePath):
    causal = pm.compile_model(load_subject(str(file)).model).system.causal
    structure = causal.graph.normal
    assert set(causal.strokes) == set(structure.bonds)
    for name, stroke in causal.strokes.items():
        bond = structure.bonds[name]
        assert stroke.cause in structure.elements, name
        assert stroke.why in FOLLOWS or stroke.cause in (bond.tail.owner, bond.head.owner), name
        if stroke.why is Why.CONSTRAINT:
            assert stroke.cause in causal.constraints


class Coupling(pm.MultiportResistance):
    """Two conductances and a mutual one; either both currents are given or both voltages."""

    left = pm.Port(pm.Electrical)
    right = pm.Port(pm.Electrical)
    own: pm.Parameter = pm.parameter("1/Ohm", default=2.0)
    mutual: pm.Parameter = pm.parameter("1/Ohm", default=1.0)

    def laws(self):
        g, h = self.own, self.mutual
        left, right = self.left, self.right
        scale = g * g - h * h
        return (
            {left.flow: g * left.effort - h * right.effort, right.flow: g * right.effort - h * left.effort},
            {
                left.effort: (g * left.flow + h * right.flow) / scale,
                right.effort: (g * right.flow + h * left.flow) / scale,
            },
        )


class OneLawLeft(pm.Component):
    """A voltage at the left port of a coupling leaves one law, which decides the right port."""

    supply = VoltageSource()
    coupling = Coupling()
    load = Resistor(resistance=2.0)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(3.0, "V"), supply.voltage),
        pm.connect(supply.pin, coupling.left),
        pm.connect(coupling.right, load.a),
        pm.connect(load.b, ground.pin),
    )


def test_the_only_law_that_is_left_is_not_told_as_a_decision_of_the_cause():
    compiled = pm.compile_model(pm.elaborate(OneLawLeft()))
    assert reason(compiled.system.causal, "coupling.right") == (Why.REMAINING, "supply")
    report = pm.explain_causality(compiled)
    text = " ".join(report.explanation().split())
    assert "R coupling has one law left that fits, and sets the strokes of bond" in text
    assert "supply has a law for one causality only" not in text
    assert "only law left, after supply" in report.table()
    run = pm.simulate(compiled, pm.Scenario(stop=0.1), method=pm.Method.RK4, step=0.01)
    # 2 v - 3 = -v / 2 at the right port
    assert run.at_end("load.port.effort") == pytest.approx(3.0 / 2.5)


class DrivenCoils(pm.Component):
    """A current decides one coil of a field; the other keeps its flux."""

    source = CurrentSource()
    coils = CoupledInductors(primary_inductance=2.0, secondary_inductance=1.0, mutual_inductance=0.5)
    load = Resistor(resistance=3.0)
    ground = Ground()

    connections = (
        pm.connect(pm.quantity(1.0, "A"), source.current),
        pm.connect(source.pin, coils.primary_a),
        pm.connect(coils.secondary_a, load.a),
        pm.connect(coils.primary_b, coils.secondary_b, load.b, ground.pin),
    )


def test_the_ports_of_a_field_say_which_source_decided_them_and_which_is_a_state():
    causal = causality(DrivenCoils())
    assert reason(causal, "source.pin") == (Why.SOURCE, "source")
    assert reason(causal, "coils.secondary") == (Why.INTEGRAL, "coils")
    why, cause = reason(causal, "coils.primary")
    assert (why in FOLLOWS | {Why.DERIVATIVE}, cause) == (True, "source")


class OneLaw(pm.Resistance):
    """A conductance that only gives its current, and not for every current a voltage."""

    port = pm.Port(pm.Electrical)

    def flow(self, effort: pm.Expr) -> pm.Expr:
        return pm.quantity(1.0, "A") * pm.tanh(effort / pm.quantity(1.0, "V"))


class Restricted(pm.Component):
    """A law for one causality on a node whose capacitor gives the voltage."""

    capacitor = Capacitor(capacitance=1.0, start_voltage=1.0)
    lamp = OneLaw()
    ground = Ground()
    connections = (pm.connect(capacitor.a, lamp.port), pm.connect(capacitor.b, ground.pin))


def test_a_law_of_one_causality_decides_its_stroke():
    assert reason(causality(Restricted()), "lamp.port") == (Why.LAW, "lamp")


class Implicit(pm.Resistance):
    """An implicit law fits either causality."""

    port = pm.Port(pm.Electrical)

    def residual(self, effort: pm.Expr, flow: pm.Expr) -> pm.Expr:
        volts, amperes = effort / pm.quantity(1.0, "V"), flow / pm.quantity(1.0, "A")
        return amperes + amperes**3 - volts


class Settled(pm.Component):
    """An implicit law on a node whose capacitor gives the voltage."""

    capacitor = Capacitor(capacitance=1.0, start_voltage=1.0)
    lamp = Implicit()
    ground = Ground()
    connections = (pm.connect(capacitor.a, lamp.port), pm.connect(capacitor.b, ground.pin))


def test_an_implicit_law_takes_what_the_storage_leaves():
    causal = causality(Settled())
    assert reason(causal, "capacitor.port") == (Why.INTEGRAL, "capacitor")
    assert reason(causal, "lamp.port") == (Why.JUNCTION, "capacitor")
