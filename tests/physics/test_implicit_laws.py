"""Resistances with implicit laws, 0 = g(effort, flow), in every causality, against closed forms."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend
from propermodel.expressions import Expr, ExprLike
from propermodel.library.mechanics.translation import Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    MultiportResistance,
    Parameter,
    Port,
    Resistance,
    Translation,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.connections import Wiring
from propermodel.modelling.documents import from_document, to_document
from tests.physics.systems import close, compiled, eigenvalues, run, system

BACKENDS = list(Backend)


class Twisted(Resistance):
    """x + x^3 = y + y^3 with x = e/F, y = f/V: the line e/F = f/V, written so that neither can be isolated."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    force: Parameter = parameter("N")
    speed: Parameter = parameter("m/s")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        x, y = effort / self.force, flow / self.speed
        return x + x * x * x - y - y * y * y


class Softening(Resistance):
    """c f = e + e^3/F^2: gives the flow openly, the effort only implicitly."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m")
    force: Parameter = parameter("N")

    def residual(self, effort: Expr, flow: Expr) -> Expr:
        return effort + effort * effort * effort / (self.force * self.force) - self.damping * flow


def braked(brake: Component) -> Component:
    mass, wall = Mass(mass=2.0, start_velocity=3.0), Fixed()
    return system(
        connect(mass.flange, brake.a),  # pyright: ignore[reportAttributeAccessIssue]
        connect(brake.b, wall.flange),  # pyright: ignore[reportAttributeAccessIssue]
        mass=mass,
        brake=brake,
        wall=wall,
    )


def relaxing(brake: Component) -> Component:
    """A spring alone on the element: the effort is given."""
    spring, wall, other = Spring(stiffness=50.0), Fixed(), Fixed()
    return system(
        connect(spring.a, wall.flange),
        connect(spring.b, brake.a),  # pyright: ignore[reportAttributeAccessIssue]
        connect(brake.b, other.flange),  # pyright: ignore[reportAttributeAccessIssue]
        spring=spring,
        brake=brake,
        wall=wall,
        other=other,
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_implicit_law_gives_the_effort(backend: Backend):
    r = run(braked(Twisted(force=4.0, speed=2.0)), 2.0, backend=backend, step=5e-3)
    close(r["mass.flange.flow"], 3.0 * np.exp(-r.time), 1e-9)
    close(r["brake.port.effort"], 6.0 * np.exp(-r.time), 1e-9)
    balance = energy_balance(r)
    assert balance.dissipated == pytest.approx(9.0 * (1.0 - math.exp(-4.0)), rel=1e-4)
    assert balance.relative_residual < 1e-4


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_implicit_law_gives_the_flow(backend: Backend):
    r = run(
        relaxing(Twisted(force=4.0, speed=2.0)),
        0.2,
        backend=backend,
        step=5e-4,
        initial={"spring.port.displacement": 0.1},
    )
    close(r["spring.port.displacement"], 0.1 * np.exp(-25.0 * r.time), 1e-8)


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_implicit_law_agrees_with_a_solution_by_hand(backend: Backend):
    r = run(braked(Softening(damping=20.0, force=5.0)), 1.0, backend=backend, step=1e-3)

    def speed(_: float, v: np.ndarray) -> list[float]:
        return [-brentq(lambda e: e + e**3 / 25.0 - 20.0 * v[0], -1e3, 1e3, xtol=1e-14) / 2.0]

    by_hand = solve_ivp(speed, (0.0, 1.0), [3.0], t_eval=r.time, rtol=1e-10, atol=1e-12)
    close(r["mass.flange.flow"], by_hand.y[0], 1e-7)


def test_an_implicit_law_that_is_linear_in_a_variable_gives_it_openly():
    made = compiled(relaxing(Softening(damping=20.0, force=5.0)))
    assert not made.system.blocks
    assert not made.system.solved
    assert compiled(braked(Softening(damping=20.0, force=5.0))).system.blocks


def test_a_model_with_an_implicit_law_comes_back_from_its_document_and_runs_the_same():
    model = elaborate(braked(Softening(damping=20.0, force=5.0)))
    again = from_document(to_document(model))
    assert again == model
    one, other = run(model, 0.5), run(again, 0.5)
    assert np.array_equal(one["mass.flange.flow"], other["mass.flange.flow"])


def test_an_implicit_law_has_a_row_of_its_own_in_a_ranking():
    rows = compiled(braked(Twisted(force=4.0, speed=2.0))).system.rows
    assert {str(row.path): row.kind for row in rows} == {"mass": "I", "brake": "R"}


# -- several ports -----------------------------------------------------------------------------------------


class Coupled(MultiportResistance):
    """Two dampers that feel each other, e = R f with a matrix R, written without choosing a causality."""

    a = Port(Translation)
    b = Port(Translation)
    own: Parameter = parameter("N.s/m")
    mutual: Parameter = parameter("N.s/m")

    def residuals(self) -> tuple[ExprLike, ...]:
        return (
            self.a.effort - self.own * self.a.flow - self.mutual * self.b.flow,
            self.b.effort - self.mutual * self.a.flow - 2.0 * self.own * self.b.flow,
        )


class Both(MultiportResistance):
    """The same in a form that is cubic in the first effort."""

    a = Port(Translation)
    b = Port(Translation)
    own: Parameter = parameter("N.s/m")
    mutual: Parameter = parameter("N.s/m")
    force: Parameter = parameter("N", default=3.0)

    def residuals(self) -> tuple[ExprLike, ...]:
        x = self.a.effort / self.force
        y = (self.own * self.a.flow + self.mutual * self.b.flow) / self.force
        return (
            self.b.effort - self.mutual * self.a.flow - 2.0 * self.own * self.b.flow,
            x + x * x * x - y - y * y * y,
        )


def loaded(field: Component, kinds: str) -> tuple[Component, list[complex]]:
    """The field with a mass ('I') or a spring ('C') at each port, and the eigenvalues by hand for m = 2, k = 50."""
    parts: dict[str, Component] = {"field": field}
    wiring: list[Wiring] = []
    for port, kind in zip("ab", kinds, strict=True):
        flange = getattr(field, port)
        if kind == "I":
            part = Mass(mass=2.0)
            wiring.append(connect(part.flange, flange))
        else:
            part, wall = Spring(stiffness=50.0), Fixed()
            parts[f"wall_{port}"] = wall
            wiring += [connect(part.a, flange), connect(part.b, wall.flange)]
        parts[f"load_{port}"] = part
    # At each port load and field have one flow and opposite efforts: e = m s f for a mass, e = k f / s for a spring.
    # Multiplied by s, and freed of the root at 0 that the multiplication brings in for a mass:
    loads = [np.poly1d([2.0, 0.0]) if kind == "I" else np.poly1d([50.0]) for kind in kinds]
    damping = [
        np.poly1d([d]) if kind == "I" else np.poly1d([d, 0.0]) for d, kind in zip((4.0, 8.0), kinds, strict=True)
    ]
    mutual = np.poly1d([1.0] + [0.0] * kinds.count("C"))
    roots = ((loads[0] + damping[0]) * (loads[1] + damping[1]) - mutual).roots
    return system(*wiring, **parts), sorted(map(complex, roots), key=lambda x: (x.real, x.imag))


@pytest.mark.parametrize("kinds", ["".join(pair) for pair in itertools.product("IC", repeat=2)])
def test_a_linear_implicit_field_takes_every_causality_and_is_eliminated(kinds: str):
    model, expected = loaded(Coupled(own=4.0, mutual=1.0), kinds)
    close(eigenvalues(model).real, np.real(expected), 1e-9)
    assert not compiled(model).system.blocks


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kinds", ["".join(pair) for pair in itertools.product("IC", repeat=2)])
def test_a_nonlinear_implicit_field_takes_every_causality(kinds: str, backend: Backend):
    initial = {
        f"load_{port}.{'flange.momentum' if kind == 'I' else 'port.displacement'}": start
        for port, kind, start in zip("ab", kinds, (0.8, -0.5), strict=True)
    }
    model, _ = loaded(Both(own=4.0, mutual=1.0), kinds)
    plain, _ = loaded(Coupled(own=4.0, mutual=1.0), kinds)
    one = run(model, 0.2, step=1e-3, initial=initial, backend=backend, every=0.02)
    other = run(plain, 0.2, step=1e-3, initial=initial, every=0.02)
    for port in "ab":
        close(one[f"field.{port}.effort"], other[f"field.{port}.effort"], 1e-8)
    assert energy_balance(one).relative_residual < 1e-2
