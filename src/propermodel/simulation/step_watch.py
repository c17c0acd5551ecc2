"""Tells during a run that its steps are too long, before numbers grow without end, or chatter unnoticed.

The machine pauses where its estimate of the fastest mode says so (`codegen/fastest.py`). What the run then says follows
from the exact Jacobian in the middle of its next step; of a large model, from more iterations there.
"""

from __future__ import annotations

from dataclasses import replace

from propermodel.codegen.fastest import LONGEST, LOOK_EVERY, NEVER, fastest_at, is_too_fast
from propermodel.codegen.machine import Machine, Memory, Request
from propermodel.compiler import CompiledModel
from propermodel.simulation.stability import MOST_STATES, limit_below

FIRST_REST = 64  # looks that are left out after one that saw too much; twice as many after the next


class StepWatch:
    """The watch over the steps of one run; `note` says what was found."""

    def __init__(self, compiled: CompiledModel, machine: Machine, step: float, window: float) -> None:
        self._compiled = compiled
        self._machine = machine
        self._step = step
        self._window = window
        self._rest = FIRST_REST
        self.note: str | None = None

    def heed(self, memory: Memory) -> None:
        """Look closely where a run has paused because its steps seem too long."""
        method = self._machine.method
        if self.note is not None or not is_too_fast(memory, method, self._step):
            return
        reason = self._reason(self._middle(memory))
        if reason is None:
            memory.next_look = memory.steps_taken + self._rest * LOOK_EVERY
            memory.fastest = 0.0
            self._rest *= 2
            return
        memory.next_look = NEVER
        self.note = (
            f"a step of {self._step:g} s is too long from {memory.time:.4g} s on: {reason}; take a smaller step, or "
            "the method ros2 or rodas"
        )

    def _middle(self, memory: Memory) -> Memory:
        """The run in the middle of its next step."""
        after = memory.copy()
        self._machine.run(after, Request(until=memory.time + self._step, step=self._step))
        return replace(memory.copy(), state=0.5 * (memory.state + after.state))

    def _reason(self, memory: Memory) -> str | None:
        method, states = self._machine.method, self._compiled.system.states
        if len(states) <= MOST_STATES:
            limit = limit_below(self._compiled, memory, method, self._step, self._window)
            return None if limit is None else str(limit)
        found = fastest_at(self._machine, memory)
        if found is None or found[0] * self._step <= LONGEST[method]:
            return None
        rate, state = found
        return (
            f"{method} is stable with steps up to {LONGEST[method] / rate:.2g} s here: the fastest mode, in which "
            f"{states[state].path} has the largest part, has an eigenvalue of the size {rate:.4g} 1/s"
        )
