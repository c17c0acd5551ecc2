"""Straight-line mechanics.

Sign convention: velocities of all flanges count in one direction. The effort of a port is the force with which its
surroundings push the component in that direction, so power is positive into it. An element between two flanges has the
velocity of `a` less that of `b`: its displacement is how far the flanges have come together, its effort is positive in
compression.
"""

from propermodel.library.mechanics.translation.components import (
    Damper,
    DegressiveDamper,
    ElasticStop,
    Friction,
    GasSpring,
    HardeningSpring,
    Lever,
    Mass,
    Projection,
    QuadraticDrag,
    Spring,
    SpringDamper,
)
from propermodel.library.mechanics.translation.contact import Impact
from propermodel.library.mechanics.translation.friction import StickingFriction
from propermodel.library.mechanics.translation.sensors import (
    ForceSensor,
    ImpulseSensor,
    MotionSensor,
    RelativeMotionSensor,
)
from propermodel.library.mechanics.translation.sources import (
    ConstantForce,
    ConstantVelocity,
    Fixed,
    ForceSource,
    VelocitySource,
    Weight,
)

__all__ = [
    "ConstantForce",
    "ConstantVelocity",
    "Damper",
    "DegressiveDamper",
    "ElasticStop",
    "Fixed",
    "ForceSensor",
    "ForceSource",
    "Friction",
    "GasSpring",
    "HardeningSpring",
    "Impact",
    "ImpulseSensor",
    "Lever",
    "Mass",
    "MotionSensor",
    "Projection",
    "QuadraticDrag",
    "RelativeMotionSensor",
    "Spring",
    "SpringDamper",
    "StickingFriction",
    "VelocitySource",
    "Weight",
]
