"""What removals do to a bond graph, before it is simplified."""

from __future__ import annotations

from dataclasses import replace

from propermodel.bondgraph.graph import Bond, Element, End
from propermodel.bondgraph.net import Net
from propermodel.bondgraph.simplify import Zero
from propermodel.diagnostics import Diagnostic, Faults, Path, ReductionError
from propermodel.expressions.core import Expr, SymbolKind, constant, symbol
from propermodel.modelling.model import (
    ConstantEffort,
    ConstantFlow,
    Cut,
    ElementKind,
    Freeze,
    PowerSource,
    Removal,
    Variable,
    ZeroEffort,
    ZeroFlow,
)

_SOURCE = {Variable.EFFORT: ElementKind.EFFORT_SOURCE, Variable.FLOW: ElementKind.FLOW_SOURCE}


def apply_removals(net: Net, removals: tuple[Removal, ...]) -> tuple[list[Zero], dict[Expr, Expr]]:
    """Replace removed elements; gives the bonds that now carry no effort or no flow, and signals to add.

    Raises:
        ReductionError: a field is removed at some of its ports only, or a bond is removed twice.
    """
    faults = Faults(ReductionError)
    zeros: list[Zero] = []
    touched: dict[Path, set[Path]] = {}
    seen: set[Path] = set()
    for removal in removals:
        if isinstance(removal, Freeze):
            continue
        bond = net.bonds.get(removal.bond)
        if bond is None or removal.bond in seen:
            faults.add(Diagnostic("reduction/removed-twice", f"'{removal.bond}' is removed twice"))
            continue
        seen.add(removal.bond)
        end = bond.head if bond.head.port else bond.tail
        touched.setdefault(end.owner, set()).add(removal.bond)
        match removal:
            case ZeroEffort():
                zeros.append((removal.bond, Variable.EFFORT))
            case ZeroFlow():
                zeros.append((removal.bond, Variable.FLOW))
            case ConstantEffort() | ConstantFlow():
                variable = Variable.EFFORT if isinstance(removal, ConstantEffort) else Variable.FLOW
                _replace_by_source(net, bond, end, variable, constant(removal.value), "constant")
            case Cut():
                _cut(net, bond, end, removal.driven)
    _drop_removed_fields(net, touched, zeros, faults)
    faults.raise_if_any()
    return zeros, {}


def _replace_by_source(net: Net, bond: Bond, end: End, variable: Variable, value: Expr, mark: str) -> None:
    """Let a source take the place of an element on its bond."""
    old = net.elements[end.owner]
    path = end.owner / f"{end.port}_{mark}"
    kind = _SOURCE[variable]
    net.elements[path] = Element(
        path=path,
        kind=kind,
        ports=("port",),
        behaviour=PowerSource(kind=kind, value=value),
        row=path,
        source=old.source,
    )
    net.incident[path] = {}
    net.drop(bond.name)
    here = End(path, "port")
    new = Bond(bond.name, bond.tail, here, bond.domain) if bond.head == end else Bond(bond.name, here, bond.head, bond.domain)
    net.add(new)


def _cut(net: Net, bond: Bond, end: End, driven: Variable) -> None:
    """Let the element be driven by what its junction has, without acting back."""
    junction = bond.other(end.owner).owner
    sibling = next(other for other in net.bonds_at(junction) if other.name != bond.name)
    kind = SymbolKind.EFFORT if driven is Variable.EFFORT else SymbolKind.FLOW
    value = symbol(kind, sibling.name / driven.value, "")
    path = end.owner / f"{end.port}_driven"
    source_kind = _SOURCE[driven]
    net.elements[path] = Element(
        path=path,
        kind=source_kind,
        ports=("port",),
        behaviour=PowerSource(kind=source_kind, value=value),
        row=path,
        source=net.elements[end.owner].source,
    )
    net.incident[path] = {}
    node = net.junctions[junction]
    own = node.path / f"{end.owner.name}_driven"
    net.add_junction(replace(node, path=own))
    net.move(bond.name, junction, own)
    net.add(Bond(path / "port", End(path, "port"), End(own), bond.domain))


def _drop_removed_fields(net: Net, touched: dict[Path, set[Path]], zeros: list[Zero], faults: Faults) -> None:
    """A field goes as a whole: every port needs a removal."""
    pending = {name for name, _ in zeros}
    for path, bonds in touched.items():
        element = net.elements[path]
        left = [bond.name for bond in net.bonds_at(path) if bond.name not in pending]
        cut = any(name in net.bonds and name not in pending and net.bonds[name] in net.bonds_at(path) for name in bonds)
        if cut:
            continue
        if left and len(element.ports) > 1:
            names = ", ".join(str(name) for name in left)
            faults.add(
                Diagnostic(
                    "reduction/partial-field",
                    f"{path} is removed at some of its ports only; {names} would be left",
                    source=element.source,
                    help="say for every port of a field what replaces it",
                )
            )
        elif not left:
            detached = [bond for bond in net.bonds_at(path)]
            if not detached:
                net.drop_node(path)
