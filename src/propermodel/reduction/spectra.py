"""What was recorded, as few lines of a spectrum: enough to predict the size of any linear answer to it.

Signals count with the weight exp(-t / t_c), t_c half the length of the run (the line Re s = 2 / T), which makes the
window end gently; by Parseval's theorem the weighted mean square of an answer is a sum over frequencies. The lines with
most energy stand for themselves; the others are gathered in bands in which an answer's gain is nearly constant, and a
band is as many lines as the signals in it are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray

ComplexArray = NDArray[np.complex128]

MOST_INSTANTS = 1 << 15
SINGLE_LINES = 100  # lines with most energy
SHARED_BANDS = 40  # of all others, equally wide on a logarithmic scale
MOST_PER_BAND = 2
_NEGLIGIBLE = 1e-6  # the share of a band's energy at which a further line of it is left out


@dataclass(frozen=True, eq=False)
class Spectra:
    """Lines (first axis): s, and the complex amplitude of every signal; the last signal is the constant 1.

    Amplitudes are scaled so that the sum of the squares of a signal's is its mean square, weighted as above.
    """

    s: ComplexArray
    amplitudes: ComplexArray  # (lines, signals + 1)


def spectra(time: FloatArray, signals: Sequence[FloatArray]) -> Spectra:
    """The spectra of recorded signals.

    Args:
        time: Instants, s, not falling; at least two different ones.
        signals: The values of each signal there.
    """
    begin, end = float(time[0]), float(time[-1])
    step = (end - begin) / max(min(len(np.unique(time)), MOST_INSTANTS) - 1, 1)
    count = round((end - begin) / step) + 1
    even = begin + step * np.arange(count)
    decay = 2.0 / (end - begin)
    weight = np.exp(-decay * (even - begin))
    rows = np.array([*(np.interp(even, time, signal) for signal in signals), np.ones(count)])
    size = 1 << (2 * count - 1).bit_length()
    found = np.fft.rfft(rows * weight, n=size)
    share = np.full(found.shape[1], 2.0)  # negative frequencies count with the positive ones
    share[[0, -1]] = 1.0
    found *= np.sqrt(share / (size * float(np.sum(weight * weight))))
    frequency = 2.0 * np.pi / (size * step) * np.arange(found.shape[1])
    sizes = np.linalg.norm(found, axis=1)
    sizes[sizes == 0.0] = 1.0
    s: list[complex] = []
    amplitudes: list[ComplexArray] = []
    for members in _bands(found / sizes[:, np.newaxis], frequency):
        part = found[:, members] / sizes[:, np.newaxis]
        energy = np.sum(np.abs(part) ** 2, axis=0)
        total = float(np.sum(energy))
        centre = float(frequency[members] @ energy) / total if total > 0.0 else float(np.mean(frequency[members]))
        # Eigenvectors of the products of all pairs of signals are those directions in which most happens.
        power, directions = np.linalg.eigh(part @ part.conj().T)
        for k in range(len(power) - 1, max(len(power) - 1 - MOST_PER_BAND, -1), -1):
            if power[k] > _NEGLIGIBLE * power[-1]:
                s.append(decay + 1j * centre)
                amplitudes.append(directions[:, k] * np.sqrt(power[k]) * sizes)
    return Spectra(np.array(s), np.array(amplitudes))


def _bands(found: ComplexArray, frequency: FloatArray) -> list[NDArray[np.intp]]:
    """The numbers of the lines of each band."""
    energy = np.sum(np.abs(found[:-1]) ** 2, axis=0)
    alone = np.zeros(len(energy), dtype=np.bool_)
    alone[np.argsort(energy)[::-1][:SINGLE_LINES]] = True
    alone[:2] = True
    rest = np.flatnonzero(~alone)
    bands = [np.array([line]) for line in np.flatnonzero(alone)]
    if rest.size:
        edges = np.geomspace(frequency[rest[0]], frequency[rest[-1]] * (1.0 + 1e-12), SHARED_BANDS + 1)
        bands += [rest[which] for which in _groups(np.searchsorted(edges, frequency[rest], side="right"))]
    return bands


def _groups(numbers: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Where each number stands."""
    return [np.flatnonzero(numbers == number) for number in np.unique(numbers)]
