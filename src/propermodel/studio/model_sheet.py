"""What the studio shows of a model: its picture, elements, equations and parameters, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from propermodel.bondgraph.graph import Bond, BondGraph, Element, FlatParameter
from propermodel.catalogue.subject import Subject
from propermodel.compiler import CompiledModel, Method, compile_quietly
from propermodel.diagnostics import NO_SOURCE, Path, Source
from propermodel.drawing.depict import depict
from propermodel.equations.definitions import define
from propermodel.equations.system import BlockKind
from propermodel.expressions.core import Expr, leaves
from propermodel.expressions.printing import short_text, to_text
from propermodel.expressions.units import parse_unit
from propermodel.modelling.model import (
    ElementKind,
    PowerSource,
    Resistive,
    Storage,
    TwoPort,
    Variable,
)
from propermodel.simulation.choosing import AUTO
from propermodel.simulation.start import parameter_values
from propermodel.studio.faults import fault_data

Json = Any

_KINDS = {
    ElementKind.INERTIA: "inertias",
    ElementKind.COMPLIANCE: "compliances",
    ElementKind.RESISTANCE: "resistances",
    ElementKind.EFFORT_SOURCE: "effort sources",
    ElementKind.FLOW_SOURCE: "flow sources",
    ElementKind.TRANSFORMER: "transformers",
    ElementKind.GYRATOR: "gyrators",
}


def model_sheet(text: str, subject: Subject, scenarios: Iterable[str]) -> Json:
    """All that a page shows of a model.

    Args:
        text: What names it.
        subject: The model.
        scenarios: What its scenarios are called.

    Raises:
        ProperModelError: the model is wrong.
    """
    compiled = compile_quietly(subject.model)
    parameters = _parameters(compiled, subject)
    return {
        "id": text,
        "name": subject.name,
        "picture": depict(compiled).document(),
        "counts": [
            {"name": name, "count": len(paths), "paths": [str(path) for path in paths]}
            for name, paths in _counts(compiled)
        ],
        "elements": _Elements(compiled, parameters).sheets(),
        "parameters": parameters,
        "scenarios": list(scenarios),
        "outputs": [str(path) for path in subject.outputs],
        "panels": [
            {
                "title": panel.title,
                "signals": [{"path": s.path, "label": s.label, "dashed": s.dashed} for s in panel.series],
            }
            for panel in subject.panels
        ],
        "methods": [*(method.value for method in Method), AUTO],
        "method": str(subject.method),
        "step": subject.step,
        "warnings": [fault_data(diagnostic) for diagnostic in compiled.warnings],
    }


def _counts(compiled: CompiledModel) -> list[tuple[str, list[Path]]]:
    """What there is of everything, and where."""
    graph, system = compiled.graph, compiled.system
    found = [
        (name, [path for path, element in graph.normal.elements.items() if element.kind is kind])
        for kind, name in _KINDS.items()
    ]
    found.append(("junctions", list(graph.normal.junctions)))
    found.append(("states", [state.path.parent for state in system.states]))
    found.append(("dependent storage", list(system.causal.derivative)))
    loops = [path for block in system.blocks for path in block.paths]
    loops += [path for block in system.solved if BlockKind.LOOP in block.kinds for path in block.paths]
    found.append(("in algebraic loops", [_owner(compiled, path) for path in loops]))
    found.append(("controllers", [controller.path for controller in graph.controllers]))
    return [(name, list(dict.fromkeys(paths)) if name != "states" else paths) for name, paths in found if paths]


def _owner(compiled: CompiledModel, path: Path) -> Path:
    """The element or junction that a variable belongs to."""
    return owner_of(compiled.graph, path) or path


def owner_of(graph: BondGraph, path: Path) -> Path | None:
    """The element, junction or controller that a path lies in; None if it lies in none."""
    known = {*graph.normal.elements, *graph.normal.junctions, *(c.path for c in graph.controllers)}
    lengths = range(len(path), 0, -1)
    return next((Path(path[:length]) for length in lengths if Path(path[:length]) in known), None)


def _parameters(compiled: CompiledModel, subject: Subject) -> list[Json]:
    """Every parameter with its value in the unit of its declaration, and where that is from."""
    given = subject.scenario.parameters
    values = parameter_values(compiled, given)
    return [_parameter(path, p, values[p.symbol], path in given) for path, p in compiled.graph.parameters.items()]


def _parameter(path: Path, parameter: FlatParameter, value: float, is_given: bool) -> Json:
    used = leaves(parameter.value)
    # The provenance is that of the declared value, which a surrounding component or the scenario may replace.
    is_declared = not is_given and all(leaf.data.path.parent == path.parent for leaf in used)
    rule = "set by the scenario" if is_given else f"= {short_text(parameter.value)}" if used else ""
    return {
        "path": str(path),
        "value": f"{value / parse_unit(parameter.unit).factor:.6g}",
        "unit": parameter.unit or "1",
        "status": parameter.status if is_declared else "",
        "source": (parameter.origin if is_declared else "") or rule,
    }


class _Elements:
    """What is known of every node of the graph."""

    def __init__(self, compiled: CompiledModel, parameters: Iterable[Json]) -> None:
        self._compiled = compiled
        self._graph = compiled.graph
        self._at = compiled.graph.normal.at()
        self._values = define(compiled.system.causal).values
        self._states = {state.path: state for state in compiled.system.states}
        self._parameters: dict[Path, list[Json]] = {}
        by_path = {row["path"]: row for row in parameters}
        for path in compiled.graph.parameters:
            self._parameters.setdefault(path.parent, []).append(by_path[str(path)])

    def sheets(self) -> Mapping[str, Json]:
        """All of them, by path."""
        found = {str(e.path): self._element(e) for e in self._graph.normal.elements.values()}
        for junction in self._graph.normal.junctions.values():
            equations = [line for bond in self._at[junction.path] for line in self._given_by(bond, junction.path)]
            found[str(junction.path)] = self._sheet(junction.path, junction.kind.value, [], equations, junction.source)
        for controller in self._graph.controllers:
            rules = [f"{leaf.data.path} := {short_text(value)}" for leaf, value in controller.updates]
            laws = [f"every {short_text(controller.period)} s", *_shortened(rules, controller.path)]
            found[str(controller.path)] = self._sheet(controller.path, "controller", laws, [], controller.source)
        for leaf, value in self._graph.signals.items():
            owner = leaf.data.path.parent
            if owner and str(owner) not in found:
                lines = _shortened([f"{leaf.data.path} = {short_text(value)}"], owner)
                found[str(owner)] = self._sheet(owner, "signal", lines, [], NO_SOURCE)
        return found

    def _element(self, element: Element) -> Json:
        laws = _shortened(_laws(element), element.path)
        equations = [line for bond in self._at[element.path] for line in self._given_by(bond, element.path)]
        if isinstance(element.behaviour, Storage):
            for coordinate in element.behaviour.coordinates:
                state = self._states.get(element.path / coordinate.name)
                if state is not None:
                    equations.append(f"d/dt {state.path.name} = {self._rate(element, state.path)}")
        return self._sheet(element.path, element.kind.value, laws, _shortened(equations, element.path), element.source)

    def _rate(self, element: Element, state: Path) -> str:
        """The rate of a state: of a storage with one port its effort or flow, else the expression it comes to."""
        behaviour = element.behaviour
        if isinstance(behaviour, Storage) and len(behaviour.stored) == 1:
            ((port, stored),) = behaviour.stored
            if stored.args == ():
                variable = Variable.FLOW if behaviour.kind is ElementKind.COMPLIANCE else Variable.EFFORT
                return str(element.path / port / variable.value)
        return short_text(self._states[state].derivative)

    def _given_by(self, bond: Bond, owner: Path) -> list[str]:
        """The definitions of what an element or junction imposes on a bond."""
        receives = self._compiled.system.causal.strokes[bond.name].effort_into == owner
        gives = self._graph.variables.of(bond, Variable.FLOW if receives else Variable.EFFORT)
        value = self._values.get(gives)
        if value is None or value is gives:
            return []
        return [f"{gives.data.path} = {short_text(value)}"]

    def _sheet(self, path: Path, kind: str, laws: list[str], equations: list[str], source: Source) -> Json:
        return {
            "kind": kind,
            "laws": laws,
            "parameters": self._parameters.get(path, []),
            "equations": equations,
            "bonds": [self._bond(bond) for bond in self._at.get(path, [])],
            "place": str(source),
        }

    def _bond(self, bond: Bond) -> Json:
        domain = self._graph.domains.get(bond.domain)
        effort, flow = ("", "") if domain is None else (domain.effort_unit, domain.flow_unit)
        return {"name": str(bond.name), "effort": effort, "flow": flow}


def _laws(element: Element) -> list[str]:
    """The constitutive laws as an author wrote them, in every causality that is offered."""
    path = element.path
    match element.behaviour:
        case Resistive(laws=laws, implicit=implicit):
            return [
                *(f"{path / r.port / r.variable.value} = {short_text(r.value)}" for law in laws for r in law.results),
                *(f"0 = {short_text(expr)}" for expr in implicit),
            ]
        case Storage() as storage:
            variable = "effort" if storage.kind is ElementKind.COMPLIANCE else "flow"
            stored = "displacement" if storage.kind is ElementKind.COMPLIANCE else "momentum"
            return [
                *(f"{path / port / variable} = {short_text(value)}" for port, value in storage.outputs),
                *(
                    f"{path / port / stored} = {short_text(value)}"
                    for port, value in storage.stored
                    if value.args or value.data.path != path / stored
                ),
                f"energy = {short_text(storage.energy)}",
            ]
        case PowerSource(kind=kind, value=value):
            variable = "effort" if kind is ElementKind.EFFORT_SOURCE else "flow"
            return [f"{path / port / variable} = {short_text(value)}" for port in element.ports]
        case TwoPort() as two_port:
            a, b = (path / port for port in element.ports)
            m = _factor(two_port.modulus)
            if two_port.kind is ElementKind.TRANSFORMER:
                return [f"{a}.effort = {m}*{b}.effort", f"{b}.flow = {m}*{a}.flow"]
            return [f"{a}.effort = {m}*{b}.flow", f"{b}.effort = {m}*{a}.flow"]


def _factor(expr: Expr) -> str:
    return to_text(expr) if not expr.args else f"({short_text(expr)})"


def _shortened(lines: Iterable[str], owner: Path) -> list[str]:
    """Lines in which what belongs to an element is called by its last names."""
    return [line.replace(f"{owner}.", "") if owner else line for line in lines]
