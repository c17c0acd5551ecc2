"""The types of TypeScript that data are declared with, read from its sources, and whether data are of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Json = Any
Type = tuple[Any, ...]

_TOKEN = re.compile(r'\s*(=>|"[^"]*"|[\w$]+|[{}()\[\]<>|?:;,=])')
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_PLAIN = {"string": str, "number": (int, float), "boolean": bool}


def types_in(*files: Path) -> dict[str, Type]:
    """The interfaces and type aliases that files export."""
    found: dict[str, Type] = {}
    for file in files:
        text = _COMMENT.sub("", file.read_text(encoding="utf-8"))
        for match in re.finditer(r"export interface (\w+)(?: extends (\w+))? (?=\{)", text):
            own = _Reader(text, match.end()).type()
            found[match[1]] = own if match[2] is None else ("both", ("name", match[2], ()), own)
        for match in re.finditer(r"export type (\w+) =(?=[^>])", text):
            found[match[1]] = _Reader(text, match.end()).type()
    return found


@dataclass
class _Reader:
    """Reads one type."""

    text: str
    place: int

    def peek(self) -> str:
        match = _TOKEN.match(self.text, self.place)
        return "" if match is None else match[1]

    def take(self, wanted: str = "") -> str:
        match = _TOKEN.match(self.text, self.place)
        assert match is not None, self.text[self.place : self.place + 60]
        assert not wanted or match[1] == wanted, (wanted, self.text[self.place : self.place + 60])
        self.place = match.end()
        return match[1]

    def type(self) -> Type:
        if self.peek() == "|":
            self.take()
        members = [self.array()]
        while self.peek() == "|":
            self.take()
            members.append(self.array())
        return members[0] if len(members) == 1 else ("union", *members)

    def array(self) -> Type:
        found = self.primary()
        while self.peek() == "[":
            self.take("[")
            self.take("]")
            found = ("array", found)
        return found

    def primary(self) -> Type:
        token = self.take()
        match token:
            case "readonly":
                return self.array()
            case "(":
                found = self.type()
                self.take(")")
                return found
            case "[":
                return ("tuple", *self.several("]"))
            case "{":
                return ("object", self.members())
        if token.startswith('"') or token.isdigit():
            return ("literal", int(token) if token.isdigit() else token[1:-1])
        arguments: tuple[Type, ...] = ()
        if self.peek() == "<":
            self.take()
            arguments = self.several(">")
        return ("name", token, arguments)

    def several(self, end: str) -> tuple[Type, ...]:
        found = [self.type()]
        while self.peek() == ",":
            self.take()
            found.append(self.type())
        self.take(end)
        return tuple(found)

    def members(self) -> dict[str, tuple[bool, Type]]:
        found: dict[str, tuple[bool, Type]] = {}
        while self.peek() != "}":
            name = self.take()
            if name == "readonly":
                name = self.take()
            is_optional = self.peek() == "?"
            if is_optional:
                self.take()
            self.take(":")
            found[name] = (is_optional, self.type())
            if self.peek() == ";":
                self.take()
        self.take("}")
        return found


def misfits(value: Json, kind: Type, known: Mapping[str, Type], place: str = "") -> list[str]:
    """Where a value is not of a type, in words; entries that the type does not have are no matter."""
    match kind:
        case ("name", "string" | "number" | "boolean" as name, _):
            is_right = isinstance(value, _PLAIN[name]) and (name == "boolean" or not isinstance(value, bool))
            return [] if is_right else [f"{place}: {value!r:.60} is no {name}"]
        case ("name", "null", _):
            return [] if value is None else [f"{place}: {value!r:.60} is not null"]
        case ("name", "Readonly", (inner,)):
            return misfits(value, inner, known, place)
        case ("name", "Record", (_, inner)):
            return _object(value, dict.fromkeys(value, (False, inner)), known, place)
        case ("name", name, _):
            return misfits(value, known[name], known, place)
        case ("literal", expected):
            return [] if value == expected else [f"{place}: {value!r:.60} is not {expected!r}"]
        case ("union", *members):
            found = [misfits(value, member, known, place) for member in members]
            return [] if [] in found else min(found, key=len)
        case ("array", inner):
            if not isinstance(value, list):
                return [f"{place}: {value!r:.60} is no list"]
            return [fault for n, item in enumerate(value) for fault in misfits(item, inner, known, f"{place}[{n}]")]
        case ("tuple", *members):
            if not isinstance(value, list) or len(value) != len(members):
                return [f"{place}: {value!r:.60} is no list of {len(members)}"]
            pairs = enumerate(zip(value, members, strict=True))
            return [fault for n, (item, each) in pairs for fault in misfits(item, each, known, f"{place}[{n}]")]
        case ("both", *members):
            return [fault for member in members for fault in misfits(value, member, known, place)]
        case ("object", members):
            return _object(value, members, known, place)
    raise TypeError(kind)


def _object(value: Json, members: Mapping[str, tuple[bool, Type]], known: Mapping[str, Type], place: str) -> list[str]:
    if not isinstance(value, dict):
        return [f"{place}: {value!r:.60} is no object"]
    found: list[str] = []
    for name, (is_optional, inner) in members.items():
        if name in value:
            found += misfits(value[name], inner, known, f"{place}.{name}")
        elif not is_optional:
            found.append(f"{place}: there is no '{name}'")
    return found
