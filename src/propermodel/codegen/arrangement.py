"""Where the numbers of printed code are: what runs it needs to know, and all that is known where it is not printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.machine import IntArray
from propermodel.codegen.program import Array

# Of a piece of a function, about: LLVM's time grows faster than its length; much shorter ones cost speed.
MOST_INSTRUCTIONS = 300


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Where numbers are in the block of a run: where regions begin, and the row of every state in its regions."""

    lanes: int
    rows: int
    regions: Mapping[str, int]
    lengths: Mapping[Array, int]
    state_rows: IntArray

    def to_json(self) -> dict[str, object]:
        """Plain data, from which `from_json` makes the same."""
        return {
            "lanes": self.lanes,
            "rows": self.rows,
            "regions": dict(self.regions),
            "lengths": dict(self.lengths),
            "state_rows": self.state_rows.tolist(),
        }

    @staticmethod
    def from_json(data: Mapping[str, Any]) -> Arrangement:
        """What `to_json` has told."""
        rows = np.array(data["state_rows"], dtype=np.int64)
        lengths = {Array(name): length for name, length in data["lengths"].items()}
        return Arrangement(data["lanes"], data["rows"], data["regions"], lengths, rows)
