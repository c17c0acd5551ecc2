"""Examples with events against closed forms: instants, values in between and what is lost."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Method, compile_model
from propermodel.simulation.simulate import simulate
from tests.examples.runs import answer, module, subject


def test_a_ball_bounces_at_the_instants_of_its_closed_form():
    run = answer("bouncing_ball")
    g, share = 9.80665, 0.8
    fall = math.sqrt(2.0 / g)
    hits = [fall * (1.0 + 2.0 * sum(share**k for k in range(1, n + 1))) for n in range(6)]
    assert [event.time for event in run.events] == pytest.approx(hits, abs=1e-11)
    height, t = run["sensor.position"], run.time
    falling = t < hits[0]
    np.testing.assert_allclose(height[falling], 1.0 - g * t[falling] ** 2 / 2, atol=1e-11)
    for n, (begin, end) in enumerate(pairwise(hits), 1):
        flight = (t > begin) & (t < end)
        since = t[flight] - begin
        expected = share**n * g * fall * since - g * since**2 / 2
        np.testing.assert_allclose(height[flight], expected, atol=1e-11)
    left = 0.2 * g * 1.0 * share ** (2 * len(hits))
    assert energy_balance(run).lost_in_events == pytest.approx(0.2 * g * 1.0 - left, rel=1e-10)


def test_a_thermostat_switches_at_the_instants_of_exponentials():
    run = answer("thermostat")
    tau, warmest, low, high = 1.0e5 / 60.0, 2000.0 / 60.0, 12.5, 13.5
    first = tau * math.log(warmest / (warmest - high))
    cooling = tau * math.log(high / low)
    heating = tau * math.log((warmest - low) / (warmest - high))
    expected = [0.0, first]
    while expected[-1] < 2400.0:
        expected.append(expected[-1] + (cooling if len(expected) % 2 == 0 else heating))
    assert [event.time for event in run.events] == pytest.approx(expected[:-1], abs=1e-5)
    settled = run["room.port.effort"][run.time >= run.events[1].time]
    assert settled.min() == pytest.approx(low, abs=1e-9)
    assert settled.max() == pytest.approx(high, abs=1e-9)
    shares = run["thermostat.heat"] / 2000.0
    assert set(shares[run.time > 0.0].tolist()) == {0.0, 1.0}


def test_a_thermostat_switches_at_the_same_instants_with_shorter_steps():
    example = module("thermostat")
    compiled = compile_model(subject("thermostat").model)
    fine = simulate(compiled, example.scenario(), method=Method.RK4, step=0.5, record_every=10.0)
    coarse = answer("thermostat")
    assert [e.time for e in fine.events] == pytest.approx([e.time for e in coarse.events], abs=1e-5)


def test_stacked_balls_by_impulses_at_instants_of_parabolas():
    run = answer("stacked_balls")
    g, masses, share = 9.80665, (0.6, 0.06), 0.9
    place, speed, now = np.array([1.0, 0.01]), np.array([0.0, 0.0]), 0.0  # heights: of the large one, and the gap
    hits, times, highs = [], run.time, np.full(len(run.time), np.nan)
    while True:
        floor = (speed[0] + math.sqrt(speed[0] ** 2 + 2.0 * g * place[0])) / g
        closing = speed[0] - speed[1]
        meeting = place[1] / closing if closing > 1e-9 else math.inf
        flight = min(floor, meeting, 1.8 - now)
        inside = (times > now + 1e-9) & (times < now + flight - 1e-9)
        since = times[inside] - now
        highs[inside] = place.sum() + speed[1] * since - g * since**2 / 2
        place = np.array([place[0] + speed[0] * flight - g * flight**2 / 2, place[1] - closing * flight])
        speed, now = speed - g * flight, now + flight
        if now >= 1.8:
            break
        if floor < meeting:
            place[0], speed[0] = 0.0, -share * speed[0]
        else:
            impulse = (1.0 + share) * (speed[0] - speed[1]) / (1.0 / masses[0] + 1.0 / masses[1])
            place[1], speed = 0.0, speed + np.array([-impulse / masses[0], impulse / masses[1]])
        hits.append(now)
    assert [event.time for event in run.events] == pytest.approx(hits, abs=1e-9)
    seen = ~np.isnan(highs)
    assert seen.sum() > 150
    np.testing.assert_allclose(run["small_height.position"][seen], highs[seen], atol=1e-8)
    assert highs[seen].max() > 2.0 * 1.01
