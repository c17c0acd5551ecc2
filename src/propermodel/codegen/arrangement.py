"""Where the numbers of printed code are: what runs it needs to know, and all that is known where it is not printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from propermodel.codegen.machine import IntArray
from propermodel.codegen.program import Array


@dataclass(frozen=True)
class Printing:
    """How functions are printed.

    In pieces of about `most_instructions`: LLVM's time grows faster than their length, and much shorter ones cost
    speed. From `loops_from` operations and stores on, what is repeated is printed as loops, by which shorter functions
    gain little.
    """

    most_instructions: int = 300
    loops_from: int = 400


PRINTING = Printing()


@dataclass(frozen=True, eq=False)
class Arrangement:
    """Where numbers are in the block of a run: where regions begin, and the rows of states and powers in theirs."""

    lanes: int
    rows: int
    regions: Mapping[str, int]
    lengths: Mapping[Array, int]
    state_rows: IntArray
    power_rows: IntArray

    def to_json(self) -> dict[str, object]:
        """Plain data, from which `from_json` makes the same."""
        return {
            "lanes": self.lanes,
            "rows": self.rows,
            "regions": dict(self.regions),
            "lengths": dict(self.lengths),
            "state_rows": self.state_rows.tolist(),
            "power_rows": self.power_rows.tolist(),
        }

    @staticmethod
    def from_json(data: Mapping[str, Any]) -> Arrangement:
        """What `to_json` has told."""
        states, powers = (np.array(data[name], dtype=np.int64) for name in ("state_rows", "power_rows"))
        lengths = {Array(name): length for name, length in data["lengths"].items()}
        return Arrangement(data["lanes"], data["rows"], data["regions"], lengths, states, powers)
