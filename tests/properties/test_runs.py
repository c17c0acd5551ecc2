"""Runs of random graphs: energy, both backends, and an independent integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from propermodel.analysis.balance import energy_balance
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import Backend, CompiledModel, compile_quietly
from tests.properties.answers import accepted, compiled, drawn
from tests.properties.graphs import model_of
from tests.properties.reference import Reference, Verdict
from tests.properties.runs import STOP, numeric_jacobian, run


def start_of(model: CompiledModel) -> dict[str, float]:
    """A start of every state."""
    count = len(model.system.states)
    values = np.random.default_rng(count).uniform(-0.3, 0.3, count)
    return {str(s.path): float(x) for s, x in zip(model.system.states, values, strict=True)}


def fine_step(model: CompiledModel, start: dict[str, float]) -> float:
    """A step that RK4 resolves well."""
    jacobian = numeric_jacobian(model, np.array(list(start.values())))
    fastest = float(np.max(np.abs(np.linalg.eigvals(jacobian)), initial=0.0)) if start else 0.0
    return max(STOP / 2000, min(STOP / 20, 0.1 / max(fastest, 1e-9)))


def test_what_sources_do_is_stored_or_dissipated():
    balanced = 0
    for _, model in accepted(range(120)):
        start = start_of(model)
        balance = energy_balance(run(model, start, fine_step(model, start)))
        assert balance.relative_residual < 1e-6
        balanced += balance.throughput > 0.0 or balance.dissipated > 0.0
    assert balanced > 60


@pytest.mark.parametrize("seed", [0, 2, 5, 10, 15, 26])
def test_native_code_runs_as_the_interpreter_does(seed: int):
    plain = compiled(seed)
    assert isinstance(plain, CompiledModel)
    native = compile_quietly(model_of(drawn(seed)), backend=Backend.NATIVE)
    start = start_of(plain)
    one, two = run(plain, start, STOP / 40), run(native, start, STOP / 40)
    for path in Reference(drawn(seed)).ports:
        for name in (f"{path}.effort", f"{path}.flow"):
            assert two[name] == pytest.approx(one[name], rel=1e-9, abs=1e-9)


def test_runs_end_where_an_implicit_integrator_of_the_drawn_graph_ends():
    """Radau on rates that dense linear algebra gives at every instant, for graphs whose storage is all independent."""
    compared = 0
    for seed, model in accepted(range(80)):
        reference = Reference(drawn(seed))
        random = np.random.default_rng(seed)
        independent = len(model.system.states) == len(reference.stored) > 0
        if compared == 8 or not independent or reference.verdict(random) is not Verdict.REGULAR or reference.laws:
            continue
        start = start_of(model)

        def rates(time: float, states: FloatArray, reference=reference, start=start) -> list[float]:
            held = dict(zip(start, map(float, states), strict=True))
            solution = reference.solve(held, time, 1, [])
            assert solution.is_found
            assert solution.is_unique
            return [solution.rate(path) for path in start]

        answer = solve_ivp(rates, (0.0, STOP), list(start.values()), method="Radau", rtol=1e-8, atol=1e-10)
        found = run(model, start, fine_step(model, start))
        for path, value in zip(start, answer.y[:, -1], strict=True):
            assert found.at_end(path) == pytest.approx(value, rel=1e-6, abs=1e-7)
        compared += 1
    assert compared == 8
