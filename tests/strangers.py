"""What strangers make of honest files: documents with changed structure, files with damaged bytes."""

from __future__ import annotations

import copy
from typing import Any

from hypothesis import strategies as st


@st.composite
def damaged_bytes(draw: st.DrawFn, original: bytes) -> bytes:
    """A file with bytes that are changed, lost, put in or doubled, or that is cut off."""
    data = bytearray(original)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        length = draw(st.integers(1, 64))
        match draw(st.sampled_from(["flip", "write", "delete", "insert", "double", "cut"])):
            case "flip" if at < len(data):
                data[at] ^= 1 << draw(st.integers(0, 7))
            case "write":
                data[at : at + length] = draw(st.binary(min_size=length, max_size=length))
            case "delete":
                del data[at : at + length]
            case "insert":
                data[at:at] = draw(st.binary(max_size=length))
            case "double":
                data[at:at] = data[at : at + length]
            case _:
                del data[at:]
    return bytes(data)


JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 60),
    st.sampled_from([1e308, -1e308, 5e-324, -0.0, 0.5, "inf", "-inf", 10**400, -(2**63), 2**63]),
    st.text(max_size=4),
    st.sampled_from(["effort", "flow", "port", "mass", "flange", "N", "m/s", "R", "C", "Se", "0", "1", "constant"]),
    st.sampled_from(["a.b", "..", "\x1b[2J", "\ud800", "x" * 1001, "m" * 64, "km9999", "((((m))))", "1/0"]),
    st.lists(st.integers(0, 9), max_size=3),
    st.dictionaries(st.sampled_from(["type", "name", "value", "ports"]), st.integers(0, 3), max_size=2),
)
# What is `like` keeps the form of a document, so that deeper checks are met.
ACTIONS = ("like", "like", "like", "like", "change", "delete", "double", "swap", "retype", "extreme")


def places(value: Any) -> list[tuple[Any, ...]]:
    """Every place in a document, as keys and indices from the top."""
    found: list[tuple[Any, ...]] = []
    stack: list[tuple[tuple[Any, ...], Any]] = [((), value)]
    while stack:
        at, item = stack.pop()
        if at:
            found.append(at)
        items = item.items() if isinstance(item, dict) else enumerate(item) if isinstance(item, list) else ()
        stack.extend(((*at, key), inner) for key, inner in items)
    return found


def form(place: tuple[Any, ...]) -> tuple[Any, ...]:
    """What a place is in the format, whichever entry of a list it is in."""
    *above, last = place
    return (*("#" if isinstance(key, int) else key for key in above), last)


def at(document: Any, place: tuple[Any, ...]) -> Any:
    """What stands at a place."""
    for key in place:
        document = document[key]
    return document


def retyped(value: Any) -> Any:
    """The same as another type of JSON."""
    match value:
        case bool():
            return str(value)
        case int() | float():
            return str(value)
        case str():
            return [value]
        case list():
            return {str(index): item for index, item in enumerate(value)}
        case dict():
            return list(value.values())
        case _:
            return 0


def extreme(value: Any) -> Any:
    """The same, but far too large."""
    match value:
        case bool() | None:
            return 10**30
        case int() | float():
            return value * 1e300 + 1e300 if value >= 0 else -(10**400)
        case str():
            return value * 1000 or "x" * 1000
        case list():
            return value * 50
        case _:
            return {f"{key}{number}": item for key, item in value.items() for number in range(20)}


@st.composite
def changed_documents(draw: st.DrawFn, original: Any) -> Any:
    """A document with up to four places where something is changed, lost, doubled, exchanged, retyped or enormous."""
    document = copy.deepcopy(original)
    known = places(original)
    alike: dict[tuple[Any, ...], list[tuple[Any, ...]]] = {}
    for place in known:
        alike.setdefault(form(place), []).append(place)
    # Each form alike: most places of a document are nodes of its expressions.
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.sampled_from(alike[draw(st.sampled_from(list(alike)))]))
        action = draw(st.sampled_from(ACTIONS))
        other = draw(st.sampled_from(alike[form(place)] if action == "like" else known))
        junk = draw(JUNK) if action == "change" else None
        try:
            parent, key = at(document, place[:-1]), place[-1]
            old = parent[key]
            if action == "delete":
                del parent[key]
            elif action == "double" and isinstance(parent, list):
                parent.insert(key, copy.deepcopy(old))
            elif action == "double":
                parent[f"{key}_"] = copy.deepcopy(old)
            else:
                new = {
                    "change": lambda junk=junk: junk,
                    "swap": lambda other=other: copy.deepcopy(at(original, other)),
                    "like": lambda other=other: copy.deepcopy(at(original, other)),
                    "retype": lambda old=old: retyped(old),
                    "extreme": lambda old=old: extreme(old),
                }[action]()
                parent[key] = new
        except (KeyError, IndexError, TypeError):
            continue  # an earlier change has taken this place away
    return document
