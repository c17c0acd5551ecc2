"""Continuous signal blocks."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip
from propermodel.modelling import Input, Output, Parameter, SignalBlock, State, parameter


class Gain(SignalBlock):
    """A signal times a constant."""

    signal = Input("1")
    result = Output("1")
    gain: Parameter = parameter("1", default=1.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.gain * self.signal}


class Limiter(SignalBlock):
    """A signal held between two limits."""

    signal = Input("1")
    result = Output("1")
    low: Parameter = parameter("1", default=-1.0)
    high: Parameter = parameter("1", default=1.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: clip(self.signal, self.low, self.high)}


class Mean(SignalBlock):
    """The mean of two signals."""

    first = Input("1")
    second = Input("1")
    result = Output("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: 0.5 * (self.first + self.second)}


class Integrator(SignalBlock):
    """The integral of a signal over time."""

    signal = Input("1/s")
    result = Output("1")
    start: Parameter = parameter("1", default=0.0)
    integral = State("1", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.integral}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.integral: self.signal}


class FirstOrder(SignalBlock):
    """A first-order lag."""

    signal = Input("1")
    result = Output("1")
    time_constant: Parameter = parameter("s", low=0.0)
    start: Parameter = parameter("1", default=0.0)
    lagged = State("1", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.lagged}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.lagged: (self.signal - self.lagged) / self.time_constant}


class RateLimiter(SignalBlock):
    """Follows a signal through a short lag, no faster than a given rate."""

    signal = Input("1")
    result = Output("1")
    rate: Parameter = parameter("1/s", low=0.0)
    lag: Parameter = parameter("s", default=0.01, low=0.0, doc="with which it follows when it may")
    start: Parameter = parameter("1", default=0.0)
    followed = State("1", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.followed}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.followed: clip((self.signal - self.followed) / self.lag, -self.rate, self.rate)}
