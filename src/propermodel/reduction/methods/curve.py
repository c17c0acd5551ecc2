"""What every method gives: models of falling size with the error that was measured for each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from propermodel.reduction.methods.workbench import SizedModel, Workbench


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """The models of one method, the largest first.

    `chosen` is the one that the method itself would take, by its own rule; `not_applied` says why a method has nothing
    to say of this model.
    """

    method: str
    source: str  # whose method it is
    models: tuple[SizedModel, ...] = ()
    chosen: SizedModel | None = None
    rule: str = ""  # by which it was chosen
    simulations: int = 0
    not_applied: str = ""
    notes: tuple[str, ...] = ()

    def smallest_within(self, tolerance: float) -> SizedModel | None:
        """The smallest model whose error is within a tolerance, in rows or, without rows, in states."""
        within = [model for model in self.models if model.error <= tolerance]
        return min(
            within,
            key=lambda m: (m.states if m.rows is None else m.rows, m.states, m.error),
            default=None,
        )


MethodOfOthers = Callable[[Workbench], Curve]
