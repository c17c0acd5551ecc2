"""Steps of the interpreted machine that control their length; the order of operations is that of the native code."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from propermodel.codegen.interpreted_code import AllFailed, Code, ImplicitCode, Working
from propermodel.codegen.machine import FloatArray
from propermodel.codegen.program import Array
from propermodel.codegen.step_control import TINY
from propermodel.codegen.tableaus import ExplicitTableau

Evaluate = Callable[[Working, Code, float], None]


class Attempt:
    """What the steps of one call keep: where the last one began, and powers along it."""

    def __init__(self, run: Working, rates: Code, evaluate: Evaluate, sizes: FloatArray, tolerance: float) -> None:
        self._run = run
        self._rates = rates
        self._evaluate = evaluate
        self._sizes = sizes
        self._tolerance = tolerance
        self._state = run.memory.state.copy()
        self._unknown = run.memory.unknown.copy()
        self._powers: list[FloatArray] = [np.zeros_like(run.arrays[Array.POWER])] * 2  # at the beginning, in the middle
        self._slopes: list[FloatArray] = []
        self.errors = np.zeros_like(run.memory.state)  # shares of what is tolerated

    def take_implicit(self, code: ImplicitCode, time: float, h: float) -> float:
        """Take a step; its error."""
        run = self._begin()
        try:
            run.arrays[Array.STEP][:] = h
            self._evaluate(run, code.first, time)
        except AllFailed:
            return math.nan  # which no shorter step can mend
        try:
            run.fail_weak(code.start)
            if not run.memory.alive.any():
                return math.inf
            self._complete()
            for stage, share in zip(code.later, code.shares, strict=True):
                self._evaluate(run, stage, time + h * share)
        except AllFailed:
            return math.inf
        return self._norm()

    def take_explicit(self, tableau: ExplicitTableau, time: float, h: float, *, is_fresh: bool) -> float:
        """Take a step; its error."""
        run = self._begin()
        try:
            if is_fresh:
                self._evaluate(run, self._rates, time)
                self._slopes = [run.arrays[Array.RATE].copy()]
                self._powers[0] = run.arrays[Array.POWER].copy()
        except AllFailed:
            return math.nan  # which no shorter step can mend
        try:
            del self._slopes[1:]
            for row, share in zip(tableau.a, tableau.c[1:], strict=True):
                run.memory.state[...] = self._state + self._combined(row) * h
                self._evaluate(run, self._rates, time + h * share)
                self._slopes.append(run.arrays[Array.RATE].copy())
        except AllFailed:
            return math.inf
        run.arrays[Array.ERROR][...] = self._combined(tableau.error) * h
        return self._norm()

    def restore(self) -> None:
        """Take the step back."""
        self._run.memory.state[...] = self._state
        self._run.memory.unknown[...] = self._unknown

    def revive(self, failures: int) -> None:
        """Forgive what had no solution in the step: all but so many failures."""
        del self._run.failures[failures:]
        self._run.memory.alive[:] = True

    def commit_implicit(self, code: ImplicitCode, time: float, h: float) -> None:
        """Make the step part of the run; its integrals wait for the powers at its end."""
        run = self._run
        end = run.memory.state.copy()
        assert code.middle is not None
        self._evaluate(run, code.middle, time + h * 0.5)
        self._evaluate(run, self._rates, time + h * 0.5)
        self._powers[1] = run.arrays[Array.POWER].copy()
        run.memory.state[...] = end
        self._grow()
        run.pending = h

    def commit_explicit(self, tableau: ExplicitTableau, time: float, h: float) -> None:
        """Make the step part of the run."""
        run = self._run
        end, power = run.memory.state.copy(), run.arrays[Array.POWER].copy()
        run.memory.state[...] = self._state + self._combined(tableau.middle) * h
        self._evaluate(run, self._rates, time + h * 0.5)
        self._integrate(self._powers[0], run.arrays[Array.POWER], power, h)
        self._powers[0] = power
        self._slopes = self._slopes[-1:]
        run.memory.state[...] = end
        self._grow()

    def close(self, time: float) -> None:
        """Complete the integrals at the end of an implicit step."""
        self._evaluate(self._run, self._rates, time)
        self._complete()

    def _begin(self) -> Working:
        self._state[...] = self._run.memory.state
        self._unknown[...] = self._run.memory.unknown
        return self._run

    def _combined(self, weights: Sequence[float]) -> FloatArray:
        """The weighted sum of the slopes."""
        terms = [slope * weight for slope, weight in zip(self._slopes, weights, strict=False) if weight]
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total

    def _norm(self) -> float:
        memory = self._run.memory
        sizes = np.maximum(np.maximum(np.abs(memory.state), memory.size), np.maximum(self._sizes, TINY))
        shares = np.abs(self._run.arrays[Array.ERROR]) / (self._tolerance * sizes)
        self.errors = np.where(np.isnan(shares), math.inf, shares)
        return float(np.max(self.errors, initial=0.0))

    def _grow(self) -> None:
        memory = self._run.memory
        np.maximum(memory.size, np.abs(memory.state), out=memory.size)

    def _complete(self) -> None:
        run = self._run
        power = run.arrays[Array.POWER].copy()
        if run.pending > 0.0:
            self._integrate(self._powers[0], self._powers[1], power, run.pending)
            run.pending = 0.0
        self._powers[0] = power

    def _integrate(self, begin: FloatArray, middle: FloatArray, end: FloatArray, span: float) -> None:
        """Add a step to the integrals, by the parabola q(s) = p + b s + a s^2 and its zeros."""
        a = ((begin + end) - middle * 2.0) * 2.0
        b = (end - begin) - a
        root = np.sqrt(np.maximum(b * b - (a * begin) * 4.0, 0.0))
        t = (b + np.copysign(root, b)) * -0.5
        first, second = (_within(r) for r in (t / a, begin / t))
        half, third = b * 0.5, a * (1.0 / 3.0)

        def integral(s: FloatArray) -> FloatArray:
            return s * (begin + s * (half + s * third))

        low, high = integral(np.minimum(first, second)), integral(np.maximum(first, second))
        whole = begin + (half + third)
        memory = self._run.memory
        memory.integral += whole * span
        memory.activity += ((np.abs(low) + np.abs(high - low)) + np.abs(whole - high)) * span


def _within(share: FloatArray) -> FloatArray:
    """A share of the step, kept within it; its beginning where there is none."""
    kept = np.where(share > 0.0, share, 0.0)
    return np.where(kept < 1.0, kept, 1.0)
