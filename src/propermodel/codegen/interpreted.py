"""The interpreted machine: the same program evaluated node by node with NumPy, as fallback and oracle.

A value is a float64, or an array of one per lane; the order of operations is that of the native code.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from propermodel.codegen.interpreted_attempt import Attempt
from propermodel.codegen.interpreted_code import AllFailed, Code, ImplicitCode, Working
from propermodel.codegen.interpreted_loop import AdaptiveLoop, Loop
from propermodel.codegen.machine import (
    QUADRATURE,
    FloatArray,
    IntArray,
    Memory,
    Method,
    Outcome,
    Request,
    check_memory,
    check_request,
    has_risen,
    not_solved,
)
from propermodel.codegen.program import Array, Program
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.codegen.rosenbrock import with_step_of
from propermodel.codegen.schedule import number_solves
from propermodel.codegen.step_control import (
    least_sizes,
    prepare_control,
)
from propermodel.codegen.tableaus import EXPLICIT_TABLEAUS


class InterpretedMachine:
    """Runs a program with NumPy."""

    def __init__(self, program: Program, method: Method, lanes: int = 1) -> None:
        self._program = program
        self._whole = program = with_reciprocals(with_step_of(program, method))
        numbers = number_solves(program)
        self._method = method
        self._lanes = lanes
        self._rates = Code(program, program.rates, numbers)
        self._displacement_rates = Code(program, program.displacement_rates, numbers)
        self._observe = Code(program, program.observe, numbers)
        self._samples = [Code(program, function, numbers) for function in program.samples]
        self._corrections = [Code(program, function, numbers) for function in program.corrections]
        self._guards = None if program.guards is None else Code(program, program.guards, numbers)
        self._jumps = None if program.jumps is None else Code(program, program.jumps, numbers)
        self._switching = None if program.switching is None else Code(program, program.switching, numbers)
        self._implicit = (
            None if program.implicit_step is None else ImplicitCode(program, program.implicit_step, numbers)
        )
        self._momenta: IntArray = np.array(program.layout.momenta, dtype=np.int64)
        count = program.layout.lengths.get(Array.STATE, 0)
        self._others: IntArray = np.setdiff1d(np.arange(count), self._momenta)

    @property
    def program(self) -> Program:
        """The program it executes."""
        return self._program

    @property
    def method(self) -> Method:
        """How it takes a step."""
        return self._method

    @property
    def lanes(self) -> int:
        """How many runs it does side by side."""
        return self._lanes

    def begun(self, memory: Memory) -> Working:
        """What functions read and write in a call that works on this memory."""
        return Working(self._whole, self._lanes, memory)

    def run(self, memory: Memory, request: Request) -> Outcome:
        """Continue the run in `memory` as requested."""
        check_memory(self._program, self._lanes, memory)
        check_request(self._program, memory, request)
        with np.errstate(all="ignore"):
            if not self._method.is_adaptive:
                return Loop(self, memory, request).run()
            prepare_control(self, memory, request)
            return AdaptiveLoop(self, memory, request).run()

    def rates(self, memory: Memory) -> tuple[FloatArray, FloatArray]:
        """The RATE and POWER arrays at the memory's time; the memory is not changed."""
        run = self._evaluated(memory.copy(), [self._rates])
        return run.arrays[Array.RATE], run.arrays[Array.POWER]

    def observe(self, memory: Memory) -> FloatArray:
        """The SIGNAL array at the memory's time; the memory is not changed."""
        return self._evaluated(memory.copy(), [self._observe]).arrays[Array.SIGNAL]

    def sample(self, memory: Memory) -> None:
        """Apply all controllers once, by rate, without counting a sample."""
        self._evaluated(memory, self._samples)

    def guards(self, memory: Memory) -> FloatArray:
        """The GUARD array at the memory's time; the memory is not changed."""
        codes = [] if self._guards is None else [self._guards]
        return self._evaluated(memory.copy(), codes).arrays[Array.GUARD]

    def jumps(self, memory: Memory) -> FloatArray:
        """The JUMP array at the memory's time; the memory is not changed."""
        codes = [] if self._jumps is None else [self._jumps]
        return self._evaluated(memory.copy(), codes).arrays[Array.JUMP]

    def switching(self, memory: Memory) -> FloatArray:
        """The SWITCHING array at the memory's time; the memory is not changed."""
        codes = [] if self._switching is None else [self._switching]
        return self._evaluated(memory.copy(), codes).arrays[Array.SWITCHING]

    def advance(self, memory: Memory, step: float) -> None:
        """Take one step of this length whatever the guards say."""
        if self._guards is None:
            raise ValueError("only a program with events is advanced by single steps")
        check_memory(self._program, self._lanes, memory)
        memory.alive[:] = True
        run = self.begun(memory)
        try:
            with np.errstate(all="ignore"):
                if self._method.is_adaptive:
                    attempt = self.attempt(run, Request(until=memory.time + step, step=step))
                    self.take(attempt, memory.time, step, is_fresh=True)
                    self.correct(run, memory.time + step)
                    self.commit(attempt, memory.time, step)
                    self.finish(attempt, memory.time + step)
                else:
                    self.step(run, memory.time, step)
                    self.close(run, memory.time + step)
        except AllFailed:
            raise not_solved(self._program, run.failures[0]) from None
        memory.time += step

    def meets_event(self, run: Working, time: float) -> bool:
        """Whether a guard has become positive since the guards were last kept; otherwise these are kept."""
        if self._guards is None:
            return False
        self.evaluate(run, self._guards, time)
        if has_risen(run.memory.guard, run.arrays[Array.GUARD]).any():
            return True
        run.memory.guard[:] = run.arrays[Array.GUARD]
        return False

    def _evaluated(self, memory: Memory, codes: Sequence[Code]) -> Working:
        check_memory(self._program, self._lanes, memory)
        run = self.begun(memory)
        if self._lanes == 1:
            memory.alive[:] = True
        with np.errstate(all="ignore"):
            for code in codes:
                code(run)
        if run.failures:
            raise not_solved(self._program, run.failures[0])
        return run

    def evaluate(self, run: Working, code: Code, time: float) -> None:
        """Execute a function at a time.

        Raises:
            AllFailed: an implicit block has no solution in the last lane alive.
        """
        run.time = time
        code(run)
        if not run.memory.alive.any():
            raise AllFailed

    def rates_at(self, run: Working, time: float) -> FloatArray:
        """The rates at a time of the call.

        Raises:
            AllFailed: an implicit block has no solution.
        """
        self.evaluate(run, self._rates, time)
        return run.arrays[Array.RATE]

    def sample_one(self, run: Working, k: int, time: float) -> None:
        """Apply the controllers of one rate."""
        self.evaluate(run, self._samples[k], time)

    def signals(self, run: Working, time: float) -> FloatArray:
        """All signals; the start of the next iteration is not changed by it."""
        kept = run.memory.unknown.copy()
        self.evaluate(run, self._observe, time)
        run.memory.unknown[...] = kept
        return run.arrays[Array.SIGNAL]

    def step(self, run: Working, time: float, h: float, is_fresh: bool = True) -> None:
        """Advance the states and the integrals by one step; if not fresh, an implicit one with the Jacobian it has."""
        if self._implicit is None:
            self._explicit_step(run, time, h)
        else:
            self._implicit_step(run, time, h, self._implicit, is_fresh)
        self.correct(run, time + h)

    def correct(self, run: Working, time: float) -> None:
        """Bring states back onto what they must obey."""
        for correction in self._corrections:
            self.evaluate(run, correction, time)

    @property
    def has_corrections(self) -> bool:
        """Whether states are changed after every step."""
        return bool(self._corrections)

    def attempt(self, run: Working, request: Request) -> Attempt:
        """What steps that control their length work on in one call."""
        return Attempt(run, self._rates, self.evaluate, least_sizes(run.memory, request), request.tolerance)

    def take(self, attempt: Attempt, time: float, h: float, *, is_fresh: bool) -> float:
        """Take a step that may be taken back; its error as a share of what is tolerated."""
        if self._implicit is not None:
            return attempt.take_implicit(self._implicit, time, h)
        return attempt.take_explicit(EXPLICIT_TABLEAUS[self._method], time, h, is_fresh=is_fresh)

    def commit(self, attempt: Attempt, time: float, h: float) -> None:
        """Make a step part of the run."""
        if self._implicit is not None:
            attempt.commit_implicit(self._implicit, time, h)
        else:
            attempt.commit_explicit(EXPLICIT_TABLEAUS[self._method], time, h)

    def finish(self, attempt: Attempt, time: float) -> None:
        """Complete the integrals at an instant."""
        if self._implicit is not None:
            attempt.close(time)

    def _implicit_step(self, run: Working, time: float, h: float, code: ImplicitCode, is_fresh: bool) -> None:
        run.arrays[Array.STEP][:] = h
        self.evaluate(run, code.first if is_fresh or code.first_again is None else code.first_again, time)
        if is_fresh:
            run.fail_weak(code.start)
            if not run.memory.alive.any():
                raise AllFailed
        self._add_powers(run, (run.pending + h) * QUADRATURE[self._method][0])
        run.pending = h
        for stage, share in zip(code.later, code.shares, strict=True):
            self.evaluate(run, stage, time + h * share)

    def close(self, run: Working, time: float) -> None:
        """Complete the integrals at the end of the last step before an instant."""
        if self._implicit is None:
            return
        self.evaluate(run, self._rates, time)
        self._add_powers(run, run.pending * QUADRATURE[self._method][-1])
        run.pending = 0.0

    def _explicit_step(self, run: Working, time: float, h: float) -> None:
        state, rate = run.arrays[Array.STATE], run.arrays[Array.RATE]
        self.evaluate(run, self._rates, time)
        self._integrate(run, h, 0)
        match self._method:
            case Method.EULER:
                state += rate * h
            case Method.SEMI_IMPLICIT:
                state[self._momenta] += rate[self._momenta] * h
                self.evaluate(run, self._displacement_rates, time + h)
                state[self._others] += rate[self._others] * h
            case Method.RK4:
                start, total, half = state.copy(), rate.copy(), h * 0.5
                for stage, (at, factor) in enumerate(((time + half, half), (time + half, half), (time + h, h)), 1):
                    state[...] = start + rate * factor
                    self.evaluate(run, self._rates, at)
                    self._integrate(run, h, stage)
                    total += rate * (2.0 if stage < 3 else 1.0)
                state[...] = start + total * (h * (1.0 / 6.0))
            case Method.ROS2 | Method.RODAS | Method.DOPRI5 | Method.CVODE:
                raise AssertionError("this method has its own step")

    def _integrate(self, run: Working, h: float, stage: int) -> None:
        self._add_powers(run, h * QUADRATURE[self._method][stage])

    def _add_powers(self, run: Working, span: float) -> None:
        part = run.arrays[Array.POWER] * span
        run.memory.integral += part
        run.memory.activity += abs(part)
