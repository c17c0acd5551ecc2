"""Expressions of a definition, seen from the root: relative paths become absolute."""

from __future__ import annotations

from dataclasses import replace

from propermodel.bondgraph.graph import ElementBehaviour, FlatEvent, SampledController
from propermodel.diagnostics import Path, Source
from propermodel.expressions.core import Expr, Op, Substitution, SymbolKind, leaves, symbol
from propermodel.modelling.model import (
    Behaviour,
    Coordinate,
    Definition,
    Event,
    PowerSource,
    ResistanceLaw,
    Resistive,
    Sampled,
    Storage,
    TwoPort,
)


class Scope:
    """Rewrites the expressions of one part."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._absolute: dict[Expr, Expr] = {}

    def __call__(self, expr: Expr) -> Expr:
        """The expression in absolute symbols."""
        if not expr.args:
            return expr if expr.op is Op.CONSTANT else self.absolute(expr)
        return Substitution({leaf: self.absolute(leaf) for leaf in leaves(expr)})(expr)

    def absolute(self, leaf: Expr) -> Expr:
        """A symbol of the definition as seen from the root."""
        known = self._absolute.get(leaf)
        if known is None:
            data = leaf.data
            is_time = data.kind is SymbolKind.TIME
            known = leaf if is_time else symbol(data.kind, self.path + data.path, data.unit)
            self._absolute[leaf] = known
        return known

    def own(self, kind: SymbolKind, name: str, definition: Definition) -> Expr | None:
        """The symbol of an output of this part, None if it has no such output."""
        unit = next((s.unit for s in definition.signals if s.name == name), None)
        return None if unit is None else symbol(kind, self.path / name, unit)

    def coordinate(self, coordinate: Coordinate) -> Coordinate:
        """A state with absolute expressions."""
        return replace(coordinate, start=self(coordinate.start), low=self(coordinate.low), high=self(coordinate.high))

    def behaviour(self, behaviour: Behaviour) -> ElementBehaviour:
        """The laws of an element in absolute symbols."""
        match behaviour:
            case Resistive():
                laws = tuple(
                    ResistanceLaw(results=tuple(replace(r, value=self(r.value)) for r in law.results))
                    for law in behaviour.laws
                )
                return Resistive(
                    laws=laws,
                    locked=None if behaviour.locked is None else self(behaviour.locked),
                    implicit=tuple(self(residual) for residual in behaviour.implicit),
                    converts=behaviour.converts,
                    preference=behaviour.preference,
                )
            case Storage():
                return replace(
                    behaviour,
                    coordinates=tuple(self.coordinate(c) for c in behaviour.coordinates),
                    stored=tuple((n, self(e)) for n, e in behaviour.stored),
                    outputs=tuple((n, self(e)) for n, e in behaviour.outputs),
                    energy=self(behaviour.energy),
                    inverse=None if behaviour.inverse is None else self(behaviour.inverse),
                )
            case PowerSource():
                return replace(behaviour, value=self(behaviour.value))
            case TwoPort():
                position = None if behaviour.position is None else self(behaviour.position)
                return replace(behaviour, modulus=self(behaviour.modulus), position=position)
            case _:
                raise TypeError(f"{behaviour!r} is not an element")

    def event(self, event: Event) -> FlatEvent:
        """An event in absolute symbols."""
        return FlatEvent(
            element=self.path,
            condition=self(event.condition),
            changes=tuple((self.absolute(target), self(value)) for target, value in event.changes),
            restitution=None if event.restitution is None else self(event.restitution),
            source=event.source,
        )

    def controller(self, sampled: Sampled, source: Source) -> SampledController:
        """A controller in absolute symbols; its outputs are held values."""
        held = {name: symbol(SymbolKind.DISCRETE, self.path / name, unit) for name, unit, _ in sampled.starts}
        return SampledController(
            path=self.path,
            period=self(sampled.period),
            starts=tuple((held[name], self(start)) for name, _, start in sampled.starts),
            updates=tuple((held[name], self(value)) for name, value in sampled.updates),
            source=source,
        )
