"""What was recorded, as few lines of a spectrum: enough to predict the size of any linear answer to it.

Signals count with the weight exp(-t / t_c), t_c half the length of the run (the line Re s = 2 / T), which makes the
window end gently; by Parseval's theorem the weighted mean square of an answer is a sum over frequencies. The lines with
most energy stand for themselves; the others are gathered in bands in which an answer's gain is nearly constant, and a
band is as many lines as the signals in it are independent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray

ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]

MOST_INSTANTS = 1 << 15
SINGLE_LINES = 100  # lines with most energy
SHARED_BANDS = 40  # of all others, equally wide on a logarithmic scale
MOST_PER_BAND = 2
FEWER = 0.5  # lines and bands for every operating point where there are several
_NEGLIGIBLE = 1e-6  # the share of a band's energy at which a further line of it is left out
_ABSENT = 1e-6  # the share of a line's energy at which an operating point has no part in it


@dataclass(frozen=True, eq=False)
class Spectra:
    """Terms (first axis): s, the operating point, and the amplitude of every signal and, last, of the constant 1.

    Terms of one line, which differ in their operating points, add up. Amplitudes are scaled so that the sum over all
    lines of the squares of a signal's is its mean square, weighted as above.
    """

    s: ComplexArray
    point: IntArray
    line: IntArray  # rising
    amplitudes: ComplexArray  # (terms, signals + 1)


def spectra(time: FloatArray, signals: Sequence[FloatArray], points: IntArray | None = None) -> Spectra:
    """The spectra of recorded signals, each divided into what it is at every operating point.

    Slow lines add up over operating points; in bands, which are fast, what happens at one is over at the next.

    Args:
        time: Instants, s, not falling; at least two different ones.
        signals: The values of each signal there.
        points: The operating points there; by default there is one.
    """
    begin, end = float(time[0]), float(time[-1])
    step = (end - begin) / max(min(len(np.unique(time)), MOST_INSTANTS) - 1, 1)
    count = round((end - begin) / step) + 1
    even = begin + step * np.arange(count)
    decay = 2.0 / (end - begin)
    weight = np.exp(-decay * (even - begin))
    rows = np.array([*(np.interp(even, time, signal) for signal in signals), np.ones(count)]) * weight
    size = 1 << (2 * count - 1).bit_length()
    share = np.full(size // 2 + 1, 2.0)  # negative frequencies count with the positive ones
    share[[0, -1]] = 1.0
    scale = np.sqrt(share / (size * float(np.sum(weight * weight))))
    whole = np.fft.rfft(rows, n=size) * scale
    frequency = 2.0 * np.pi / (size * step) * np.arange(whole.shape[1])
    sizes = np.linalg.norm(whole, axis=1)
    sizes[sizes == 0.0] = 1.0
    whole /= sizes[:, np.newaxis]
    present = np.zeros(1, dtype=np.int64) if points is None else np.unique(points)
    if points is None or len(present) == 1:
        parts = {int(present[0]): whole}
    else:
        there = points[np.clip(np.searchsorted(time, even, side="right") - 1, 0, len(time) - 1)]
        parts = {
            int(point): np.fft.rfft(rows * (there == point), n=size) * scale / sizes[:, np.newaxis] for point in present
        }
    lines = _Lines(decay, sizes)
    fewer = 1.0 if len(parts) == 1 else FEWER
    for members in _bands(whole, frequency, round(SINGLE_LINES * fewer), round(SHARED_BANDS * fewer)):
        if len(members) == 1:
            lines.add_line(frequency[members[0]], {point: part[:, members[0]] for point, part in parts.items()})
        else:
            for point, part in parts.items():
                lines.add_band(frequency[members], point, part[:, members], MOST_PER_BAND if len(parts) == 1 else 1)
    return lines.spectra()


class _Lines:
    """Terms while they are collected."""

    def __init__(self, decay: float, sizes: FloatArray) -> None:
        self._decay = decay
        self._sizes = sizes
        self._terms: list[tuple[complex, int, int, ComplexArray]] = []
        self._count = 0

    def add_line(self, frequency: float, parts: Mapping[int, ComplexArray]) -> None:
        """A line with its part at every operating point."""
        total = max(float(np.sum(np.abs(part) ** 2)) for part in parts.values())
        for point, part in parts.items():
            if len(parts) == 1 or float(np.sum(np.abs(part) ** 2)) > _ABSENT * total:
                self._terms.append((self._decay + 1j * frequency, point, self._count, part * self._sizes))
        self._count += 1

    def add_band(self, frequency: FloatArray, point: int, part: ComplexArray, most: int) -> None:
        """A band at one operating point, as those combinations of its lines in which most happens."""
        energy = np.sum(np.abs(part) ** 2, axis=0)
        total = float(np.sum(energy))
        if total == 0.0:
            return
        centre = float(frequency @ energy) / total
        # They are the eigenvectors of the products of all pairs of signals.
        directions, heights, _ = np.linalg.svd(_fewer_lines(part), full_matrices=False)
        for k in range(min(most, len(heights))):
            if heights[k] ** 2 > _NEGLIGIBLE * heights[0] ** 2:
                amplitude = directions[:, k] * heights[k] * self._sizes
                self._terms.append((self._decay + 1j * centre, point, self._count, amplitude))
                self._count += 1

    def spectra(self) -> Spectra:
        """All of them."""
        s, point, line, amplitudes = zip(*self._terms, strict=True)
        return Spectra(np.array(s), np.array(point), np.array(line), np.array(amplitudes))


def _fewer_lines(part: ComplexArray) -> ComplexArray:
    """As few columns as there are signals, with the same products of pairs of signals."""
    if part.shape[1] <= part.shape[0]:
        return part
    power, directions = np.linalg.eigh(part @ part.conj().T)
    return directions * np.sqrt(np.maximum(power, 0.0))


def _bands(found: ComplexArray, frequency: FloatArray, singles: int, shared: int) -> list[NDArray[np.intp]]:
    """The numbers of the lines of each band."""
    energy = np.sum(np.abs(found[:-1]) ** 2, axis=0)
    alone = np.zeros(len(energy), dtype=np.bool_)
    alone[np.argsort(energy)[::-1][:singles]] = True
    alone[:2] = True
    rest = np.flatnonzero(~alone)
    bands = [np.array([line]) for line in np.flatnonzero(alone)]
    if rest.size:
        edges = np.geomspace(frequency[rest[0]], frequency[rest[-1]] * (1.0 + 1e-12), shared + 1)
        bands += [rest[which] for which in _groups(np.searchsorted(edges, frequency[rest], side="right"))]
    return bands


def _groups(numbers: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Where each number stands."""
    return [np.flatnonzero(numbers == number) for number in np.unique(numbers)]
