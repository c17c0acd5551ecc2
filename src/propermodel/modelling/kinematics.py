"""A mechanism as one transformer: its geometry is given, its slopes are derived.

The displacements of some ports (the outputs) are functions of the displacements of the others (the inputs). With
x = x(q), the flows are dx/dt = J dq/dt and the efforts e_q = J^T e_x, J = dx/dq: power is conserved whatever the
geometry. It expands into what a textbook draws (Karnopp, Margolis and Rosenberg, System Dynamics, ch. 9): one
modulated transformer for each input and output that depends on it, a 1-junction at each input, a 0-junction at each
output, and one integrator for each input, which holds its displacement.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from propermodel.diagnostics import Diagnostic, Path, Source
from propermodel.expressions.core import ZERO, Expr, Substitution, SymbolKind, constant, leaves, symbol
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.expressions.units import parse_unit
from propermodel.modelling.components import Component
from propermodel.modelling.model import (
    Block,
    Coordinate,
    Definition,
    Direction,
    ElementKind,
    HalfArrow,
    JunctionKind,
    Node,
    ParameterData,
    Part,
    PortData,
    SignalData,
    SignalLink,
    TwoPort,
)
from propermodel.modelling.ports import Port
from propermodel.modelling.tracing import Tracer

# The part that integrates the flows of the inputs; its outputs are all displacements, by the name of the port.
MOTION = "displacement"


class KinematicTransformer(Component):
    """A mechanism without mass: `positions()` gives the displacement of each output in those of the inputs.

    Power enters at the inputs and leaves at the outputs. `starts()` may give the displacements of inputs at the start;
    the others start at zero. `known()` names inputs whose displacement a signal gives; the others are integrated. The
    displacements are the signals `displacement.<port>`; an output that is held stays
    at displacement zero, so write a closed loop such that it closes where its positions vanish.
    """

    def positions(self) -> Mapping[Expr, Expr]:
        """The displacement of every output, `{self.piston.displacement: ...}`, in those of the inputs."""
        raise TypeError(f"{type(self).__name__} must define positions()")

    def starts(self) -> Mapping[Expr, Expr]:
        """The displacement of inputs at the start, `{self.crank.displacement: ...}`."""
        return {}

    def known(self) -> Mapping[Expr, Expr]:
        """The displacement of inputs that signals give, `{self.x.displacement: self.position}`."""
        return {}


@dataclass(frozen=True)
class Expansion:
    """The inside of a mechanism: parts and wiring."""

    parts: tuple[Part, ...] = ()
    connections: tuple[Node | HalfArrow | SignalLink, ...] = ()


def expand(tracer: Tracer, parameters: tuple[ParameterData, ...]) -> Expansion:
    """The elements that a `KinematicTransformer` stands for."""
    geometry = _Geometry(tracer)
    tracer.faults.raise_if_any()
    return _Expanding(tracer, geometry, parameters).run()


class _Geometry:
    """The positions of a mechanism in the displacements of its inputs, and their slopes."""

    def __init__(self, tracer: Tracer) -> None:
        self.ports = tracer.ports
        given = _by_port(tracer, "positions")
        self.outputs = tuple(name for name in tracer.ports if name in given)
        self.inputs = tuple(name for name in tracer.ports if name not in given)
        self.known = _by_port(tracer, "known")
        own = {name: _displacement(name, port) for name, port in tracer.ports.items()}
        self.at_state = Substitution({own[n]: self.coordinate(n) for n in self.inputs})
        self.positions = {name: given[name] for name in self.outputs}
        self.starts = _by_port(tracer, "starts")
        symbols = [own[name] for name in self.inputs]
        slopes = partial_derivatives([self.positions[name] for name in self.outputs], symbols)
        self.slopes = {
            (i, o): slope[own[i]]
            for o, slope in zip(self.outputs, slopes, strict=True)
            for i in self.inputs
            if own[i] in slope
        }
        self._check(tracer, own)

    @property
    def integrated(self) -> tuple[str, ...]:
        """The inputs whose displacement no signal gives."""
        return tuple(name for name in self.inputs if name not in self.known)

    def coordinate(self, name: str) -> Expr:
        """The displacement of an input, as the integrator knows it: a state of it, or a signal that it reads."""
        port = self.ports[name]
        if name in self.known:
            return symbol(SymbolKind.SIGNAL, Path((known_name(name),)), port.domain.displacement_unit)
        return _state(name, port)

    def _check(self, tracer: Tracer, own: Mapping[str, Expr]) -> None:
        """Report outputs in terms of outputs, and what does not depend on any input."""
        by_symbol = {leaf: name for name, leaf in own.items()}
        for name in self.outputs:
            uses = [by_symbol[leaf] for leaf in leaves(self.positions[name]) if leaf in by_symbol]
            circular = [other for other in uses if other in self.outputs]
            if circular or not any((i, name) in self.slopes for i in self.inputs):
                reason = f"mentions the output '{circular[0]}'" if circular else "depends on no input"
                tracer.faults.add(
                    Diagnostic(
                        "model/positions",
                        f"the position of '{name}' of {tracer.cls.__name__} {reason}",
                        source=tracer.place("positions"),
                        help="give every output in the displacements of the others: {self.piston.displacement: ...}",
                    )
                )
        idle = [i for i in self.inputs if not any((i, o) in self.slopes for o in self.outputs)]
        wrong = [name for name in (*self.starts, *self.known) if name not in self.inputs]
        wrong += [name for name in self.starts if name in self.known]
        if not tracer.faults.found and (idle or wrong or not self.outputs):
            reason = (
                f"the input '{idle[0]}' moves no output"
                if idle
                else f"'{wrong[0]}' has a start or a known displacement although positions() or known() gives it"
                if wrong
                else "it has no outputs"
            )
            tracer.faults.add(
                Diagnostic(
                    "model/positions",
                    f"the geometry of {tracer.cls.__name__} is incomplete: {reason}",
                    source=tracer.place("positions"),
                    help="positions() gives the outputs; of an input either starts() or known() gives the displacement",
                )
            )


def _by_port(tracer: Tracer, method: str) -> dict[str, Expr]:
    """What a method of a mechanism gives, by port; anything but displacements of its own ports is reported."""
    result: dict[str, Expr] = {}
    for path, expr in tracer.mapping(method).items():
        if len(path) == 2 and path.name == "displacement" and path[0] in tracer.ports:
            result[path[0]] = expr
        else:
            tracer.faults.add(
                Diagnostic(
                    "model/positions",
                    f"{tracer.cls.__name__}.{method} defines '{path}', which is no displacement of its ports",
                    source=tracer.place(method),
                    help="the keys are displacements of ports: {self.piston.displacement: ...}",
                )
            )
    return result


def _displacement(name: str, port: Port[Any]) -> Expr:
    return symbol(SymbolKind.DISPLACEMENT, Path((name, "displacement")), port.domain.displacement_unit)


def _state(name: str, port: Port[Any]) -> Expr:
    return symbol(SymbolKind.STATE, Path((name,)), port.domain.displacement_unit)


class _Expanding:
    """Builds the parts and the wiring of one mechanism."""

    def __init__(self, tracer: Tracer, geometry: _Geometry, parameters: tuple[ParameterData, ...]) -> None:
        self.source: Source = tracer.cls.defined_at
        self.ports = tracer.ports
        self.geometry = geometry
        self.parameters = parameters
        self.parts: list[Part] = []
        self.connections: list[Node | HalfArrow | SignalLink] = []

    def run(self) -> Expansion:
        """The whole expansion."""
        geometry = self.geometry
        self.motion()
        for name in geometry.inputs:
            self.junction(f"with_{name}", JunctionKind.ONE)
            self.arrow(Path((name,)), Path((f"with_{name}",)))
        for name in geometry.outputs:
            self.junction(f"at_{name}", JunctionKind.ZERO)
        for (i, o), slope in geometry.slopes.items():
            self.transformer(i, o, slope)
        for name in geometry.outputs:
            self.arrow(Path((f"at_{name}",)), Path((name,)))
        return Expansion(tuple(self.parts), tuple(self.connections))

    def unit(self, name: str) -> str:
        """The unit of a port's displacement."""
        return self.ports[name].domain.displacement_unit

    def arrow(self, tail: Path, head: Path) -> None:
        """A bond."""
        self.connections.append(HalfArrow(tail=tail, head=head, source=self.source))

    def junction(self, name: str, kind: JunctionKind) -> None:
        """A junction of its own."""
        title = "ZeroJunction" if kind is JunctionKind.ZERO else "OneJunction"
        definition = Definition(type_name=title, doc="", behaviour=kind, source=self.source)
        self.parts.append(Part(name=name, definition=definition))

    def motion(self) -> None:
        """The integrator of the inputs, which also gives the positions of the outputs and the slopes."""
        geometry = self.geometry
        integrated = geometry.integrated
        outputs = [(n, geometry.coordinate(n), self.unit(n)) for n in geometry.inputs]
        outputs += [(n, geometry.at_state(geometry.positions[n]), self.unit(n)) for n in geometry.outputs]
        outputs += [
            (slope_name(i, o), geometry.at_state(slope), _quotient(self.unit(o), self.unit(i)))
            for (i, o), slope in geometry.slopes.items()
        ]
        flows = [(f"{n}_flow", self.ports[n].domain.flow_unit) for n in integrated]
        infinity = constant(float("inf"))
        coordinates = tuple(
            Coordinate(name=n, unit=self.unit(n), start=geometry.starts.get(n, ZERO), low=-infinity, high=infinity)
            for n in integrated
        )
        signals = [SignalData(name=n, unit=u, direction=Direction.OUTPUT) for n, _, u in outputs]
        signals += [SignalData(name=n, unit=u, direction=Direction.INPUT) for n, u in flows]
        signals += [
            SignalData(name=known_name(n), unit=self.unit(n), direction=Direction.INPUT) for n in geometry.known
        ]
        definition = Definition(
            type_name="Displacements",
            doc="The displacements of the inputs, and what follows from them.",
            parameters=self.parameters,
            signals=tuple(signals),
            behaviour=Block(
                outputs=tuple((n, e) for n, e, _ in outputs),
                states=coordinates,
                derivatives=tuple(
                    (n, symbol(SymbolKind.SIGNAL, Path((flow,)), unit))
                    for n, (flow, unit) in zip(integrated, flows, strict=True)
                ),
            ),
            source=self.source,
        )
        values = tuple(
            (data.name, symbol(SymbolKind.PARAMETER, Path((data.name,)), data.unit)) for data in self.parameters
        )
        self.parts.append(Part(name=MOTION, definition=definition, values=values))
        for name, value in geometry.known.items():
            self.link(value, Path((MOTION, known_name(name))))
        for name, (flow, unit) in zip(integrated, flows, strict=True):
            value = symbol(SymbolKind.FLOW, Path((name, "flow")), unit)
            self.link(value, Path((MOTION, flow)))

    def link(self, value: Expr, target: Path) -> None:
        """A signal."""
        self.connections.append(SignalLink(value=value, targets=(target,), source=self.source))

    def transformer(self, i: str, o: str, slope: Expr) -> None:
        """What an input contributes to an output."""
        name = f"{i}_to_{o}"
        unit, per = self.unit(o), _quotient(self.unit(o), self.unit(i))
        definition = Definition(
            type_name="Transformer",
            doc="The share of one input in one output.",
            ports=(
                PortData(name="a", domain=self.ports[i].domain.name),
                PortData(name="b", domain=self.ports[o].domain.name),
            ),
            signals=(
                SignalData(name="slope", unit=per, direction=Direction.INPUT),
                SignalData(name="position", unit=unit, direction=Direction.INPUT),
            ),
            behaviour=TwoPort(
                kind=ElementKind.TRANSFORMER,
                modulus=symbol(SymbolKind.SIGNAL, Path(("slope",)), per),
                position=symbol(SymbolKind.SIGNAL, Path(("position",)), unit),
            ),
            source=self.source,
        )
        self.parts.append(Part(name=name, definition=definition))
        self.link(symbol(SymbolKind.SIGNAL, Path((MOTION, slope_name(i, o))), per), Path((name, "slope")))
        self.link(symbol(SymbolKind.SIGNAL, Path((MOTION, o)), unit), Path((name, "position")))
        self.arrow(Path((f"with_{i}",)), Path((name, "a")))
        self.arrow(Path((name, "b")), Path((f"at_{o}",)))


def known_name(name: str) -> str:
    """The signal that gives the displacement of an input from outside."""
    return f"{name}_known"


def slope_name(i: str, o: str) -> str:
    """The signal that holds the derivative of an output's displacement with respect to an input's."""
    return f"{o}_per_{i}"


def _quotient(above: str, below: str) -> str:
    """The unit of a ratio of displacements, written out where the units differ."""
    if parse_unit(above).dimension == parse_unit(below).dimension:
        return "1"
    return f"{above}/{below}" if below.isalnum() else f"{above}/({below})"


__all__ = ["MOTION", "Expansion", "KinematicTransformer", "expand", "known_name", "slope_name"]
