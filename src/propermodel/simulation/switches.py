"""Positions of ideal switches in a run: which of their equations hold as they are, and which say something of states.

Where switches make equations dependent, a combination of them, without any unknown, is a constraint on the states: a
coil behind an open switch has no current. Its rate decides what the combination does not. What is then still open
(the potential of a part that floats, the share of a current among closed switches) is left to small leakages, equal in
all switches; a combination that they decide must hold by itself, or the switches contradict each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from propermodel.codegen.lower import Lowered, SwitchingSlots
from propermodel.codegen.machine import FloatArray, IntArray, Memory
from propermodel.diagnostics import Path, SimulationError
from propermodel.equations.formulate import RELAXATION

URGENCY = 1e15  # 1/s, with which a constraint that does not hold pulls while events decide what gives way
LEAKAGE = 1e-9  # of an open switch, 1/Ohm, and of a closed one, Ohm, where nothing else decides
AGREEMENT = 1e-6  # to which equations that say the same must agree, V or A
NOWHERE = Path()
_ANYTHING = 1e300
_DEPENDENT = 1e-12  # what is left of an equation by rounding

Evaluate = Callable[[Memory], FloatArray]  # the SWITCHING array


@dataclass(frozen=True, eq=False)
class _Position:
    """What the equations of a block mean: `combinations[i]` takes the place of equation i where that is dependent."""

    combinations: FloatArray  # size x size; rows of independent equations are zero
    is_constraint: FloatArray  # whether equation i says something about states; 1 or 0
    is_open: FloatArray  # whether equation i leaves its unknown open; 1 or 0


@dataclass(frozen=True, slots=True)
class Violation:
    """What does not hold: by how much (V or A, or as units are), at which switch, together with which."""

    size: float
    element: Path
    members: tuple[Path, ...]


def contradiction(members: Iterable[Path]) -> str:
    """What is said of switches that cannot all be as they are."""
    names = ", ".join(str(path) for path in dict.fromkeys(members))
    return f"{names}: closed around a source of effort, or open in series with a source of flow, they contradict it"


class Switches:
    """The weights of all blocks with ideal switches, kept in the memory of a run."""

    def __init__(self, lowered: Lowered, evaluate: Evaluate) -> None:
        self._blocks = lowered.switching
        self._evaluate = evaluate
        self._positions: dict[tuple[int, bytes], _Position] = {}

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._blocks)

    def decide(self, memory: Memory) -> None:
        """Let what contradicts drive efforts and flows without bounds, so that their signs tell which switch moves."""
        self._weigh(memory, URGENCY, 1.0 / LEAKAGE, _ANYTHING)

    def hold(self, memory: Memory) -> None:
        """Let constraints hold as they do.

        Raises:
            SimulationError: switches contradict each other.
        """
        found = self._worst(memory, lambda position: position.is_open)
        if not found.size <= AGREEMENT:
            raise SimulationError.of(
                "simulation/not-converged",
                f"{contradiction(found.members)} by {found.size:g}",
                help="put a resistance or a storage in between, or let one of them give way",
            )
        self._weigh(memory, 1.0 / RELAXATION, 0.0, AGREEMENT)

    def pull(self, memory: Memory, urgency: float) -> None:
        """Let constraints that do not hold pull the states with this urgency, 1/s."""
        self._weigh(memory, urgency, 0.0, _ANYTHING)

    def violation(self, memory: Memory) -> Violation:
        """How far the states are from what the switches ask of them."""
        return self._worst(memory, lambda position: position.is_constraint)

    def _worst(self, memory: Memory, of: Callable[[_Position], FloatArray]) -> Violation:
        worst = Violation(0.0, NOWHERE, ())
        numbers = self._evaluate(memory)
        for block in self._blocks:
            position = self._position(block, numbers)
            sizes = of(position) * np.abs(position.combinations @ _residuals(block, numbers))
            i = int(np.argmax(sizes))
            if not sizes[i] <= worst.size:
                members = tuple(p for p, w in zip(block.paths, position.combinations[i], strict=True) if w != 0.0)
                worst = Violation(float(sizes[i]), block.paths[i], members)
        return worst

    def _weigh(self, memory: Memory, urgency: float, contradiction: float, tolerance: float) -> None:
        numbers = self._evaluate(memory)
        for block in self._blocks:
            position = self._position(block, numbers)
            dependent = position.is_constraint + position.is_open
            scale = max(1.0, urgency)
            constraints = position.is_constraint[:, np.newaxis] * position.combinations
            left_open = position.is_open[:, np.newaxis] * position.combinations
            memory.unknown[block.of_residual] = (
                np.diag(1.0 - dependent) + (urgency / scale) * constraints - contradiction * left_open
            )
            memory.unknown[block.of_drift] = constraints / scale
            memory.unknown[block.of_other] = left_open
            memory.unknown[block.tolerance] = tolerance

    def _position(self, block: SwitchingSlots, numbers: FloatArray) -> _Position:
        size = len(block.tolerance)
        matrices = numbers[block.first + size : block.first + size + 2 * size * size]
        key = (block.first, matrices.tobytes())
        if key not in self._positions:
            matrix, drift = matrices.reshape(2, size, size)
            self._positions[key] = _position(matrix, drift)
        return self._positions[key]


def unsettled(lowered: Lowered, unknown: FloatArray) -> None:
    """Write weights with which every block has a solution, before the positions of its switches are known."""
    for block in lowered.switching:
        identity = np.eye(len(block.tolerance))
        unknown[block.of_residual] = identity
        unknown[block.of_other] = -LEAKAGE * identity
        unknown[block.tolerance] = _ANYTHING


def _residuals(block: SwitchingSlots, numbers: FloatArray) -> FloatArray:
    return numbers[block.first : block.first + len(block.tolerance)]


def _position(matrix: FloatArray, drift: FloatArray) -> _Position:
    size = len(matrix)
    combinations = np.zeros((size, size))
    is_constraint, is_open = np.zeros(size), np.zeros(size)
    magnitudes = np.tile(np.max(np.abs(matrix), axis=1, keepdims=True), size)
    rows, left, right = _dependent(matrix, magnitudes)
    if len(rows):
        sizes = np.abs(left) @ np.abs(drift) @ np.abs(right)
        again, further, _ = _dependent(left @ drift @ right, sizes)
        combinations[rows] = left
        is_constraint[rows] = 1.0
        # Combinations of constraints whose rates decide nothing either.
        combinations[rows[again]] = further @ left
        is_constraint[rows[again]], is_open[rows[again]] = 0.0, 1.0
    return _Position(combinations, is_constraint, is_open)


def _dependent(matrix: FloatArray, sizes: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """The dependent rows of a square matrix, and its left and right null spaces.

    Gaussian elimination with complete pivoting; `sizes` are magnitudes beside which an entry is rounding. Row k of the
    left null space has a 1 at dependent row k.
    """
    size = len(matrix)
    scale = np.max(sizes, axis=1, initial=0.0)
    scale = np.where(scale > 0.0, scale, 1.0)
    a = np.where(np.abs(matrix) > _DEPENDENT * sizes, matrix, 0.0) / scale[:, np.newaxis]
    rows, columns = np.arange(size), np.arange(size)
    rank = 0
    while rank < size:
        left = np.abs(a[rank:, rank:])
        i, j = divmod(int(np.argmax(left)), size - rank)
        if left[i, j] <= _DEPENDENT:
            break
        for array, one in ((rows, i), (columns, j)):
            array[[rank, rank + one]] = array[[rank + one, rank]]
        a[[rank, rank + i]] = a[[rank + i, rank]]
        a[:, [rank, rank + j]] = a[:, [rank + j, rank]]
        factors = a[rank + 1 :, rank] / a[rank, rank]
        a[rank + 1 :, rank:] -= np.outer(factors, a[rank, rank:])
        rank += 1
    kept_rows, kept_columns = rows[:rank], columns[:rank]
    dependent, free = np.sort(rows[rank:]), np.sort(columns[rank:])
    core = matrix[np.ix_(kept_rows, kept_columns)]
    left_null, right_null = np.zeros((size - rank, size)), np.zeros((size, size - rank))
    left_null[np.arange(size - rank), dependent] = 1.0
    right_null[free, np.arange(size - rank)] = 1.0
    if rank:
        left_null[:, kept_rows] = -np.linalg.solve(core.T, matrix[np.ix_(dependent, kept_columns)].T).T
        right_null[kept_columns] = -np.linalg.solve(core, matrix[np.ix_(kept_rows, free)])
    return dependent, left_null, right_null
