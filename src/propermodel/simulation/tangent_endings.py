"""How a run with derivatives ended: as the run itself would have, or at a derivative that is no finite number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propermodel.codegen.machine import Failure, Memory, Status
from propermodel.codegen.schedule import number_solves
from propermodel.codegen.tangents import TangentProgram
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.simulation.endings import failed_ending, overflow_ending
from propermodel.simulation.overflow import Overflow
from propermodel.simulation.trajectory import Ending, RunStatus


def ending_at_stop(
    compiled: CompiledModel, tangents: TangentProgram, memory: Memory, powers: Sequence[int], names: Sequence[Path]
) -> Ending:
    """The ending of a run of one lane that has come to its stop.

    Args:
        compiled: The model.
        tangents: Its program with tangents.
        memory: Where the run is.
        powers: The entries of POWER that the program has.
        names: The parameters of its directions.
    """
    at = memory.time
    bad = ~(np.isfinite(memory.integral) & np.isfinite(memory.activity))
    if not bad.any():
        return Ending(RunStatus.COMPLETED, f"completed to {at:.6g} s", at)
    own = np.flatnonzero(bad[: tangents.powers])
    if own.size:
        return overflow_ending(compiled, Overflow(at, tuple(powers[int(i)] for i in own)), memory)
    direction, place = divmod(int(np.flatnonzero(bad)[0]) - tangents.powers, 2 * tangents.powers)
    what = compiled.lowered.powers[powers[place % tangents.powers]].path
    return _not_finite(at, f"energy exchanged at {what}", what, names[direction])


def ending_of_failure(
    compiled: CompiledModel,
    tangents: TangentProgram,
    failure: Failure,
    memory: Memory,
    before: Memory,
    names: Sequence[Path],
) -> Ending:
    """The ending of a run of one lane that has failed; its memory there, and before the last call."""
    if failure.status is Status.NOT_CONVERGED:
        # The blocks of the program with tangents are some of those of the model, in another order.
        solve = list(number_solves(tangents.program))[failure.index]
        number = number_solves(compiled.lowered.program)[solve]
        return failed_ending(compiled, Failure(0, failure.status, failure.time, number), memory, before)
    if failure.index >= tangents.states:
        direction, place = divmod(failure.index - tangents.states, tangents.states)
        what = compiled.system.states[place].path
        return _not_finite(failure.time, f"state {what}", what, names[direction])
    return failed_ending(compiled, failure, memory, before)


def _not_finite(at: float, what: str, path: Path, name: Path) -> Ending:
    return Ending(
        RunStatus.FAILED,
        f"stopped at {at:.6g} s: the derivative of the {what} with respect to {name} is no longer a finite number: "
        "a law has a vertical tangent there, or deviations grow without bound",
        at,
        path,
    )
