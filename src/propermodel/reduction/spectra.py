"""What was recorded, as energies of frequency bands: enough to predict the size of any linear answer to it.

Signals count with the weight exp(-t / t_c), t_c half the length of the run (the line Re s = 2 / T), which makes the
window end gently; by Parseval's theorem the weighted mean square of an answer is a sum over frequencies. Frequencies
are gathered into bands in which an answer's gain is nearly constant: those with most energy alone, the others together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propermodel.codegen.machine import FloatArray

ComplexArray = NDArray[np.complex128]

MOST_INSTANTS = 1 << 15
SINGLE_LINES = 120  # frequencies with most energy, which are bands of their own
SHARED_BANDS = 80  # of all others, equally wide on a logarithmic scale


@dataclass(frozen=True, eq=False)
class Spectra:
    """Per band (first axis): s, and the mean of the products of all pairs of signals, weighted as above.

    A signal of ones is added at the end, so that constants may be taken from the others.
    """

    s: ComplexArray
    products: ComplexArray  # (bands, signals + 1, signals + 1): mean of x_i conj(x_j)

    def rms(self, gains: ComplexArray, signals: Sequence[int]) -> float:
        """The root mean square of a sum of some signals (-1: the ones), each times its gain (bands, signals)."""
        products = self.products[:, signals][:, :, signals]
        total = np.einsum("bi,bij,bj->", gains, products, gains.conj())
        return float(np.sqrt(max(total.real, 0.0)))


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
    lines = 1 << (2 * count - 1).bit_length()
    found = np.fft.rfft(rows * weight, n=lines)
    share = np.full(found.shape[1], 2.0)  # negative frequencies count with the positive ones
    share[[0, -1]] = 1.0
    share /= lines * float(np.sum(weight * weight))
    frequency = 2.0 * np.pi / (lines * step) * np.arange(found.shape[1])
    centres: list[float] = []
    products: list[ComplexArray] = []
    for members in _bands(found, share, frequency):
        part = found[:, members]
        energy = np.sum(np.abs(part) ** 2 / np.maximum(_energies(found, share), 1e-300)[:, np.newaxis], axis=0)
        total = float(np.sum(energy))
        centre = frequency[members] @ energy / total if total > 0.0 else np.mean(frequency[members])
        centres.append(float(centre))
        products.append((part * share[members]) @ part.conj().T)
    return Spectra(decay + 1j * np.array(centres), np.array(products))


def _energies(found: ComplexArray, share: FloatArray) -> FloatArray:
    return np.sum(np.abs(found) ** 2 * share, axis=1)


def _bands(found: ComplexArray, share: FloatArray, frequency: FloatArray) -> list[NDArray[np.intp]]:
    """The numbers of the lines of each band."""
    whole = np.maximum(_energies(found, share), 1e-300)
    energy = np.sum(np.abs(found[:-1]) ** 2 * share / whole[:-1, np.newaxis], axis=0)
    alone = np.zeros(len(energy), dtype=np.bool_)
    alone[np.argsort(energy)[::-1][:SINGLE_LINES]] = True
    alone[:2] = True
    rest = np.flatnonzero(~alone)
    bands = [np.array([line]) for line in np.flatnonzero(alone)]
    if rest.size:
        edges = np.geomspace(frequency[rest[0]], frequency[rest[-1]] * (1.0 + 1e-12), SHARED_BANDS + 1)
        which = np.searchsorted(edges, frequency[rest], side="right")
        # A line that is a band of its own divides the band around it, so that gains change little inside.
        which = which + (SHARED_BANDS + 2) * np.cumsum(alone)[rest]
        bands += [rest[which == number] for number in np.unique(which)]
    return bands
