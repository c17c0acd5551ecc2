"""Signal ports, signal blocks and sampled controllers."""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.diagnostics import Source
from propermodel.expressions.core import ZERO, Expr, ExprLike, SymbolKind
from propermodel.modelling.components import Component, Parameter, in_unit, parameter
from propermodel.modelling.ports import Member, VectorPort
from propermodel.modelling.references import Declared


class SignalPort(Declared):
    """A value without power."""

    __slots__ = ("start",)

    def __init__(self, unit: str, kind: SymbolKind = SymbolKind.SIGNAL, start: ExprLike = 0.0) -> None:
        super().__init__(kind, unit)
        object.__setattr__(self, "start", in_unit(start, unit))

    def __get__(self, instance: Component | VectorPort | None, owner: type | None = None) -> Expr:
        if instance is None:
            return self
        if isinstance(instance, VectorPort):
            return instance.own(self)
        return self.view(instance, instance.name_of(self))


class Output(SignalPort):
    """A signal that a component gives; a controller holds it between samples, at first at `start`."""

    __slots__ = ()


class Input(SignalPort, Member):
    """A signal that a component reads."""

    __slots__ = ()

    def twin(self, *, gives: bool, source: Source) -> SignalPort:
        """A signal that a vector port takes, or gives."""
        return Output(self.unit) if gives else Input(self.unit)


class Discrete(SignalPort):
    """A value that is held: a controller changes it once a period, an element or signal block by its events."""

    __slots__ = ()

    def __init__(self, unit: str, start: ExprLike = 0.0) -> None:
        super().__init__(unit, SymbolKind.DISCRETE, start)


class State(SignalPort):
    """A continuous state of a signal block."""

    __slots__ = ()

    def __init__(self, unit: str, start: ExprLike = 0.0) -> None:
        super().__init__(unit, SymbolKind.STATE, start)


Updates = Mapping[Expr, ExprLike]


class SignalBlock(Component):
    """Continuous signal processing: outputs as expressions of inputs, states and time."""

    def outputs(self) -> Updates:
        """The value of every output."""
        raise TypeError(f"{type(self).__name__} must define outputs()")

    def derivatives(self) -> Updates:
        """The derivative of every continuous state."""
        return {}


class Controller(Component):
    """A sampled controller: `step` gives the new discrete states and outputs, all changed at once."""

    period: Parameter = parameter("s", default=0.01, low=0.0)

    def step(self) -> Updates:
        """The new value of every output and every discrete state that changes."""
        raise TypeError(f"{type(self).__name__} must define step()")


__all__ = ["ZERO", "Controller", "Discrete", "Input", "Output", "SignalBlock", "State", "Updates"]
