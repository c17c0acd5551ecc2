"""Models along a ranking: what is least important goes first, then the next as well."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propermodel.modelling.model import Removal
from propermodel.reduction.methods.workbench import SizedModel, Workbench

MOST_SIZES = 60  # of one curve


def models_along(bench: Workbench, order: Sequence[tuple[Removal, ...]]) -> tuple[SizedModel, ...]:
    """The full model, and what is left after the first removals of an order, evenly over its length if it is long."""
    counts = np.unique(np.linspace(0, len(order), min(len(order), MOST_SIZES) + 1).astype(int))
    found: list[SizedModel] = []
    for count in counts:
        gone = [removal for some in order[:count] for removal in some]
        found.append(bench.measure(gone))
    return tuple(found)
