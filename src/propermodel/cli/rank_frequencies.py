"""`propermodel rank MODEL --frequencies FROM:TO`: activity from frequency responses, without simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from propermodel.cli.faults import CommandError

if TYPE_CHECKING:
    from propermodel.analysis.frequency_ranking import Density
    from propermodel.analysis.ranking import ActivityRanking
    from propermodel.compiler import CompiledModel
    from propermodel.diagnostics import Path
    from propermodel.expressions.core import Expr
    from propermodel.modelling.model import Scenario
    from propermodel.simulation.equilibrium import Equilibrium

COUNT = 60


def rank_between(
    compiled: CompiledModel, at: Scenario | Equilibrium, frequencies: str, inputs: list[str] | None
) -> ActivityRanking:
    """The ranking over frequencies in Hz, `0.1:30` or `0.1:30:100`, under inputs that may name their spectral density.

    Raises:
        CommandError: the frequencies or a density are no numbers.
        ReductionError: they cannot be ranked.
    """
    import numpy as np

    from propermodel.analysis.frequency_ranking import rank_frequencies

    low, high, count = _parsed(frequencies)
    omega = 2.0 * np.pi * np.geomspace(low, high, count)
    spectrum: dict[Expr | Path | str, Density] = dict(_density(text) for text in inputs or () if "=" in text)
    chosen = [text.partition("=")[0] for text in inputs or ()] or None
    return rank_frequencies(compiled, at, omega, inputs=chosen, spectrum=spectrum or None)


def _parsed(text: str) -> tuple[float, float, int]:
    parts = text.split(":")
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2]) if len(parts) == 3 else COUNT
    except (ValueError, IndexError):
        raise _fault(text) from None
    if len(parts) > 3 or not (0.0 < low < high < float("inf") and 2 <= count <= 10_000):
        raise _fault(text)
    return low, high, count


def _fault(text: str) -> CommandError:
    return CommandError.of(
        "command/frequencies",
        f"'{text}' is no range of frequencies",
        help="give them in Hz, from above zero, with or without their number: --frequencies 0.1:30, or 0.1:30:100",
    )


def _density(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise CommandError.of(
            "command/frequencies",
            f"'{value}' is no spectral density of {name}",
            help="give a number in the square of the unit of the input per rad/s: --input road=0.01",
        ) from None
