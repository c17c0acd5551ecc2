"""Rotating mechanics.

Sign convention: angular velocities of all shafts count in one sense. The effort of a port is the torque with which its
surroundings turn the component in that sense, so power is positive into it. An element between two shafts has the
velocity of `a` less that of `b`. A gear takes power in at `a` and gives it out at `b`.
"""

from propermodel.library.mechanics.rotation.components import (
    Backlash,
    CoulombFriction,
    GravityPendulum,
    QuadraticTorque,
    RotatingInertia,
    RotationalDamper,
    RotationalSpringDamper,
    SlippingClutch,
    StribeckFriction,
    TorsionSpring,
    ViscousFriction,
)
from propermodel.library.mechanics.rotation.friction import Brake, Freewheel, LockingClutch, StickingFriction
from propermodel.library.mechanics.rotation.machines import (
    BeltDrive,
    Differential,
    Gear,
    LossyGear,
    ModulatedGear,
    PlanetaryGear,
    RollingWheel,
    TorqueDrivenLoss,
    TorqueGivenLoss,
    passing_efficiency,
)
from propermodel.library.mechanics.rotation.sensors import (
    AngularImpulseSensor,
    RelativeRotationSensor,
    RotationSensor,
    TorqueSensor,
)
from propermodel.library.mechanics.rotation.sources import (
    ConstantSpeed,
    ConstantTorque,
    FixedShaft,
    SpeedSource,
    TorqueSource,
)

__all__ = [
    "AngularImpulseSensor",
    "Backlash",
    "BeltDrive",
    "Brake",
    "ConstantSpeed",
    "ConstantTorque",
    "CoulombFriction",
    "Differential",
    "FixedShaft",
    "Freewheel",
    "Gear",
    "GravityPendulum",
    "LockingClutch",
    "LossyGear",
    "ModulatedGear",
    "PlanetaryGear",
    "QuadraticTorque",
    "RelativeRotationSensor",
    "RollingWheel",
    "RotatingInertia",
    "RotationSensor",
    "RotationalDamper",
    "RotationalSpringDamper",
    "SlippingClutch",
    "SpeedSource",
    "StickingFriction",
    "StribeckFriction",
    "TorqueDrivenLoss",
    "TorqueGivenLoss",
    "TorqueSensor",
    "TorqueSource",
    "TorsionSpring",
    "ViscousFriction",
    "passing_efficiency",
]
