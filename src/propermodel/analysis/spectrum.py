"""Eigenvalues of a real matrix, those that rounding cannot tell apart taken together.

A double eigenvalue (a free mass, critical damping) comes out of any algorithm as two that differ by the root of the
rounding error; their mean is exact to rounding, and the subspace that they span together is well defined (Golub and
Van Loan (2013), Matrix Computations, 7.2 and 7.6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eig, get_lapack_funcs, matrix_balance, rsf2csf, schur, solve_sylvester

from propermodel.codegen.machine import FloatArray

ComplexArray = np.ndarray[Any, np.dtype[np.complex128]]
ROUNDING = 10.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Root:
    """An eigenvalue, or two that are conjugate, of which this is the one with the positive imaginary part."""

    value: complex
    multiplicity: int
    uncertainty: float  # rounding error of the value
    vector: ComplexArray  # a right eigenvector
    shares: ComplexArray  # diagonal of the projection on what belongs to it; its sum is the multiplicity

    @property
    def is_pair(self) -> bool:
        """Whether the conjugate is an eigenvalue too."""
        return self.value.imag > 0.0


def roots_of(matrix: FloatArray, least_norm: float = 0.0) -> tuple[Root, ...]:
    """The eigenvalues of a real matrix, smallest first, with eigenvectors and projections.

    Args:
        matrix: The matrix, square.
        least_norm: The size of what the matrix was computed from, where it may be larger: rounding counts from it.
    """
    if not len(matrix):
        return ()
    evened, scale = balanced(matrix)
    form: Any = schur(evened, output="real")
    real: FloatArray = form[0]
    triangle, basis = rsf2csf(real, form[1])
    values = _values(real, triangle)
    left, right, conditions = _vectors(triangle)
    left, right = basis @ left, basis @ right
    norm = max(float(np.linalg.norm(real)), least_norm, 1e-300)
    uncertainty = ROUNDING * norm / conditions
    conjugates = _conjugates(values)
    gaps = _gaps(values)
    roots: list[Root] = []
    clusters = _clusters(values, uncertainty, conjugates)
    lone = {members[0] for members in clusters if len(members) == 1}
    while clusters:
        members = clusters.pop()
        if len(members) > 1:
            together = _together(triangle, basis, values, members, norm)
            if together is None:
                clusters.extend(_parted(values, members, conjugates))
            else:
                roots.append(_root(*together, len(members), scale))
            continue
        (index,) = members
        vector, dual = right[:, index], left[:, index].conj()
        shares = vector * dual / np.dot(dual, vector)
        error = float(uncertainty[index]) if index in lone and uncertainty[index] < gaps[index] else 0.0
        roots.append(_root(complex(values[index]), error, vector, shares, 1, scale))
    return tuple(sorted(roots, key=lambda root: (abs(root.value), root.value.real)))


def balanced(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The matrix in states of comparable sizes z, and the factors f of x = f z."""
    if not len(matrix):
        return matrix, np.zeros(0)
    # Large factors do not fit into the permutation that SciPy derives from them, and that is not asked for.
    with np.errstate(invalid="ignore"):
        scaled: Any = matrix_balance(matrix, permute=False, separate=True)
    return scaled[0], scaled[1][0]


def all_values(roots: tuple[Root, ...]) -> ComplexArray:
    """Every eigenvalue as often as it occurs, with conjugates."""
    found: list[complex] = []
    for root in roots:
        both = (root.value, root.value.conjugate()) if root.is_pair else (root.value,)
        found.extend(value for value in both for _ in range(root.multiplicity))
    return np.array(found, dtype=np.complex128)


def _root(
    found: complex, error: float, vector: ComplexArray, shares: ComplexArray, multiplicity: int, scale: FloatArray
) -> Root:
    value = complex(
        0.0 if abs(found.real) <= error else found.real,
        0.0 if abs(found.imag) <= error else found.imag,
    )
    vector = vector * scale
    return Root(value, multiplicity, error, vector / np.linalg.norm(vector), shares)


def _values(real: FloatArray, triangle: ComplexArray) -> ComplexArray:
    """The diagonal of a complex Schur form, conjugates exactly conjugate."""
    values = np.diag(triangle).copy()
    pairs = np.flatnonzero(np.diag(real, -1))
    upper = np.where(values[pairs].imag > 0.0, values[pairs], values[pairs].conj())
    is_first_upper = values[pairs].imag > 0.0
    values[pairs] = np.where(is_first_upper, upper, upper.conj())
    values[pairs + 1] = values[pairs].conj()
    lone = np.setdiff1d(np.arange(len(values)), np.concatenate((pairs, pairs + 1)))
    values[lone] = values[lone].real
    return values


