"""All smaller models of a network that is not linear, side by side through time.

A step of TR-BDF2 (Bank et al. 1985; L-stable, second order) is the linear network at one real s, with what the past
has left in the laws' violations, and with as many unknowns as there are bent laws, which Newton's method finds. What
has been taken out is data: a law that says zero, or a constant. A model is given up as soon as the squares of its
errors prove it outside.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.galleries.exhaustion import Choice, Choices, Exhaustion, IntArray, Meaning, choices_of
from benchmarks.galleries.judge import AT_REST, Equations
from benchmarks.galleries.network import INTERVALS, Element, FloatArray, Half, Kind, Law, Network

SUBSTEPS = 1  # of an interval
BETA = 1.0 - math.sqrt(0.5)  # of a step: the weight of the newest rate in both stages
GAMMA = 2.0 * BETA  # of a step: where its first stage ends
ILL_CONDITIONED = 1e10  # of the network with all values of the order of one: it has no solution
GIVEN_UP = 0.1  # error of an output beyond which a model is followed no further
MOST_ITERATIONS = 30
SHORT = 1e-5  # of an interval: the step that shares out what is stored at the start
LEAST_SLOPE = 1e-2  # of a quadratic law in Newton's method, as a share of the linear one: at rest it has none
FLAT = 1e-13  # keeps Newton's method going where a law has become flat
CLOSE = 1e-7  # what Newton's method may leave, as a share of the size of the law
MOST_WITH_CONSTANTS = 2_500  # sets
AT_ONCE = 4000  # models


@dataclass(frozen=True, slots=True, eq=False)
class _Bend:
    """The part of a law beyond value x, and its slope, for a law that gives effort."""

    element: Element

    def beyond(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What the law gives more than its linear part, and the slope of that."""
        value, scale = self.element.value, self.element.scale
        y = x / scale
        match self.element.law:
            case Law.HARDENING:
                return value * x * y * y, 3.0 * value * y * y
            case Law.SATURATING:
                size = 1.0 + np.abs(y)
                return value * x / size - value * x, value / (size * size) - value
            case Law.FRICTION:
                t = np.tanh(y)
                return value * (scale * t - x), -value * t * t
            case Law.QUADRATIC:
                return value * (x * np.abs(y) - x), value * (np.maximum(2.0 * np.abs(y), LEAST_SLOPE) - 1.0)
            case Law.LINEAR:
                return np.zeros_like(x), np.zeros_like(x)


def exhaust_bent(network: Network) -> Exhaustion:
    """Judge every smaller network; errors beyond `GIVEN_UP` are infinite, but for single removals."""
    full = _full(network).run()
    choices = choices_of(
        network, full[:, 0].T, full[0, 0] if network.is_biased else 0.0 * full[0, 0], MOST_WITH_CONSTANTS
    )
    every = np.array(list(itertools.product(*(range(len(some)) for some in choices))), dtype=np.int8)
    tried = len(every)
    every = every[_are_sound(network, every, choices)]
    single = np.count_nonzero(every, axis=1) <= 1
    meanings, errors = [every[single]], [_errors(network, every[single], choices, full, np.inf)]
    rest = every[~single]
    for begin in range(0, len(rest), AT_ONCE):
        some = rest[begin : begin + AT_ONCE]
        meanings.append(some)
        errors.append(_errors(network, some, choices, full, GIVEN_UP))
    return Exhaustion(np.concatenate(meanings), np.concatenate(errors), choices, tried)


def run_bent(network: Network) -> FloatArray:
    """The efforts, then flows, of all elements of the full network at the ends of all intervals."""
    return _full(network).run()[:, 0].T


def at_rest(network: Network) -> tuple[FloatArray, FloatArray]:
    """The equilibrium of a network with its constant drives: efforts then flows, and displacements and momenta."""
    if not network.is_biased:
        return np.zeros(2 * len(network.elements)), np.zeros(len(network.elements))
    nothing, keep = _nothing(network)
    # One step that takes so long that all has come to rest.
    resting = _March(network, nothing, keep, AT_REST / network.stop)
    stored = resting.solved(np.zeros_like(nothing, dtype=np.float64), 0.0)
    return resting.now[0], stored[0]


def _full(network: Network) -> _March:
    return _begun(network, *_nothing(network))


def _nothing(network: Network) -> tuple[IntArray, Choices]:
    """What leaves one network as it is."""
    keep = tuple((Choice(Meaning.KEEP, Half.EFFORT),) for _ in network)
    return np.zeros((1, len(network.elements)), dtype=np.int8), keep


