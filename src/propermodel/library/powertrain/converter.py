"""A hydrodynamic torque converter with lock-up clutch, and the charging pump of the transmission."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, maximum, tanh
from propermodel.modelling import (
    Component,
    Input,
    MultiportResistance,
    Output,
    Parameter,
    Port,
    Resistance,
    Rotation,
    SignalBlock,
    connect,
    parameter,
    quantity,
    table,
)

CURVE_SOURCE = "NREL ADVISOR TX_ZF5HP590AT (TC-419) scaled to the TC-418's stall ratio 1.98; closed at r = 1"
SPEED_RATIOS = (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0, 1.11, 1.25, 1.67, 2.0)
# Capacity in 1e-3 N m s2/rad2.
CAPACITY = (
    *(30.141, 29.221, 28.152, 27.052, 25.356, 23.452, 21.188, 18.714, 16.145, 14.139, 12.183, 6.830, 0.0),
    *(-8.734, -17.313, -43.403, -69.252),
)
TORQUE_RATIO = (1.98, 1.84, 1.73, 1.63, 1.52, 1.41, 1.30, 1.20, 1.09, 1.03, 0.985, 0.985, 1, 1, 1, 1, 1)


class ConverterCurves(SignalBlock):
    """Capacity c and torque ratio t of a converter at the present speed ratio r."""

    impeller_speed = Input("rad/s")
    turbine_speed = Input("rad/s")
    capacity = Output("N.m.s2/rad2")
    torque_ratio = Output("1")
    capacity_curve = table("N.m.s2/rad2", ("1",), [SPEED_RATIOS], [1e-3 * c for c in CAPACITY], source=CURVE_SOURCE)
    torque_ratio_curve = table("1", ("1",), [SPEED_RATIOS], TORQUE_RATIO, source=CURVE_SOURCE)

    def outputs(self) -> dict[Expr, ExprLike]:
        ratio = clip(self.turbine_speed / maximum(self.impeller_speed, quantity(1.0, "rad/s")), 0.0, 2.5)
        return {self.capacity: self.capacity_curve(ratio), self.torque_ratio: self.torque_ratio_curve(ratio)}


class FluidCoupling(MultiportResistance):
    """Both torques from both speeds: T_p = k c(r) omega_p^2, T_t = t(r) T_p; k fades to 0 in neutral."""

    impeller = Port(Rotation)
    turbine = Port(Rotation)
    capacity = Input("N.m.s2/rad2")
    torque_ratio = Input("1")
    engagement = Input("1")

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        speed = maximum(self.impeller.flow, quantity(1.0, "rad/s"))
        torque = self.engagement * self.capacity * speed * speed
        return ({self.impeller.effort: torque, self.turbine.effort: -self.torque_ratio * torque},)


class LockUpClutch(Resistance):
    """A clutch that slips with a torque up to its capacity, and does not slip once it has closed."""

    a = Port(Rotation)
    b = Port(Rotation)
    port = Port(Rotation, between=(a, b))
    capacity = Input("N.m")
    closed = Input("1")
    width: Parameter = parameter("rad/s", default=2.0, low=0.0, status="estimated", doc="of the sign of slip")

    def effort(self, flow: Expr) -> Expr:
        return self.capacity * tanh(flow / self.width)

    def locked(self) -> Expr:
        """The condition in which there is no slip."""
        return self.closed > 0.5


class TorqueConverter(Component):
    """Converter and clutch in parallel: one energy element."""

    energy_group = True

    impeller = Port(Rotation)
    turbine = Port(Rotation)
    engagement = Input("1")
    clutch_capacity = Input("N.m")
    clutch_closed = Input("1")
    torque_ratio = Output("1")

    curves = ConverterCurves()
    fluid = FluidCoupling()
    clutch = LockUpClutch()

    connections = (
        connect(impeller, fluid.impeller, clutch.a),
        connect(turbine, fluid.turbine, clutch.b),
        connect(fluid.impeller.flow, curves.impeller_speed),
        connect(fluid.turbine.flow, curves.turbine_speed),
        connect(curves.capacity, fluid.capacity),
        connect(curves.torque_ratio, fluid.torque_ratio, torque_ratio),
        connect(engagement, fluid.engagement),
        connect(clutch_capacity, clutch.capacity),
        connect(clutch_closed, clutch.closed),
    )


class ChargingPump(Resistance):
    """The pump that feeds converter and clutches: a constant torque, smoothed through standstill."""

    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m", default=15.0, low=0.0, status="estimated")
    width: Parameter = parameter("rad/s", default=1.0, low=0.0, status="estimated", doc="of the sign of speed")

    def effort(self, flow: Expr) -> Expr:
        return self.torque * tanh(flow / self.width)
