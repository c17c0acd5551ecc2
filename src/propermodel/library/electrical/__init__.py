"""Electricity.

Sign convention: the effort is voltage against ground, the flow is the current into the component, so power is
positive into it. An element between two pins has the voltage of `a` less that of `b`; its current passes from `a`
to `b`.
"""

from propermodel.library.electrical.components import (
    Capacitor,
    Conductor,
    CoupledInductors,
    Diode,
    IdealGyrator,
    IdealTransformer,
    Inductor,
    Potentiometer,
    Resistor,
    SaturatingInductor,
    VariableCapacitor,
    VariableInductor,
    VariableResistor,
    ZenerDiode,
)
from propermodel.library.electrical.controlled import (
    CurrentControlledCurrent,
    CurrentControlledVoltage,
    VoltageControlledCurrent,
    VoltageControlledVoltage,
)
from propermodel.library.electrical.machines import (
    DCMotor,
    ElectromechanicalConversion,
    OperationalAmplifier,
    VoiceCoil,
)
from propermodel.library.electrical.sensors import (
    ChargeSensor,
    CurrentSensor,
    FloatingVoltageSensor,
    FluxLinkageSensor,
    VoltageSensor,
)
from propermodel.library.electrical.sources import (
    ConstantCurrent,
    ConstantVoltage,
    CurrentSource,
    FloatingCurrentSource,
    FloatingVoltageSource,
    Ground,
    VoltageSource,
)
from propermodel.library.electrical.switches import IdealDiode, IdealSwitch, IdealThyristor
from propermodel.library.electrical.transistors import FieldEffectTransistor, NPNTransistor, PNPTransistor

__all__ = [
    "Capacitor",
    "ChargeSensor",
    "Conductor",
    "ConstantCurrent",
    "ConstantVoltage",
    "CoupledInductors",
    "CurrentControlledCurrent",
    "CurrentControlledVoltage",
    "CurrentSensor",
    "CurrentSource",
    "DCMotor",
    "Diode",
    "ElectromechanicalConversion",
    "FieldEffectTransistor",
    "FloatingCurrentSource",
    "FloatingVoltageSensor",
    "FloatingVoltageSource",
    "FluxLinkageSensor",
    "Ground",
    "IdealDiode",
    "IdealGyrator",
    "IdealSwitch",
    "IdealThyristor",
    "IdealTransformer",
    "Inductor",
    "NPNTransistor",
    "OperationalAmplifier",
    "PNPTransistor",
    "Potentiometer",
    "Resistor",
    "SaturatingInductor",
    "VariableCapacitor",
    "VariableInductor",
    "VariableResistor",
    "VoiceCoil",
    "VoltageControlledCurrent",
    "VoltageControlledVoltage",
    "VoltageSensor",
    "VoltageSource",
    "ZenerDiode",
]
