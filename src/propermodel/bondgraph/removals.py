"""What removals do to a bond graph, before it is simplified."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import takewhile

from propermodel.bondgraph.graph import Absorbed, Bond, Element, End
from propermodel.bondgraph.merging import linear_one_port, merged_element, sharing
from propermodel.bondgraph.net import Net
from propermodel.bondgraph.simplify import Zero, normalise
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Faults, Path, ReductionError, one_of
from propermodel.expressions.core import ONE, ZERO, Expr, SymbolKind, constant, symbol
from propermodel.modelling.domains import DomainData
from propermodel.modelling.model import (
    BondRemoval,
    ConstantEffort,
    ConstantFlow,
    Cut,
    ElementKind,
    Freeze,
    Merge,
    PowerSource,
    Prescribe,
    Removal,
    Variable,
    ZeroEffort,
    ZeroFlow,
)

NewInput = Callable[[Path, str], Expr]  # an input of the scenario over time, by its path and unit

_SOURCE = {Variable.EFFORT: ElementKind.EFFORT_SOURCE, Variable.FLOW: ElementKind.FLOW_SOURCE}


def make_removals(
    net: Net, domains: Mapping[str, DomainData], removals: tuple[Removal, ...], new_input: NewInput
) -> None:
    """Make the removals in a net in normal form, and bring it to normal form again.

    A removal may name a bond that only exists once earlier removals are made (of a model reduced before), so those
    whose bonds exist are made together, and the rest after simplification. Elements are merged after the removals that
    are written before, which may be what joins them.

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
        possible = _next([removal for removal in pending if removal.bond in net.bonds])
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
        normalise(net, _apply(net, domains, possible, new_input, faults))
        pending = [removal for removal in pending if removal not in possible]
    faults.raise_if_any()


def _next(removals: list[BondRemoval]) -> list[BondRemoval]:
    """Those that are made together: all up to the first merging, or mergings in a row."""
    is_merge = bool(removals) and isinstance(removals[0], Merge)
    return list(takewhile(lambda removal: isinstance(removal, Merge) is is_merge, removals))


def _apply(
    net: Net, domains: Mapping[str, DomainData], removals: list[BondRemoval], new_input: NewInput, faults: Faults
) -> list[Zero]:
    """Replace removed elements; gives the bonds that now carry no effort or no flow."""
    zeros: list[Zero] = []
    touched: dict[Path, set[Path]] = {}
    for removal in removals:
        bond = net.bonds[removal.bond]
        end = bond.head if bond.head.port else bond.tail
        if end.port:
            if not isinstance(removal, Cut | Prescribe):
                touched.setdefault(end.owner, set()).add(removal.bond)
        elif isinstance(removal, ConstantEffort | ConstantFlow):
            faults.add(
                Diagnostic(
                    "reduction/no-element",
                    f"'{removal.bond}' joins two junctions: there is no element to hold constant",
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
            case Merge():
                zero = _merge(net, bond, end, removal, faults)
                if zero is not None:
                    zeros.append(zero)
            case Cut():
                if _can_be_driven(net, bond, end, removal.driven, faults):
                    _drive(net, domains, bond, removal.driven, None)
            case Prescribe():
                if _can_be_driven(net, bond, end, removal.driven, faults):
                    unit = _unit(domains[bond.domain], removal.driven)
                    _drive(net, domains, bond, removal.driven, new_input(bond.name / removal.driven.value, unit))
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


def _merge(net: Net, bond: Bond, end: End, removal: Merge, faults: Faults) -> Zero | None:
    """Let one element stand for the element at this bond and for that at another."""
    structure = net.freeze()
    known = net.merged.get(removal.into)
    keeper = removal.into.parent if known is None else known.merged
    one, other = linear_one_port(structure, keeper), linear_one_port(structure, end.owner)
    factor = None
    if one is not None and other is not None and one.element.kind is other.element.kind:
        factor = dict(sharing(structure, one)).get(other.junction)
    if one is None or other is None or factor is None or one.element is other.element:
        faults.add(
            Diagnostic(
                "reduction/merge",
                f"{bond.name} cannot be merged into {removal.into}",
                source=net.elements[end.owner].source if end.owner in net.elements else NO_SOURCE,
                help="both are linear one-ports of one kind at junctions that share a variable, or are joined by "
                "transformers with constant moduli; pm.find_merges names such pairs",
            )
        )
        return None
    together = merged_element(one, other, factor)
    if known is None:
        net.merged[removal.into] = Absorbed(together.path, one.kind, one.coefficient, ONE)
        (old,) = net.bonds_at(keeper)
        net.drop_node(keeper)
        net.incident[together.path] = {}
        name, here = together.path / together.ports[0], End(together.path, together.ports[0])
        is_head = old.head.owner == keeper
        net.add(Bond(name, old.tail if is_head else here, here if is_head else old.head, old.domain))
    net.elements[together.path] = together
    net.merged[bond.name] = Absorbed(together.path, one.kind, other.coefficient, factor)
    return bond.name, one.kind.common.other


def _can_be_driven(net: Net, bond: Bond, end: End, driven: Variable, faults: Faults) -> bool:
    """Whether what a bond leads to can be driven by this variable: the one that the junction before it shares."""
    if _driving_end(net, bond, driven) is not None:
        return True
    junction = net.junctions.get(bond.other(end.owner).owner)
    element = net.elements.get(end.owner)
    what = "no junction" if junction is None else f"the {junction.kind}-junction {junction.path}"
    faults.add(
        Diagnostic(
            "reduction/cut",
            f"{bond.name} cannot be driven by the {driven} of {what}",
            source=NO_SOURCE if element is None else element.source,
            help="an element at a 1-junction is driven by its flow, one at a 0-junction by its effort",
        )
    )
    return False


def _driving_end(net: Net, bond: Bond, driven: Variable) -> End | None:
    """The junction at an end of a bond that shares a variable."""
    for end in (bond.tail, bond.head):
        junction = net.junctions.get(end.owner)
        if junction is not None and junction.kind.common is driven:
            return end
    return None


def _drive(net: Net, domains: Mapping[str, DomainData], bond: Bond, driven: Variable, given: Expr | None) -> None:
    """Let what lies behind a bond be driven by what the junction before it has, or by an input, without acting back."""
    near = _driving_end(net, bond, driven)
    assert near is not None
    junction = net.junctions[near.owner]
    far = bond.other(junction.path)
    base, name = (far.owner, far.port) if far.port else (bond.name.parent, bond.name.name)
    if given is None:
        # A source of nothing reads the junction's variable, and keeps the junction where there is no more to it.
        probe = _add_source(net, base / f"{name}_probe", driven.other, ZERO, bond.domain, junction.path)
        net.probes.add(probe.name.parent)
        kind = SymbolKind.EFFORT if driven is Variable.EFFORT else SymbolKind.FLOW
        given = symbol(kind, probe.name / driven.value, _unit(domains[bond.domain], driven))
    mark = f"{(far.owner if far.port else bond.name).name}_driven"
    own = net.fresh(junction.path / mark, "") if junction.path / mark in net.incident else junction.path / mark
    net.add_junction(replace(junction, path=own))
    net.move(bond.name, junction.path, own)
    _add_source(net, base / f"{name}_driven", driven, given, bond.domain, own)


def _unit(domain: DomainData, variable: Variable) -> str:
    return domain.effort_unit if variable is Variable.EFFORT else domain.flow_unit


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
