"""Balanced and modal truncation: states without meaning, for comparison of accuracy with physical models.

Both take the linear model at the start of the run, with the inputs of the run. Balanced truncation (Moore 1981) keeps
the directions that are reached and seen most; what is not stable by itself is balanced as if seen through exp(-t / T),
T the length of the run. Modal truncation (Davison 1966) keeps the slowest modes, and of others their static answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.reduction.methods.curve import Curve
from propermodel.reduction.methods.linear_runs import LinearRun, Matrix
from propermodel.reduction.methods.workbench import SizedModel, Workbench

_NOTHING = 1e-12  # share of the largest Hankel singular value below which a direction is rounding
_PAIR = 1e-9  # relative distance within which two values are conjugate


@dataclass(frozen=True, slots=True, eq=False)
class Balanced:
    """A model in balanced states, the most important first: all but A, B and C as before."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    values: FloatArray  # Hankel singular values, of all directions that are more than rounding


def balance(A: FloatArray, B: FloatArray, C: FloatArray, shift: float = 0.0) -> Balanced:
    """Balance a model whose A - shift I is stable, by the square roots of its Gramians (Laub et al. 1987)."""
    from scipy.linalg import solve_continuous_lyapunov

    stable = A - shift * np.eye(len(A))
    reached = _root(np.array(solve_continuous_lyapunov(stable, -B @ B.T), dtype=np.float64))
    seen = _root(np.array(solve_continuous_lyapunov(stable.T, -C.T @ C), dtype=np.float64))
    left, values, right = np.linalg.svd(seen.T @ reached)
    known = values > _NOTHING * values[0] if len(values) else np.zeros(0, dtype=np.bool_)
    root = np.sqrt(values[known])
    to_states = reached @ right.T[:, known] / root
    from_states = (seen @ left[:, known] / root).T
    return Balanced(from_states @ A @ to_states, from_states @ B, C @ to_states, values[known])


def _root(gramian: FloatArray) -> FloatArray:
    """R with R R^T = gramian, which is symmetric and not negative but for rounding."""
    sizes, directions = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return directions * np.sqrt(np.maximum(sizes, 0.0))


def by_balanced_truncation(bench: Workbench) -> Curve:
    """Truncated models of every order."""
    method, source = "balanced truncation", "Moore 1981"
    if bench.why_not_linear:
        return Curve(method=method, source=source, not_applied=bench.why_not_linear)
    linear = bench.linear
    growth = max(np.linalg.eigvals(linear.A).real, default=-1.0)
    length = float(linear.time[-1] - linear.time[0])
    slowest = 1e-6 / length  # slower than this counts as an integrator
    shift = 0.0 if growth < -slowest else max(growth, 0.0) + 1.0 / length
    found = balance(linear.A, _in_scale(linear), linear.C / _ranges(linear)[:, np.newaxis], shift)
    back, sizes = _ranges(linear)[:, np.newaxis], _input_sizes(linear)
    models = [
        _model(linear, found.A[:r, :r], found.B[:r] / sizes, back * found.C[:, :r], linear.D)
        for r in range(len(found.values), -1, -1)
    ]
    notes = () if shift == 0.0 else (f"balanced as if seen through exp(-{shift:.3g} t), as the model is not stable",)
    return Curve(method=method, source=source, models=tuple(models), notes=notes)


def by_modal_truncation(bench: Workbench) -> Curve:
    """Models of the slowest modes."""
    method, source = "modal truncation", "Davison 1966"
    if bench.why_not_linear:
        return Curve(method=method, source=source, not_applied=bench.why_not_linear)
    linear = bench.linear
    values, vectors = np.linalg.eig(linear.A.astype(np.complex128))
    order = np.argsort(np.abs(values), kind="stable")
    values, vectors = values[order], vectors[:, order]
    if len(values) and np.linalg.cond(vectors) > 1e12:
        return Curve(method=method, source=source, not_applied="the linear model has no full set of modes")
    B = np.array(np.linalg.solve(vectors, linear.B.astype(np.complex128)), dtype=np.complex128)
    C = np.array(linear.C @ vectors, dtype=np.complex128)
    models: list[SizedModel] = []
    for r in range(len(values), -1, -1):
        is_split = 0 < r < len(values) and abs(values[r - 1] - values[r].conj()) <= _PAIR * abs(values[r])
        if is_split and abs(values[r].imag) > 0.0:
            continue  # half of an oscillation
        fast = slice(r, None)
        if np.any(values[fast] == 0.0):
            continue  # an integrator has no static answer
        static = linear.D - np.real((C[:, fast] / values[fast]) @ B[fast])
        models.append(_model(linear, np.array(np.diag(values[:r]), dtype=np.complex128), B[:r], C[:, :r], static))
    return Curve(method=method, source=source, models=tuple(models))


def _model(
    linear: LinearRun,
    A: Matrix,
    B: Matrix,
    C: Matrix,
    D: FloatArray,
) -> SizedModel:
    error = linear.error(linear.response(A, B, C, D))
    return SizedModel(rows=None, states=len(A), error=error if np.isfinite(error) else np.inf)


def _ranges(linear: LinearRun) -> FloatArray:
    return np.ptp(linear.expected, axis=1)


def _input_sizes(linear: LinearRun) -> FloatArray:
    sizes = np.sqrt(np.mean(linear.inputs**2, axis=1))
    return np.where(sizes > 0.0, sizes, 1.0)


def _in_scale(linear: LinearRun) -> FloatArray:
    """B for inputs that are of the order of one in the run."""
    return linear.B * _input_sizes(linear)
