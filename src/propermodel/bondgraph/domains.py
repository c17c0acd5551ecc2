"""The domain of every bond, and whether all that bonds and junctions join is of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from propermodel.bondgraph.graph import Bond, End, Structure
from propermodel.bondgraph.nodes import Nodes
from propermodel.diagnostics import NO_SOURCE, Diagnostic, Involved, Path


def complete_domains(bonds: dict[Path, Bond]) -> None:
    """Let bonds between written junctions take the domain of their neighbours."""
    unknown = [name for name, bond in bonds.items() if not bond.domain]
    by_owner: dict[Path, str] = {}
    while unknown:
        for bond in bonds.values():
            if bond.domain:
                for end in (bond.tail, bond.head):
                    if not end.port:
                        by_owner[end.owner] = bond.domain
        rest: list[Path] = []
        for name in unknown:
            bond = bonds[name]
            domain = by_owner.get(bond.tail.owner) or by_owner.get(bond.head.owner)
            if domain:
                bonds[name] = replace(bond, domain=domain)
            else:
                rest.append(name)
        if len(rest) == len(unknown):
            break
        unknown = rest


def mixed_domains(structure: Structure, port_domain: Mapping[Path, str]) -> list[Diagnostic]:
    """A fault for each web of junctions that joins ports of several domains; junctions themselves have none."""
    webs = Nodes()
    for bond in structure.bonds.values():
        webs.add(bond.tail.path)
        webs.add(bond.head.path)
        webs.join(bond.tail.path, bond.head.path)
    joined: dict[Path, dict[End, None]] = {}
    for bond in structure.bonds.values():
        joined.setdefault(webs.find(bond.tail.path), {}).update({bond.tail: None, bond.head: None})
    return [fault for ends in joined.values() if (fault := _mixed(structure, port_domain, list(ends))) is not None]


def _mixed(structure: Structure, port_domain: Mapping[Path, str], ends: list[End]) -> Diagnostic | None:
    ports = {end: port_domain[end.path] for end in ends if end.path in port_domain}
    domains = sorted(set(ports.values()))
    if len(domains) < 2:
        return None
    written = [structure.junctions[end.owner] for end in ends if not end.port and end not in ports]
    of_elements = {end: domain for end, domain in ports.items() if end.port}
    # A port of a component that is wired of parts is named where no element tells of its domain.
    others = {end: domain for end, domain in ports.items() if domain not in of_elements.values()}
    involved = tuple(
        Involved(str(end.path), f"is {domain}", structure.elements[end.owner].source if end.port else NO_SOURCE)
        for end, domain in (of_elements | others).items()
    )
    return Diagnostic(
        "model/domain",
        f"bonds join ports of different domains ({', '.join(domains)})",
        where=f"{written[0].path} ({written[0].kind}-junction)" if written else "",
        source=written[0].source if written else involved[0].source,
        involved=involved,
        help="put a transducer (transformer or gyrator) between the domains",
    )
