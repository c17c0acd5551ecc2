"""The picture of a bond graph as plain data: groups, nodes, bonds and signals, without any place on a page.

One document serves every drawing: the static one, the notebook, the report and the studio. The drawing code itself is
in `web/src/graph` and knows no physics.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from propermodel.diagnostics import Path

FORMAT = "propermodel picture"
VERSION = 1

Json = dict[str, object]


class Strokes(StrEnum):
    """How the causality of a bond came about."""

    PREFERRED = "preferred"
    DEPENDENT = "dependent"  # storage whose state depends on others
    FIXED = "fixed"  # by its author
    CONFLICT = "conflict"  # of an element that contradicts others
    NONE = "none"  # no causality yet


@dataclass(frozen=True, slots=True)
class Gone:
    """What stands in the place of an element that a reduction took away: a short sign, and the same in words."""

    sign: str
    meaning: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureNode:
    """A junction, an element, or a source or user of signals; `row` is the entry of the ranking that it counts in."""

    path: Path
    kind: str
    group: Path
    row: Path | None = None
    gone: Gone | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureBond:
    """A bond between two nodes; the half arrow points to `head`, the stroke stands at `effort_into`."""

    name: Path
    tail: Path
    head: Path
    domain: str
    effort_into: Path | None
    strokes: Strokes
    is_gone: bool = False


@dataclass(frozen=True, slots=True)
class PictureSignal:
    """Information that one node has from another."""

    giver: Path
    user: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureActivity:
    """Activities of rows and of bonds, as shares of the total of all rows, J."""

    total: float
    rows: Mapping[Path, float]
    bonds: Mapping[Path, float] = field(default_factory=dict[Path, float])


@dataclass(frozen=True, kw_only=True)
class Picture:
    """What is drawn of a model. `groups` are the levels of its hierarchy, each after the one around it."""

    name: str
    groups: tuple[Path, ...]
    nodes: tuple[PictureNode, ...]
    bonds: tuple[PictureBond, ...]
    signals: tuple[PictureSignal, ...]
    activity: PictureActivity | None = None

    def document(self) -> Json:
        """The picture as plain data, as the drawing code reads it."""
        found: Json = {
            "format": FORMAT,
            "version": VERSION,
            "name": self.name,
            "groups": [
                {"path": str(group), "name": group.name or self.name, "parent": str(group.parent)}
                for group in self.groups
            ],
            "nodes": [_node(node) for node in self.nodes],
            "bonds": [_bond(bond) for bond in self.bonds],
            "signals": [{"from": str(signal.giver), "to": str(signal.user)} for signal in self.signals],
        }
        if self.activity is not None:
            found["activity"] = {
                "total": self.activity.total,
                "rows": {str(path): share for path, share in self.activity.rows.items()},
                "bonds": {str(path): share for path, share in self.activity.bonds.items()},
            }
        return found


def _node(node: PictureNode) -> Json:
    found: Json = {
        "path": str(node.path),
        "kind": node.kind,
        "name": node.path.name,
        "group": str(node.group),
    }
    if node.row is not None:
        found["row"] = str(node.row)
    if node.gone is not None:
        found["gone"] = {"sign": node.gone.sign, "meaning": node.gone.meaning}
    return found


def _bond(bond: PictureBond) -> Json:
    found: Json = {
        "name": str(bond.name),
        "tail": str(bond.tail),
        "head": str(bond.head),
        "domain": bond.domain,
        "causality": bond.strokes.value,
    }
    if bond.effort_into is not None:
        found["effortInto"] = str(bond.effort_into)
    if bond.is_gone:
        found["gone"] = True
    return found
