"""Excitation for models of the library that bring no scenario of their own."""

from __future__ import annotations

import math

from propermodel.diagnostics import Path
from propermodel.modelling import Scenario, table_values

WHEELBASE = 2.6  # m, of the half car
# Cycles per metre, height in m, phase.
_WAVES = ((0.05, 0.012, 0.3), (0.11, 0.006, 1.1), (0.23, 0.003, 2.9), (0.41, 0.0016, 0.7), (0.83, 0.0008, 4.1))


def rough_road(speed: float = 20.0, stop: float = 20.0) -> Scenario:
    """Both wheels of a half car on a road of five waves (made up), the rear wheel later."""
    times = [k * 0.005 for k in range(round(stop / 0.005) + 1)]

    def vertical_speed(time: float) -> float:
        at = speed * time
        start = min(1.0, max(0.0, at / 10.0))  # the road begins flat
        turns = ((2.0 * math.pi * n, height, phase) for n, height, phase in _WAVES)
        return start * sum(w * speed * height * math.cos(w * at + phase) for w, height, phase in turns)

    delay = WHEELBASE / speed
    wheels = {"front_road": 0.0, "rear_road": delay}
    return Scenario(
        name="rough_road",
        stop=stop,
        inputs={
            Path((name, "flow")): table_values([times], [vertical_speed(t - late) for t in times])
            for name, late in wheels.items()
        },
        description=f"a rough road at {speed:g} m/s",
    )
