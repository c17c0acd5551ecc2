"""Matrices of the states: against differences, against the pencil of the drawn graph, and in the limit of stiffness."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.linalg import eigvals

from propermodel.analysis.linearise import linearise
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import Backend, CompiledModel, compile_quietly
from propermodel.modelling import Scenario
from tests.properties.answers import accepted, drawn
from tests.properties.graphs import Field, Graph, model_of
from tests.properties.reference import Reference, Verdict
from tests.properties.rewrite import with_stiff_couplings
from tests.properties.runs import numeric_jacobian

SEEDS = range(120)
FAST = 1e6  # eigenvalues beyond this are infinite: constraints


def linear(graph: Graph) -> Graph:
    """The graph with linear laws and constant moduli."""
    ones = tuple(replace(one, law="linear") for one in graph.one_ports)
    couplers = tuple(replace(two, modulus=replace(two.modulus, depth=0.0)) for two in graph.couplers)
    return replace(graph, one_ports=ones, couplers=couplers)


@cache
def linear_models() -> list[tuple[Graph, CompiledModel]]:
    """The accepted graphs, made linear."""
    graphs = [linear(drawn(seed)) for seed, _ in accepted(SEEDS)]
    return [(g, compile_quietly(model_of(g), backend=Backend.INTERPRETED)) for g in graphs]


def distance(found: FloatArray, expected: FloatArray) -> float:
    """How far each expected eigenvalue is from the nearest one found, relative to its size."""
    return max((float(np.min(np.abs(found - x))) / (1.0 + abs(x)) for x in expected), default=0.0)


def test_the_matrix_of_a_linearisation_is_that_of_differences():
    compared = nonlinear = 0
    for _, model in accepted(SEEDS):
        paths = [state.path for state in model.system.states]
        states = np.random.default_rng(len(paths)).uniform(-0.3, 0.3, len(paths))
        at = Scenario(initial=dict(zip(paths, map(float, states), strict=True)))
        found = linearise(model, at).A
        expected = numeric_jacobian(model, states)
        scale = 1.0 + float(np.max(np.abs(expected), initial=0.0))
        assert np.max(np.abs(found - expected), initial=0.0) < 1e-6 * scale
        compared += len(paths)
        nonlinear += bool(model.system.blocks)
    assert compared > 300
    assert nonlinear > 20


def test_eigenvalues_are_those_of_the_drawn_graph():
    compared = 0
    for graph, model in linear_models():
        reference = Reference(graph)
        if reference.verdict(np.random.default_rng(0)) is not Verdict.REGULAR:
            continue
        pencil = eigvals(-reference.A, reference.B)
        finite = pencil[np.isfinite(pencil) & (np.abs(pencil) < FAST)]
        count = len(model.system.states)
        found = np.linalg.eigvals(numeric_jacobian(model, np.zeros(count))) if count else np.zeros(0)
        # A multiple eigenvalue loses half of the digits or more.
        assert distance(found, finite) < 1e-4
        assert distance(finite, found) < 1e-4
        compared += count
    assert compared > 200


def test_dependent_storage_is_the_limit_of_stiff_couplings():
    compared = 0
    for graph, model in linear_models():
        dependents = {str(d.element) for d in model.system.dependents}
        count = len(model.system.states)
        if not dependents or not count or any(isinstance(graph_field(graph, path), Field) for path in dependents):
            continue
        expected = np.linalg.eigvals(numeric_jacobian(model, np.zeros(count)))
        storages = {int(path[1:]) for path in dependents}
        errors: list[float] = []
        for stiffness in (1e6, 1e7, 1e8):
            stiff = stiffly_coupled(graph, storages, stiffness)
            states = np.zeros(len(stiff.system.states))
            errors.append(distance(np.linalg.eigvals(numeric_jacobian(stiff, states)), expected))
        assert errors[1] < 0.2 * errors[0] or errors[1] < 1e-5
        assert errors[1] < 1e-3
        compared += 1
    assert compared > 20


def graph_field(graph: Graph, path: str) -> Field | None:
    """The field of this path, None for a one-port."""
    return graph.fields[int(path[1:])] if path[0] == "m" else None


def stiffly_coupled(graph: Graph, storages: set[int], stiffness: float) -> CompiledModel:
    """The graph with its dependent storages behind couplings."""
    return compile_quietly(model_of(with_stiff_couplings(graph, storages, stiffness)), backend=Backend.INTERPRETED)
