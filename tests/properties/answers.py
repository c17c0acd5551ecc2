"""What the engine answers to a drawn graph at one instant, and how it compares with dense linear algebra."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from random import Random

import numpy as np

from propermodel.codegen.build import build_machine
from propermodel.codegen.machine import FloatArray, Method
from propermodel.compiler import Backend, CompiledModel, compile_quietly
from propermodel.diagnostics import ProperModelError, parse_path
from propermodel.modelling import Scenario
from propermodel.simulation.start import begin
from tests.properties.generate import random_graph
from tests.properties.graphs import Graph, model_of
from tests.properties.reference import Reference, Verdict

TIME = 0.37
# A point where something is larger than this is close to a singularity; another one is taken.
LARGEST = 100.0


class Outcome(StrEnum):
    AGREES = "accepted, agrees with the reference"
    DIFFERS = "accepted, differs from the reference"
    UNSOLVED = "accepted, a loop has no solution that Newton's method finds"
    REFUSED = "refused, and singular"
    WRONGLY_REFUSED = "refused, though regular"


@dataclass(frozen=True)
class Answer:
    """The outcome for one graph, with what it rests on."""

    outcome: Outcome
    verdict: Verdict
    code: str = ""  # of a refusal
    error: float = 0.0  # the worst relative difference
    undetermined: int = 0  # port variables that the engine does not give


@cache
def drawn(seed: int) -> Graph:
    """The random graph of a seed."""
    return random_graph(Random(seed))


@cache
def compiled(seed: int) -> CompiledModel | ProperModelError:
    """The compiled model of a seed's graph, or why there is none."""
    return compile_or_refuse(drawn(seed))


def compile_or_refuse(graph: Graph) -> CompiledModel | ProperModelError:
    """The compiled model of a graph, or why there is none."""
    try:
        return compile_quietly(model_of(graph), backend=Backend.INTERPRETED)
    except ProperModelError as error:
        return error


def accepted(seeds: range) -> Iterator[tuple[int, CompiledModel]]:
    """The graphs of these seeds that compile."""
    for seed in seeds:
        model = compiled(seed)
        if isinstance(model, CompiledModel):
            yield seed, model


def answer_to(graph: Graph, model: CompiledModel | ProperModelError, seed: int) -> Answer:
    """Compare the engine's answer to a graph with the reference, at a random state."""
    reference = Reference(graph)
    random = np.random.default_rng(seed)
    verdict = reference.verdict(random)
    if isinstance(model, ProperModelError):
        outcome = Outcome.REFUSED if verdict is Verdict.SINGULAR else Outcome.WRONGLY_REFUSED
        return Answer(outcome, verdict, code=model.diagnostics[0].code)
    orders = 2 if verdict is Verdict.SINGULAR else max(2, reference.index(random))
    for size in (0.3, 0.2, 0.1, 0.03):
        point = _Point(model, random.uniform(-size, size, len(model.system.states)))
        if point.failed or point.largest < LARGEST:
            break
    if point.failed:
        return Answer(Outcome.UNSOLVED, verdict)
    return _compared(reference, verdict, point, orders)


class _Point:
    """The rates and observables of a model at a state."""

    def __init__(self, model: CompiledModel, states: FloatArray) -> None:
        self.model = model
        self.states = {str(s.path): float(x) for s, x in zip(model.system.states, states, strict=True)}
        machine = build_machine(model.lowered.program, Method.EULER, backend=Backend.INTERPRETED)
        memory = begin(model, Scenario(stop=1.0))
        memory.state[:], memory.time = states, TIME
        self.failed = False
        try:
            self.rates = machine.rates(memory)[0]
            self.signals = machine.observe(memory)
        except ProperModelError as error:
            assert error.diagnostics[0].code == "simulation/not-converged"  # noqa: PT017 (a status, not a crash)
            self.failed = True
            return
        self.largest = float(np.max(np.abs([*self.rates, *self.signals]), initial=0.0))

    def observed(self, path: str) -> float | None:
        """The value of an observable; None if the model does not give it."""
        found = self.model.lowered.observables.get(parse_path(path))
        return None if found is None else float(self.signals[found.index])


def _compared(reference: Reference, verdict: Verdict, point: _Point, orders: int) -> Answer:
    columns: dict[int, float] = {}
    for path, column in reference.ports.items():
        for offset, name in enumerate(("effort", "flow")):
            value = point.observed(f"{path}.{name}")
            if value is not None:
                columns[column + offset] = value
    guess = np.zeros((orders + 1, reference.count))
    guess[0, list(columns)] = list(columns.values())
    for path, column in reference.stored.items():
        guess[0, column] = point.observed(path) or 0.0
    solution = reference.solve(point.states, TIME, orders, list(columns))
    if not solution.is_found:
        solution = reference.solve(point.states, TIME, orders, list(columns), guess)
    pairs = [(value, solution.series[0, column]) for column, value in columns.items()]
    pairs += [(r, solution.rate(path)) for path, r in zip(point.states, point.rates, strict=True)]
    error = max((abs(a - b) / (1.0 + abs(b)) for a, b in pairs), default=0.0)
    agrees = solution.is_found and solution.is_unique and error < 1e-6
    missing = 2 * len(reference.ports) - len(columns)
    return Answer(Outcome.AGREES if agrees else Outcome.DIFFERS, verdict, error=error, undetermined=missing)
