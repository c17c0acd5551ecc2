"""Heat as a pseudo bond, as engineers who count heat and not entropy write it.

Sign convention: the effort is absolute temperature, the flow is the heat flow into the component. Their product is no
power: these elements have no place in a ranking of true ones, and a balance of their own. Converters join them to true
bonds.
"""

from propermodel.library.pseudo_thermal.components import HeatStore, ThermalConductor, ThermalRadiation, ThermalResistor
from propermodel.library.pseudo_thermal.converters import (
    DamperHeat,
    FrictionHeat,
    ResistorHeat,
    TrueThermalPort,
)
from propermodel.library.pseudo_thermal.sensors import (
    HeatFlowSensor,
    HeatSensor,
    TemperatureSensor,
)
from propermodel.library.pseudo_thermal.sources import FixedTemperature, PrescribedHeatFlow, PrescribedTemperature

__all__ = [
    "DamperHeat",
    "FixedTemperature",
    "FrictionHeat",
    "HeatFlowSensor",
    "HeatSensor",
    "HeatStore",
    "PrescribedHeatFlow",
    "PrescribedTemperature",
    "ResistorHeat",
    "TemperatureSensor",
    "ThermalConductor",
    "ThermalRadiation",
    "ThermalResistor",
    "TrueThermalPort",
]
