"""Modes of a linear model: how its small deviations decay, oscillate or grow, and who takes part."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from propermodel.analysis.spectrum import ComplexArray, Root, roots_of
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path

if TYPE_CHECKING:
    from propermodel.analysis.linear_model import LinearModel

LEAST_SHARE = 1e-9  # smaller participations are rounding and are not listed
MOST_NAMED = 3  # participants in a printed row


@dataclass(frozen=True, eq=False, kw_only=True)
class Mode:
    """One way in which small deviations change by themselves: exp(eigenvalue t), or a decaying oscillation.

    Participations are shares, largest first, whose absolute values add up to 1. That of the states is without
    dimension and does not depend on units (Perez-Arriaga, Verghese and Schweppe (1982), IEEE Trans. PAS-101, 3117).
    That of elements comes from energy: `energy` is the share of each storage in the energy of the mode, `dissipation`
    that of each resistance in its losses, negative where the element feeds the mode; both are means over a cycle.
    """

    eigenvalue: complex  # 1/s; the upper one of a conjugate pair
    multiplicity: int
    shape: ComplexArray  # an eigenvector, in the order of the states of the model, length 1
    states: Mapping[Path, float]
    energy: Mapping[Path, float]
    dissipation: Mapping[Path, float]

    @property
    def is_oscillation(self) -> bool:
        """Whether it oscillates: it is a conjugate pair."""
        return self.eigenvalue.imag > 0.0

    @property
    def frequency(self) -> float:
        """The frequency of its oscillation, Hz; 0 if it does not oscillate."""
        return self.eigenvalue.imag / (2.0 * math.pi)

    @property
    def natural_frequency(self) -> float:
        """What the frequency would be without damping, Hz."""
        return abs(self.eigenvalue) / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """The damping as a share of the critical one: 1 decays without oscillation, 0 stays, negative grows."""
        return (0.0 - self.eigenvalue.real) / abs(self.eigenvalue) if self.eigenvalue else 0.0

    @property
    def time_constant(self) -> float:
        """The time in which it decays by the factor e, s; infinite if it stays, negative if it grows."""
        return -1.0 / self.eigenvalue.real if self.eigenvalue.real else math.inf


@dataclass(frozen=True)
class Modes:
    """All modes of a linear model, slowest first."""

    name: str
    modes: tuple[Mode, ...]

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[Mode]:
        return iter(self.modes)

    def __getitem__(self, index: int) -> Mode:
        return self.modes[index]

    def __str__(self) -> str:
        header = ("frequency Hz", "damping", "time constant s", "", "states")
        rows = [
            (
                f"{mode.frequency:.6g}",
                f"{mode.damping_ratio:.4g}",
                f"{mode.time_constant:.4g}",
                f"x{mode.multiplicity}" if mode.multiplicity > 1 else "",
                ", ".join(f"{path} {100.0 * share:.0f} %" for path, share in tuple(mode.states.items())[:MOST_NAMED]),
            )
            for mode in self.modes
        ]
        table = [header, *rows]
        widths = [max(len(row[column]) for row in table) for column in range(4)]
        return "\n".join(
            [
                f"modes of {self.name}",
                *(
                    "  ".join(("", *(f"{text:>{width}}" for text, width in zip(row, widths, strict=False)), row[4]))
                    for row in table
                ),
            ]
        )


def modes_of(model: LinearModel) -> Modes:
    """The modes of a linear model, conjugate eigenvalues as one, slowest first."""
    return Modes(model.name, tuple(_mode(model, root) for root in roots_of(model.A)))


def _mode(model: LinearModel, root: Root) -> Mode:
    elements = model.elements
    power = 0.5 * np.real(np.conj(elements.efforts @ root.vector) * (elements.others @ root.vector))
    stored = np.array(elements.is_storage, dtype=np.bool_)
    lost = np.where(stored, 0.0, power)
    is_rounding = np.sum(np.abs(lost)) <= root.uncertainty * np.sum(np.abs(power[stored]))
    return Mode(
        eigenvalue=root.value,
        multiplicity=root.multiplicity,
        shape=root.vector,
        states=_shares(model.states, np.abs(root.shares)),
        energy=_shares(elements.paths, np.where(stored, power, 0.0)),
        dissipation=_shares(elements.paths, lost * (not is_rounding)),
    )


def _shares(paths: Iterable[Path], parts: FloatArray) -> Mapping[Path, float]:
    """The share of each path, its parts added, in the sum of all sizes."""
    sums: dict[Path, float] = {}
    for path, part in zip(paths, parts.tolist(), strict=True):
        sums[path] = sums.get(path, 0.0) + part
    total = sum(map(abs, sums.values()))
    if total == 0.0:
        return MappingProxyType({})
    shares = {path: part / total for path, part in sums.items() if abs(part) > LEAST_SHARE * total}
    return MappingProxyType(dict(sorted(shares.items(), key=lambda item: -abs(item[1]))))
