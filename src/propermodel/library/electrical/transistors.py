"""Transistors in large signals, without their capacitances."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, maximum, minimum, where
from propermodel.modelling import Electrical, MultiportResistance, Parameter, Port, parameter


class FieldEffectTransistor(MultiportResistance):
    """An n-channel MOSFET by Shichman and Hodges (1968); its gate takes no current.

    With v = v_gs - V_th > 0 the drain takes K (v - v_ds / 2) v_ds (1 + lambda v_ds) up to v_ds = v, then
    K v^2 / 2 (1 + lambda v_ds). Source and drain change places when v_ds is negative.
    """

    gate = Port(Electrical)
    drain = Port(Electrical)
    source = Port(Electrical)
    control = Port(Electrical, between=(gate, source))
    channel = Port(Electrical, between=(drain, source))
    threshold: Parameter = parameter("V", default=1.0)
    transconductance: Parameter = parameter("A/V2", default=0.1, low=0.0)
    modulation: Parameter = parameter("1/V", default=0.0, low=0.0, doc="of the channel's length")

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        return ({self.control.flow: 0.0, self.channel.flow: self._current()},)

    def residuals(self) -> tuple[ExprLike, ...]:
        """The same current, whatever is given: a current may feed the drain."""
        return (self.control.flow, self.channel.flow - self._current())

    def _current(self) -> Expr:
        across = abs(self.channel.effort)
        is_forward = self.channel.effort >= 0.0
        seen = self.control.effort - where(is_forward, 0.0, self.channel.effort)
        overdrive = maximum(seen - self.threshold, 0.0)
        within = minimum(across, overdrive)
        current = self.transconductance * (overdrive - 0.5 * within) * within * (1.0 + self.modulation * across)
        return where(is_forward, current, -current)
