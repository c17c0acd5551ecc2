"""A model as a script of Python that makes an equal one: one function for each definition, laws as formulas."""

from __future__ import annotations

import dataclasses
import re
import textwrap
from enum import Enum
from typing import cast

from propermodel.diagnostics import Path, Source
from propermodel.exchange.formulas import TAKEN, Formulas, expressions_in, identifier
from propermodel.expressions import core
from propermodel.expressions.core import Expr
from propermodel.modelling import domains
from propermodel.modelling import model as models
from propermodel.modelling.files import FileName, partial_file
from propermodel.modelling.model import Definition, Model
from propermodel.modelling.schema import check_text, malformed, path_text

WIDTH = 120

HEAD = '''"""A model as plain data, `model` below: change it here, and run it with `propermodel run FILE.py:model`."""
'''
PATHS = '''

def path(text: str) -> Path:
    """The path written with dots."""
    return parse_path(text)
'''


def to_python(model: Model) -> str:
    """A script of Python that makes a model equal to this one, removals included.

    It holds what a document holds, except for the files and lines where parts were declared.
    """
    script = _Script()
    for definition in _in_order(model.root.definition):
        script.define(definition)
    formulas = Formulas(expressions_in(model), script.names)
    body = _Printer(formulas, script.known).text(model, 0)
    text = "\n".join([*script.text, "", *formulas.lines, f"model = {body}", ""])
    return "\n".join([HEAD, *_imports(text), PATHS, text])


def write_python(model: Model, path: FileName) -> None:
    """Write a script of Python that makes a model equal to this one."""
    partial = partial_file(path)
    partial.write_text(to_python(model), encoding="utf-8", newline="\n")
    partial.replace(path)


def _imports(text: str) -> list[str]:
    """The imports of what a script uses."""
    used = set(re.findall(r"\b[A-Za-z]\w*", text))
    lines = ["from math import inf", ""] if "inf" in used else []
    lines.append("from propermodel.diagnostics import Path, parse_path")
    for module in (core, domains, models):
        own = {name for name, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__}
        names = sorted(own & used, key=lambda name: (name[0].islower(), name))
        if names:
            listed = ", ".join(names)
            line = f"from {module.__name__} import {listed}"
            wrapped = "\n".join(["(", *(f"    {name}," for name in names), ")"])
            lines.append(line if len(line) < WIDTH else f"from {module.__name__} import {wrapped}")
    return lines


def _in_order(root: Definition) -> list[Definition]:
    """A definition after those it uses, each object once."""
    found: dict[int, Definition] = {}
    stack = [root]
    while stack:
        definition = stack[-1]
        inner = [part.definition for part in definition.parts if id(part.definition) not in found]
        if id(definition) in found:
            stack.pop()
        elif inner:
            stack.extend(reversed(inner))
        else:
            found[id(definition)] = definition
            stack.pop()
    return list(found.values())


class _Script:
    """The definitions written so far; equal ones, which are different objects, are written once."""

    def __init__(self) -> None:
        self.text: list[str] = []
        self.known: dict[int, str] = {}  # definition: its variable
        self.names: set[str] = {*TAKEN, "model", *_own_names()}
        self._by_body: dict[str, str] = {}

    def define(self, definition: Definition) -> None:
        """Write the function that makes a definition."""
        formulas = Formulas(expressions_in(definition), self.names)
        printed = _Printer(formulas, self.known).text(definition, 1)
        body = "\n".join(f"    {line}" for line in (*formulas.lines, f"return {printed}"))
        if body not in self._by_body:
            name = identifier(_snake(definition.type_name), self.names)
            variable = identifier(name, self.names).upper()
            while variable in self.names:
                variable += "_"
            self.names.update((name, variable))
            self._by_body[body] = variable
            self.text.append(f"\ndef {name}() -> Definition:\n{body}\n\n\n{variable} = {name}()\n")
        self.known[id(definition)] = self._by_body[body]


def _own_names() -> set[str]:
    return {name for module in (core, domains, models) for name in vars(module)}


def _snake(text: str) -> str:
    return "".join(f"_{c}" if c.isupper() and k and not text[k - 1].isupper() else c for k, c in enumerate(text))


class _Printer:
    """Plain data as calls that make it."""

    def __init__(self, formulas: Formulas, definitions: dict[int, str]) -> None:
        self._formulas = formulas
        self._definitions = definitions

    def text(self, value: object, depth: int) -> str:
        """A value; what does not fit in a line takes one for each of its parts."""
        match value:
            case Expr():
                return self._formulas(value)
            case Path():
                return f"path({path_text(value)!r})"
            case Enum():
                return f"{type(value).__name__}.{value.name}"
            case Definition() if id(value) in self._definitions:
                return self._definitions[id(value)]
            case tuple() if value and all(type(item) is float for item in cast("tuple[object, ...]", value)):
                return self._numbers(cast("tuple[float, ...]", value), depth)
            case tuple():
                items = [self.text(item, depth + 1) for item in cast("tuple[object, ...]", value)]
                return _joined("(", items, ")", depth, is_tuple=True)
            case str():
                return repr(check_text(value, lambda message: malformed("the model", message)))
            case float():
                return repr(value)  # inf stands for itself, as the script imports it
            case bool() | int() | None:
                return repr(value)
            case _ if dataclasses.is_dataclass(value):
                fields = [field for field in dataclasses.fields(value) if _is_written(value, field)]
                items = [f"{field.name}={self.text(getattr(value, field.name), depth + 1)}" for field in fields]
                return _joined(f"{type(value).__name__}(", items, ")", depth)
            case _:
                raise malformed("the model", f"a script cannot hold a {type(value).__name__}")

    @staticmethod
    def _numbers(values: tuple[float, ...], depth: int) -> str:
        """Many numbers to a line."""
        line = f"({', '.join(map(repr, values))},)"
        if len(line) + 4 * depth < WIDTH:
            return line
        space = "    " * (depth + 1)
        rows = textwrap.wrap(line[1:-1], WIDTH, initial_indent=space, subsequent_indent=space)
        return "\n".join(["(", *rows, f"{'    ' * depth})"])


def _is_written(value: object, field: dataclasses.Field[object]) -> bool:
    item = getattr(value, field.name)
    if isinstance(item, Source):
        return False
    if field.default_factory is not dataclasses.MISSING:
        return item != field.default_factory()
    return field.default is dataclasses.MISSING or item != field.default


def _joined(head: str, items: list[str], tail: str, depth: int, *, is_tuple: bool = False) -> str:
    comma = "," if is_tuple and len(items) == 1 else ""
    line = f"{head}{', '.join(items)}{comma}{tail}"
    if "\n" not in line and len(line) + 4 * depth < WIDTH:
        return line
    space = "    " * (depth + 1)
    return "\n".join([head, *(f"{space}{item}," for item in items), f"{'    ' * depth}{tail}"])
