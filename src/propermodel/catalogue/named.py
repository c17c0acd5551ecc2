"""Models of the library under short names, with their usual scenarios, outputs and panels."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from propermodel.compiler import Method
from propermodel.report.panels import Panel, Series


@dataclass(frozen=True, slots=True)
class Target:
    """Something in a module, with the arguments it is called with."""

    module: str
    name: str
    arguments: tuple[str, ...] = ()

    def made(self) -> Any:
        """What it gives."""
        return getattr(importlib.import_module(self.module), self.name)(*self.arguments)


@dataclass(frozen=True, kw_only=True)
class NamedModel:
    """A model of the library under a short name, with its usual scenarios; the first is the default."""

    component: Target
    title: str
    description: str
    scenarios: Mapping[str, Target]
    outputs: tuple[str, ...] = ()
    totals: Mapping[str, str] = field(default_factory=dict[str, str])
    panels: tuple[Panel, ...] = ()
    method: Method = Method.SEMI_IMPLICIT
    step: float | None = None


_MISSIONS = {"fmtv_mixed": Target("propermodel.library.vehicle.mission", "mission", ("fmtv_mixed",))}
_SPEED = Panel(
    "Speed of the truck", (Series("driver.speed_profile", "profile", dashed=True), Series("chassis.speed", "truck"))
)
_ENGINE = Panel("Engine speed", (Series("engine.crankshaft.flow"),))
_GEAR = Panel("Gear", (Series("transmission.to_gear"),), unit="gear")
_FUEL = Panel("Fuel", (Series("engine.fuel_meter.mass"),))

NAMED_MODELS: Mapping[str, NamedModel] = MappingProxyType(
    {
        "truck": NamedModel(
            component=Target("propermodel.library.vehicle.truck", "HybridTruck"),
            title="Hybrid truck",
            description="a truck with a diesel engine and a hydraulic accumulator, on a mixed mission of 2200 s",
            scenarios=_MISSIONS,
            outputs=(
                "chassis.speed",
                "chassis.acceleration",
                "engine.crankshaft.flow",
                "engine.injection.fuel",
                "hydraulics.accumulator_pressure",
            ),
            totals={"fuel_kg": "engine.fuel_meter.mass"},
            panels=(
                _SPEED,
                _ENGINE,
                _GEAR,
                Panel(
                    "Pressure of the accumulator and the reservoir",
                    (
                        Series("hydraulics.accumulator_pressure", "accumulator"),
                        Series("hydraulics.reservoir_pressure", "reservoir", dashed=True),
                    ),
                ),
                Panel(
                    "State of charge: oil in the accumulator",
                    (Series("hydraulics.accumulator_oil", scale=1e3),),
                    unit="L",
                ),
                _FUEL,
            ),
        ),
        "conventional-truck": NamedModel(
            component=Target("propermodel.library.vehicle.truck", "ConventionalTruck"),
            title="Conventional truck",
            description="the same truck without the hydraulic drive",
            scenarios=_MISSIONS,
            outputs=("chassis.speed", "chassis.acceleration", "engine.crankshaft.flow", "engine.injection.fuel"),
            totals={"fuel_kg": "engine.fuel_meter.mass"},
            panels=(_SPEED, _ENGINE, _GEAR, _FUEL),
        ),
        "half-car": NamedModel(
            component=Target("propermodel.library.vehicle.half_car", "HalfCar"),
            title="Half car",
            description="a body on two wheels, with gas springs, on a rough road",
            scenarios={"rough_road": Target("propermodel.catalogue.roads", "rough_road")},
            outputs=("heave.flange.flow", "pitch.shaft.flow"),
            panels=(
                Panel(
                    "Vertical speed of the road",
                    (Series("front_road.flow", "front"), Series("rear_road.flow", "rear", dashed=True)),
                ),
                Panel("Vertical speed of the body", (Series("heave.flange.flow"),)),
                Panel("Pitch rate", (Series("pitch.shaft.flow"),)),
                Panel(
                    "Force of the tyre springs, from equilibrium",
                    (
                        Series("front.tyre.spring.port.effort", "front"),
                        Series("rear.tyre.spring.port.effort", "rear", dashed=True),
                    ),
                ),
            ),
        ),
    }
)