def _begun(network: Network, meanings: IntArray, choices: Choices) -> _March:
    """Networks at the start: what is stored in the full one at rest, shared out anew where removals tie it together.

    A short implicit step brings that about, as an impact would: what is conserved is kept. A second one then finds
    rates without it.
    """
    march = _March(network, meanings, choices, SUBSTEPS * INTERVALS / (BETA * network.stop))
    if network.is_biased:
        start = _March(network, meanings, choices, INTERVALS / (SHORT * network.stop))
        stored = np.where(meanings == Meaning.KEEP, at_rest(network)[1], 0.0)
        for _ in range(2):
            stored = start.solved(stored, 0.0)
        march.begin(stored, start.now)
    return march


def _errors(network: Network, meanings: IntArray, choices: Choices, full: FloatArray, most: float) -> FloatArray:
    """(networks, outputs): root mean square of the change, as a share of the output's range."""
    count = len(network.elements)
    asked = [network.number(o.element) + (count if o.half is Half.FLOW else 0) for o in network.outputs]
    expected = full[:, 0, asked]
    ranges = np.ptp(expected, axis=0)
    march = _begun(network, meanings, choices)
    squares = np.zeros((len(meanings), len(asked)))
    found = np.full((len(meanings), len(asked)), np.inf)
    here = np.arange(len(meanings))
    for row in expected[1:]:
        now = march.advanced()[:, asked]
        squares += ((now - row) / ranges) ** 2
        is_left = np.all(squares <= most * most * len(expected), axis=1)
        if not np.all(is_left):
            march.leave(is_left)
            squares, here = squares[is_left], here[is_left]
            if not len(here):
                return found
    found[here] = np.sqrt(squares / len(expected))
    return found


def _are_sound(network: Network, meanings: IntArray, choices: Choices) -> NDArray[np.bool_]:
    """Which networks have a solution, whatever their values: judged with values of the order of one."""
    random = np.random.default_rng(0)
    rows = [
        _Rows.of(
            Network(
                name="",
                family="",
                elements=tuple(
                    Element(e.name, e.kind, e.place, float(random.uniform(0.5, 2.0))) for e in network.elements
                ),
                couplings=tuple(
                    type(c)(c.name, c.first, c.second, float(random.uniform(0.5, 2.0)), c.is_gyrator)
                    for c in network.couplings
                ),
                drives=network.drives,
                outputs=network.outputs,
                stop=network.stop,
            ),
            1.0,
        )
    ]
    found = [
        np.linalg.cond(rows[0].matrices(meanings[begin : begin + AT_ONCE], choices)) < ILL_CONDITIONED
        for begin in range(0, len(meanings), AT_ONCE)
    ]
    return np.concatenate(found)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """The equations of a network at one real s, and what may stand in the place of a law."""

    matrix: FloatArray
    right: FloatArray
    observed: FloatArray
    first: int  # row of the first law

    @classmethod
    def of(cls, network: Network, s: float) -> _Rows:
        equations = Equations(network)
        return cls(
            equations.constant + s * equations.rate,
            equations.right.real,
            equations.observed.real,
            len(network.nodes),
        )

    def matrices(self, meanings: IntArray, choices: Choices) -> FloatArray:
        """One matrix for every network."""
        found = np.repeat(self.matrix[np.newaxis], len(meanings), axis=0)
        count = meanings.shape[1]
        for number, some in enumerate(choices):
            for choice in some:
                if choice.meaning is not Meaning.KEEP:
                    own = number if choice.half is Half.EFFORT else count + number
                    found[meanings[:, number] == choice.meaning, self.first + number] = self.observed[own]
        return found


