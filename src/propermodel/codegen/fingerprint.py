"""A digest of a program: equal for programs of equal content, in every process and on every machine.

It follows the data classes field by field, so that a new field counts without being named here; a value of an unknown
type is refused rather than left out. Expressions are graphs: each node is written once and then called by its number.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

from propermodel.diagnostics import Path
from propermodel.expressions.core import Expr


def fingerprint(value: object) -> str:
    """The digest of frozen data classes, mappings, tuples, texts, numbers and expressions in them.

    Raises:
        TypeError: something inside has no content that could be compared between processes.
    """
    writer = _Writer()
    writer.write(value)
    return hashlib.sha256("".join(writer.parts).encode()).hexdigest()


class _Writer:
    """Everything written so far; every part begins with its kind and says how long it is or where it ends."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self._numbers: dict[Expr, int] = {}
        self._fields: dict[type, tuple[str, ...]] = {}

    def write(self, value: Any) -> None:
        writer = _WRITERS.get(type(value))
        if writer is not None:
            writer(self, value)
        elif isinstance(value, Enum):
            self.text(f"{type(value).__name__}.{value.name}")
        elif isinstance(value, Mapping):
            self.parts.append(f"map{len(value)}(")
            for key, item in value.items():
                self.write(key)
                self.write(item)
        elif is_dataclass(value):
            self.data_class(value)
        else:
            raise TypeError(f"{type(value).__name__} has no fingerprint")

    def data_class(self, value: Any) -> None:
        kind = type(value)
        names = self._fields.get(kind)
        if names is None:
            names = self._fields[kind] = tuple(field.name for field in fields(value))
        self.parts.append(f"{kind.__name__}{len(names)}(")
        for name in names:
            self.parts.append(f"{name}=")
            self.write(getattr(value, name))

    def items(self, value: tuple[Any, ...]) -> None:
        self.parts.append(f"{len(value)}(")
        for item in value:
            self.write(item)

    def text(self, value: str) -> None:
        self.parts.append(f"{len(value)}'{value}'")

    def atom(self, value: object) -> None:
        self.parts.append(f"{value!r};")

    def path(self, value: Path) -> None:
        self.text(str(value))

    def expression(self, root: Expr) -> None:
        numbers = self._numbers
        stack = [root]
        while stack:
            node = stack[-1]
            if node in numbers:
                stack.pop()
                continue
            missing = [arg for arg in node.args if arg not in numbers]
            if missing:
                stack.extend(reversed(missing))
                continue
            stack.pop()
            given = ",".join([str(numbers[arg]) for arg in node.args])
            data = "" if node.data is None else repr(node.data)
            self.parts.append(f"#{node.op.name}{len(data)}'{data}'{given};")
            numbers[node] = len(numbers)
        self.parts.append(f"@{numbers[root]};")


_WRITERS: dict[type, Callable[[_Writer, Any], None]] = {
    bool: _Writer.atom,
    int: _Writer.atom,
    float: _Writer.atom,
    type(None): _Writer.atom,
    str: _Writer.text,
    tuple: _Writer.items,
    Path: _Writer.path,
    Expr: _Writer.expression,
}
