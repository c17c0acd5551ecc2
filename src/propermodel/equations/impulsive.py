"""Storage that a source decides alone: where the source jumps, it would have to answer with an impulse."""

from __future__ import annotations

from propermodel.bondgraph.graph import BondGraph, Element
from propermodel.causality.paths import Signals
from propermodel.diagnostics import Diagnostic, Involved, Path, Severity
from propermodel.equations.system import DependentStorage, EquationSystem
from propermodel.expressions.core import SymbolKind, leaves
from propermodel.modelling.model import ElementKind, PowerSource, Variable

_CURES = {
    ElementKind.INERTIA: "put a compliance between them, or drive it with an effort source",
    ElementKind.COMPLIANCE: "put a resistance between them, or drive it with a flow source",
}


def impulsive_sources(system: EquationSystem) -> tuple[Diagnostic, ...]:
    """A warning for each inertia whose flow, and compliance whose effort, sources decide and nothing else.

    It follows them, and answers with the rate of what they give: no finite effort makes an inertia jump.
    """
    decided = dict.fromkeys(d.element for d in system.dependents if _is_free_of_states(d))
    if not decided:
        return ()
    graph, signals = system.causal.graph, Signals(system.causal)
    found = ((graph.normal.elements[path], _sources(graph, signals, path)) for path in decided)
    return tuple(_warning(graph, signals, element, sources) for element, sources in found if sources)


def _is_free_of_states(dependent: DependentStorage) -> bool:
    return all(leaf.data.kind not in (SymbolKind.STATE, SymbolKind.UNKNOWN) for leaf in leaves(dependent.stored))


def _sources(graph: BondGraph, signals: Signals, storage: Path) -> list[Element]:
    """The sources that reach a storage through the junction structure; a locked one has none."""
    begins = dict.fromkeys(path.begin for taken in signals.deciding(storage) for path in signals.influences(taken))
    elements = [graph.normal.elements[begin] for begin in begins]
    return [element for element in elements if isinstance(element.behaviour, PowerSource)]


def _warning(graph: BondGraph, signals: Signals, element: Element, sources: list[Element]) -> Diagnostic:
    decided = Variable.FLOW if element.kind is ElementKind.INERTIA else Variable.EFFORT
    bond = signals.at[element.path][0]
    word, answer = graph.word(bond, decided), graph.word(bond, decided.other)
    names = " and ".join(str(source.path) for source in sources)
    return Diagnostic(
        "equations/impulsive",
        f"nothing but {names} decides the {word} of {element.path}: where that jumps, its {answer} is an impulse",
        where=str(element.path),
        source=element.source,
        involved=(
            *(Involved(str(s.path), f"prescribes its {_prescribed(graph, signals, s)}", s.source) for s in sources),
            Involved(str(element.path), f"has no {word} of its own", element.source),
        ),
        help=_CURES[element.kind],
        severity=Severity.WARNING,
    )


def _prescribed(graph: BondGraph, signals: Signals, source: Element) -> str:
    variable = Variable.FLOW if source.kind is ElementKind.FLOW_SOURCE else Variable.EFFORT
    return graph.word(signals.at[source.path][0], variable)
