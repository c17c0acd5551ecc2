"""Electricity.

Sign convention: the effort is voltage against ground, the flow is the current into the component, so power is
positive into it. An element between two pins has the voltage of `a` less that of `b`; its current passes from `a`
to `b`.
"""

from propermodel.library.electrical.components import (
    Capacitor,
    CoupledInductors,
    Diode,
    IdealTransformer,
    Inductor,
    Resistor,
    VariableResistor,
)
from propermodel.library.electrical.machines import (
    DCMotor,
    ElectromechanicalConversion,
    OperationalAmplifier,
    VoiceCoil,
)
from propermodel.library.electrical.sensors import CurrentSensor, VoltageSensor
from propermodel.library.electrical.sources import CurrentSource, FloatingVoltageSource, Ground, VoltageSource

__all__ = [
    "Capacitor",
    "CoupledInductors",
    "CurrentSensor",
    "CurrentSource",
    "DCMotor",
    "Diode",
    "ElectromechanicalConversion",
    "FloatingVoltageSource",
    "Ground",
    "IdealTransformer",
    "Inductor",
    "OperationalAmplifier",
    "Resistor",
    "VariableResistor",
    "VoiceCoil",
    "VoltageSensor",
    "VoltageSource",
]
