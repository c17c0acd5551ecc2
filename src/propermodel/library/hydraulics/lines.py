"""Oil that moves in lines: laminar loss, inertia, and sections that carry waves."""

from __future__ import annotations

import math

from propermodel.expressions import Expr
from propermodel.library.hydraulics.components import OilChamber
from propermodel.modelling import (
    Component,
    Hydraulic,
    Inertia,
    Parameter,
    Port,
    Resistance,
    connect,
    parameter,
)


class LaminarLine(Resistance):
    """Laminar loss of a round pipe: dp = 128 mu l Q / (pi d^4) (Hagen and Poiseuille)."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    diameter: Parameter = parameter("m", low=0.0)
    length: Parameter = parameter("m", low=0.0)
    viscosity: Parameter = parameter("Pa.s", default=0.0278, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return 128.0 * self.viscosity * self.length / (math.pi * self.diameter**4.0) * flow


class OilInertia(Inertia):
    """A column of oil in a line: dp = (rho l / A) dQ/dt."""

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    port = Port(Hydraulic, between=(a, b))
    length: Parameter = parameter("m", low=0.0)
    area: Parameter = parameter("m2", low=0.0)
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0)
    start_flow: Parameter = parameter("m3/s", default=0.0)

    def momentum(self, flow: Expr) -> Expr:
        return self.density * self.length / self.area * flow

    def start(self) -> Expr:
        """The pressure momentum at the start."""
        return self.density * self.length / self.area * self.start_flow


class LineSection(Component):
    """A piece of pipe: oil that is accelerated and rubs, then oil that is compressed.

    A chain of sections carries waves at sqrt(bulk modulus / density), well up to about a fifth of the frequency at
    which a wave is one section long.
    """

    a = Port(Hydraulic)
    b = Port(Hydraulic)
    length: Parameter = parameter("m", low=0.0)
    diameter: Parameter = parameter("m", low=0.0)
    density: Parameter = parameter("kg/m3", default=870.0, low=0.0)
    bulk_modulus: Parameter = parameter("Pa", default=1.7e9, low=0.0)
    viscosity: Parameter = parameter("Pa.s", default=0.0278, low=0.0)
    start_flow: Parameter = parameter("m3/s", default=0.0)
    start_pressure: Parameter = parameter("Pa", default=0.0, doc="gauge")

    loss = LaminarLine(diameter=diameter, length=length, viscosity=viscosity)
    column = OilInertia(
        length=length, area=0.25 * math.pi * diameter * diameter, density=density, start_flow=start_flow
    )
    oil = OilChamber(
        volume=0.25 * math.pi * diameter * diameter * length, bulk_modulus=bulk_modulus, start_pressure=start_pressure
    )

    connections = (
        connect(a, loss.a),
        connect(loss.b, column.a),
        connect(column.b, oil.port, b),
    )
