"""The coefficients of methods: linearly implicit ones (Rosenbrock), explicit ones with an estimate (Runge-Kutta)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from propermodel.codegen.machine import Method


@dataclass(frozen=True)
class Tableau:
    """A linearly implicit method of two stages or more; `a` and `c` have a row for each stage after the first.

    A method with an error estimate also has the weights of the stages in it, and those that lead to the middle of the
    step.
    """

    gamma: float
    a: tuple[tuple[float, ...], ...]
    c: tuple[tuple[float, ...], ...]
    m: tuple[float, ...]
    alpha: tuple[float, ...]
    drift: tuple[float, ...]  # g_i
    takes_any_matrix: bool = False  # a W-method: the order is there with an old Jacobian, too
    error: tuple[float, ...] = ()
    middle: tuple[float, ...] = ()


@dataclass(frozen=True)
class ExplicitTableau:
    """An explicit method whose last stage stands at the end of the step and is the first of the next one.

    `a` has a row for each stage after the first; the last row leads to the end. `error` weighs the stages in the
    difference to the embedded method, `middle` leads to the middle of the step.
    """

    a: tuple[tuple[float, ...], ...]
    c: tuple[float, ...]
    error: tuple[float, ...]
    middle: tuple[float, ...]


_GAMMA = 1.0 - math.sqrt(0.5)
_WEIGHT = 0.75  # of the second stage, which then is at two thirds of the step: what depends on time alone has order 3

# Verwer, Spee, Blom and Hundsdorfer, A second-order Rosenbrock method applied to photochemical dispersion problems,
# SIAM J. Sci. Comput. 20 (1999): of order 2 with any matrix in the place of J, L-stable with J itself, for any weight.
ROS2 = Tableau(
    gamma=_GAMMA,
    a=((0.5 / (_WEIGHT * _GAMMA),),),
    c=((-1.0 / (_WEIGHT * _GAMMA),),),
    m=((2.0 - _WEIGHT) / _GAMMA, _WEIGHT / _GAMMA),
    alpha=(0.0, 0.5 / _WEIGHT),
    drift=(_GAMMA, _GAMMA - _GAMMA / _WEIGHT),
    takes_any_matrix=True,
)

# Hairer and Wanner, Solving Ordinary Differential Equations II (1996), section VI.4, and their code RODAS: order 4 with
# an estimate of order 3, both stiffly accurate and L-stable. The last solution is the estimate of the error.
_RODAS_END = (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950)
# Half of the end, and what the continuous extension of the code adds in the middle: (d_2 + d_3 / 2) / 4.
_RODAS_BEND = (
    (10.12623508344586 - 0.6762803392806898 / 2.0) / 4.0,
    (-7.487995877610167 + 6.087714651680015 / 2.0) / 4.0,
    (-34.80091861555747 + 16.43084320892478 / 2.0) / 4.0,
    (-7.992771707568823 + 24.76722511418386 / 2.0) / 4.0,
    (1.025137723295662 - 6.594389125716872 / 2.0) / 4.0,
    0.0,
)
RODAS = Tableau(
    gamma=0.25,
    a=(
        (1.544,),
        (0.9466785280815826, 0.2557011698983284),
        (3.314825187068521, 2.896124015972201, 0.9986419139977817),
        _RODAS_END,
        (*_RODAS_END, 1.0),
    ),
    c=(
        (-5.6688,),
        (-2.430093356833875, -0.2063599157091915),
        (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
        (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
        (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054),
    ),
    m=(*_RODAS_END, 1.0, 1.0),
    alpha=(0.0, 0.386, 0.21, 0.63, 1.0, 1.0),
    drift=(0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0),
    error=(0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
    middle=tuple(0.5 * m + d for m, d in zip((*_RODAS_END, 1.0, 1.0), _RODAS_BEND, strict=True)),
)

# Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comput. Appl. Math. 6 (1980): order 5 with an
# estimate of order 4. Middle of order 4: Shampine, Some practical Runge-Kutta formulas, Math. Comp. 46 (1986).
DOPRI5 = ExplicitTableau(
    a=(
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    ),
    c=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0),
    error=(71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),
    middle=(
        6025192743 / 30085553152 / 2,
        0.0,
        51252292925 / 65400821598 / 2,
        -2691868925 / 45128329728 / 2,
        187940372067 / 1594534317056 / 2,
        -1776094331 / 19743644256 / 2,
        11237099 / 235043384 / 2,
    ),
)

TABLEAUS: Mapping[Method, Tableau] = {Method.ROS2: ROS2, Method.RODAS: RODAS}
EXPLICIT_TABLEAUS: Mapping[Method, ExplicitTableau] = {Method.DOPRI5: DOPRI5}
