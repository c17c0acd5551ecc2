"""The energetic primitives that authors subclass. The laws offered are the causalities offered."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, TypeVar

from propermodel.expressions.core import Expr, ExprLike
from propermodel.modelling.components import Component
from propermodel.modelling.domains import Domain
from propermodel.modelling.model import Preference
from propermodel.modelling.ports import Port
from propermodel.modelling.signals import State

D = TypeVar("D", bound=Domain)

PortValues = Mapping[Port[D], ExprLike]


class Resistance(Component):
    """A one-port R: `effort(flow)`, `flow(effort)`, or both; a linear law is inverted for the author.

    `residual(effort, flow)` gives an implicit law, 0 = g(effort, flow), for the causalities without a law.
    `locked()` may give a condition under which the flow is held at its value near zero (a clutch that has
    closed). An element that gives its flow, because a compliance or source sets its effort, stands still at once.
    `preference` says which of effort and flow it gives where the model leaves a choice.
    """

    preference: ClassVar[Preference | None] = None


class MultiportResistance(Component):
    """A multiport R: `laws()` gives one mapping for each causality.

    Each mapping gives one variable of every port, `{self.shaft.effort: ..., self.oil.flow: ...}`, in terms of
    the other variables (`self.shaft.flow`, `self.oil.effort`). `residuals()` gives an implicit law, one expression
    of efforts and flows per port that vanishes, for the causalities without a law. With `converts = True` it may join
    true bonds with pseudo ones, as an electric heater does with a graph of temperatures and heat flows.
    """

    converts: ClassVar[bool] = False

    def laws(self) -> tuple[Mapping[Expr, ExprLike], ...]:
        """One mapping for each causality offered."""
        return ()

    def residuals(self) -> tuple[ExprLike, ...]:
        """One expression per port that vanishes."""
        return ()


class Compliance(Component):
    """A one-port C: `effort(displacement)`, `displacement(effort)` or both; `energy(...)` unless linear.

    `start()` gives the displacement at the start, also in inputs, `limits()` the range it is meant for. With the
    `preference` `DERIVATIVE` it is dependent storage where others can decide it, with `INTEGRAL` others are.
    """

    preference: ClassVar[Preference | None] = None


class Inertia(Component):
    """A one-port I: `flow(momentum)`, `momentum(flow)` or both; `energy(momentum)` unless linear.

    `start()` gives the momentum at the start, `limits()` the range it is meant for. With the `preference`
    `DERIVATIVE` it is dependent storage where others can decide it, with `INTEGRAL` others are.
    """

    preference: ClassVar[Preference | None] = None


class MultiportCompliance(Component):
    """A multiport C in coordinates of the author's choice, declared as `State`s.

    `displacements()` and `efforts()` give one expression per port in the coordinates; `energy()` the stored
    energy. Where only `energy()` is given, coordinates are what the ports store, in order, and the efforts are its
    gradient. `limits()` gives the range of coordinates, `{self.volume: (low, high)}`. A port whose effort is decided
    elsewhere (derivative causality) decides a coordinate instead.
    """

    preference: ClassVar[Preference | None] = None


class MultiportInertia(Component):
    """A multiport I in coordinates of the author's choice: `momenta()`, `flows()`, `energy()`, `limits()`."""

    preference: ClassVar[Preference | None] = None


class EffortSource(Component):
    """An effort source; `effort()` gives its value."""


class FlowSource(Component):
    """A flow source; `flow()` gives its value."""


class Transformer(Component):
    """A two-port with e_a = m e_b, f_b = m f_a; `modulus()` gives m. Power enters at `a`, leaves at `b`."""


class Gyrator(Component):
    """A two-port with e_a = r f_b, e_b = r f_a; `modulus()` gives r. Power enters at `a`, leaves at `b`."""


class Junction(Component):
    """A junction written out; `port` is where bonds end."""


class ZeroJunction(Junction):
    """A 0-junction: one effort, flows sum to zero. Connect it with `bond`."""


class OneJunction(Junction):
    """A 1-junction: one flow, efforts sum to zero. Connect it with `bond`."""


ELEMENTS = (
    Resistance,
    MultiportResistance,
    Compliance,
    Inertia,
    MultiportCompliance,
    MultiportInertia,
    EffortSource,
    FlowSource,
    Transformer,
    Gyrator,
)

__all__ = [
    "ELEMENTS",
    "Compliance",
    "EffortSource",
    "FlowSource",
    "Gyrator",
    "Inertia",
    "Junction",
    "MultiportCompliance",
    "MultiportInertia",
    "MultiportResistance",
    "OneJunction",
    "Preference",
    "Resistance",
    "State",
    "Transformer",
    "ZeroJunction",
]
