"""Events of a run: the instant is found inside the step, then states and held values jump, round by round.

The run stops before a step at whose end a guard has become positive. Steps of other lengths from the same state bracket
the first instant at which one has; there the changes are made. What they raise in turn happens at the same instant.
Events that follow each other without end (a ball that comes to rest, a relay without hysteresis) end the run.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from propermodel.bondgraph.pseudo import pseudo_elements
from propermodel.codegen.lower import Lowered
from propermodel.codegen.machine import FloatArray, IntArray, Machine, Memory, has_risen
from propermodel.codegen.program import Array, Slot
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError
from propermodel.equations.rank import RankLoss
from propermodel.simulation.commutation import commutate
from propermodel.simulation.switches import Switches
from propermodel.simulation.trajectory import Ending, EventRecord, RunStatus
from propermodel.simulation.zeros import listed

MOST_IN_ONE_STEP = 100  # events of one element within the length of one step
MOST_ROUNDS = 100  # changes that raise each other at one instant
SHARPNESS = 1e-12  # an instant is found to this share of a step, or to some units in the last place of the time
_MOST_TRIALS = 100
_PASSES_ZERO = 1e-6  # a determinant that is smaller after its change of sign than this share of before has passed zero


@dataclass(frozen=True, slots=True)
class _Trial:
    """The run after a step of some length, with its guards."""

    length: float
    memory: Memory
    guards: FloatArray


class Follower(Protocol):
    """What else follows the events of a run."""

    def arrived(self, memory: Memory, number: int) -> None:
        """The guard of an event has become positive at an instant that was searched for."""
        ...

    def changed(self, memory: Memory, slots: Sequence[Slot], first: int, values: FloatArray) -> None:
        """States or held values have become entries of JUMP, from `first` on."""
        ...

    def left(self, memory: Memory) -> None:
        """Everything that happens at the instant has happened."""
        ...


class Events:
    """The events of one run as they happen; `keep_row` records all signals at an instant, before and after it.

    When `is_stopping`, the last event of the model changes nothing and ends the run.
    """

    def __init__(
        self,
        compiled: CompiledModel,
        machine: Machine,
        step: float,
        keep_row: Callable[[float, FloatArray], None],
        earlier: tuple[EventRecord, ...] = (),
        *,
        is_stopping: bool = False,
        follower: Follower | None = None,
    ) -> None:
        self._compiled = compiled
        self._machine = machine
        self._follower = follower
        self._step = step
        self._keep_row = keep_row
        self._earlier = earlier
        self._stop = len(compiled.system.events) - 1 if is_stopping else -1
        self._ranks = {n: event for n, event in enumerate(compiled.system.events) if isinstance(event, RankLoss)}
        self._silent = [*self._ranks, self._stop]  # numbers of events that change nothing
        self._happened: list[EventRecord] = []
        self._recent: dict[Path, deque[float]] = {}
        self._energies = _energy_entries(compiled.lowered, compiled)
        self._switches = Switches(compiled.lowered, machine.switching)

    @property
    def records(self) -> tuple[EventRecord, ...]:
        """Every event since the origin of the run."""
        return (*self._earlier, *self._happened)

    def begin(self, memory: Memory) -> Ending | None:
        """Let happen what is true at the start."""
        if not memory.guard.size:
            return None
        try:
            signals = self._machine.observe(memory)
            self._switches.decide(memory)
            guards = self._machine.guards(memory)
            memory.guard[list(self._ranks)] = guards[list(self._ranks)]
            if has_risen(memory.guard, guards).any() or self._switches.violation(memory).size > 0.0:
                if not self._switches:  # before the start nothing says how switches were
                    self._keep_row(memory.time, signals)
                return self._change(memory, guards, signals)
            self._switches.hold(memory)
            return None
        except SimulationError as error:
            return _unsolved(memory.time, error)

    def happen(self, memory: Memory, step: float) -> Ending | None:
        """Find the first event in a step, go there and make its changes; an ending where this has no end."""
        try:
            earlier = self._machine.guards(memory)
            found = self._find(memory, step)
            lost = self._rank_lost(memory.guard, earlier, found.guards)
            _move(found.memory, memory)
            if lost is not None:
                return _singular(memory.time, lost)
            self._tell_arrival(memory, found)
            signals = self._machine.observe(memory)
            self._keep_row(memory.time, signals)
            return self._change(memory, found.guards, signals)
        except SimulationError as error:
            return _unsolved(memory.time, error)

    # -- the instant -------------------------------------------------------------------------------

    def _find(self, memory: Memory, step: float) -> _Trial:
        """The run just after a guard has become positive."""
        before = memory.guard
        low = _Trial(0.0, memory, self._machine.guards(memory))
        if has_risen(before, low.guards).any():
            return replace(low, memory=memory.copy())
        high = self._trial(memory, step)
        sharpness = max(SHARPNESS * step, 4.0 * math.ulp(memory.time))
        weights = [1.0, 1.0]  # of the guards at both ends
        moves: list[bool] = []  # whether a trial moved the high end
        for _ in range(_MOST_TRIALS):
            width = high.length - low.length
            if width <= sharpness:
                break
            is_slow = len(moves) >= 3 and len(set(moves[-3:])) == 1
            share = 0.5 if is_slow else _share(before, low.guards, high.guards, weights)
            # Near an end the root is not hit but enclosed.
            margin = min(0.5 * sharpness / width, 0.5)
            middle = self._trial(memory, low.length + width * min(max(share, margin), 1.0 - margin))
            is_after = bool(has_risen(before, middle.guards).any())
            low, high = (low, middle) if is_after else (middle, high)
            # The Illinois rule: an end that stays counts less and less.
            if moves and moves[-1] is is_after:
                weights[0 if is_after else 1] *= 0.5
            else:
                weights = [1.0, 1.0]
            moves.append(is_after)
        return high

    def _trial(self, memory: Memory, length: float) -> _Trial:
        trial = memory.copy()
        self._machine.advance(trial, length)
        return _Trial(length, trial, self._machine.guards(trial))

    def _rank_lost(self, kept: FloatArray, earlier: FloatArray, now: FloatArray) -> RankLoss | None:
        """The equations whose determinant has passed zero, rather than jumped over it."""
        risen = has_risen(kept, now)
        for number, event in self._ranks.items():
            if risen[number] and now[number] <= _PASSES_ZERO * abs(earlier[number]) < math.inf:
                return event
        return None

    def _tell_arrival(self, memory: Memory, found: _Trial) -> None:
        """Tell a follower of the event that decides the instant, unless it is the beginning of a step."""
        risen = np.flatnonzero(has_risen(memory.guard, found.guards))
        loud = risen[~np.isin(risen, self._silent)]
        if self._follower is not None and found.length > 0.0 and loud.size:
            self._follower.arrived(memory, int(loud[0]))

    # -- the changes -------------------------------------------------------------------------------

    def _change(self, memory: Memory, guards: FloatArray, signals: FloatArray) -> Ending | None:
        """Make the changes of all guards that have become positive, and of those that these raise.

        What switches hold is settled when no further one moves.
        """
        is_stopped = False
        for _ in range(MOST_ROUNDS):
            risen = np.flatnonzero(has_risen(memory.guard, guards))
            memory.guard[:] = guards
            if not risen.size:
                guards, signals = self._settle(memory, signals)
                if has_risen(memory.guard, guards).any():
                    continue
                if self._follower is not None:
                    self._follower.left(memory)
                self._keep_row(memory.time, signals)
                return _stopped(memory.time) if is_stopped else self._endless(memory.time)
            is_stopped = is_stopped or self._stop in risen
            values = self._jumps(memory, risen)
            struck, signals = self._strike(memory, risen, values, signals)
            later = sum(struck.values())  # what impulses take away that has not been told yet
            for number in risen[~np.isin(risen, self._silent)]:
                before = self._energy(signals)
                self._apply(memory, int(number), values)
                self._switches.decide(memory)
                signals = self._machine.observe(memory)
                element = self._compiled.system.events[number].element
                after = self._energy(signals)
                rest = later - struck.get(int(number), 0.0)
                self._happened.append(EventRecord(memory.time, element, before + later, after + rest))
                later = rest
                recent = self._recent.setdefault(element, deque(maxlen=MOST_IN_ONE_STEP))
                recent.append(memory.time)
            guards = self._machine.guards(memory)
        self._keep_row(memory.time, signals)
        count = Counter(record.element for record in self._happened if record.time == memory.time)
        path = count.most_common(1)[0][0]
        return _chattering(path, memory.time, f"{MOST_ROUNDS} times in a row, they make each other happen at once")

    def _settle(self, memory: Memory, signals: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Bring the states where the switches ask them to be; the guards and signals then."""
        if not self._switches:
            return memory.guard, signals
        before = self._energy(signals)
        done = commutate(self._compiled, self._machine, self._switches, memory)
        self._switches.hold(memory)
        signals = self._machine.observe(memory)
        after = self._energy(signals)
        if done is not None and not done.is_small:
            if after > before:
                raise SimulationError.of(
                    "simulation/not-converged",
                    f"an impulse of {', '.join(map(str, done.members))} would add {after - before:g} J",
                    help="put a resistance in series with the switch",
                )
            self._happened.append(EventRecord(memory.time, done.element, before, after))
        return self._machine.guards(memory), signals

    def _jumps(self, memory: Memory, risen: IntArray) -> FloatArray:
        """What these events make of the run, impulses of all of them together."""
        impacts = self._compiled.lowered.impacts
        for number, flag in () if impacts is None else impacts.flags:
            memory.unknown[flag.index] = 1.0 if number in risen else 0.0
        return self._machine.jumps(memory)

    def _strike(
        self, memory: Memory, risen: IntArray, values: FloatArray, signals: FloatArray
    ) -> tuple[Mapping[int, float], FloatArray]:
        """Let impulses change the states; the energy that each event loses, and the signals afterwards.

        What they lose together is shared out as the work of their impulses.
        """
        impacts = self._compiled.lowered.impacts
        if impacts is None or not any(number in risen for number, _ in impacts.flags):
            return {}, signals
        before = self._energy(signals)
        for k, slot in enumerate(impacts.states):
            memory.state[slot.index] = values[impacts.first + k]
        if self._follower is not None:
            self._follower.changed(memory, impacts.states, impacts.first, values)
        signals = self._machine.observe(memory)
        lost = before - self._energy(signals)
        works = {
            number: abs(float(values[impacts.first + len(impacts.states) + k]))
            for k, (number, _) in enumerate(impacts.flags)
            if number in risen
        }
        total = sum(works.values())
        return {n: lost * (work / total if total else 1.0 / len(works)) for n, work in works.items()}, signals

    def _apply(self, memory: Memory, number: int, values: FloatArray) -> None:
        targets = self._compiled.lowered.targets
        first = sum(len(slots) for slots in targets[:number])
        for k, slot in enumerate(targets[number]):
            array = memory.state if slot.array is Array.STATE else memory.discrete
            array[slot.index] = values[first + k]
        if self._follower is not None:
            self._follower.changed(memory, targets[number], first, values)

    def _energy(self, signals: FloatArray) -> float:
        return float(signals[self._energies].sum())

    def _endless(self, now: float) -> Ending | None:
        """The ending of a run in which an element has too many events within one step."""
        for path, times in self._recent.items():
            if len(times) == MOST_IN_ONE_STEP and times[-1] == now and now - times[0] < self._step:
                return _chattering(path, now, f"{MOST_IN_ONE_STEP} of them lie within one step of {self._step:g} s")
        return None


