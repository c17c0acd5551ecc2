"""Sources that another voltage or current controls: two-ports that feel without taking power."""

from __future__ import annotations

from propermodel.expressions import ExprLike
from propermodel.library.electrical.sensors import CurrentSensor
from propermodel.library.electrical.sources import FloatingCurrentSource, FloatingVoltageSource
from propermodel.modelling import Component, Electrical, FlowSource, Parameter, Port, connect, parameter


class OpenPair(FlowSource):
    """Feels the voltage between two pins without taking current."""

    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))

    def flow(self) -> ExprLike:
        return 0.0


class VoltageControlledVoltage(Component):
    """The voltage of `out_a` above `out_b` is `gain` times that of `in_a` above `in_b`, which pass no current."""

    in_a = Port(Electrical)
    in_b = Port(Electrical)
    out_a = Port(Electrical)
    out_b = Port(Electrical)
    gain: Parameter = parameter("1")

    feel = OpenPair()
    supply = FloatingVoltageSource()

    connections = (
        connect(in_a, feel.a),
        connect(in_b, feel.b),
        connect(out_a, supply.a),
        connect(out_b, supply.b),
        connect(gain * feel.port.effort, supply.voltage),
    )


class VoltageControlledCurrent(Component):
    """The current from `out_a` to `out_b` is `transconductance` times the voltage of `in_a` above `in_b`."""

    in_a = Port(Electrical)
    in_b = Port(Electrical)
    out_a = Port(Electrical)
    out_b = Port(Electrical)
    transconductance: Parameter = parameter("1/Ohm")

    feel = OpenPair()
    supply = FloatingCurrentSource()

    connections = (
        connect(in_a, feel.a),
        connect(in_b, feel.b),
        connect(out_a, supply.a),
        connect(out_b, supply.b),
        connect(transconductance * feel.port.effort, supply.current),
    )


class CurrentControlledVoltage(Component):
    """The voltage of `out_a` above `out_b` is `transresistance` times the current from `in_a` to `in_b`."""

    in_a = Port(Electrical)
    in_b = Port(Electrical)
    out_a = Port(Electrical)
    out_b = Port(Electrical)
    transresistance: Parameter = parameter("Ohm")

    feel = CurrentSensor()
    supply = FloatingVoltageSource()

    connections = (
        connect(in_a, feel.a),
        connect(in_b, feel.b),
        connect(out_a, supply.a),
        connect(out_b, supply.b),
        connect(transresistance * feel.current, supply.voltage),
    )


class CurrentControlledCurrent(Component):
    """The current from `out_a` to `out_b` is `gain` times that from `in_a` to `in_b`, whose voltages are equal."""

    in_a = Port(Electrical)
    in_b = Port(Electrical)
    out_a = Port(Electrical)
    out_b = Port(Electrical)
    gain: Parameter = parameter("1")

    feel = CurrentSensor()
    supply = FloatingCurrentSource()

    connections = (
        connect(in_a, feel.a),
        connect(in_b, feel.b),
        connect(out_a, supply.a),
        connect(out_b, supply.b),
        connect(gain * feel.current, supply.current),
    )
