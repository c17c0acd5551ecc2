"""JSON from strangers: its size is known before it is parsed, and nothing is said twice."""

from __future__ import annotations

import json
import re
from collections import Counter
from typing import Any

from propermodel.diagnostics import DocumentError
from propermodel.modelling.limits import Limits, exceeded

Json = Any

_CURE = "open a file that propermodel wrote, complete and unchanged"
_ESCAPE = re.compile(r"\\.", re.DOTALL)
_BRACKET = re.compile(r"[\[\]{}]")


def parse_json(data: bytes, limits: Limits) -> Json:
    """The value that JSON in UTF-8 holds; every entry of an object is given once, every number is a number.

    Raises:
        DocumentError: it is not JSON, goes beyond a limit, or has entries twice.
    """
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _no_json(f"the file is not text in UTF-8 (byte {error.start})") from None
    _check_amount(text, limits)
    _check_depth(text, limits)
    try:
        return json.loads(text, object_pairs_hook=_once, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise _no_json(f"the file is not JSON: {error.msg} in line {error.lineno}, column {error.colno}") from None
    except ValueError as error:  # a number with thousands of digits
        raise _no_json(f"the file is not JSON: {error}") from None


def _check_amount(text: str, limits: Limits) -> None:
    """Refuse too many values, or too many texts or names in paths for so many values.

    Every value follows a comma or opens a list or an object, has at most one name, and a number at most one dot.
    """
    values = max(1 + sum(map(text.count, ",[{")), text.count('"') // 4, text.count(".") // 2)
    if values > limits.values:
        raise exceeded("values", f"the document has up to {values} values; at most {limits.values} are read")


def _check_depth(text: str, limits: Limits) -> None:
    if text.count("[") + text.count("{") <= limits.depth:
        return
    without_escapes = _ESCAPE.sub("__", text) if "\\" in text else text
    depth = position = 0
    for number, piece in enumerate(without_escapes.split('"')):
        for bracket in _BRACKET.finditer(piece) if number % 2 == 0 else ():
            depth += 1 if bracket[0] in "[{" else -1
            if depth > limits.depth:
                line = text.count("\n", 0, position + bracket.start()) + 1
                raise exceeded("depth", f"more than {limits.depth} lists and objects in each other in line {line}")
        position += len(piece) + 1


def _once(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    found = dict(pairs)
    if len(found) < len(pairs):
        double = Counter(name for name, _ in pairs).most_common(1)[0][0]
        raise _no_json(f"the entry {double[:60]!r} is given twice in one object")
    return found


def _no_constant(text: str) -> float:
    raise DocumentError.of(
        "document/json", f"'{text}' is not a number of JSON", help='infinities are written as "inf" and "-inf"'
    )


def _no_json(message: str) -> DocumentError:
    return DocumentError.of("document/json", message, help=_CURE)
