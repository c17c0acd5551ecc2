# pyright: basic
"""Adds powers to their integrals where they are computed, in a copy of `rates` that stores no powers.

The numbers of a large model come from the second cache of the processor, and every third would be a power that is
written only to be read once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from propermodel.codegen.llvm_text import Frame, Text
from propermodel.codegen.machine import Method
from propermodel.codegen.program import Array

ADDING = "rates.adding"  # the function
SHARE = "share"  # region of one row: the time that an evaluation stands for
METHODS = frozenset({Method.EULER, Method.SEMI_IMPLICIT, Method.RK4})  # that add every evaluation of powers at once


@dataclass(frozen=True)
class Sums:
    """Where integrals are, and how a power is added to them."""

    frame: Frame

    def takes(self, row: int) -> bool:
        """Whether a row is that of a power."""
        return self.frame.is_in(Array.POWER, row)

    def share(self, text: Text) -> str:
        """The time that the evaluation stands for."""
        return text.load_row(self.frame.regions[SHARE])

    def add(self, text: Text, energy: str, load: Callable[[int], str], store: Callable[[int, str], None]) -> None:
        """Add an energy to both integrals, which are so many rows away from the power."""
        to_integral, to_activity = (
            self.frame.regions[region] - self.frame.regions[Array.POWER] for region in ("integral", "activity")
        )
        store(to_integral, text.add(load(to_integral), energy))
        store(to_activity, text.add(load(to_activity), text.size(energy)))