def _share(before: FloatArray, low: FloatArray, high: FloatArray, weights: list[float]) -> float:
    """Where between two trials the first of the guards that have become positive is zero, if they were straight."""
    shares = [
        weights[0] * -float(low[i]) / (weights[0] * -float(low[i]) + weights[1] * float(high[i]))
        for i in np.flatnonzero(has_risen(before, high))
        if math.isfinite(low[i]) and math.isfinite(high[i]) and low[i] <= 0.0
    ]
    return min(shares, default=0.5)


def _move(source: Memory, target: Memory) -> None:
    """Bring the run in one memory to where it is in another."""
    for name in ("state", "unknown", "integral", "activity"):
        getattr(target, name)[...] = getattr(source, name)
    target.steps_taken += 1 if source.time > target.time else 0
    target.time = source.time


def _energy_entries(lowered: Lowered, compiled: CompiledModel) -> list[int]:
    """Where the energies of all storage are; what storage on pseudo bonds holds is no energy."""
    pseudo = pseudo_elements(compiled.graph)
    stored = [found.element for found in compiled.system.energies if found.element not in pseudo]
    return [lowered.observables[element / "energy"].index for element in stored]


def _stopped(time: float) -> Ending:
    return Ending(RunStatus.STOPPED, f"stopped at {time:.6g} s, where its condition has become true", time)


def _singular(time: float, lost: RankLoss) -> Ending:
    names, causes = listed(map(str, lost.paths)), listed(map(str, lost.changing))
    return Ending(
        RunStatus.FAILED,
        f"stopped at {time:.6g} s: the equations of {names} determine nothing there, as {causes} changes: their "
        "determinant passes zero (a resistance that has become negative, a gain of a loop that reaches 1)",
        time,
        lost.element,
    )


def _unsolved(time: float, error: SimulationError) -> Ending:
    return Ending(RunStatus.FAILED, f"stopped at {time:.6g} s, at an event: {error.diagnostics[0].message}", time)


def _chattering(path: Path, time: float, why: str) -> Ending:
    message = f"stopped at {time:.6g} s: the events of {path} follow each other without end: {why}"
    return Ending(RunStatus.CHATTERING, message, time, path)
