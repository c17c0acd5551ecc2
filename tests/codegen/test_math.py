"""The elementary functions of native code, against the system's library."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from propermodel.codegen.machine import Method
from propermodel.codegen.native import NativeMachine
from propermodel.expressions import atan2, cos, exp, log, sin, tanh
from propermodel.expressions.core import Expr
from tests.codegen.programs import Draft

LANES = 4
WIDTH = 50


def evaluate(function: Callable[..., Expr], *arguments: np.ndarray) -> np.ndarray:
    """A function of numbers in native code, lane by lane."""
    draft = Draft()
    leaves = [[draft.state(f"x{k}_{i}") for i in range(WIDTH)] for k in range(len(arguments))]
    for i in range(WIDTH):
        draft.signal(function(*(column[i] for column in leaves)))
    machine = NativeMachine(draft.program(), Method.EULER, LANES)
    memory = draft.memory(LANES)
    size = WIDTH * LANES
    count = arguments[0].size
    padded = [np.resize(argument, -(-count // size) * size).reshape(-1, WIDTH, LANES) for argument in arguments]
    found = []
    for columns in zip(*padded, strict=True):
        memory.state[:] = np.concatenate(columns)
        found.append(machine.observe(memory))
    return np.array(found).ravel()[:count]


SPECIAL = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, -1e-310, 1e308, 710.0, -745.2, -1.0, 2e6, 1e22])
RANDOM = np.random.default_rng(0)
NEAR = RANDOM.uniform(-7.0, 7.0, 4000)
TINY = RANDOM.normal(size=1000) * 1e-6
FUNCTIONS = {
    "exp": (exp, np.exp, np.concatenate([SPECIAL, NEAR, TINY, RANDOM.uniform(-744.0, 709.0, 4000)])),
    "log": (log, np.log, np.concatenate([SPECIAL, np.exp(100.0 * NEAR), 1.0 + TINY, RANDOM.uniform(0.5, 2.0, 4000)])),
    "sin": (sin, np.sin, np.concatenate([SPECIAL, NEAR, TINY, RANDOM.uniform(-1e6, 1e6, 4000), np.arange(99) * np.pi])),
    "cos": (cos, np.cos, np.concatenate([SPECIAL, NEAR, TINY, RANDOM.uniform(-1e6, 1e6, 4000), np.arange(99) * np.pi])),
    "tanh": (tanh, np.tanh, np.concatenate([SPECIAL, NEAR, TINY, RANDOM.uniform(-25.0, 25.0, 4000)])),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_are_accurate_to_their_last_places(name: str) -> None:
    function, reference, places = FUNCTIONS[name]
    with np.errstate(all="ignore"):
        expected = reference(places)
    np.testing.assert_allclose(evaluate(function, places), expected, rtol=1.2e-15, atol=1e-323)


def test_the_angle_of_two_numbers() -> None:
    ends = np.array([0.0, -0.0, 1.0, -1.0, np.nan, 1e-320, 1e200])
    y, x = (
        np.concatenate([part.ravel(), NEAR * size]) for part, size in zip(np.meshgrid(ends, ends), (1, 3), strict=True)
    )
    x[-2000:] *= np.exp(NEAR[-2000:])
    expected = np.arctan2(y, x)
    found = evaluate(atan2, y, x)
    np.testing.assert_allclose(found, expected, rtol=4e-16, atol=1e-323)
    np.testing.assert_array_equal(np.signbit(found[:-4000]), np.signbit(expected[:-4000]))


@pytest.mark.parametrize("exponent", [1.4, -1.4, 0.3, 2.7, -3.1, 1.0 / 7.0, 40.25, 33.0, -0.001])
def test_powers_with_any_exponent(exponent: float) -> None:
    ends = np.array([0.0, -0.0, np.inf, np.nan, -1.0, 1e300, 1e-310])
    bases = np.concatenate([ends, np.exp(3.0 * NEAR), RANDOM.uniform(0.5, 2.0, 2000)])
    with np.errstate(all="ignore"):
        expected = bases**exponent
    np.testing.assert_allclose(evaluate(lambda x: x**exponent, bases), expected, rtol=2e-15, atol=1e-323)
