"""The equations of a model without elimination: their eigenvalues are those of the drawn graph."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigvals

import propermodel as pm
from propermodel.codegen.machine import FloatArray
from propermodel.reduction.surrogate import fit
from tests.properties.reference import Reference, Verdict
from tests.properties.test_linear_parts import FAST, distance, linear_models


def finite_eigenvalues(constant: FloatArray, rate: FloatArray) -> FloatArray:
    found = eigvals(constant, -rate)
    return found[np.isfinite(found) & (np.abs(found) < FAST)]


def test_eigenvalues_are_those_of_the_drawn_graph():
    compared = 0
    for graph, model in linear_models():
        reference = Reference(graph)
        if reference.verdict(np.random.default_rng(0)) is not Verdict.REGULAR or not model.system.states:
            continue
        run = pm.simulate(model, pm.Scenario(stop=2e-3), step=1e-3, record_every=1e-3)
        surrogate = fit(run, ())
        found = finite_eigenvalues(surrogate.points[0].constant.toarray(), surrogate.points[0].rate.toarray())
        expected = finite_eigenvalues(reference.A, reference.B)
        assert distance(found, expected) < 1e-4
        assert distance(expected, found) < 1e-4
        compared += len(model.system.states)
    assert compared > 200
