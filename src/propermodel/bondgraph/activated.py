"""Activated bonds: one end is felt without power, the other end acts with whatever power that takes.

The beginning is a source of nothing (no flow where an effort is felt, no effort where a flow is), the end is a source
whose value is what is felt. So a stroke at an activated bond is as fixed as that of a source.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from propermodel.bondgraph.graph import ActivatedBond, Bond, Element, End, Junction
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Path, Source
from propermodel.expressions.core import ZERO, Expr, SymbolKind, symbol
from propermodel.modelling.domains import DomainData
from propermodel.modelling.model import ElementKind, PowerSource, Variable

_SETS = {Variable.EFFORT: ElementKind.EFFORT_SOURCE, Variable.FLOW: ElementKind.FLOW_SOURCE}


@dataclass(frozen=True, slots=True, kw_only=True)
class Ends:
    """An activated bond between two junctions as it was written; `place` is the component that has it."""

    place: Path
    tail: Path  # within the component
    head: Path
    carries: Variable
    source: Source = NO_SOURCE

    @property
    def name(self) -> Path:
        """What the bond is called: after both its ends."""
        return self.place + self.tail / f"to_{'_'.join(self.head)}"


def activated(ends: Ends, tail: End, head: End) -> tuple[ActivatedBond, tuple[Bond, Bond]]:
    """An activated bond with the two bonds of its sources, which point the way it points."""
    bond = ActivatedBond(
        path=ends.name,
        felt=ends.name.parent / f"{ends.name.name}_felt" / "port",
        given=ends.name / "port",
        carries=ends.carries,
        source=ends.source,
    )
    felt = Bond(bond.felt, tail, End(bond.felt.parent, "port"), "")
    given = Bond(bond.given, End(bond.given.parent, "port"), head, "")
    return bond, (felt, given)


def sources_of(bond: ActivatedBond, domain: DomainData | None) -> tuple[Element, Element]:
    """The source of nothing at the beginning of an activated bond, and the source at its end."""
    return _source(bond, bond.felt, bond.carries.other, ZERO), _source(
        bond, bond.given, bond.carries, felt(bond, domain)
    )


def felt(bond: ActivatedBond, domain: DomainData | None) -> Expr:
    """What an activated bond carries, as the symbol of the bond where it is felt."""
    is_effort = bond.carries is Variable.EFFORT
    kind = SymbolKind.EFFORT if is_effort else SymbolKind.FLOW
    unit = "" if domain is None else domain.effort_unit if is_effort else domain.flow_unit
    return symbol(kind, bond.felt / bond.carries.value, unit)


def _source(bond: ActivatedBond, port: Path, variable: Variable, value: Expr) -> Element:
    behaviour = PowerSource(kind=_SETS[variable], value=value)
    path = port.parent
    return Element(path=path, kind=behaviour.kind, ports=("port",), behaviour=behaviour, row=path, source=bond.source)


def faults(
    bond: ActivatedBond,
    bonds: Mapping[Path, Bond],
    junctions: Mapping[Path, Junction],
    domains: Mapping[str, DomainData],
) -> list[Diagnostic]:
    """Why an activated bond cannot be: its ends have different domains, or its beginning would hold what it feels."""
    before, after = (domains.get(bonds[name].domain) for name in (bond.felt, bond.given))
    carried, other = bond.carries, bond.carries.other
    if before is not None and after is not None and before != after:
        return [
            Diagnostic(
                "model/activated-bond",
                f"the activated bond {bond.path} carries the {_word(before, carried)} of {before.name} "
                f"to a place of {after.name}",
                source=bond.source,
                help="use a sensor, a signal block that turns the one into the other, and a source with an input",
            )
        ]
    junction = junctions[bonds[bond.felt].tail.owner]
    if junction.kind.common is not carried:
        flow = _word(before, other)
        where = "a 0-junction" if carried is Variable.EFFORT else "a 1-junction"
        return [
            Diagnostic(
                "model/activated-bond",
                f"the activated bond {bond.path} carries the {_word(before, carried)} alone, and would hold the {flow} "
                f"of the {junction.kind}-junction {junction.path} at zero, which all bonds there share",
                source=bond.source,
                help=f"begin it at {where}, whose bonds share the {_word(before, carried)}, "
                f'or let it carry the other variable: carries="{other}"',
            )
        ]
    return []


def _word(domain: DomainData | None, variable: Variable) -> str:
    if domain is None:
        return variable.value
    return domain.effort if variable is Variable.EFFORT else domain.flow


def with_domains(bonds: dict[Path, Bond], found: list[ActivatedBond]) -> None:
    """Give an end whose place has no domain of its own that of the other end."""
    for bond in found:
        for one, other in ((bond.felt, bond.given), (bond.given, bond.felt)):
            if not bonds[one].domain:
                bonds[one] = replace(bonds[one], domain=bonds[other].domain)
