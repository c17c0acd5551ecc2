"""How a run ended, in a sentence that names the element and the reason."""

from __future__ import annotations

from collections.abc import Sequence

from propermodel.codegen.machine import Failure, Memory, Outcome, Status
from propermodel.codegen.schedule import number_solves
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.simulation.overflow import Overflow, overflow_at_end
from propermodel.simulation.singular import singular_reason
from propermodel.simulation.stability import reason_in_step
from propermodel.simulation.stepping import Stepping
from propermodel.simulation.switches import contradiction
from propermodel.simulation.trajectory import Ending, RunStatus


def ending_of(
    compiled: CompiledModel,
    outcome: Outcome | Ending | None,
    memory: Memory,
    before: Memory,
    overflow: Overflow | None,
    stepping: Stepping | None = None,
) -> Ending:
    """How a run of one lane ended.

    Args:
        compiled: The model.
        outcome: What the last call answered; None when the user interrupted, an ending where events have no end.
        memory: Where the run is.
        before: The memory before the last call, whose numbers were finite.
        overflow: The first energies that were no finite numbers, where some were kept.
        stepping: How it took its steps.
    """
    at = memory.time
    if outcome is None:
        return Ending(RunStatus.INTERRUPTED, f"interrupted at {at:.6g} s; what was computed is kept", at)
    if overflow is None and outcome.status in (Status.FINISHED, Status.PAUSED, Status.EVENT, RunStatus.STOPPED):
        overflow = overflow_at_end(memory)
    if overflow is not None:
        return overflow_ending(compiled, overflow, memory)
    if isinstance(outcome, Ending):
        return outcome
    match outcome.status:
        case Status.FINISHED | Status.PAUSED | Status.EVENT:
            return Ending(RunStatus.COMPLETED, f"completed to {at:.6g} s", at)
        case _:
            failure = Failure(0, outcome.status, outcome.time, outcome.index)
            return failed_ending(compiled, failure, memory, before, stepping)


def overflow_ending(compiled: CompiledModel, overflow: Overflow, memory: Memory) -> Ending:
    """The ending of a run whose energies are no longer finite numbers."""
    powers = [compiled.lowered.powers[index] for index in overflow.powers]
    path = _of_an_element(compiled, [power.path for power in powers])
    why = singular_reason(compiled, memory, (power.value for power in powers))
    return Ending(
        RunStatus.FAILED,
        f"stopped at {overflow.time:.6g} s: the energy exchanged at {path} is no longer a finite number; "
        f"{why or 'try a smaller step'}",
        overflow.time,
        path,
    )


def failed_ending(
    compiled: CompiledModel, failure: Failure, memory: Memory, before: Memory, stepping: Stepping | None = None
) -> Ending:
    """How a run of one lane failed.

    Args:
        compiled: The model.
        failure: What the machine said of it.
        memory: Where the run is.
        before: The memory before the last call, whose numbers were finite.
        stepping: How it took its steps.
    """
    match failure.status:
        case Status.NOT_FINITE:
            path = compiled.system.states[failure.index].path
            why = singular_reason(compiled, before)
            if not why and stepping is not None:
                why = reason_in_step(compiled, before, stepping.method, stepping.longest())
            return Ending(
                RunStatus.FAILED,
                f"stopped at {failure.time:.6g} s: the state {path} is no longer a finite number; "
                f"{why or 'try a smaller step'}",
                failure.time,
                path,
            )
        case Status.OUT_OF_RANGE:
            state = compiled.system.states[failure.index]
            value = float(memory.state[failure.index])
            return Ending(
                RunStatus.FAILED,
                f"stopped at {failure.time:.6g} s: the state {state.path} = {value:.6g} {state.unit} has left the "
                "range it is meant for",
                failure.time,
                state.path,
            )
        case Status.STEP_TOO_SMALL:
            path = compiled.system.states[failure.index].path
            why = singular_reason(compiled, memory)
            return Ending(
                RunStatus.FAILED,
                f"stopped at {failure.time:.6g} s: no step is short enough for the tolerance, most of the error is in "
                f"{path}; {why or 'is there a jump that should be an event, or a solution that has no end here?'}",
                failure.time,
                path,
            )
        case Status.SINGULAR_STEP:
            path = compiled.system.states[failure.index].path
            return Ending(
                RunStatus.FAILED,
                f"stopped at {failure.time:.6g} s: the equations of the implicit step are singular, first that of "
                f"{path}; try a smaller step, or rk4",
                failure.time,
                path,
            )
        case _:
            block = list(number_solves(compiled.lowered.program))[failure.index]
            names = ", ".join(str(path) for path in dict.fromkeys(block.paths))
            if any(switching.unknowns == block.unknowns for switching in compiled.system.switching):
                message = f"stopped at {failure.time:.6g} s: {contradiction(block.paths)}"
                return Ending(RunStatus.FAILED, message, failure.time, block.paths[0])
            closing = [str(c.element) for c in compiled.system.closures if c.element in block.paths]
            if closing and (len(closing) == len(block.paths) or block.unknowns[0].data.path.name == "rank"):
                return Ending(
                    RunStatus.FAILED,
                    f"stopped at {failure.time:.6g} s: the mechanism is in a singular position: {', '.join(closing)} "
                    "do not hold it independently there (bars in one line, a dead centre, a constraint stated twice)",
                    failure.time,
                    block.paths[0],
                )
            return Ending(
                RunStatus.FAILED,
                f"stopped at {failure.time:.6g} s: Newton's method found no solution for {names}",
                failure.time,
                block.paths[0],
            )


def _of_an_element(compiled: CompiledModel, paths: Sequence[Path]) -> Path:
    """The first of these paths that is a bond of an energy element, as authors know it, or the first."""
    known = {bond for row in compiled.system.rows for bond in row.bonds}
    return next((path for path in paths if path in known), paths[0])
