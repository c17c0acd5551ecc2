"""Which ports are one node: connections join them, and a port named in two connections joins both."""

from __future__ import annotations

from propermodel.diagnostics import Path


class Nodes:
    """Ports in disjoint sets, each named after its port nearest the root."""

    def __init__(self) -> None:
        self._parent: dict[Path, Path] = {}
        self._size: dict[Path, int] = {}

    def add(self, port: Path) -> None:
        """A port that is a node of its own until it is joined."""
        if port not in self._parent:
            self._parent[port] = port
            self._size[port] = 1

    def find(self, port: Path) -> Path:
        """The name of the node that a port belongs to."""
        parent = self._parent
        while parent[port] != port:
            parent[port] = parent[parent[port]]
            port = parent[port]
        return port

    def join(self, a: Path, b: Path) -> None:
        """Make two nodes one."""
        a, b = self.find(a), self.find(b)
        if a != b:
            keep, gone = (a, b) if (len(a), a) <= (len(b), b) else (b, a)
            self._parent[gone] = keep
            self._size[keep] += self._size[gone]

    def is_shared(self, port: Path) -> bool:
        """Whether the node of a port has other ports."""
        return self._size[self.find(port)] > 1
