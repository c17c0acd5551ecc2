"""Bodies and mechanisms that move in a vertical plane.

Sign convention of bodies: x forward, z up, pitch nose up (from x towards z). Velocities are those of the centre of
gravity in a frame fixed to the body, so a turning frame adds the gyroscopic terms of Euler's equations.

Mechanisms (`linkages`) work in a frame fixed to the ground: x along, y up, angles from x towards y.
"""

from propermodel.library.mechanics.planar.components import EulerGyrator, PlanarBody, PlanarFrame, Sines
from propermodel.library.mechanics.planar.linkages import (
    Arm,
    FixedPoint,
    FourBarLinkage,
    Link,
    PinnedRod,
    PointMass,
    SliderCrankLinkage,
)
from propermodel.library.mechanics.planar.ports import Point

__all__ = [
    "Arm",
    "EulerGyrator",
    "FixedPoint",
    "FourBarLinkage",
    "Link",
    "PinnedRod",
    "PlanarBody",
    "PlanarFrame",
    "Point",
    "PointMass",
    "Sines",
    "SliderCrankLinkage",
]
