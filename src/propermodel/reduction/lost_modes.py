"""Modes that a reduction must not lose, however little energy they carry: growing, hardly damped and slow ones.

The eigenvalues of the full and of the reduced model are compared at some instants of the run. What decays well and
within the window may go. A mode that grows, that hardly decays, or that takes longer than the window to do so may not
go unseen: a later moment, or a slightly different excitation, would show it. Sampled controllers are held: what grows
more slowly than they act they may well hold, so that nothing is said of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from scipy.optimize import linear_sum_assignment

from propermodel.analysis.spectral_change import GROWTH
from propermodel.analysis.spectrum import ComplexArray, Root, roots_of
from propermodel.codegen.machine import FloatArray, Memory
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import SimulationError
from propermodel.expressions.interpret import interpret
from propermodel.simulation.point import Point
from propermodel.simulation.start import begin, parameter_values
from propermodel.simulation.trajectory import Trajectory

INSTANTS = (1.0 / 3.0, 2.0 / 3.0, 1.0)  # of the window
LIGHT_DAMPING = 0.02  # damping ratio below which an oscillation counts as hardly damped
SAME = 0.3  # relative distance up to which an eigenvalue of the reduced model stands for one of the full model
MOST_STATES = 400  # spectra of larger models are not compared here


class ModeKind(StrEnum):
    """Why a mode matters although little energy is in it."""

    GROWING = "growing"
    HARDLY_DAMPED = "hardly damped"
    SLOW = "slow"


@dataclass(frozen=True, slots=True)
class LostMode:
    """A mode of one model that the other does not have; `is_new` if it is the reduced model that has it."""

    eigenvalue: complex  # 1/s, the upper one of a pair
    kind: ModeKind
    instant: float  # s
    is_new: bool
    share: float  # of the instants that were looked at
    other: complex | None = None  # what it has become, where it is there with another damping

    @property
    def is_serious(self) -> bool:
        """Whether one model grows, wherever it was looked at, and the other does not."""
        return self.kind is ModeKind.GROWING and self.share == 1.0

    def __str__(self) -> str:
        size = abs(self.eigenvalue)
        swing = f" at {self.eigenvalue.imag / (2.0 * np.pi):.3g} Hz" if self.eigenvalue.imag else ""
        match self.kind:
            case ModeKind.GROWING:
                what = f"a mode that grows with {self.eigenvalue.real:.3g} 1/s{swing}"
            case ModeKind.HARDLY_DAMPED:
                what = f"an oscillation{swing} with a damping ratio of {-self.eigenvalue.real / size:.2g}"
            case ModeKind.SLOW:
                what = f"a slow change with a time constant of {1.0 / size:.3g} s" if size else "a conserved quantity"
        if self.other is not None:
            return f"{what} has one of {0.0 - self.other.real / abs(self.other):.2g} in the reduced model"
        who = "appears in the reduced model only" if self.is_new else "is lost"
        return f"{what} {who} (seen at {self.instant:.3g} s)"


@dataclass(frozen=True, eq=False)
class _Spectrum:
    instant: float
    roots: tuple[Root, ...]

    @property
    def values(self) -> ComplexArray:
        """All values with their multiplicity, of pairs the upper one."""
        return np.array([root.value for root in self.roots for _ in range(root.multiplicity)], dtype=np.complex128)

    def uncertainties(self) -> FloatArray:
        """The rounding error of each of these values."""
        return np.array([max(r.uncertainty, 1e-12) for r in self.roots for _ in range(r.multiplicity)])


class ModeWatch:
    """The spectra of a full model along its run, with which those of reduced models are compared."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._run = trajectory
        window = trajectory.scenario.start, trajectory.ending.time
        self._length = window[1] - window[0]
        self.problem = ""
        compiled = trajectory.compiled
        values = parameter_values(compiled, trajectory.scenario.parameters)
        # How fast a mode must grow to count, 1/s.
        self._growth = GROWTH / self._length
        for controller in compiled.graph.controllers:
            self._growth = max(self._growth, 1.0 / interpret(controller.period, values))
        if len(compiled.system.states) > MOST_STATES:
            self.problem = f"spectra of more than {MOST_STATES} states are not compared"
            self._full: tuple[_Spectrum, ...] = ()
            return
        rows = [int(np.argmin(np.abs(trajectory.time - (window[0] + s * self._length)))) for s in INSTANTS]
        self._rows = tuple(dict.fromkeys(rows))
        try:
            self._full = tuple(self._spectrum(compiled, trajectory.memory.copy(), row) for row in self._rows)
        except SimulationError as error:
            self.problem = f"spectra were not compared: {error.diagnostics[0].message}"
            self._full = ()

    def lost(self, reduced: CompiledModel) -> tuple[LostMode, ...]:
        """The modes that matter and that only one of the two models has.

        Raises:
            SimulationError: the reduced model has no start, or no derivatives at an instant.
        """
        if not self._full:
            return ()
        memory = begin(reduced, self._run.scenario)
        Point(reduced.system, reduced.lowered, memory)  # it has to start
        found: dict[tuple[ModeKind, bool], list[LostMode]] = {}
        for row, full in zip(self._rows, self._full, strict=True):
            other = self._spectrum(reduced, memory.copy(), row)
            for is_new, (one, two) in ((False, (full, other)), (True, (other, full))):
                first: dict[ModeKind, LostMode] = {}
                for value, kind, became in self._missing(one, two):
                    if not (is_new and (kind is ModeKind.SLOW or became is not None)):
                        first.setdefault(kind, LostMode(value, kind, full.instant, is_new, 0.0, became))
                for kind, mode in first.items():
                    found.setdefault((kind, is_new), []).append(mode)
        # What is seen at few instants belongs to a moment (a kink, a shift), not to the model.
        shares = [(modes[0], len(modes) / len(self._rows)) for modes in found.values()]
        return tuple(replace(mode, share=share) for mode, share in shares if share > 0.5)

    def _missing(self, one: _Spectrum, two: _Spectrum) -> Iterable[tuple[complex, ModeKind, complex | None]]:
        """The modes of one spectrum that matter and that the other does not have, or damps much less; by growth."""
        watched = [
            (complex(value), kind, float(error))
            for value, error in zip(one.values, one.uncertainties(), strict=True)
            if (kind := self._kind(complex(value), float(error))) is not None
        ]
        watched.sort(key=lambda item: -item[0].real)
        others = two.values
        if not watched:
            return
        values = np.array([value for value, _, _ in watched])
        errors = np.array([error for _, _, error in watched])
        distance = np.abs(values[:, np.newaxis] - others[np.newaxis, :])
        scale = np.maximum(np.abs(values)[:, np.newaxis], np.abs(others)[np.newaxis, :])
        # What is zero to rounding, or too slow to be seen in a hundred windows, is the same.
        floor = 0.01 / self._length / SAME
        relative = distance / np.maximum(np.maximum(scale, 100.0 * errors[:, np.newaxis]), floor)
        met: dict[int, complex] = {}
        if others.size:
            rows, columns = linear_sum_assignment(np.minimum(relative, 1e6))
            pairs = zip(rows, columns, strict=True)
            met = {int(r): complex(others[c]) for r, c in pairs if relative[r, c] <= SAME}
        for number, (value, kind, _) in enumerate(watched):
            if number not in met:
                yield value, kind, None
            elif kind is ModeKind.HARDLY_DAMPED and -met[number].real < 0.5 * -value.real:
                yield value, kind, met[number]

    def _kind(self, value: complex, error: float) -> ModeKind | None:
        real, size = value.real, abs(value)
        if real > 10.0 * error and real > self._growth:
            return ModeKind.GROWING
        if value.imag and abs(real) < LIGHT_DAMPING * size and size * self._length > 1.0:
            return ModeKind.HARDLY_DAMPED
        if size * self._length < 1.0:
            return ModeKind.SLOW
        return None

    def _spectrum(self, compiled: CompiledModel, memory: Memory, row: int) -> _Spectrum:
        """The spectrum of a model at a recorded instant, in the state that the full model has there."""
        system, run = compiled.system, self._run
        memory.time = float(run.time[row])
        for index, state in enumerate(system.states):
            if state.path in run:
                memory.state[index] = run[state.path][row]
        for index, held in enumerate(compiled.lowered.held):
            if held.data.path in run:
                memory.discrete[index] = run[held.data.path][row]
        point = Point(system, compiled.lowered, memory)
        matrix = point.matrix([s.derivative for s in system.states], [s.symbol for s in system.states])
        if not np.isfinite(matrix).all():
            raise SimulationError.of("linear/not-finite", f"a derivative is not finite at {memory.time:g} s")
        return _Spectrum(memory.time, roots_of(matrix))


def told(modes: Sequence[LostMode]) -> list[str]:
    """What must be said of lost modes, in words."""
    return [f"{mode}: a longer run or another excitation may show the difference" for mode in modes]
