"""Sensors of pressure and volume flow; they take no power."""

from __future__ import annotations

from propermodel.expressions import ExprLike
from propermodel.modelling import Component, EffortSource, FlowSource, Hydraulic, Output, Port, connect


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
