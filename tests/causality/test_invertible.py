"""What keeps a law from being inverted, in words."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import propermodel as pm
from propermodel import Component, Expr, Parameter, Port, Resistance, Translation, connect, parameter
from propermodel.bondgraph.flatten import flatten
from propermodel.causality.invertible import Inversion
from propermodel.expressions import clip, exp, maximum
from tests.parts import Mass

Law = Callable[[Resistance, Expr], Expr]


def obstacle(law: Callable[[Expr], Expr]) -> str:
    """The obstacle of the law F(v / 1 m/s) of a drag on a mass, in N."""

    class Drag(Resistance):
        port = Port(Translation)
        force: Parameter = parameter("N", default=1.0)
        speed: Parameter = parameter("m/s", default=1.0)

        def effort(self, flow: Expr) -> Expr:
            return self.force * law(flow / self.speed)

    drag, mass = Drag(), Mass(mass=1.0)
    rig = type("Rig", (Component,), {"drag": drag, "mass": mass, "connections": (connect(drag.port, mass.flange),)})
    graph = flatten(pm.elaborate(rig()))
    return Inversion(graph).obstacle(graph.normal.elements[pm.Path(("drag",))])


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (lambda v: 3.0 * v, ""),
        (lambda v: v + v**3.0, ""),
        (lambda v: clip(v, -1.0, 1.0), "is flat from 1 to 10 m/s"),
        (lambda v: maximum(v - 1.0, 0.0), "is flat from 0 to 1e-12 m/s"),
        (lambda v: v * exp(-v * v), "turns back between 1 and 10 m/s"),
        (lambda v: v * v, "turns back between -1e-12 and 0 m/s"),
        (lambda v: v * v * v, "is flat at 0"),
        (lambda v: 0.0 * v + 1.0, "does not depend on what it takes"),
    ],
)
def test_what_keeps_a_law_from_being_inverted(law: Callable[[Expr], Expr], expected: str):
    assert obstacle(law) == expected
