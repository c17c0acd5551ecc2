"""The native loop alone: no start of a run, no recording, no report around it; code compiled thoroughly."""

from __future__ import annotations

from time import process_time

from propermodel.codegen.machine import Memory, Method, Request, Status
from propermodel.codegen.native import NativeMachine
from propermodel.compiler import CompiledModel
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import start_of


class Alone:
    """A model at the start of a scenario, with a method."""

    def __init__(self, compiled: CompiledModel, scenario: Scenario, method: Method) -> None:
        self._machine = NativeMachine(compiled.lowered.program, method, long_run=0)
        self._start = start_of(compiled, scenario).memory
        self._scenario = scenario
        self._method = method

    def run(self, value: float, jacobian_every: int = 1) -> Memory:
        """A run at a step, s, or at a tolerance where the method chooses its steps.

        Raises:
            ArithmeticError: it does not reach its end.
        """
        scenario = self._scenario
        is_adaptive = self._method.is_adaptive
        request = Request(
            until=scenario.stop,
            step=scenario.stop - scenario.start if is_adaptive else value,
            tolerance=value if is_adaptive else 0.5,
            jacobian_every=jacobian_every,
            most_ticks=10**9,
        )
        memory = self._start.copy()
        outcome = self._machine.run(memory, request)
        if outcome.status is not Status.FINISHED:
            raise ArithmeticError(f"{outcome.status} at {outcome.time:g} s")
        return memory

    def seconds(self, value: float, jacobian_every: int = 1) -> float:
        """The processor time of a run."""
        begin = process_time()
        self.run(value, jacobian_every)
        return process_time() - begin
