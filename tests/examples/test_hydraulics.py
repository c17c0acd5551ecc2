"""Hydraulic examples against closed forms and equations written by hand."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from tests.examples.runs import answer


def solved(rates, start, times, **options):
    """Hand-written equations by an independent integrator, tightly."""
    done = solve_ivp(rates, (times[0], times[-1]), start, t_eval=times, rtol=1e-10, atol=1e-12, **options)
    assert done.success
    return done.y


def test_two_tanks_by_torricelli_and_poiseuille():
    run = answer("two_tanks")
    rho, g = 1000.0, 9.80665
    conductance = math.pi * 0.010**4 / (128 * 1e-3 * 2.0) * rho * g

    def rates(t, levels):
        pipe = conductance * (levels[0] - levels[1])
        out = 0.61 * 4e-5 * math.sqrt(2 * g * max(levels[1], 0.0))
        return [-pipe / 0.10, (pipe - out) / 0.05]

    upper, lower = solved(rates, [1.0, 0.0], run.time)
    np.testing.assert_allclose(run["upper.port.effort"] / (rho * g), upper, atol=2e-4)
    np.testing.assert_allclose(run["lower.port.effort"] / (rho * g), lower, atol=2e-4)
