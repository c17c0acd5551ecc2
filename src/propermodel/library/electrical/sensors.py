"""Sensors of voltage, current, charge and flux linkage; they take no power."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    Electrical,
    FlowSource,
    Input,
    Output,
    Parameter,
    Port,
    SignalBlock,
    State,
    connect,
    parameter,
)


class NoCurrent(FlowSource):
    """Feels a voltage without taking current."""

    pin = Port(Electrical)

    def flow(self) -> ExprLike:
        return 0.0


class VoltageSensor(Component):
    """The voltage of a node against ground."""

    pin = Port(Electrical)
    voltage = Output("V")

    touch = NoCurrent()

    connections = (
        connect(pin, touch.pin),
        connect(touch.pin.effort, voltage),
    )


class NoVoltageDrop(EffortSource):
    """Lets current pass without loss."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class CurrentSensor(Component):
    """The current from pin `a` to pin `b`."""

    a = Port(Electrical)
    b = Port(Electrical)
    current = Output("A")

    meter = NoVoltageDrop()

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, current),
    )


class NoCurrentBetween(FlowSource):
    """Feels the voltage between two pins without letting current pass."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))

    def flow(self) -> ExprLike:
        return 0.0


class FloatingVoltageSensor(Component):
    """The voltage of pin `a` less that of pin `b`."""

    a = Port(Electrical)
    b = Port(Electrical)
    voltage = Output("V")

    touch = NoCurrentBetween()

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.effort, voltage),
    )


class ChargeCounter(SignalBlock):
    """The charge that a current has carried."""

    current = Input("A")
    charge = Output("C")
    start: Parameter = parameter("C", default=0.0)
    passed = State("C", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.charge: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.current}


class ChargeSensor(Component):
    """The charge that has passed from pin `a` to pin `b`, and the current."""

    a = Port(Electrical)
    b = Port(Electrical)
    start: Parameter = parameter("C", default=0.0, doc="charge at the start")
    charge = Output("C")
    current = Output("A")

    meter = NoVoltageDrop()
    counter = ChargeCounter(start=start)

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, current, counter.current),
        connect(counter.charge, charge),
    )


class FluxCounter(SignalBlock):
    """The flux linkage that a voltage has built up."""

    voltage = Input("V")
    flux_linkage = Output("V.s")
    start: Parameter = parameter("V.s", default=0.0)
    linked = State("V.s", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.flux_linkage: self.linked}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.linked: self.voltage}


class FluxLinkageSensor(Component):
    """The flux linkage between pins `a` and `b`: the voltage between them, summed up over time."""

    a = Port(Electrical)
    b = Port(Electrical)
    start: Parameter = parameter("V.s", default=0.0, doc="flux linkage at the start")
    flux_linkage = Output("V.s")
    voltage = Output("V")

    touch = NoCurrentBetween()
    counter = FluxCounter(start=start)

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.effort, voltage, counter.voltage),
        connect(counter.flux_linkage, flux_linkage),
    )
