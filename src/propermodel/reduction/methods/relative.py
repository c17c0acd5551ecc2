"""Relative activity: what is small among its neighbours goes (Rideout, Stein, Louca 2007).

A bond is compared with the most active bond of its junction, so that a term of a sum goes only if it is small in that
sum. Deleting the effort at a 1-junction, or the flow at a 0-junction, is the usual case. The dual (a whole junction
held at rest or at no effort) is right where everything that leads there is small at the junctions beyond.
"""

from __future__ import annotations

from propermodel.bondgraph.graph import Bond
from propermodel.diagnostics import Path
from propermodel.equations.system import Row
from propermodel.modelling.model import JunctionKind, Removal, ZeroEffort, ZeroFlow
from propermodel.reduction.evidence import RunEvidence
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.ranking import models_along
from propermodel.reduction.methods.workbench import Workbench

NEGLIGIBLE = 0.01  # share at a junction below which the method calls a term negligible


def by_relative_activity(bench: Workbench) -> Curve:
    """Remove elements in the order of their shares at junctions, with the better of both replacements."""
    shares = {row.path: _share(bench, row) for row in bench.rows}
    order = sorted(shares, key=lambda path: (shares[path][0], path))
    models = models_along(bench, [shares[path][1] for path in order])
    removals = [removal for path in order if shares[path][0] <= NEGLIGIBLE for removal in shares[path][1]]
    return Curve(
        method="relative activity",
        source="Rideout, Stein and Louca 2007",
        models=models,
        chosen=bench.measure(removals),
        rule=f"remove what has at most {NEGLIGIBLE:.0%} of the greatest activity at its junction",
        simulations=bench.simulations,
        notes=("bonds inside the junction structure are not cut: only elements go",),
    )


def _share(bench: Workbench, row: Row) -> tuple[float, tuple[Removal, ...]]:
    """The largest share that a row's removal neglects, with the removals: the better replacement at each bond."""
    found = [_at_bond(bench.evidence, bench.evidence.structure.bonds[name]) for name in row.bonds]
    return max(share for share, _ in found), tuple(removal for _, removal in found)


def _at_bond(evidence: RunEvidence, bond: Bond) -> tuple[float, Removal]:
    junction = bond.tail.owner if not bond.tail.port else bond.head.owner
    here = evidence.structure.junctions.get(junction)
    if here is None:  # an element that meets only one other
        return 1.0, ZeroEffort(bond.name)
    own, dual = evidence.share(bond, junction), _beyond(evidence, junction)
    delete, hold = (ZeroEffort, ZeroFlow) if here.kind is JunctionKind.ONE else (ZeroFlow, ZeroEffort)
    return (own, delete(bond.name)) if own <= dual else (dual, hold(bond.name))


def _beyond(evidence: RunEvidence, junction: Path) -> float:
    """The largest share, at the junctions of the other kind around one, of the bonds that lead to it."""
    kind = evidence.structure.junctions[junction].kind
    ends = [(bond, bond.other(junction)) for bond in evidence.at[junction]]
    shares = [
        evidence.share(bond, end.owner)
        for bond, end in ends
        if not end.port and evidence.structure.junctions[end.owner].kind is not kind
    ]
    return max(shares, default=1.0)
