"""Hydraulics.

Sign convention: the effort is gauge pressure (above ambient), the flow is the volume flow into the component, so
power is positive into it. An element between two ports has the pressure of `a` less that of `b`; its flow passes from
`a` to `b`.
"""

from propermodel.library.hydraulics.components import GasVessel, Leakage, LineResistance, OilChamber, Orifice
from propermodel.library.hydraulics.cylinders import Cylinder, FixedPump, Piston, Plunger
from propermodel.library.hydraulics.fluids import NITROGEN, BenedictWebbRubin
from propermodel.library.hydraulics.lines import LaminarLine, LineSection, OilInertia
from propermodel.library.hydraulics.machines import Displacement, PumpMotor, TorqueLoss, UnitFriction, VolumetricLoss
from propermodel.library.hydraulics.sensors import (
    FlowSensor,
    PressureDropSensor,
    PressureMomentumSensor,
    PressureSensor,
    VolumeSensor,
)
from propermodel.library.hydraulics.sources import (
    ConstantPressure,
    ConstantVolumeFlow,
    OpenTank,
    PressureSource,
    VolumeFlowSource,
)
from propermodel.library.hydraulics.valves import CheckValve, MeteringOrifice, ReliefValve, ServoValve
from propermodel.library.hydraulics.vessels import GasAccumulator, LevelTank

__all__ = [
    "NITROGEN",
    "BenedictWebbRubin",
    "CheckValve",
    "ConstantPressure",
    "ConstantVolumeFlow",
    "Cylinder",
    "Displacement",
    "FixedPump",
    "FlowSensor",
    "GasAccumulator",
    "GasVessel",
    "LaminarLine",
    "Leakage",
    "LevelTank",
    "LineResistance",
    "LineSection",
    "MeteringOrifice",
    "OilChamber",
    "OilInertia",
    "OpenTank",
    "Orifice",
    "Piston",
    "Plunger",
    "PressureDropSensor",
    "PressureMomentumSensor",
    "PressureSensor",
    "PressureSource",
    "PumpMotor",
    "ReliefValve",
    "ServoValve",
    "TorqueLoss",
    "UnitFriction",
    "VolumeFlowSource",
    "VolumeSensor",
    "VolumetricLoss",
]
