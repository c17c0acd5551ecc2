"""Signals that are functions of time."""

from __future__ import annotations

import math

from propermodel.expressions import Expr, ExprLike, clip, floor, maximum, sin, time, where
from propermodel.modelling import Discrete, Output, Parameter, SignalBlock, parameter, when
from propermodel.modelling.events import When


class Constant(SignalBlock):
    """A constant signal."""

    result = Output("1")
    value: Parameter = parameter("1")

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.value}


class Step(SignalBlock):
    """A signal that jumps once; let the jump fall on a step of the run."""

    result = Output("1")
    before: Parameter = parameter("1", default=0.0)
    after: Parameter = parameter("1", default=1.0)
    at: Parameter = parameter("s", default=0.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: where(time >= self.at, self.after, self.before)}


class Ramp(SignalBlock):
    """A signal that goes from one value to another at a constant rate, from `begin` to `end`."""

    result = Output("1")
    before: Parameter = parameter("1", default=0.0)
    after: Parameter = parameter("1", default=1.0)
    begin: Parameter = parameter("s", default=0.0)
    end: Parameter = parameter("s", default=1.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        share = clip((time - self.begin) / (self.end - self.begin), 0.0, 1.0)
        return {self.result: self.before + (self.after - self.before) * share}


class Sine(SignalBlock):
    """A harmonic signal: offset + amplitude sin(2 pi f t + phase)."""

    result = Output("1")
    amplitude: Parameter = parameter("1", default=1.0)
    frequency: Parameter = parameter("Hz", low=0.0)
    phase: Parameter = parameter("rad", default=0.0)
    offset: Parameter = parameter("1", default=0.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        angle = 2.0 * math.pi * self.frequency * time + self.phase
        return {self.result: self.offset + self.amplitude * sin(angle)}


class SquareWave(SignalBlock):
    """A signal that is high for a share of every period and low for the rest."""

    result = Output("1")
    low: Parameter = parameter("1", default=0.0)
    high: Parameter = parameter("1", default=1.0)
    frequency: Parameter = parameter("Hz", low=0.0)
    duty: Parameter = parameter("1", default=0.5, low=0.0, high=1.0)

    def outputs(self) -> dict[Expr, ExprLike]:
        cycles = self.frequency * time
        return {self.result: where(cycles - floor(cycles) < self.duty, self.high, self.low)}


class PulseWidth(SignalBlock):
    """A signal that is 1 for a share of every period and 0 for the rest, switched at located instants.

    For power electronics: steps end where it switches, so that none of them averages over both.
    """

    result = Output("1")
    frequency: Parameter = parameter("Hz", low=0.0)
    duty: Parameter = parameter("1", default=0.5, low=0.0, high=1.0)
    is_on = Discrete("1")
    periods = Discrete("1", start=-1.0)  # that have begun before this one

    def outputs(self) -> dict[Expr, ExprLike]:
        return {self.result: self.is_on}

    def events(self) -> tuple[When, ...]:
        """It is switched off after its share of a period, and on when the next one begins."""
        cycles, is_on = self.frequency * time, self.is_on > 0.5
        following = self.periods + 1.0
        return (
            when(is_on & (cycles > self.periods + self.duty), {self.is_on: 0.0}),
            when(
                ~is_on & (cycles >= following) & (self.duty > 0.0),
                {self.is_on: 1.0, self.periods: maximum(following, floor(cycles))},
            ),
        )
