"""What events do to the derivatives of a run: the instant moves with the parameters, and what jumps there carries on.

With g the guard, f the rates and s the derivatives of the states x before the event, its instant moves by

    tau = - (dg/dx s + dg/dp) / (dg/dx f + dg/dt)

At the moving instant the derivatives are s + f tau; jumps act on these; afterwards, at a fixed time again, they are
less by the rates after the event times tau (the saltation matrix of Aizerman and Gantmakher, 1958).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propermodel.codegen.machine import FloatArray, Machine, Memory
from propermodel.codegen.program import Array, Slot
from propermodel.codegen.tangents import TangentProgram
from propermodel.diagnostics import Path, SimulationError


class TangentEvents:
    """Follows the events of a run with tangents.

    Raises:
        SimulationError: an instant has no derivative.
    """

    def __init__(
        self, tangents: TangentProgram, elements: Sequence[Path], names: Sequence[Path], machine: Machine
    ) -> None:
        self._tangents = tangents
        self._elements = elements  # of the events, in the order of their guards
        self._names = names  # of the directions
        self._machine = machine
        self._moves: FloatArray = np.zeros(len(tangents.directions))  # of the instant, with each parameter

    def arrived(self, memory: Memory, number: int) -> None:
        """A guard has become positive at an instant that was searched for."""
        tangents = self._tangents
        values = self._machine.jumps(memory)
        in_time = float(values[tangents.guard(len(tangents.directions))][number])
        for k in range(len(tangents.directions)):
            change = float(values[tangents.guard(k)][number])
            if change and not abs(in_time) > 0.0:
                raise SimulationError.of(
                    "simulation/sensitivities",
                    f"the instant at which {self._elements[number]} acts has no derivative with respect to "
                    f"{self._names[k]}: its condition is only just reached, or jumps",
                    help="take differences of two runs with slightly different parameters",
                )
            self._moves[k] = -change / in_time if change else 0.0
        self._shift(memory, 1.0)

    def changed(self, memory: Memory, slots: Sequence[Slot], first: int, values: FloatArray) -> None:
        """States or held values have become entries of JUMP, from `first` on."""
        tangents = self._tangents
        with_time = values[tangents.jump(len(tangents.directions))]
        for k, move in enumerate(self._moves):
            along = values[tangents.jump(k)]
            for place, slot in enumerate(slots, first):
                array, size = (
                    (memory.state, tangents.states)
                    if slot.array is Array.STATE
                    else (memory.discrete, tangents.discretes)
                )
                array[(k + 1) * size + slot.index] = along[place] + with_time[place] * move

    def left(self, memory: Memory) -> None:
        """Everything that happens at the instant has happened."""
        self._shift(memory, -1.0)
        self._moves[:] = 0.0

    def _shift(self, memory: Memory, sense: float) -> None:
        """Between derivatives at a fixed time and at the moving instant, which is later by `sense` times its move."""
        if not self._moves.any():
            return
        tangents = self._tangents
        rates, powers = self._machine.rates(memory)
        own = powers[: tangents.powers]
        for k, move in enumerate(sense * self._moves):
            memory.state[tangents.state(k)] += rates[: tangents.states] * move
            memory.integral[tangents.power(k)] += own * move
            memory.integral[tangents.absolute_power(k)] += np.abs(own) * move
