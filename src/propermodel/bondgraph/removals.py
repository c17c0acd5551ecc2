"""What removals do to a bond graph, before it is simplified."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

from propermodel.bondgraph.graph import Bond, Element, End
from propermodel.bondgraph.net import Net
from propermodel.bondgraph.simplify import Zero, normalise
from propermodel.diagnostics import Diagnostic, Faults, Path, ReductionError, one_of
from propermodel.expressions.core import ZERO, Expr, SymbolKind, constant, symbol
from propermodel.modelling.domains import DomainData
from propermodel.modelling.model import (
    BondRemoval,
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


def make_removals(net: Net, domains: Mapping[str, DomainData], removals: tuple[Removal, ...]) -> None:
    """Make the removals in a net in normal form, and bring it to normal form again.

    A removal may name a bond that only exists once earlier removals are made (of a model reduced before), so those
    whose bonds exist are made together, and the rest after simplification.

    Raises:
        ReductionError: a removal names no bond, a bond is removed twice, or a field goes at some of its ports only.
    """
    pending = [removal for removal in removals if not isinstance(removal, Freeze)]
    faults = Faults(ReductionError)
    for name, count in Counter(removal.bond for removal in pending).items():
        if count > 1:
            faults.add(
                Diagnostic(
                    "reduction/removed-twice",
                    f"'{name}' is removed {count} times",
                    help="keep one of the removals that name this bond",
                )
            )
    faults.raise_if_any()
    while pending:
        possible = [removal for removal in pending if removal.bond in net.bonds]
        if not possible:
            for removal in pending:
                if removal.bond not in net.known_zero:
                    faults.add(
                        Diagnostic(
                            "reduction/unknown-removal",
                            f"a removal names '{removal.bond}', which is no bond of the model in normal form",
                            help=one_of(str(removal.bond), map(str, net.bonds), "there are no bonds left"),
                        )
                    )
            break
        normalise(net, _apply(net, domains, possible, faults))
        pending = [removal for removal in pending if removal not in possible]
    faults.raise_if_any()


def _apply(net: Net, domains: Mapping[str, DomainData], removals: list[BondRemoval], faults: Faults) -> list[Zero]:
    """Replace removed elements; gives the bonds that now carry no effort or no flow."""
    zeros: list[Zero] = []
    touched: dict[Path, set[Path]] = {}
    for removal in removals:
        bond = net.bonds[removal.bond]
        end = bond.head if bond.head.port else bond.tail
        if end.port:
            touched.setdefault(end.owner, set()).add(removal.bond)
        elif not isinstance(removal, ZeroEffort | ZeroFlow):
            faults.add(
                Diagnostic(
                    "reduction/no-element",
                    f"'{removal.bond}' joins two junctions: there is no element to drive or to hold constant",
                    help="name the bond of an element, or take the whole group away with no effort or no flow",
                )
            )
            continue
        match removal:
            case ZeroEffort():
                zeros.append((removal.bond, Variable.EFFORT))
            case ZeroFlow():
                zeros.append((removal.bond, Variable.FLOW))
            case ConstantEffort() | ConstantFlow():
                variable = Variable.EFFORT if isinstance(removal, ConstantEffort) else Variable.FLOW
                _replace_by_source(net, bond, end, variable, constant(removal.value))
            case Cut():
                if _can_be_cut(net, bond, end, removal.driven, faults):
                    _cut(net, domains, bond, end, removal.driven)
    _drop_removed_fields(net, touched, zeros, faults)
    return zeros


def _replace_by_source(net: Net, bond: Bond, end: End, variable: Variable, value: Expr) -> None:
    """Let a source take the place of an element on its bond."""
    old = net.elements[end.owner]
    path = end.owner / f"{end.port}_constant"
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
    new = (
        Bond(bond.name, bond.tail, here, bond.domain)
        if bond.head == end
        else Bond(bond.name, here, bond.head, bond.domain)
    )
    net.add(new)


def _can_be_cut(net: Net, bond: Bond, end: End, driven: Variable, faults: Faults) -> bool:
    """Whether the element can be driven by this variable: the one that its junction shares."""
    junction = net.junctions.get(bond.other(end.owner).owner)
    if junction is not None and junction.kind.common is driven:
        return True
    element = net.elements[end.owner]
    what = "no junction" if junction is None else f"the {junction.kind}-junction {junction.path}"
    faults.add(
        Diagnostic(
            "reduction/cut",
            f"{bond.name} cannot be driven by the {driven} of {what}",
            source=element.source,
            help="an element at a 1-junction is driven by its flow, one at a 0-junction by its effort",
        )
    )
    return False


def _cut(net: Net, domains: Mapping[str, DomainData], bond: Bond, end: End, driven: Variable) -> None:
    """Let the element be driven by what its junction has, without acting back."""
    junction = net.junctions[bond.other(end.owner).owner]
    # A source of nothing reads the junction's variable, and keeps the junction where there is no more to it.
    probe = _add_source(net, end.owner / f"{end.port}_probe", driven.other, ZERO, bond.domain, junction.path)
    net.probes.add(probe.name.parent)
    kind = SymbolKind.EFFORT if driven is Variable.EFFORT else SymbolKind.FLOW
    domain = domains[bond.domain]
    unit = domain.effort_unit if driven is Variable.EFFORT else domain.flow_unit
    own = junction.path / f"{end.owner.name}_driven"
    net.add_junction(replace(junction, path=own))
    net.move(bond.name, junction.path, own)
    value = symbol(kind, probe.name / driven.value, unit)
    _add_source(net, end.owner / f"{end.port}_driven", driven, value, bond.domain, own)


def _add_source(net: Net, path: Path, variable: Variable, value: Expr, domain: str, junction: Path) -> Bond:
    """Add a source at a junction."""
    kind = _SOURCE[variable]
    behaviour = PowerSource(kind=kind, value=value)
    net.elements[path] = Element(path=path, kind=kind, ports=("port",), behaviour=behaviour, row=path)
    net.incident[path] = {}
    bond = Bond(path / "port", End(junction), End(path, "port"), domain)
    net.add(bond)
    return bond


def _drop_removed_fields(net: Net, touched: dict[Path, set[Path]], zeros: list[Zero], faults: Faults) -> None:
    """Take away elements whose bonds all have another end now; a field goes as a whole."""
    pending = {name for name, _ in zeros}
    for path, bonds in touched.items():
        element = net.elements[path]
        left = [bond.name for bond in net.bonds_at(path) if bond.name not in pending]
        if not left and not net.bonds_at(path):
            net.drop_node(path)
        elif left and len(element.ports) > 1 and element.kind.is_energetic and not bonds.issuperset(left):
            names = ", ".join(str(name) for name in left)
            faults.add(
                Diagnostic(
                    "reduction/partial-field",
                    f"{path} is removed at some of its ports only; {names} would be left",
                    source=element.source,
                    help="say for every port of a field what replaces it",
                )
            )
