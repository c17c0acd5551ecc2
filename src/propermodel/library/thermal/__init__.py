"""Heat as a true bond.

Sign convention: the effort is temperature above ambient, the flow is the entropy that enters the component, so power
is positive into it and counts what heat could still do against ambient. Ambient is the zero of effort.
"""

from propermodel.library.thermal.components import (
    Conduction,
    Convection,
    HeatCapacity,
    HeatingResistor,
    Radiation,
    WallConductance,
)
from propermodel.library.thermal.heating import HeatingDamper, HeatingFriction
from propermodel.library.thermal.sensors import (
    EntropyFlowSensor,
    EntropySensor,
    HeatFlowSensor,
    TemperatureSensor,
)
from propermodel.library.thermal.sources import (
    Ambient,
    ConstantHeatFlow,
    FixedTemperature,
    HeatFlowSource,
    HeatSource,
    TemperatureSource,
)

__all__ = [
    "Ambient",
    "Conduction",
    "ConstantHeatFlow",
    "Convection",
    "EntropyFlowSensor",
    "EntropySensor",
    "FixedTemperature",
    "HeatCapacity",
    "HeatFlowSensor",
    "HeatFlowSource",
    "HeatSource",
    "HeatingDamper",
    "HeatingFriction",
    "HeatingResistor",
    "Radiation",
    "TemperatureSensor",
    "TemperatureSource",
    "WallConductance",
]
