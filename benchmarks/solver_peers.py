"""Solvers of others on the model of `hybrid.py`, driven from Python step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

from benchmarks.cvode_from_c import CvodeFromC, sundials_libraries
from benchmarks.hybrid import Hybrid, Outcome
from benchmarks.python_peers import Answer, with_numba
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.modelling.model import Scenario
from propermodel.simulation.side_by_side import joined
from propermodel.simulation.start import start_of

Run = Callable[[float], Outcome]  # of a tolerance, or of a step


def peers(hybrid: Hybrid, scale: FloatArray) -> dict[str, Run | str]:
    """Each peer by name: how it runs at a tolerance, or why it does not."""
    found: dict[str, Run | str] = {
        "SciPy LSODA, from Python": lambda tolerance: _scipy(hybrid, scale, "LSODA", tolerance),
        "SciPy Radau, from Python": lambda tolerance: _scipy(hybrid, scale, "Radau", tolerance),
    }
    if find_spec("sksundae") is None:
        found["CVODE by scikit-sundae, from Python"] = "scikit-sundae is not installed"
    else:
        found["CVODE by scikit-sundae, from Python"] = lambda tolerance: _cvode(hybrid, scale, tolerance)
    if sundials_libraries() is None:
        found["CVODE, from C"] = "scikit-sundae, whose libraries it takes, is not installed"
    else:
        driven = CvodeFromC(hybrid)
        found["CVODE, from C"] = lambda tolerance: driven.run(tolerance, scale)
    return found


NO_CODE = {
    "CasADi CVODES": "the scalar graph of CasADi has no table look-ups, of which the truck has fifteen",
    "diffrax Kvaerno5": "its implicit steps are not printed; JAX is measured with fixed steps among the ensembles",
}


def fixed_step_peers(compiled: CompiledModel, scenario: Scenario) -> dict[str, Run | str]:
    """Peers that take fixed steps of semi-implicit Euler, as runs of a step."""
    if find_spec("numba") is None:
        return {"numba semi-implicit-euler": "numba is not installed"}
    start = start_of(compiled, scenario).memory
    one = joined([start, start], 2)
    single = replace(one, **{name: getattr(one, name)[:, :1] for name in ("state", "discrete", "parameter", "unknown")})

    @cache
    def made(step: float) -> Callable[[], Answer]:
        return with_numba(compiled.lowered.program, single, step, scenario.stop)

    def run(step: float) -> Outcome:
        states, activities = made(step)()
        memory = start.copy()
        memory.state[:], memory.activity[:], memory.time = states[0], activities[0], scenario.stop
        steps = round((scenario.stop - scenario.start) / step)
        return Outcome(memory, steps, steps)

    return {"numba semi-implicit-euler": run}


def _scipy(hybrid: Hybrid, scale: FloatArray, name: str, tolerance: float) -> Outcome:
    import scipy.integrate

    solver_class = getattr(scipy.integrate, name)

    def rates(time: float, state: FloatArray) -> FloatArray:
        return hybrid.f(time, state).copy()

    def advance(begin: float, end: float, state: FloatArray) -> tuple[FloatArray, int]:
        solver = solver_class(
            rates, begin, state, end, rtol=max(tolerance, 1e-13), atol=tolerance * scale, jac=hybrid.jacobian
        )
        before, steps = hybrid.powers(begin, state), 0
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise ArithmeticError(message)
            after = hybrid.powers(solver.t, solver.y)
            hybrid.add_trapezoid(solver.t - solver.t_old, before, after)
            before, steps = after, steps + 1
        return solver.y, steps

    return hybrid.run(advance)


def _cvode(hybrid: Hybrid, scale: FloatArray, tolerance: float) -> Outcome:
    from sksundae.cvode import CVODE

    def rates(time: float, state: FloatArray, to: FloatArray) -> None:
        to[:] = hybrid.f(time, state)

    def slopes(time: float, state: FloatArray, _: FloatArray, to: FloatArray) -> None:
        to[:] = hybrid.jacobian(time, state)

    solver: Any = CVODE(rates, jacfn=slopes, rtol=tolerance, atol=tolerance * scale, max_num_steps=1_000_000)

    def advance(begin: float, end: float, state: FloatArray) -> tuple[FloatArray, int]:
        solver.init_step(begin, state)
        before, steps, time = hybrid.powers(begin, state), 0, begin
        while time < end:
            found = solver.step(end, method="onestep", tstop=end)
            if not found.success:
                raise ArithmeticError(found.message)
            after = hybrid.powers(found.t, found.y)
            hybrid.add_trapezoid(found.t - time, before, after)
            before, steps, time, state = after, steps + 1, float(found.t), found.y
        return state, steps

    return hybrid.run(advance)
