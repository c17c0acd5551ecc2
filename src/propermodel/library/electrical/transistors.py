"""Transistors in large signals, without their capacitances."""

from __future__ import annotations

from typing import ClassVar

from propermodel.expressions import Expr, ExprLike, maximum, minimum, where
from propermodel.library.electrical.components import exponential
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


class _BipolarTransistor(MultiportResistance):
    """The transport form of the model of Ebers and Moll (1954), as in Massobrio and Antognetti (1993), section 2.2."""

    polarity: ClassVar[float]  # 1 for n-p-n, -1 for p-n-p

    base = Port(Electrical)
    collector = Port(Electrical)
    emitter = Port(Electrical)
    emitter_junction = Port(Electrical, between=(base, emitter))
    collector_junction = Port(Electrical, between=(base, collector))
    saturation_current: Parameter = parameter("A", default=1e-14, low=0.0)
    forward_gain: Parameter = parameter("1", default=100.0, low=0.0)
    reverse_gain: Parameter = parameter("1", default=1.0, low=0.0)
    thermal_voltage: Parameter = parameter("V", default=0.02585, low=0.0)
    leakage: Parameter = parameter("1/Ohm", default=1e-12, low=0.0, doc="of each junction")
    knee: Parameter = parameter("V", default=0.8)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        emitter, collector = self._currents()
        return ({self.emitter_junction.flow: emitter, self.collector_junction.flow: collector},)

    def residuals(self) -> tuple[ExprLike, ...]:
        """The same currents, whatever is given."""
        emitter, collector = self._currents()
        return (self.emitter_junction.flow - emitter, self.collector_junction.flow - collector)

    def _currents(self) -> tuple[Expr, Expr]:
        """From the base through each junction."""
        forward, reverse = (
            self._diffusion(self.emitter_junction.effort),
            self._diffusion(self.collector_junction.effort),
        )
        transported = forward - reverse
        return (
            transported + forward / self.forward_gain + self.leakage * self.emitter_junction.effort,
            reverse / self.reverse_gain - transported + self.leakage * self.collector_junction.effort,
        )

    def _diffusion(self, voltage: Expr) -> Expr:
        growth = exponential(self.polarity * voltage, self.thermal_voltage, self.knee) - 1.0
        return self.polarity * self.saturation_current * growth


class NPNTransistor(_BipolarTransistor):
    """An n-p-n transistor by Ebers and Moll, without its capacitances.

    With i_f = I_s (exp(v_be / V_t) - 1), and i_r alike of v_bc, the collector takes i_f - i_r - i_r / beta_r and the
    base i_f / beta_f + i_r / beta_r. Above `knee` the exponentials go on as their tangents.
    """

    polarity = 1.0


class PNPTransistor(_BipolarTransistor):
    """A p-n-p transistor by Ebers and Moll: an n-p-n one with all voltages and currents reversed."""

    polarity = -1.0
