"""Leaves that stand for something of a component while its class body is being written.

A leaf knows the object it hangs on (a part, a port, a parameter: names come later, from the class body) and
the path below it; elaboration turns it into a symbol with a path.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from propermodel.diagnostics import Path, Source, UnknownNameError, one_of, portable_file
from propermodel.expressions.core import Expr, Op, Symbol, SymbolKind, intern_node


def call_site(depth: int) -> Source:
    """The file and line of the author, `depth` frames above the caller."""
    frame = sys._getframe(depth + 1)  # pyright: ignore[reportPrivateUsage]
    return Source(portable_file(frame.f_code.co_filename), frame.f_lineno)


def unknown_name(owner: str, name: str, known: Iterable[str]) -> AttributeError:
    """The error for a name that a component or port does not have; Python's own look-ups get Python's own."""
    if name.startswith("_"):
        return AttributeError(f"{owner} has no attribute '{name}'")
    return UnknownNameError.of(
        "model/unknown-name", f"{owner} has no '{name}'", source=call_site(2), help=one_of(name, known)
    )


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
