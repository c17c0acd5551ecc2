"""Leaves that stand for something of a component while its class body is being written.

A leaf knows the object it hangs on (a part, a port, a parameter: names come later, from the class body) and
the path below it; elaboration turns it into a symbol with a path.
"""

from __future__ import annotations

from typing import Any

from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr, Op, Symbol, SymbolKind, intern_node


class Reference(Symbol):
    """A symbol relative to an object that has no name yet."""

    __slots__ = ("root",)

    def __init__(self, kind: SymbolKind, root: object, path: Path, unit: str) -> None:
        super().__init__(kind, path, unit)
        self.root = root

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Reference) and self.root is other.root and super().__eq__(other)

    def __hash__(self) -> int:
        return hash((id(self.root), self.kind, self.path))


def reference(kind: SymbolKind, root: object, path: Path, unit: str) -> Expr:
    """The leaf for something below an object."""
    return intern_node(Op.SYMBOL, (), Reference(kind, root, path, unit))


class Declared(Expr):
    """A leaf with its own identity: two `parameter("kg")` are two parameters, also before they have names."""

    __slots__ = ()

    def __init__(self, kind: SymbolKind, unit: str) -> None:
        object.__setattr__(self, "op", Op.SYMBOL)
        object.__setattr__(self, "args", ())
        object.__setattr__(self, "data", Reference(kind, self, Path(), unit))

    @property
    def unit(self) -> str:
        """The unit it is declared in."""
        return self.data.unit

    def view(self, owner: Any, name: str) -> Expr:
        """The leaf seen from an instance of the component that declares it."""
        return reference(self.data.kind, owner.root, owner.path / name, self.unit)
