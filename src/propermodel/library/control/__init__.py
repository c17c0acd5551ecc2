"""Signal processing and sampled controllers; signals carry no power and no unit of their own (`1`) unless said."""

from propermodel.library.control.components import (
    PID,
    DeadZone,
    FirstOrder,
    Gain,
    Integrator,
    Limiter,
    Mean,
    RateLimiter,
    SecondOrder,
)
from propermodel.library.control.controllers import SampledPID, SampleHold
from propermodel.library.control.sources import Constant, PulseWidth, Ramp, Sine, SquareWave, Step

__all__ = [
    "PID",
    "Constant",
    "DeadZone",
    "FirstOrder",
    "Gain",
    "Integrator",
    "Limiter",
    "Mean",
    "PulseWidth",
    "Ramp",
    "RateLimiter",
    "SampleHold",
    "SampledPID",
    "SecondOrder",
    "Sine",
    "SquareWave",
    "Step",
]
