"""Electricity.

Sign convention: the effort is voltage against ground, the flow is the current into the component, so power is
positive into it. An element between two pins has the voltage of `a` less that of `b`; its current passes from `a`
to `b`.
"""

from propermodel.library.electrical.components import Capacitor, Inductor, Resistor
from propermodel.library.electrical.machines import DCMotor
from propermodel.library.electrical.sensors import CurrentSensor, VoltageSensor
from propermodel.library.electrical.sources import CurrentSource, Ground, VoltageSource

__all__ = [
    "Capacitor",
    "CurrentSensor",
    "CurrentSource",
    "DCMotor",
    "Ground",
    "Inductor",
    "Resistor",
    "VoltageSensor",
    "VoltageSource",
]
