"""Features of signals that have closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from propermodel.analysis.features import Peak, Undefined, signal_features

TIME = np.linspace(0.0, 20.0, 20001)


def test_a_lag_rises_and_settles_as_its_time_constant_says():
    # 1 - exp(-t / 2): from 10 % to 90 % in 2 ln 9; within 2 % after 2 ln 50.
    found = signal_features(TIME, 1.0 - np.exp(-TIME / 2.0))
    assert found.final == pytest.approx(1.0, abs=1e-4)
    assert found.rise == pytest.approx(2.0 * np.log(9.0), rel=1e-3)
    assert found.settling == pytest.approx(2.0 * np.log(50.0), rel=1e-3)


def test_the_overshoot_of_an_oscillator_is_its_peak():
    # Damping ratio 0.2 at 2 rad/s: overshoot exp(-pi z / sqrt(1 - z^2)) at pi / (2 sqrt(1 - z^2)).
    z, w = 0.2, 2.0
    damped = w * np.sqrt(1.0 - z * z)
    values = 1.0 - np.exp(-z * w * TIME) * (np.cos(damped * TIME) + z * w / damped * np.sin(damped * TIME))
    found = signal_features(TIME, values)
    assert isinstance(found.peak, Peak)
    assert found.peak.value == pytest.approx(1.0 + np.exp(-np.pi * z / np.sqrt(1.0 - z * z)), rel=1e-6)
    assert found.peak.after == pytest.approx(np.pi / damped, abs=2e-3)


@pytest.mark.parametrize(("origin", "height"), [(0.0, 1.0), (5.0, -3.0), (-2.0, 1e6)])
def test_features_do_not_depend_on_where_and_how_large_a_signal_is(origin: float, height: float):
    shape = (1.0 - np.exp(-TIME)) * (1.0 + 0.3 * np.exp(-TIME) * np.sin(3.0 * TIME))
    plain, moved = signal_features(TIME, shape), signal_features(TIME + 7.0, origin + height * shape)
    assert moved.rise == pytest.approx(plain.rise, rel=1e-6)
    assert moved.settling == pytest.approx(plain.settling, rel=1e-6)
    assert isinstance(moved.peak, Peak)
    assert isinstance(plain.peak, Peak)
    assert moved.peak.after == pytest.approx(plain.peak.after)
    assert moved.peak.value == pytest.approx(origin + height * plain.peak.value)


def test_what_a_signal_does_not_have_is_undefined_and_says_why():
    bump = signal_features(TIME, np.exp(-((TIME - 5.0) ** 2)))
    assert isinstance(bump.rise, Undefined)
    assert "ends about where it begins" in str(bump.rise)
    assert not isinstance(bump.settling, Undefined)  # it returns to rest
    swing = signal_features(TIME, np.sin(TIME))
    assert isinstance(swing.settling, Undefined)
    assert "still moves" in str(swing.settling)
    still = signal_features(TIME, np.full(len(TIME), 3.0))
    assert all(isinstance(feature, Undefined) for feature in (still.peak, still.rise, still.settling))
    assert still.final == 3.0
    jump = signal_features(np.array([0.0, 1.0, 1.0, 9.0]), np.array([0.0, 0.0, 2.0, 2.0]))
    assert isinstance(jump.rise, Undefined)
    assert jump.settling == pytest.approx(1.0)
