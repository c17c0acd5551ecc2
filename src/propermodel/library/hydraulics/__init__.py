"""Hydraulics.

Sign convention: the effort is gauge pressure (above ambient), the flow is the volume flow into the component, so
power is positive into it. An element between two ports has the pressure of `a` less that of `b`; its flow passes from
`a` to `b`.
"""

from propermodel.library.hydraulics.components import GasVessel, Leakage, LineResistance, OilChamber, Orifice
from propermodel.library.hydraulics.fluids import NITROGEN, BenedictWebbRubin
from propermodel.library.hydraulics.machines import Displacement, PumpMotor, TorqueLoss, UnitFriction, VolumetricLoss
from propermodel.library.hydraulics.sensors import FlowSensor, PressureSensor
from propermodel.library.hydraulics.sources import OpenTank, PressureSource, VolumeFlowSource

__all__ = [
    "NITROGEN",
    "BenedictWebbRubin",
    "Displacement",
    "FlowSensor",
    "GasVessel",
    "Leakage",
    "LineResistance",
    "OilChamber",
    "OpenTank",
    "Orifice",
    "PressureSensor",
    "PressureSource",
    "PumpMotor",
    "TorqueLoss",
    "UnitFriction",
    "VolumeFlowSource",
    "VolumetricLoss",
]
