"""Sensors of voltage and current; they take no power."""

from __future__ import annotations

from propermodel.expressions import ExprLike
from propermodel.modelling import Component, EffortSource, Electrical, FlowSource, Output, Port, connect


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
