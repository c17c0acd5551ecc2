"""Dry friction that sticks: its modes change at located instants."""

from __future__ import annotations

from propermodel.expressions import Expr, where
from propermodel.modelling import Discrete, Parameter, Port, Resistance, Translation, parameter, quantity, when
from propermodel.modelling.events import When

STANDSTILL = quantity(1e-12, "m/s")  # above rounding, below every speed that matters
REVERSAL = quantity(1e-6, "m/s")  # a speed beyond it, after a change of sign, comes from an impact


class StickingFriction(Resistance):
    """Coulomb friction between two flanges: a constant force while they slip, whatever holds them while they stick.

    They stick when the slip has come to zero, and slip when the force that holds them exceeds `breakaway` times
    `force`. An impact makes them slip.
    """

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    force: Parameter = parameter("N", low=0.0, doc="while slipping")
    breakaway: Parameter = parameter("1", default=1.0, low=1.0, doc="of the force, to begin to slip")
    mode = Discrete("1")  # 1 and -1: slipping forward and backward, 0: sticking

    def effort(self, flow: Expr) -> Expr:
        return self.force * self.mode

    def locked(self) -> Expr:
        """While they stick."""
        return abs(self.mode) < 0.5

    def events(self) -> tuple[When, ...]:
        """They stick, turn round, or slip."""
        slip, held, most = self.port.flow, self.port.effort, self.breakaway * self.force
        sticks = abs(self.mode) < 0.5
        is_small = abs(slip) < REVERSAL
        stop = where(is_small, 0.0, -1.0)  # a restitution of -1 leaves the slip as it is
        return (
            when((self.mode > 0.5) & (slip < -STANDSTILL), {self.mode: where(is_small, 0.0, -1.0)}, restitution=stop),
            when((self.mode < -0.5) & (slip > STANDSTILL), {self.mode: where(is_small, 0.0, 1.0)}, restitution=stop),
            when(sticks & ((slip > STANDSTILL) | ((held > most) & (slip >= -STANDSTILL))), {self.mode: 1.0}),
            when(sticks & ((slip < -STANDSTILL) | ((held < -most) & (slip <= STANDSTILL))), {self.mode: -1.0}),
        )
