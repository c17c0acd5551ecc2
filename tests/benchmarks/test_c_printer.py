"""The printer of C is worth comparing with only if it computes the same."""

import numpy as np
import pytest

from benchmarks.c_machine import SETTINGS, CMachine, compiler
from propermodel.codegen.machine import Memory, Method, Request
from propermodel.codegen.native import NativeMachine
from propermodel.compiler import compile_model
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from propermodel.modelling.elaborate import elaborate
from propermodel.simulation.side_by_side import joined
from propermodel.simulation.start import start_of


@pytest.mark.skipif(compiler() is None, reason="g++ is not installed")
@pytest.mark.parametrize(("method", "lanes"), [(Method.EULER, 1), (Method.SEMI_IMPLICIT, 2)])
def test_printed_c_takes_the_steps_of_the_package(method: Method, lanes: int):
    """The truck has tables of one and two coordinates, controllers, implicit blocks and every function."""
    truck = compile_model(elaborate(HybridTruck()))
    start = start_of(truck, mission("fmtv_mixed", until=2.0)).memory
    memories = [start, start.copy()]
    memories[1].state *= 1.01
    ours = joined(memories[:lanes], lanes)
    theirs = ours.copy()
    NativeMachine(truck.lowered.program, method, lanes).run(ours, Request(until=2.0, step=2e-4, most_ticks=10**6))
    unhurried = SETTINGS[0].flags[1:]  # without -O2, which takes four times as long to compile
    CMachine(truck.lowered.program, method, lanes, unhurried).run(theirs, 2.0, 2e-4)
    assert theirs.time == ours.time
    assert ours.activity.max() > 0.0
    for name in ("state", "discrete", "activity", "integral"):
        assert_close(ours, theirs, name)


def assert_close(ours: Memory, theirs: Memory, name: str) -> None:
    expected, found = getattr(ours, name), getattr(theirs, name)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
