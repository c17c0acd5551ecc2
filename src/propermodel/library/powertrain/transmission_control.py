"""Shift, lock-up and neutral logic of the transmission, sampled at 100 Hz; all values estimated."""

from __future__ import annotations

import math

from propermodel.expressions import Expr, ExprLike, clip, exp, minimum, time, where
from propermodel.library.powertrain.transmission import GEARS
from propermodel.modelling import Controller, Discrete, Input, Output, Parameter, parameter, table

# Turbine speed in rpm at no throttle and at full throttle, for gears 1 to 7; out of reach where there is no next gear.
UP_IDLE = (1750, 1850, 1650, 1650, 1700, 1650, 1e6)
UP_FULL = (2100, 2350, 2350, 2350, 2350, 2350, 1e6)
DOWN_IDLE = (-1e6, 950, 850, 950, 950, 950, 950)
DOWN_FULL = (-1e6, 1250, 1150, 1250, 1250, 1250, 1250)


class TransmissionControl(Controller):
    """One gear at a time, lock-up above a turbine speed, neutral at a stand."""

    engine_speed = Input("rad/s")
    turbine_speed = Input("rad/s")
    throttle = Input("1")
    standstill = Input("1")
    from_gear = Output("1", start=1.0)
    to_gear = Output("1", start=1.0)
    shift_start = Output("s", start=-10.0)
    engagement = Output("1", start=0.0)
    clutch_capacity = Output("N.m", start=0.0)
    clutch_closed = Output("1", start=0.0)
    shifting = Discrete("1")
    filtered_throttle = Discrete("1")
    shift_time: Parameter = parameter("s", low=0.0)
    rest_time: Parameter = parameter("s", default=1.5, low=0.0, status="estimated", doc="between two shifts")
    hurry_speed: Parameter = parameter(
        "rad/s", default=2200.0 * math.pi / 30.0, status="estimated", doc="above which upshifts do not wait"
    )
    throttle_lag: Parameter = parameter("s", default=0.3, low=0.0, status="estimated")
    lock_speed: Parameter = parameter("rad/s", default=1150.0 * math.pi / 30.0, status="estimated")
    unlock_speed: Parameter = parameter("rad/s", default=1000.0 * math.pi / 30.0, status="estimated")
    clutch_torque: Parameter = parameter("N.m", default=2000.0, low=0.0, status="estimated")
    clutch_ramp: Parameter = parameter("s", default=0.5, low=0.0, status="estimated")
    closing_slip: Parameter = parameter("rad/s", default=0.3, low=0.0, status="estimated")
    closing_torque: Parameter = parameter("N.m", default=100.0, low=0.0, status="estimated")
    engagement_rate: Parameter = parameter("1/s", default=2.5, low=0.0, status="estimated")
    up_idle = table("rpm", ("1",), [GEARS], UP_IDLE, source="estimated")
    up_full = table("rpm", ("1",), [GEARS], UP_FULL, source="estimated")
    down_idle = table("rpm", ("1",), [GEARS], DOWN_IDLE, source="estimated")
    down_full = table("rpm", ("1",), [GEARS], DOWN_FULL, source="estimated")

    def step(self) -> dict[Expr, ExprLike]:
        throttle = self.filtered_throttle + (self.throttle - self.filtered_throttle) * self.filter_share()
        gear, shifting = self.next_gear(throttle)
        capacity, closed = self.clutch(gear, shifting)
        starts = shifting & (self.shifting_still() < 0.5)
        target = where(self.standstill > 0.5, 0.0, 1.0)
        move = self.engagement_rate * self.period
        return {
            self.filtered_throttle: throttle,
            self.shifting: where(shifting, 1.0, 0.0),
            self.from_gear: where(starts, self.to_gear, self.from_gear),
            self.to_gear: gear,
            self.shift_start: where(starts, time, self.shift_start),
            self.engagement: clip(target, self.engagement - move, self.engagement + move),
            self.clutch_capacity: capacity,
            self.clutch_closed: where(closed, 1.0, 0.0),
        }

    def filter_share(self) -> Expr:
        """How far the filter moves in one period."""
        return 1.0 - exp(-self.period / self.throttle_lag)

    def shifting_still(self) -> Expr:
        """Whether the shift under way goes on."""
        over = time - self.shift_start >= self.shift_time - 0.5 * self.period
        return where(over, 0.0, self.shifting)

    def next_gear(self, throttle: Expr) -> tuple[Expr, Expr]:
        """The gear to be in, and whether a shift is under way."""
        gear, speed = self.to_gear, self.turbine_speed
        up = self.up_idle(gear) + (self.up_full(gear) - self.up_idle(gear)) * throttle
        down = self.down_idle(gear) + (self.down_full(gear) - self.down_idle(gear)) * throttle
        since = time - self.shift_start - self.shift_time
        rested = since >= self.rest_time - 0.5 * self.period
        steady = self.shifting_still() < 0.5
        shift_up = steady & (speed > up) & (rested | (speed > self.hurry_speed))
        shift_down = steady & (speed < down) & rested
        change = where(shift_up, 1.0, where(shift_down, -1.0, 0.0))
        return gear + change, shift_up | shift_down | ~steady

    def clutch(self, gear: Expr, shifting: Expr) -> tuple[Expr, Expr]:
        """Capacity of the lock-up clutch, and whether it is closed."""
        opened = shifting | (gear < 1.5) | (self.turbine_speed < self.unlock_speed)
        closed_before = self.clutch_closed > 0.5
        engages = (self.clutch_capacity > 0.0) | (self.turbine_speed > self.lock_speed)
        ramped = self.clutch_capacity + self.clutch_torque * self.period / self.clutch_ramp
        grown = where(engages & ~closed_before, minimum(self.clutch_torque, ramped), self.clutch_capacity)
        slip = abs(self.engine_speed - self.turbine_speed)
        closes = (grown > self.closing_torque) & (slip < self.closing_slip)
        return where(opened, 0.0, grown), ~opened & (closed_before | closes)
