"""Bodies and mechanisms that move in a vertical plane.

Mechanisms are built of parts with frames (`Frame`: x along, y up, angle from x towards y, all seen from the ground):
from a `FixedFrame` outwards, joints and bars give the position of their frame `b`, bodies and sensors take it. Forces
and torques at a frame act on the part, positive in the positive direction.

Linkages (`linkages`) are geometry in the same axes, with points and angles as ports.

Vehicles (`PlanarBody`, `PlanarFrame`) have axes of their own: x forward, z up, pitch nose up (from x towards z).
Velocities are those of the centre of gravity in a frame fixed to the body, so a turning frame adds the gyroscopic
terms of Euler's equations.
"""

from propermodel.library.mechanics.planar.bodies import Body, CarriedMass, FixedTranslation
from propermodel.library.mechanics.planar.components import EulerGyrator, PlanarBody, PlanarFrame, Sines
from propermodel.library.mechanics.planar.joints import (
    ActuatedPrismatic,
    ActuatedRevolute,
    ClosingRevolute,
    FreeMotion,
    PointGap,
    Prismatic,
    Revolute,
    Slide,
)
from propermodel.library.mechanics.planar.linkages import (
    Arm,
    FixedPoint,
    FourBarLinkage,
    Link,
    PinnedRod,
    PointMass,
    SliderCrankLinkage,
)
from propermodel.library.mechanics.planar.ports import Frame, Point
from propermodel.library.mechanics.planar.sensors import FrameSensor
from propermodel.library.mechanics.planar.sources import FixedFrame, FrameForce
from propermodel.library.mechanics.planar.springs import Distance, LineDamping, LineSpringDamper, Stretch

__all__ = [
    "ActuatedPrismatic",
    "ActuatedRevolute",
    "Arm",
    "Body",
    "CarriedMass",
    "ClosingRevolute",
    "Distance",
    "EulerGyrator",
    "FixedFrame",
    "FixedPoint",
    "FixedTranslation",
    "FourBarLinkage",
    "Frame",
    "FrameForce",
    "FrameSensor",
    "FreeMotion",
    "LineDamping",
    "LineSpringDamper",
    "Link",
    "PinnedRod",
    "PlanarBody",
    "PlanarFrame",
    "Point",
    "PointGap",
    "PointMass",
    "Prismatic",
    "Revolute",
    "Sines",
    "Slide",
    "SliderCrankLinkage",
    "Stretch",
]
