"""Continuous signal blocks."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, where
from propermodel.modelling import Discrete, Input, Output, Parameter, SignalBlock, State, parameter, when
from propermodel.modelling.events import When


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


class Derivative(SignalBlock):
    """The rate of change of a signal, through a first-order lag: s / (1 + T s); it begins at rest on the signal."""

    signal = Input("1")
    result = Output("1/s")
    filter_time: Parameter = parameter("s", low=0.0)
    start: Parameter = parameter("1", default=0.0, doc="the signal at the start")
    lagged = State("1", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: (self.signal - self.lagged) / self.filter_time}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.lagged: (self.signal - self.lagged) / self.filter_time}


class LeadLag(SignalBlock):
    """A compensator (1 + T_1 s) / (1 + T_2 s): it leads with T_1 above T_2, and lags below."""

    signal = Input("1")
    result = Output("1")
    lead_time: Parameter = parameter("s", low=0.0)
    lag_time: Parameter = parameter("s", low=0.0)
    start: Parameter = parameter("1", default=0.0)
    lagged = State("1", start=start)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.lagged + self.lead_time / self.lag_time * (self.signal - self.lagged)}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {self.lagged: (self.signal - self.lagged) / self.lag_time}


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


class SecondOrder(SignalBlock):
    """A second-order lag: y'' + 2 zeta w y' + w^2 y = w^2 u."""

    signal = Input("1")
    result = Output("1")
    natural_frequency: Parameter = parameter("rad/s", low=0.0)
    damping_ratio: Parameter = parameter("1", default=0.7, low=0.0)
    value = State("1")
    rate = State("1/s")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.value}

    def derivatives(self) -> dict[Expr, ExprLike]:
        w = self.natural_frequency
        return {
            self.value: self.rate,
            self.rate: w * w * (self.signal - self.value) - 2.0 * self.damping_ratio * w * self.rate,
        }


class PID(SignalBlock):
    """A continuous PID controller: u = k e + k_i integral(e) - k_d dy/dt, the derivative filtered.

    The derivative acts on the measurement (Åström and Murray, Feedback Systems, ch. 10).
    """

    setpoint = Input("1")
    measurement = Input("1")
    command = Output("1")
    proportional_gain: Parameter = parameter("1", default=1.0)
    integral_gain: Parameter = parameter("1/s", default=0.0)
    derivative_gain: Parameter = parameter("s", default=0.0)
    filter_time: Parameter = parameter("s", default=0.01, low=0.0, doc="lag of the derivative")
    integral = State("1")
    lagged = State("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        change = (self.measurement - self.lagged) / self.filter_time
        proportional = self.proportional_gain * (self.setpoint - self.measurement)
        return {self.command: proportional + self.integral - self.derivative_gain * change}

    def derivatives(self) -> dict[Expr, ExprLike]:
        return {
            self.integral: self.integral_gain * (self.setpoint - self.measurement),
            self.lagged: (self.measurement - self.lagged) / self.filter_time,
        }


class DeadZone(SignalBlock):
    """What a signal exceeds a zone around zero by."""

    signal = Input("1")
    result = Output("1")
    low: Parameter = parameter("1", default=-1.0)
    high: Parameter = parameter("1", default=1.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.signal - clip(self.signal, self.low, self.high)}


class Relay(SignalBlock):
    """Switches on above one value of a signal and off below another; in between it stays as it is."""

    signal = Input("1")
    result = Output("1")
    high: Parameter = parameter("1", default=0.5, doc="switches on above it")
    low: Parameter = parameter("1", default=-0.5, doc="switches off below it")
    on: Parameter = parameter("1", default=1.0, doc="the result while on")
    off: Parameter = parameter("1", default=0.0, doc="the result while off")
    is_on = Discrete("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: where(self.is_on > 0.5, self.on, self.off)}

    def events(self) -> tuple[When, ...]:
        """It switches."""
        return (
            when((self.is_on < 0.5) & (self.signal > self.high), {self.is_on: 1.0}),
            when((self.is_on > 0.5) & (self.signal < self.low), {self.is_on: 0.0}),
        )


class Selector(SignalBlock):
    """One of two signals: the first while `choice` is above 0.5, else the second."""

    first = Input("1")
    second = Input("1")
    choice = Input("1")
    result = Output("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: where(self.choice > 0.5, self.first, self.second)}
