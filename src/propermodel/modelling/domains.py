"""Energy domains: which pair of variables is effort and flow, and what a connection shares."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar


class Shared(StrEnum):
    """What the ports of one connection have in common."""

    EFFORT = "effort"  # a connection is a 0-junction: hydraulics, electrics, heat
    FLOW = "flow"  # a connection is a 1-junction: mechanics


@dataclass(frozen=True, slots=True, kw_only=True)
class DomainData:
    """A domain as plain data; what a `Model` holds."""

    name: str
    effort: str
    effort_unit: str
    flow: str
    flow_unit: str
    displacement_unit: str
    momentum_unit: str
    shared: Shared
    datum: str
    is_true: bool


class Domain:
    """An energy domain. Subclass it to declare one; it is never instantiated.

    `shared` says what connected ports have in common, `datum` from where an effort or flow with an arbitrary zero is
    counted, and `is_true` that effort times flow is power (a pseudo bond graph says False and is never ranked
    with true bonds).
    """

    name: ClassVar[str]
    effort: ClassVar[str]
    effort_unit: ClassVar[str]
    flow: ClassVar[str]
    flow_unit: ClassVar[str]
    displacement_unit: ClassVar[str]
    momentum_unit: ClassVar[str]
    shared: ClassVar[Shared]
    datum: ClassVar[str] = ""
    is_true: ClassVar[bool] = True

    @classmethod
    def data(cls) -> DomainData:
        """The domain by value."""
        return DomainData(
            name=cls.name,
            effort=cls.effort,
            effort_unit=cls.effort_unit,
            flow=cls.flow,
            flow_unit=cls.flow_unit,
            displacement_unit=cls.displacement_unit,
            momentum_unit=cls.momentum_unit,
            shared=cls.shared,
            datum=cls.datum,
            is_true=cls.is_true,
        )


class Translation(Domain):
    """Straight-line mechanics: force and velocity; connected flanges move together."""

    name = "translation"
    effort, effort_unit = "force", "N"
    flow, flow_unit = "velocity", "m/s"
    displacement_unit, momentum_unit = "m", "N.s"
    shared = Shared.FLOW
    datum = "velocity counts from the frame at rest, and with it what inertias take part in"


class Rotation(Domain):
    """Rotating mechanics: torque and angular velocity; connected shafts turn together."""

    name = "rotation"
    effort, effort_unit = "torque", "N.m"
    flow, flow_unit = "angular velocity", "rad/s"
    displacement_unit, momentum_unit = "rad", "N.m.s"
    shared = Shared.FLOW
    datum = "angular velocity counts from the frame at rest, and with it what inertias take part in"


class Hydraulic(Domain):
    """Hydraulics: gauge pressure and volume flow; connected ports have one pressure."""

    name = "hydraulic"
    effort, effort_unit = "pressure", "Pa"
    flow, flow_unit = "volume flow", "m3/s"
    displacement_unit, momentum_unit = "m3", "Pa.s"
    shared = Shared.EFFORT
    datum = "pressure counts from ambient"


class Thermal(Domain):
    """Heat as a true bond: temperature above ambient, entropy flow; connected ports have one temperature."""

    name = "thermal"
    effort, effort_unit = "temperature above ambient", "K"
    flow, flow_unit = "entropy flow", "W/K"
    displacement_unit, momentum_unit = "J/K", "K.s"
    shared = Shared.EFFORT
    datum = "temperature counts from ambient, so heat counts by what could still do work"


class PseudoThermal(Domain):
    """Heat as a pseudo bond: temperature and heat flow, whose product is no power.

    Connected ports have one temperature. Only a converter joins these bonds with true ones.
    """

    name = "pseudo_thermal"
    effort, effort_unit = "temperature", "K"
    flow, flow_unit = "heat flow", "W"
    displacement_unit, momentum_unit = "J", "K.s"
    shared = Shared.EFFORT
    datum = "temperature counts from absolute zero"
    is_true = False


class Electrical(Domain):
    """Electricity: voltage and current; connected pins have one potential."""

    name = "electrical"
    effort, effort_unit = "voltage", "V"
    flow, flow_unit = "current", "A"
    displacement_unit, momentum_unit = "C", "V.s"
    shared = Shared.EFFORT
    datum = "voltage counts from ground"
