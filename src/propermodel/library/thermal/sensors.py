"""Sensors of temperature, entropy flow, heat flow and entropy; they take no heat."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    FlowSource,
    Input,
    Output,
    Parameter,
    Port,
    SignalBlock,
    State,
    Thermal,
    connect,
    parameter,
)


class NoHeat(FlowSource):
    """Feels a temperature without taking heat."""

    port = Port(Thermal)

    def flow(self) -> ExprLike:
        return 0.0


class TemperatureSensor(Component):
    """The absolute temperature of a node."""

    port = Port(Thermal)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    temperature = Output("K")

    touch = NoHeat()

    connections = (
        connect(port, touch.port),
        connect(touch.port.effort + ambient_temperature, temperature),
    )


class NoDrop(EffortSource):
    """Lets entropy pass without a difference of temperature."""

    a = Port(Thermal)
    b = Port(Thermal)
    port = Port(Thermal, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class EntropyFlowSensor(Component):
    """The entropy flow from port `a` to port `b`."""

    a = Port(Thermal)
    b = Port(Thermal)
    entropy_flow = Output("W/K")

    meter = NoDrop()

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, entropy_flow),
    )


class HeatFlowSensor(Component):
    """The heat flow from port `a` to port `b`: entropy flow times absolute temperature."""

    a = Port(Thermal)
    b = Port(Thermal)
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    heat_flow = Output("W")

    meter = NoDrop()
    touch = NoHeat()

    connections = (
        connect(a, meter.a, touch.port),
        connect(meter.b, b),
        connect((touch.port.effort + ambient_temperature) * meter.port.flow, heat_flow),
    )


class EntropyCounter(SignalBlock):
    """The entropy that a flow has carried."""

    entropy_flow = Input("W/K")
    entropy = Output("J/K")
    start: Parameter = parameter("J/K", default=0.0)
    passed = State("J/K", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.entropy: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.entropy_flow}


class EntropySensor(Component):
    """The entropy that has passed from port `a` to port `b`, and the entropy flow."""

    a = Port(Thermal)
    b = Port(Thermal)
    start: Parameter = parameter("J/K", default=0.0, doc="entropy at the start")
    entropy = Output("J/K")
    entropy_flow = Output("W/K")

    meter = NoDrop()
    counter = EntropyCounter(start=start)

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, entropy_flow, counter.entropy_flow),
        connect(counter.entropy, entropy),
    )
