"""Mechanical examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

from tests.examples.runs import answer


def test_geared_inertias_turn_as_one():
    run = answer("geared_inertias")
    rotor = 3.0 / (0.01 + 0.5 / 25.0) * run.time
    np.testing.assert_allclose(run["rotor.shaft.flow"], rotor, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["drum.shaft.flow"], rotor / 5.0, rtol=1e-12, atol=1e-12)


def test_the_period_of_a_wide_swing_is_an_elliptic_integral():
    run = answer("pendulum")
    angle, t = run["weight.shaft.displacement"], run.time
    down = [i for i in range(len(t) - 1) if angle[i] > 0 >= angle[i + 1]]
    at = [t[i] + 0.01 * angle[i] / (angle[i] - angle[i + 1]) for i in down]
    small = 2 * math.pi * math.sqrt(0.5 / 9.80665)
    period = small * 2 / math.pi * ellipk(math.sin(math.radians(60.0)) ** 2)
    assert period / small == pytest.approx(1.373, abs=5e-4)  # what the docstring says
    assert at[1] - at[0] == pytest.approx(period, rel=1e-4)
