"""Road: hills, rolling resistance and roughness as functions of place, exchanged by a mission."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, sqrt
from propermodel.modelling import Input, Output, Parameter, SignalBlock, parameter, table


class Road(SignalBlock):
    """What the vehicle meets at its place x, that of the centre of gravity; flat and smooth unless a mission says so.

    Roughness is the slope dz/dx of the short waves under each axle, on an equidistant grid; hills are the grade of the
    long ones.
    """

    position = Input("m")
    sine_slope = Output("1")
    rolling_coefficient = Output("1")
    front_slope = Output("1")
    rear_front_slope = Output("1")
    rear_rear_slope = Output("1")
    front_ahead: Parameter = parameter("m", doc="distance of the axle ahead of the centre of gravity")
    rear_front_ahead: Parameter = parameter("m", doc="distance of the axle ahead of the centre of gravity")
    rear_rear_ahead: Parameter = parameter("m", doc="distance of the axle ahead of the centre of gravity")
    grade = table("1", ("m",), [(-1e3, 0.0, 1e6)], (0.0, 0.0, 0.0), source="flat")
    rolling_resistance = table(
        "1", ("m",), [(-1e3, 0.0, 1e6)], (0.012, 0.012, 0.012), source="paved, between ADVISOR and Chrono; estimated"
    )
    roughness = table("1", ("m",), [(-1e3, 1e6)], (0.0, 0.0), source="smooth")

    def outputs(self) -> dict[Expr, ExprLike]:
        grade = self.grade(self.position)
        return {
            self.sine_slope: grade / sqrt(1.0 + grade * grade),
            self.rolling_coefficient: self.rolling_resistance(self.position),
            self.front_slope: self.roughness(self.position + self.front_ahead),
            self.rear_front_slope: self.roughness(self.position + self.rear_front_ahead),
            self.rear_rear_slope: self.roughness(self.position + self.rear_rear_ahead),
        }
