"""The exact response of a linear network to its drives, whatever has been taken out of it.

All equations are written down at every line of a damped Fourier transformation, s = sigma + j omega: balances at nodes,
couplings, and a law for every element. What is missing from a law (its violation) answers linearly, so an element is
taken out by the violation that makes its effort, or flow, zero or constant. No causality, no states, no time steps; it
shares no code with the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.galleries.network import GROUND, INTERVALS, Field, FloatArray, Half, Kind, Network, Place

ComplexArray = NDArray[np.complex128]

SAMPLES = 2 * INTERVALS  # the second half of the period is thrown away
LINES = INTERVALS + 1
FADING = 12.0  # what comes round again after the period has shrunk to exp(-12)
SOFTNESS = 12  # order of the filter that ends the lines gently, so that a jump leaves no ripple far from it
AT_REST = 1e-7  # s, as a share of 1 / window, at which an equilibrium is looked up


@dataclass(frozen=True, slots=True)
class Response:
    """The lines of efforts and flows of all elements and of outputs, and how they answer to violations of laws."""

    own: ComplexArray  # (efforts then flows, laws, lines)
    answers: ComplexArray  # (outputs, laws, lines)
    moved: ComplexArray  # (efforts then flows, lines): how far they are from equilibrium
    outputs: ComplexArray  # (outputs, lines): likewise
    equilibrium: FloatArray  # (efforts then flows): at the start


class Lines:
    """The transformation between instants of a window and lines."""

    def __init__(self, stop: float) -> None:
        """Choose the lines for a window that ends at `stop`, s."""
        self._sigma = FADING / (2.0 * stop)
        self._times = 2.0 * stop * np.arange(SAMPLES) / SAMPLES
        self.s: ComplexArray = np.array(self._sigma + 1j * np.pi / stop * np.arange(LINES), dtype=np.complex128)
        self._gentle = np.exp(-36.0 * (np.arange(LINES) / (LINES - 1)) ** SOFTNESS)
        self.constant: ComplexArray = SAMPLES / (2.0 * stop * self.s)  # of the constant 1 that begins with the window

    def of(self, values: FloatArray) -> ComplexArray:
        """The lines of a signal that is straight between its values at the ends of intervals; afterwards it fades."""
        fading = 0.5 + 0.5 * np.cos(np.pi * np.arange(SAMPLES - INTERVALS) / (SAMPLES - INTERVALS))
        whole = np.concatenate([values[:INTERVALS], values[-1] * fading])
        half = self.s * self._times[1] / 2.0
        straight = (np.sinh(half) / half) ** 2
        return np.fft.rfft(whole * np.exp(-self._sigma * self._times)) * straight

    def instants(self, lines: ComplexArray) -> FloatArray:
        """The values of signals (last axis) at the ends of all intervals."""
        found = np.fft.irfft(lines * self._gentle, n=SAMPLES, axis=-1)[..., : INTERVALS + 1]
        return found * np.exp(self._sigma * self._times[: INTERVALS + 1])


def respond(network: Network) -> Response:
    """The response of a network with all its elements."""
    lines = Lines(network.stop)
    count = len(network.elements)
    rest = _solved(network, np.array([AT_REST / network.stop + 0.0j]))[:, :, 0].real
    steady = np.array([0.0 if isinstance(drive.values, np.ndarray) else drive.values for drive in network.drives])
    equilibrium = rest[:, count:] @ steady
    found = _solved(network, lines.s)
    given = np.array(
        [lines.of(d.values) if isinstance(d.values, np.ndarray) else np.zeros(LINES) for d in network.drives]
    )
    moved = np.einsum("vdl,dl->vl", found[:, count:], given)
    chosen = [network.number(out.element) + (count if out.half is Half.FLOW else 0) for out in network.outputs]
    return Response(
        own=found[:, :count],
        answers=found[chosen, :count],
        moved=moved,
        outputs=moved[chosen],
        equilibrium=equilibrium,
    )


def _solved(network: Network, s: ComplexArray) -> ComplexArray:
    """(efforts then flows of elements, laws then drives, s): what they are per unit."""
    equations = Equations(network)
    matrix = equations.constant + s[:, np.newaxis, np.newaxis] * equations.rate
    found = np.linalg.solve(matrix, np.broadcast_to(equations.right, (len(s), *equations.right.shape)))
    return np.ascontiguousarray(np.transpose(equations.observed @ found, (1, 2, 0)))


class Equations:
    """(constant + s rate) x = right; x are the quantities of nodes, and what passes through elements and couplings."""

    def __init__(self, network: Network) -> None:
        self._nodes = list(network.nodes)
        self._count = len(network.elements)
        places = [element.place for element in network.elements]
        for coupling in network.couplings:
            places += [coupling.first, coupling.second]
        self._size = len(self._nodes) + len(places)
        efforts = np.array([self._effort(place, number) for number, place in enumerate(places)])
        flows = np.array([self._flow(place, number) for number, place in enumerate(places)])
        balances, imposed = self._balances(network, places)
        laws, law_rates = self._laws(network, efforts, flows)
        couplings = self._couplings(network, efforts, flows)
        self.constant = np.concatenate([balances, laws, couplings])
        self.rate = np.concatenate([np.zeros_like(balances), law_rates, np.zeros_like(couplings)])
        self.right = np.zeros((self._size, self._count + len(network.drives)), dtype=np.complex128)
        first = len(self._nodes)
        self.right[first : first + self._count, : self._count] = np.eye(self._count)
        self.right[:first, self._count :] = imposed
        self.observed = np.concatenate([efforts[: self._count], flows[: self._count]]).astype(np.complex128)

    def _across(self, place: Place) -> FloatArray:
        found = np.zeros(self._size)
        for node, sign in ((place.a, 1.0), (place.b, -1.0)):
            if node != GROUND:
                found[self._nodes.index(node)] += sign
        return found

    def _through(self, number: int) -> FloatArray:
        found = np.zeros(self._size)
        found[len(self._nodes) + number] = 1.0
        return found

    def _effort(self, place: Place, number: int) -> FloatArray:
        return self._through(number) if place.field.shares_flow else self._across(place)

    def _flow(self, place: Place, number: int) -> FloatArray:
        return self._across(place) if place.field.shares_flow else self._through(number)

    def _balances(self, network: Network, places: list[Place]) -> tuple[FloatArray, FloatArray]:
        """What leaves every node is what drives bring; nodes with an imposed quantity have it instead."""
        balances = np.zeros((len(self._nodes), self._size))
        for number, place in enumerate(places):
            # What a coupling takes at its first place comes out at its second.
            is_second = number >= self._count and (number - self._count) % 2 == 1
            leaving = -1.0 if is_second else 1.0
            for node, sign in ((place.a, leaving), (place.b, -leaving)):
                if node != GROUND:
                    balances[self._nodes.index(node)] += sign * self._through(number)
        imposed = np.zeros((len(self._nodes), len(network.drives)))
        for number, drive in enumerate(network.drives):
            row = self._nodes.index(drive.node)
            imposed[row, number] = 1.0
            if _is_shared(network.nodes[drive.node], drive.half):
                balances[row] = 0.0
                balances[row, row] = 1.0
        return balances, imposed

    def _laws(self, network: Network, efforts: FloatArray, flows: FloatArray) -> tuple[FloatArray, FloatArray]:
        constant, rate = np.zeros((self._count, self._size)), np.zeros((self._count, self._size))
        for number, element in enumerate(network.elements):
            match element.kind:
                case Kind.RESISTANCE:
                    constant[number] = efforts[number] - element.value * flows[number]
                case Kind.INERTIA:
                    constant[number], rate[number] = efforts[number], -element.value * flows[number]
                case Kind.COMPLIANCE:
                    constant[number], rate[number] = flows[number], -efforts[number] / element.value
        return constant, rate

    def _couplings(self, network: Network, efforts: FloatArray, flows: FloatArray) -> FloatArray:
        found = np.zeros((2 * len(network.couplings), self._size))
        for number, coupling in enumerate(network.couplings):
            first, m = self._count + 2 * number, coupling.modulus
            if coupling.is_gyrator:
                found[2 * number] = efforts[first] - m * flows[first + 1]
                found[2 * number + 1] = efforts[first + 1] - m * flows[first]
            else:
                found[2 * number] = efforts[first] - m * efforts[first + 1]
                found[2 * number + 1] = flows[first + 1] - m * flows[first]
        return found


def _is_shared(field: Field, half: Half) -> bool:
    return field.shares_flow == (half is Half.FLOW)
