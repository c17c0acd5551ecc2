"""Plain data as JSON can hold it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

Json = Any


def finite(data: Json) -> Json:
    """The data with null in place of numbers that JSON cannot hold."""
    match data:
        case float():
            return data if math.isfinite(data) else None
        case Mapping():
            return {key: finite(value) for key, value in data.items()}
        case list():
            return [finite(value) for value in data]
        case _:
            return data
