"""What a reduction does to the modes of a model: which it loses, which become unstable, and how stiff it is then."""

from __future__ import annotations

import math
from dataclasses import dataclass

from propermodel.analysis.linear_model import LinearModel
from propermodel.analysis.modes import Mode
from propermodel.diagnostics import Path

LIGHT = 0.1  # damping ratio below which a mode is lightly damped
NEAR = 0.3  # of the size of an eigenvalue: within it another one is its counterpart
STIFFER = 1.05  # times the largest eigenvalue of the full model
GROWTH = 0.3  # of a mode in the window, as a logarithm, from which on it counts as growing


@dataclass(frozen=True, slots=True)
class Spectrum:
    """The eigenvalues of a linear model in four numbers."""

    order: int
    radius: float  # the size of the largest eigenvalue, 1/s
    slowest: float  # the size of the smallest that is not zero, 1/s
    unstable: int  # eigenvalues with a positive real part

    @property
    def stiffness(self) -> float:
        """The largest eigenvalue over the smallest that is not zero."""
        return self.radius / self.slowest if self.slowest else 1.0


@dataclass(frozen=True, slots=True)
class CriticalMode:
    """A mode that grows, or oscillates with little damping, and the state that has the largest part in it."""

    real: float  # 1/s
    imaginary: float  # rad/s
    state: Path

    @property
    def nature(self) -> str:
        """What is critical about it."""
        return "unstable" if self.real > 0.0 else "lightly damped"

    def __str__(self) -> str:
        size = math.hypot(self.real, self.imaginary)
        rate = (
            f"{size / (2.0 * math.pi):.3g} Hz with the damping {-self.real / size:.2g}"
            if self.imaginary
            else f"growing as exp({self.real:.3g} t)"
        )
        return f"{self.nature} mode of {self.state} ({rate})"


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectralChange:
    """The modes of a full and a reduced model near the same instant of a run.

    `lost` are critical modes of the full model without a counterpart; `gained` unstable ones that only the reduced
    model has. What neither turns nor grows noticeably within the window is a slow drift, of which the run says
    nothing: it is not critical.
    """

    time: float
    full: Spectrum
    reduced: Spectrum
    lost: tuple[CriticalMode, ...]
    gained: tuple[CriticalMode, ...]

    @property
    def is_stiffer(self) -> bool:
        """Whether the reduced model has a faster mode than the full one, so that it may need shorter steps."""
        return self.reduced.radius > STIFFER * self.full.radius


def spectral_change(full: LinearModel, reduced: LinearModel, window: float) -> SpectralChange:
    """Compare the modes of two linear models.

    Args:
        full: The full model.
        reduced: The reduced one, near the same instant.
        window: Length of the run, s.
    """
    before, after = tuple(full.modes()), tuple(reduced.modes())
    return SpectralChange(
        time=full.point.time,
        full=_spectrum(before),
        reduced=_spectrum(after),
        lost=_without_counterpart([m for m in before if _grows(m, window) or _swings(m, window)], after),
        gained=_without_counterpart([m for m in after if _grows(m, window)], before),
    )


def _spectrum(modes: tuple[Mode, ...]) -> Spectrum:
    counts = [mode.multiplicity * (2 if mode.is_oscillation else 1) for mode in modes]
    sizes = [abs(mode.eigenvalue) for mode in modes if mode.eigenvalue]
    return Spectrum(
        order=sum(counts),
        radius=max(sizes, default=0.0),
        slowest=min(sizes, default=0.0),
        unstable=sum(count for count, mode in zip(counts, modes, strict=True) if _is_unstable(mode)),
    )


def _is_unstable(mode: Mode) -> bool:
    return mode.eigenvalue.real > 0.0


def _grows(mode: Mode, window: float) -> bool:
    """Whether it has grown noticeably by the end of the window."""
    return mode.eigenvalue.real * window > GROWTH


def _swings(mode: Mode, window: float) -> bool:
    """Whether it is an oscillation with little damping, fast enough to be seen in the window."""
    is_light = mode.is_oscillation and mode.damping_ratio < LIGHT
    return is_light and abs(mode.eigenvalue) * window > 1.0


def _without_counterpart(modes: list[Mode], others: tuple[Mode, ...]) -> tuple[CriticalMode, ...]:
    """The modes to which no other is near; every other mode is the counterpart of one at most, the nearest first."""
    pairs = sorted(
        (distance, i, k)
        for i, mode in enumerate(modes)
        for k, other in enumerate(others)
        if (distance := abs(other.eigenvalue - mode.eigenvalue)) <= NEAR * abs(mode.eigenvalue)
        and _is_unstable(other) == _is_unstable(mode)
    )
    met: dict[int, int] = {}
    for _, i, k in pairs:
        if i not in met and k not in met.values():
            met[i] = k
    return tuple(
        CriticalMode(mode.eigenvalue.real, mode.eigenvalue.imag, next(iter(mode.states), Path()))
        for i, mode in enumerate(modes)
        if i not in met
    )
