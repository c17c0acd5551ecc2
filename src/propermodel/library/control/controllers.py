"""Sampled controllers."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, where
from propermodel.modelling import Controller, Discrete, Input, Output, Parameter, parameter


class SampledPID(Controller):
    """A sampled PID controller with limits; its integral rests while the output is at a limit (clamping).

    The derivative acts on the measurement, so a step of the setpoint gives no kick (Åström and Murray, Feedback
    Systems, ch. 10).
    """

    setpoint = Input("1")
    measurement = Input("1")
    command = Output("1")
    integral = Discrete("1")
    last_measurement = Discrete("1")
    proportional_gain: Parameter = parameter("1", default=1.0)
    integral_gain: Parameter = parameter("1/s", default=0.0)
    derivative_gain: Parameter = parameter("s", default=0.0)
    low: Parameter = parameter("1", default=-1.0)
    high: Parameter = parameter("1", default=1.0)

    def step(self) -> dict[Expr, ExprLike]:
        error = self.setpoint - self.measurement
        change = (self.measurement - self.last_measurement) / self.period
        free = self.proportional_gain * error + self.integral - self.derivative_gain * change
        # The integral grows only while that leads the output away from its limit, or it is at none.
        may_grow = ((free < self.high) | (error < 0.0)) & ((free > self.low) | (error > 0.0))
        grown = self.integral + self.integral_gain * self.period * error
        return {
            self.command: clip(free, self.low, self.high),
            self.integral: where(may_grow, grown, self.integral),
            self.last_measurement: self.measurement,
        }


class SampleHold(Controller):
    """A signal read once a period and held in between."""

    signal = Input("1")
    result = Output("1")

    def step(self) -> dict[Expr, ExprLike]:
        return {self.result: self.signal}
