"""Transfer functions as zeros, poles and gain."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from propermodel.analysis.responses import connected_states
from propermodel.analysis.spectrum import ROUNDING, ComplexArray, Root, all_values, balanced, roots_of
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Path, SimulationError
from propermodel.expressions.core import Expr

if TYPE_CHECKING:
    from propermodel.analysis.linear_model import LinearModel

LARGEST = 600.0  # of the logarithm of a gain
CANCELLED = 1e-7  # a zero this near to a pole, as a share of its size, cancels it


@dataclass(frozen=True, eq=False, kw_only=True)
class TransferFunction:
    """gain * product of (s - zero) / product of (s - pole), in SI.

    Modes that the input does not move or the output does not show are left out.
    """

    input: Path
    output: Path
    zeros: ComplexArray  # 1/s
    poles: ComplexArray  # 1/s
    gain: float

    def __call__(self, s: complex) -> complex:
        """Its value at a complex frequency, rad/s.

        Raises:
            ZeroDivisionError: s is a pole.
        """
        value = complex(self.gain)
        below: list[complex] = self.poles.tolist()
        for zero in reversed(self.zeros.tolist()):
            value *= (s - zero) / (s - below.pop()) if below else s - zero
        for pole in below:
            value /= s - pole
        return value

    @property
    def relative_degree(self) -> int:
        """The number of poles less that of zeros; negative where the output follows rates of the input."""
        return len(self.poles) - len(self.zeros)

    @property
    def static_gain(self) -> float:
        """The value at s = 0: the lasting answer to a step of 1 where it is stable; infinite with a pole at 0."""
        if np.any(self.poles == 0.0):
            return math.inf
        return self(0.0).real

    def to_scipy(self) -> Any:
        """The same as `scipy.signal.ZerosPolesGain`."""
        from scipy.signal import ZerosPolesGain

        return ZerosPolesGain(self.zeros, self.poles, self.gain)

    def __str__(self) -> str:
        above, below = _factors(self.zeros), _factors(self.poles)
        numerator = " ".join([f"{self.gain:.6g}", *above])
        width = max(len(numerator), len(" ".join(below)))
        fraction = [numerator.center(width), "-" * width, " ".join(below).center(width)] if below else [numerator]
        return "\n".join([f"{self.output} / {self.input} =", *(f"  {line}".rstrip() for line in fraction)])


def transfer_function(
    model: LinearModel, input: Expr | Path | str | None, output: Expr | Path | str | None
) -> TransferFunction:
    """The transfer function from one input to one output.

    Raises:
        SimulationError: there is no such input or output, a name is left out and there are several, or the gain is too
            large or too small for a number.
    """
    row, column = model.output_index(output), model.input_index(input)
    used = connected_states(model, [column], [row])
    A = model.A[np.ix_(used, used)]
    rate = model.B_rate[used, column]
    b, c = model.B[used, column] + A @ rate, model.C[row, used]
    d = float(model.D[row, column] + c @ rate)
    try:
        zeros, gain = _zeros(A, b, c, d, float(model.D_rate[row, column]))
    except OverflowError:
        raise SimulationError.of(
            "linear/gain",
            f"the gain from {model.inputs[column]} to {model.outputs[row]} is no floating-point number: "
            "too many poles lie between the two",
            help="use frequency_response(), or an output nearer to the input",
        ) from None
    poles = roots_of(A)
    if gain == 0.0:
        above = below = np.zeros(0, dtype=np.complex128)
    else:
        above, below = _without_common(all_values(zeros), all_values(poles))
    return TransferFunction(input=model.inputs[column], output=model.outputs[row], zeros=above, poles=below, gain=gain)


def _zeros(a: FloatArray, b: FloatArray, c: FloatArray, d: float, d_rate: float) -> tuple[tuple[Root, ...], float]:
    """The zeros of c (s - a)^-1 b + d + d_rate s, and the factor of its highest power of s.

    While the output does not show the input itself, zeros have c x = 0: the part of the state along c goes, and the
    rate of c x is the next output (Emami-Naeini and Van Dooren (1982), Automatica 18, 415, for one input and output).

    Raises:
        OverflowError: the factor is not within the range of floating-point numbers.
    """
    if d_rate != 0.0:
        # Divided by s, the function is proper: an integrator stands before the input.
        count = len(a)
        a = np.block([[a, b[:, np.newaxis]], [np.zeros((1, count + 1))]])
        b, c, d = np.append(np.zeros(count), 1.0), np.append(c, d), d_rate
    evened = balanced(np.block([[a, b[:, np.newaxis]], [c[np.newaxis], np.array([[d]])]]))[0]
    a, b, c = evened[:-1, :-1], evened[:-1, -1], evened[-1, :-1]
    norm = float(np.linalg.norm(a)) or 1.0
    first, times, exponent = _first_markov_parameter(a / norm, b, c, d)
    if first == 0.0:
        return (), 0.0
    direct, lengths = math.copysign(1.0, first), 0.0
    for _ in range(times):
        length = float(np.linalg.norm(c))
        along = c / length
        rest = np.linalg.svd(along[np.newaxis])[2][1:].T
        lengths += math.log(length)
        c, a, b = along @ a @ rest, rest.T @ a @ rest, rest.T @ b
    size = math.log(abs(first)) + exponent + max(times - 1, 0) * math.log(norm)
    if abs(size) > LARGEST:
        raise OverflowError
    return roots_of(a - np.outer(b, c) / (direct * math.exp(size - lengths)), norm), direct * math.exp(size)


def _first_markov_parameter(a: FloatArray, b: FloatArray, c: FloatArray, d: float) -> tuple[float, int, float]:
    """The first of d, c b, c a b, ... that is more than rounding, its number, and the logarithm of its factor.

    The parameter is 0 if all of them vanish.
    """
    if d != 0.0:
        return d, 0, 0.0
    moved, bound, exponent = b, np.abs(b), 0.0
    for times in range(1, len(a) + 1):
        size = float(np.max(bound))
        if size == 0.0:
            break
        moved, bound, exponent = moved / size, bound / size, exponent + math.log(size)
        value, largest = float(c @ moved), float(np.abs(c) @ bound)
        if abs(value) > times * len(a) * ROUNDING * largest:
            return value, times, exponent
        moved, bound = a @ moved, np.abs(a) @ bound
    return 0.0, 0, 0.0


def _without_common(zeros: ComplexArray, poles: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Zeros and poles without those that cancel: modes that the input does not move or the output does not show."""
    left = list(poles)
    kept: list[complex] = []
    for zero in zeros:
        near = min(left, key=lambda pole: abs(pole - zero), default=None)
        if near is not None and abs(near - zero) <= CANCELLED * abs(near):
            left.remove(near)
        else:
            kept.append(zero)
    return np.array(kept, dtype=np.complex128), np.array(left, dtype=np.complex128)


def _factors(roots: ComplexArray) -> list[str]:
    """The factors of a polynomial as text, conjugate roots as one, equal ones as a power."""
    texts: list[str] = []
    for root, times in Counter(root for root in roots.tolist() if root.imag >= 0.0).items():
        if root.imag > 0.0:
            middle = f"{-2.0 * root.real:+.6g} s" if root.real else ""
            text = f"(s^2{middle}{abs(root) ** 2:+.6g})"
        else:
            text = f"(s{-root.real:+.6g})" if root.real else "s"
        texts.append(text if times == 1 else f"{text}^{times}")
    return texts