def _vectors(triangle: ComplexArray) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Left and right eigenvectors of a triangular matrix, columns of length 1, and the cosine between the two."""
    found: Any = eig(triangle, left=True, right=True, check_finite=False)
    left, right = found[1], found[2]
    conditions = np.abs(np.sum(left.conj() * right, axis=0))
    return left, right, np.maximum(conditions, 1e-300)


def _gaps(values: ComplexArray) -> FloatArray:
    """The distance of each value from the next one."""
    distances = np.abs(values[:, None] - values[None, :])
    np.fill_diagonal(distances, np.inf)
    return distances.min(axis=1)


def _conjugates(values: ComplexArray) -> dict[int, int]:
    """For the index of each value above the real axis that of its conjugate, which stands beside it."""
    return {
        index: other
        for index in range(len(values))
        if values[index].imag > 0.0
        for other in (index - 1, index + 1)
        if 0 <= other < len(values) and values[other] == values[index].conjugate()
    }


def _clusters(values: ComplexArray, uncertainty: FloatArray, conjugates: dict[int, int]) -> list[list[int]]:
    """Indices of eigenvalues that rounding cannot tell apart; of conjugate clusters only the upper one."""
    left = [index for index in range(len(values)) if values[index].imag >= 0.0]
    left.sort(key=lambda index: (values[index].real, values[index].imag))
    clusters: list[list[int]] = []
    while left:
        members = [left.pop()]
        grown = 0
        while grown < len(members):
            index = members[grown]
            # What is well determined is not near a defective value, however uncertain that one is.
            near = [
                other
                for other in left
                if abs(values[other] - values[index]) <= 2.0 * min(uncertainty[other], uncertainty[index])
            ]
            left = [other for other in left if other not in near]
            members.extend(near)
            grown += 1
        reaches_down = any(values[index].imag <= uncertainty[index] for index in members)
        clusters.append(_with_conjugates(members, conjugates) if reaches_down else sorted(members))
    return clusters


def _with_conjugates(members: list[int], conjugates: dict[int, int]) -> list[int]:
    return sorted([*members, *(conjugates[index] for index in members if index in conjugates)])


def _parted(values: ComplexArray, members: list[int], conjugates: dict[int, int]) -> list[list[int]]:
    """What a cluster that is no multiple eigenvalue consists of: itself without conjugates, or two, at its widest gap.

    A defective eigenvalue is so uncertain that everything seems to be near it.
    """
    upper = [index for index in members if values[index].imag >= 0.0]
    if len(upper) < len(members):
        return [upper]
    from scipy.cluster.hierarchy import cut_tree, linkage

    at = np.column_stack((values[upper].real, values[upper].imag))
    side = cut_tree(linkage(at, method="single"), n_clusters=2)[:, 0]
    parts = ([index for index, where in zip(upper, side, strict=True) if where == k] for k in (0, 1))
    return [_with_conjugates(part, conjugates) for part in parts]


def _together(
    triangle: ComplexArray, basis: ComplexArray, values: ComplexArray, members: list[int], norm: float
) -> tuple[complex, float, ComplexArray, ComplexArray] | None:
    """The mean of a cluster, its rounding error, an eigenvector, and the diagonal of the projection.

    Nothing, if the cluster is no multiple eigenvalue even so: other values are within the error of its mean, or
    rounding would not give a polynomial this far from that of a multiple one, although each of its roots is uncertain.
    """
    count, size = len(values), len(members)
    chosen = np.zeros(count, dtype=np.int32)
    chosen[members] = 1
    (reorder,) = get_lapack_funcs(("trsen",), (triangle,))
    room = max(1, 2 * size * (count - size))
    triangle, basis, _, _, condition, _, _ = reorder(chosen, triangle, basis, job="E", lwork=room)
    first, second = basis[:, :size], basis[:, size:]
    dual = first.conj().T
    if size < count:
        inner, coupling, outer = triangle[:size, :size], triangle[:size, size:], triangle[size:, size:]
        dual = dual + solve_sylvester(inner, -outer, coupling) @ second.conj().T
    mean = complex(np.mean(values[members]))
    error = ROUNDING * norm / max(float(condition), 1e-300)
    others = np.delete(values, members)
    if np.any(np.abs(others - mean) <= error):
        return None
    deviation = np.abs(np.poly(values[members] - mean))[1:]
    if np.any(deviation > size * error * norm ** np.arange(size)):
        return None
    return mean, error, first[:, 0], np.sum(first * dual.T, axis=1)
