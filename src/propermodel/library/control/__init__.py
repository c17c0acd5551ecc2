"""Signal processing and sampled controllers; signals carry no power and no unit of their own (`1`) unless said."""

from propermodel.library.control.components import FirstOrder, Gain, Integrator, Limiter, Mean, RateLimiter
from propermodel.library.control.controllers import SampledPID

__all__ = ["FirstOrder", "Gain", "Integrator", "Limiter", "Mean", "RateLimiter", "SampledPID"]
