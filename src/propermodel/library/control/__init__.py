"""Signal processing and sampled controllers; signals carry no power and no unit of their own (`1`) unless said."""

from propermodel.library.control.components import (
    PID,
    DeadZone,
    Derivative,
    FirstOrder,
    Gain,
    Integrator,
    LeadLag,
    Limiter,
    Mean,
    RateLimiter,
    Relay,
    SecondOrder,
    Selector,
)
from propermodel.library.control.controllers import SampledPID, SampleHold
from propermodel.library.control.sources import Constant, PulseWidth, Ramp, Sine, SquareWave, Step

__all__ = [
    "PID",
    "Constant",
    "DeadZone",
    "Derivative",
    "FirstOrder",
    "Gain",
    "Integrator",
    "LeadLag",
    "Limiter",
    "Mean",
    "PulseWidth",
    "Ramp",
    "RateLimiter",
    "Relay",
    "SampleHold",
    "SampledPID",
    "SecondOrder",
    "Selector",
    "Sine",
    "SquareWave",
    "Step",
]
