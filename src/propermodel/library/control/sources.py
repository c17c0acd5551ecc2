"""Signals that are functions of time."""

from __future__ import annotations

import math

from propermodel.expressions import Expr, ExprLike, clip, floor, sin, time, where
from propermodel.modelling import Output, Parameter, SignalBlock, parameter


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
