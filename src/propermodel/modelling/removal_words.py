"""Removals in words."""

from __future__ import annotations

from propermodel.modelling.model import (
    ConstantEffort,
    ConstantFlow,
    Cut,
    Freeze,
    Merge,
    Prescribe,
    Removal,
    ZeroEffort,
    ZeroFlow,
)


def removal_text(removal: Removal) -> str:
    """A removal in words."""
    match removal:
        case ZeroEffort(bond):
            return f"no effort at {bond}"
        case ZeroFlow(bond):
            return f"no flow at {bond}"
        case ConstantEffort(bond, value):
            return f"constant effort {value:.6g} at {bond}"
        case ConstantFlow(bond, value):
            return f"constant flow {value:.6g} at {bond}"
        case Cut(bond, driven):
            return f"one-way cut at {bond}, which receives the {driven}"
        case Merge(bond, into):
            return f"{bond} merged into {into}"
        case Prescribe(bond, driven):
            return f"driven at {bond} by the input {bond}.{driven}"
        case Freeze(signal, value):
            return f"signal {signal} frozen at {value:.6g}"
