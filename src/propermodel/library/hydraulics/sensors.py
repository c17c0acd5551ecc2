"""Sensors of pressure, volume flow, volume and pressure momentum; they take no power."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import (
    Component,
    EffortSource,
    FlowSource,
    Hydraulic,
    Input,
    Output,
    Parameter,
    Port,
    SignalBlock,
    State,
    connect,
    parameter,
)


class NoFlow(FlowSource):
    """Feels a pressure without taking oil."""

    port = Port(Hydraulic)

    def flow(self) -> ExprLike:
        return 0.0


class PressureSensor(Component):
    """The gauge pressure of a node."""

    port = Port(Hydraulic)
    pressure = Output("Pa")

    touch = NoFlow()

    connections = (
        connect(port, touch.port),
        connect(touch.port.effort, pressure),
    )


class NoPressureDrop(EffortSource):
    """Lets oil pass without loss."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))

    def effort(self) -> ExprLike:
        return 0.0


class FlowSensor(Component):
    """The volume flow from port `a` to port `b`."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    volume_flow = Output("m3/s")

    meter = NoPressureDrop()

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, volume_flow),
    )


class VolumeCounter(SignalBlock):
    """The volume that a flow has carried."""

    volume_flow = Input("m3/s")
    volume = Output("m3")
    start: Parameter = parameter("m3", default=0.0)
    passed = State("m3", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.volume: self.passed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.passed: self.volume_flow}


class VolumeSensor(Component):
    """The volume that has passed from port `a` to port `b`, and the volume flow."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    start: Parameter = parameter("m3", default=0.0, doc="volume at the start")
    volume = Output("m3")
    volume_flow = Output("m3/s")

    meter = NoPressureDrop()
    counter = VolumeCounter(start=start)

    connections = (
        connect(a, meter.a),
        connect(meter.b, b),
        connect(meter.port.flow, volume_flow, counter.volume_flow),
        connect(counter.volume, volume),
    )


class NoFlowBetween(FlowSource):
    """Feels the pressure drop between two ports without letting oil pass."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))

    def flow(self) -> ExprLike:
        return 0.0


class PressureDropSensor(Component):
    """The pressure at port `a` less that at port `b`."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    pressure_drop = Output("Pa")

    touch = NoFlowBetween()

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.effort, pressure_drop),
    )


class PressureMomentumCounter(SignalBlock):
    """The pressure momentum that a pressure drop has built up."""

    pressure_drop = Input("Pa")
    momentum = Output("Pa.s")
    start: Parameter = parameter("Pa.s", default=0.0)
    built_up = State("Pa.s", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.momentum: self.built_up}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.built_up: self.pressure_drop}


class PressureMomentumSensor(Component):
    """The pressure momentum between ports `a` and `b`: the pressure drop between them, summed up over time."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    start: Parameter = parameter("Pa.s", default=0.0, doc="pressure momentum at the start")
    momentum = Output("Pa.s")
    pressure_drop = Output("Pa")

    touch = NoFlowBetween()
    counter = PressureMomentumCounter(start=start)

    connections = (
        connect(a, touch.a),
        connect(b, touch.b),
        connect(touch.port.effort, pressure_drop, counter.pressure_drop),
        connect(counter.momentum, momentum),
    )
