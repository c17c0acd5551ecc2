"""Bodies that move in a vertical plane.

Sign convention: x forward, z up, pitch nose up (from x towards z). Velocities are those of the centre of gravity in a
frame fixed to the body, so a turning frame adds the gyroscopic terms of Euler's equations.
"""

from propermodel.library.mechanics.planar.components import EulerGyrator, PlanarBody, PlanarFrame, Sines

__all__ = ["EulerGyrator", "PlanarBody", "PlanarFrame", "Sines"]
