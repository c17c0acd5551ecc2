"""The driver: follows a speed profile by one wish for torque; sampled at 100 Hz, gains estimated."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, maximum, time, where
from propermodel.expressions.core import slope
from propermodel.modelling import Controller, Discrete, Input, Output, Parameter, parameter, table


class Driver(Controller):
    """Feed-forward of acceleration, grade and resistance, with a proportional and an integral part.

    F = m (1.05 a_ff + g (sin(slope) + f_r)) + rho C_d A v^2 / 2 + k_p e + z, as torque at the transfer case.
    The integral rests while the engine is asked for more than it can give.
    """

    speed = Input("m/s")
    sine_slope = Input("1")
    rolling_coefficient = Input("1")
    engine_demand = Input("N.m")
    full_load_torque = Input("N.m")
    wish = Output("N.m")
    standstill = Output("1", start=1.0)
    integral = Discrete("N")
    mass: Parameter = parameter("kg", low=0.0, doc="of the whole truck")
    wheel_radius: Parameter = parameter("m", low=0.0)
    final_drive_ratio: Parameter = parameter("1", low=0.0)
    drag_area: Parameter = parameter("m2", low=0.0)
    air_density: Parameter = parameter("kg/m3", low=0.0)
    gravity: Parameter = parameter("m/s2", default=9.81)
    preview: Parameter = parameter("s", default=0.3, status="estimated", doc="of the acceleration of the profile")
    start_preview: Parameter = parameter("s", default=0.6, status="estimated", doc="of the end of a standstill")
    rotating_factor: Parameter = parameter("1", default=1.05, status="estimated", doc="of mass for rotating parts")
    proportional_gain: Parameter = parameter("N.s/m", default=15000.0, status="estimated")
    integral_gain: Parameter = parameter("N/m", default=2500.0, status="estimated")
    integral_limit: Parameter = parameter("N", default=20e3, low=0.0, status="estimated")
    most_driving: Parameter = parameter("N", default=60e3, low=0.0, status="estimated")
    most_braking: Parameter = parameter("N", default=80e3, low=0.0, status="estimated")
    driveline_efficiency: Parameter = parameter("1", default=0.92, low=0.0, high=1.0, status="estimated")
    standing_profile: Parameter = parameter("m/s", default=0.05, low=0.0, status="estimated")
    standing_speed: Parameter = parameter("m/s", default=0.5, low=0.0, status="estimated")
    least_full_load: Parameter = parameter("N.m", default=50.0, low=0.0, status="estimated")
    speed_profile = table("m/s", ("s",), [(0.0, 1.0)], (0.0, 0.0), source="at a stand unless a mission says otherwise")

    def step(self) -> dict[Expr, ExprLike]:
        profile = self.speed_profile(time)
        ahead = self.speed_profile(time + self.start_preview)
        halts = (profile < self.standing_profile) & (ahead < self.standing_profile)
        stands = halts & (self.speed < self.standing_speed)
        error = profile - self.speed
        resting = where(stands, 0.0, self.integral)
        force = self.feed_forward() + self.proportional_gain * error + resting
        limited_force = clip(force, -self.most_braking, self.most_driving)
        torque = limited_force * self.wheel_radius / self.final_drive_ratio
        saturated = (self.engine_demand > maximum(self.full_load_torque, self.least_full_load)) & (error > 0.0)
        grown = self.integral + self.integral_gain * self.period * error
        limited = clip(grown, -self.integral_limit, self.integral_limit)
        return {
            self.wish: where(torque > 0.0, torque / self.driveline_efficiency, torque * self.driveline_efficiency),
            self.standstill: where(stands, 1.0, 0.0),
            self.integral: where(stands, 0.0, where(saturated, self.integral, limited)),
        }

    def feed_forward(self) -> Expr:
        """The force that the profile, the hill and the resistances ask for."""
        acceleration = slope(self.speed_profile.leaf, 0, time + self.preview)
        weight = self.gravity * (self.sine_slope + self.rolling_coefficient)
        drag = 0.5 * self.air_density * self.drag_area * self.speed * self.speed
        return self.mass * (self.rotating_factor * acceleration + weight) + drag
