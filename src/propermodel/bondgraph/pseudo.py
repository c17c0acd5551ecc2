"""Which bonds are pseudo bonds, whose effort times flow is no power, and which elements stand on them."""

from __future__ import annotations

from collections.abc import Mapping

from propermodel.bondgraph.graph import Bond, BondGraph
from propermodel.diagnostics import Path


def is_pseudo(graph: BondGraph, bond: Bond) -> bool:
    """Whether a bond belongs to a pseudo domain."""
    domain = graph.domains.get(bond.domain)
    return domain is not None and not domain.is_true


def is_pseudo_port(graph: BondGraph, port: Path) -> bool:
    """Whether a port or bond has a pseudo domain, whose effort times flow is no power and has no unit here."""
    bond = graph.original.bonds.get(port) or graph.normal.bonds.get(port)
    if bond is not None:
        return is_pseudo(graph, bond)
    node = graph.node_ports.get(port)
    return node is not None and not graph.domains[node.domain].is_true


def pseudo_elements(graph: BondGraph) -> Mapping[Path, str]:
    """The elements of the normal form whose bonds are all pseudo, with their domain."""
    found: dict[Path, str] = {}
    true: set[Path] = set()
    for bond in graph.normal.bonds.values():
        for end in (bond.tail, bond.head):
            if end.port and is_pseudo(graph, bond):
                found[end.owner] = bond.domain
            elif end.port:
                true.add(end.owner)
    return {path: domain for path, domain in found.items() if path not in true}
