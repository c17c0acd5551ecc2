"""Variables of elements that a model does without: what of them follows from the rest, and why the others do not.

Efforts and flows follow from junctions and two-ports (`equations.definitions`), and what storage holds from them by its
law: a mass that is left out still has a velocity, and m v. A compliance whose effort is prescribed has no law any more;
its displacement is the integral of its flow. What follows from nothing is refused with the removal that is to blame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.bondgraph.graph import Element
from propermodel.bondgraph.parameters import parameter_values
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Path, SimulationError, one_of
from propermodel.expressions.core import Expr, SymbolKind, substitute, symbol
from propermodel.expressions.interpret import interpret
from propermodel.modelling.model import ConstantEffort, ElementKind, Freeze, Scenario, Storage, Variable
from propermodel.modelling.removal_words import removal_text


@dataclass(frozen=True, slots=True)
class Integral:
    """A stored quantity that is the integral of an observable from its value at the start."""

    rate: Path
    start: Expr

    def values(self, time: FloatArray, rate: FloatArray, begin: float) -> FloatArray:
        """The quantity at the instants of the rate, which is linear in between."""
        steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(time)
        return begin + np.concatenate([[0.0], np.cumsum(steps)])


def integral_of(compiled: CompiledModel, path: Path) -> Integral | None:
    """How a stored quantity of a removed element follows as an integral; None for everything else.

    Raises:
        SimulationError: it belongs to a removed element and follows from nothing.
    """
    owner = removed_element(compiled, path)
    if owner is None:
        return None
    behaviour = owner.behaviour
    if not isinstance(behaviour, Storage):
        return None
    stored = _stored_at(owner, behaviour, path)
    if stored is None:
        return None
    port, start = stored
    effort, flow = (owner.path / port / variable.value for variable in Variable)
    is_compliance = behaviour.kind is ElementKind.COMPLIANCE
    output, rate = (effort, flow) if is_compliance else (flow, effort)
    known = compiled.lowered.observables
    if _has_law(compiled, behaviour, owner.path / port) and output in known:
        return None  # its law gives it
    if rate in known:
        return Integral(rate, start)
    raise SimulationError([_refusal(compiled, path, owner, f"neither its {output.name} nor its {rate.name} follows")])


def start_of(compiled: CompiledModel, scenario: Scenario, path: Path, integral: Integral) -> float:
    """The value at the start: what the scenario gives, else what the model says."""
    if path in scenario.initial:
        return scenario.initial[path]
    values = parameter_values(compiled.graph.parameters, scenario.parameters)
    return float(interpret(integral.start, values))


def refusal_of(compiled: CompiledModel, path: Path) -> Diagnostic | None:
    """Why an observable of a removed element does not exist; None if it belongs to none."""
    owner = removed_element(compiled, path)
    if owner is None:
        return None
    if path.name == "energy" and isinstance(owner.behaviour, Storage):
        return _refusal(compiled, path, owner, "it stores nothing any more")
    return _refusal(compiled, path, owner, "no junction or law that is left gives it")


def unknown_observable(compiled: CompiledModel, path: Path) -> Diagnostic:
    """The fault of an observable that the model does not have."""
    return refusal_of(compiled, path) or Diagnostic(
        "simulation/unknown-observable",
        f"the model has no observable '{path}'",
        help=one_of(str(path), map(str, compiled.lowered.observables)),
    )


def entries_for(compiled: CompiledModel, path: Path) -> tuple[Path, ...]:
    """The observables that must be recorded for one to be known.

    Raises:
        SimulationError: it does not exist, or belongs to a removed element and follows from nothing.
    """
    known = compiled.lowered.observables
    integral = integral_of(compiled, path)
    if integral is not None:
        return (integral.rate,)
    if path.name == "power" and path not in known:
        return (*entries_for(compiled, path.parent / "effort"), *entries_for(compiled, path.parent / "flow"))
    if path not in known:
        raise SimulationError([unknown_observable(compiled, path)])
    return (path,)


def removed_element(compiled: CompiledModel, path: Path) -> Element | None:
    """The element of the full model that a path lies in, if this model does without it."""
    if not compiled.model.removals:
        return None
    graph = compiled.graph
    for length in range(len(path) - 1, 0, -1):
        owner = Path(path[:length])
        if owner in graph.original.elements:
            return None if owner in graph.normal.elements else graph.original.elements[owner]
    return None


def _stored_at(owner: Element, behaviour: Storage, path: Path) -> tuple[str, Expr] | None:
    """The port whose stored quantity a path names, and its value at the start."""
    starts = {symbol(SymbolKind.STATE, owner.path / c.name, c.unit): c.start for c in behaviour.coordinates}
    name = "displacement" if behaviour.kind is ElementKind.COMPLIANCE else "momentum"
    for port, expr in behaviour.stored:
        is_coordinate = expr in starts and expr.data.path == path
        if path == owner.path / port / name or is_coordinate:
            return port, substitute(expr, starts)
    return None


def _has_law(compiled: CompiledModel, behaviour: Storage, bond: Path) -> bool:
    """Whether what is stored follows from the output of the law, as nothing prescribes the effort of a compliance."""
    if behaviour.inverse is None:
        return False
    if behaviour.kind is not ElementKind.COMPLIANCE:
        return True
    graph = compiled.graph
    is_constant = any(isinstance(r, ConstantEffort) and r.bond == bond for r in graph.removals)
    return not is_constant and graph.known_zero.get(bond) is not Variable.EFFORT


def _refusal(compiled: CompiledModel, path: Path, owner: Element, why: str) -> Diagnostic:
    own = [
        removal_text(removal)
        for removal in compiled.model.removals
        if not isinstance(removal, Freeze) and (removal.bond.is_below(owner.path) or owner.path.is_below(removal.bond))
    ]
    cause = ", ".join(own) if own else "the removals leave it nothing to act on"
    ports = [owner.path / port / variable.value for port in owner.ports for variable in Variable]
    known = [name for name in ports if name in compiled.lowered.observables]
    offer = f"what is known of it: {', '.join(map(str, known))}" if known else "ask for a variable of what is left"
    return Diagnostic(
        "reduction/not-recovered",
        f"'{path}' belongs to {owner.path}, which this model does without ({cause}), and {why}",
        source=owner.source,
        help=f"{offer}; or run the full model",
    )