class _March:
    """Networks of which each has its own laws in the place of some elements."""

    def __init__(self, network: Network, meanings: IntArray, choices: Choices, s: float) -> None:
        """Solve the networks at one s, the inverse of the weight of the newest rate."""
        self._network = network
        self._count = len(network.elements)
        self._s = s
        rows = _Rows.of(network, self._s)
        solved = np.linalg.solve(
            rows.matrices(meanings, choices), np.broadcast_to(rows.right, (len(meanings), *rows.right.shape))
        )
        answers = rows.observed @ solved
        self._laws = np.ascontiguousarray(answers[:, :, : self._count])
        self._drives = np.ascontiguousarray(answers[:, :, self._count :])
        self._kept = meanings == Meaning.KEEP
        self._values = np.zeros(meanings.shape)
        for number, some in enumerate(choices):
            for choice in some:
                self._values[meanings[:, number] == choice.meaning, number] = choice.value
        self._bends = [(n, _Bend(element)) for n, element in enumerate(network) if element.law is not Law.LINEAR]
        kinds = [element.kind for element in network]
        self._is_compliance = np.array([kind is Kind.COMPLIANCE for kind in kinds])
        self._is_inertia = np.array([kind is Kind.INERTIA for kind in kinds])
        self._value = np.array([element.value for element in network])
        self._sizes = np.array([self._size(element) for _, element in ((n, b.element) for n, b in self._bends)])
        self._stored = np.zeros(meanings.shape)  # displacement or momentum
        self.now = np.zeros((len(meanings), 2 * self._count))  # efforts then flows
        self._bent = np.zeros((len(meanings), len(self._bends)))
        self._instant = 0

    def _size(self, element: Element) -> float:
        """How large the violation of a bent law may be."""
        size = element.value * element.scale
        return size * self._s / element.value if element.kind is Kind.COMPLIANCE else size

    def begin(self, stored: FloatArray, now: FloatArray) -> None:
        """Begin with displacements and momenta, and efforts then flows."""
        self._stored, self.now = stored, now

    def leave(self, which: NDArray[np.bool_]) -> None:
        """Follow only some of the networks."""
        self._laws, self._drives = self._laws[which], self._drives[which]
        self._kept, self._values, self._stored = self._kept[which], self._values[which], self._stored[which]
        self.now, self._bent = self.now[which], self._bent[which]

    def run(self) -> FloatArray:
        """(instants, networks, efforts then flows) to the end."""
        return np.array([self.now.copy(), *(self.advanced().copy() for _ in range(INTERVALS))])

    def advanced(self) -> FloatArray:
        """(networks, efforts then flows) at the end of the next interval."""
        share = 1.0 / (GAMMA * (2.0 - GAMMA))
        for sub in range(SUBSTEPS):
            before, begin = self._stored, self._instant + sub / SUBSTEPS
            middle = self.solved(before + self._rate() / self._s, begin + GAMMA / SUBSTEPS)
            self._stored = self.solved(share * middle - (share - 1.0) * before, begin + 1.0 / SUBSTEPS)
        self._instant += 1
        return self.now

    def _rate(self) -> FloatArray:
        efforts, flows = self.now[:, : self._count], self.now[:, self._count :]
        return np.where(self._is_compliance, flows, np.where(self._is_inertia, efforts, 0.0))

    def solved(self, past: FloatArray, instant: float) -> FloatArray:
        """What is stored when s (x - past) is the newest rate; `now` follows."""
        drives = np.array([_between(drive.values, instant) for drive in self._network.drives])
        violations = np.where(
            self._kept, np.where(self._is_compliance | self._is_inertia, -self._s * past, 0.0), self._values
        )
        linear = (self._laws @ violations[:, :, np.newaxis])[:, :, 0] + self._drives @ drives
        self.now = linear + self._bending(linear, past)
        moved = past + self._rate() / self._s
        return np.where(self._kept, moved, 0.0)

    def _bending(self, linear: FloatArray, past: FloatArray) -> FloatArray:
        """What the bent laws add, by Newton's method for all networks at once."""
        if not self._bends:
            return np.zeros_like(linear)
        numbers = [number for number, _ in self._bends]
        flows = [self._count + number for number in numbers]
        laws = self._laws[:, :, numbers]
        own = laws[:, flows]
        kept = self._kept[:, numbers]
        flow = linear[:, flows]
        unknown = self._bent.copy()
        open_ = np.arange(len(linear))
        for _ in range(MOST_ITERATIONS):
            some = unknown[open_]
            here = flow[open_] + (own[open_] @ some[:, :, np.newaxis])[:, :, 0]
            wanted, slopes = self._beyond(here, past[open_], kept[open_])
            residual = some - wanted
            is_wrong = ~np.all(np.abs(residual) <= CLOSE * (self._sizes + np.abs(wanted)), axis=1)
            if not np.any(is_wrong):
                break
            open_, slopes, residual = open_[is_wrong], slopes[is_wrong], residual[is_wrong]
            jacobian = (1.0 + FLAT) * np.eye(len(numbers)) - slopes[:, :, np.newaxis] * own[open_]
            unknown[open_] -= np.linalg.solve(jacobian, residual[:, :, np.newaxis])[:, :, 0]
        else:
            unknown[open_] = np.nan  # a law that cannot give what is asked of it: there is no solution
        self._bent = unknown
        return (laws @ unknown[:, :, np.newaxis])[:, :, 0]

    def _beyond(self, flow: FloatArray, past: FloatArray, kept: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """The violations that the bent laws ask for at some flows, and their slopes."""
        wanted, slopes = np.zeros_like(flow), np.zeros_like(flow)
        for column, (number, bend) in enumerate(self._bends):
            if bend.element.kind is Kind.COMPLIANCE:
                x, inner = past[:, number] + flow[:, column] / self._s, 1.0 / self._s
                factor = -self._s / bend.element.value
            else:
                x, inner, factor = flow[:, column], 1.0, 1.0
            beyond, slope = bend.beyond(x)
            wanted[:, column], slopes[:, column] = factor * beyond, factor * slope * inner
        return np.where(kept, wanted, 0.0), np.where(kept, slopes, 0.0)


def _between(values: FloatArray | float, instant: float) -> float:
    """The value of a drive at an instant, in intervals."""
    if not isinstance(values, np.ndarray):
        return values
    number = min(int(instant), INTERVALS - 1)
    share = instant - number
    return float((1.0 - share) * values[number] + share * values[number + 1])
