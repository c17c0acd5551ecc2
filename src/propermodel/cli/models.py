"""From what stands on the command line to a model and its scenario."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from types import MappingProxyType, ModuleType
from typing import Any

from propermodel.cli.faults import CommandError
from propermodel.compiler import Method
from propermodel.diagnostics import Diagnostic, Path, ProperModelError, Source, nearest, parse_path, portable_file
from propermodel.modelling import Component, Model, Scenario, elaborate
from propermodel.modelling.components import Repeated
from propermodel.report.panels import Panel, Series
from propermodel.simulation.choosing import Choice
from propermodel.simulation.stepping import DEFAULT_TOLERANCE


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A model with its scenario and what is asked of it."""

    name: str
    model: Model
    scenario: Scenario
    outputs: tuple[Path, ...] = ()
    totals: Mapping[str, Path] = field(default_factory=dict[str, Path])
    panels: tuple[Panel, ...] = ()
    method: Choice = Method.SEMI_IMPLICIT
    step: float | None = None
    jacobian_every: int = 1
    tolerance: float = DEFAULT_TOLERANCE


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
            scenarios=_MISSIONS,
            outputs=("chassis.speed", "chassis.acceleration", "engine.crankshaft.flow", "engine.injection.fuel"),
            totals={"fuel_kg": "engine.fuel_meter.mass"},
            panels=(_SPEED, _ENGINE, _GEAR, _FUEL),
        ),
        "half-car": NamedModel(
            component=Target("propermodel.library.vehicle.half_car", "HalfCar"),
            scenarios={"rough_road": Target("propermodel.cli.roads", "rough_road")},
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


def load_subject(text: str, scenario: str | None = None) -> Subject:
    """The model that `text` names, with the scenario that `scenario` names (by default the model's own).

    Raises:
        CommandError: there is no such model or scenario.
        ProperModelError: the model is wrong.
    """
    if text in NAMED_MODELS:
        return _from_library(text, scenario)
    if text.endswith(".json"):
        from propermodel.modelling.documents import read_model

        model = read_model(text)
        return Subject(name=FilePath(text).stem, model=model, scenario=_scenario(scenario, {}, None))
    if text.endswith(".npz"):
        return _from_run(text, scenario)
    file, mark, name = text.rpartition(":")
    if mark and file.endswith(".py"):
        module = import_file(file)
        model = _as_model(_member(module, name, file), text)
        return Subject(name=model.name, model=model, scenario=_scenario(scenario, {}, module))
    if text.endswith(".py"):
        module = import_file(text)
        systems = _systems(module)
        if len(systems) == 1:
            model = _as_model(getattr(module, systems[0]), text)
            return Subject(name=model.name, model=model, scenario=_scenario(scenario, {}, module))
        raise CommandError.of(
            "command/model",
            f"'{text}' is a file of components: say which one is the model",
            help="one of " + ", ".join(f"{text}:{n}" for n in _components(module)) if _components(module) else "",
        )
    raise CommandError.of(
        "command/unknown-model",
        f"there is no model '{text}'",
        help=nearest(text, NAMED_MODELS) or f"give one of {', '.join(NAMED_MODELS)}; file.py:Class; or a JSON document",
    )


def _from_run(file: str, scenario: str | None) -> Subject:
    from propermodel.simulation.storage import load_trajectory

    stored = load_trajectory(file)
    return Subject(
        name=stored.model.name,
        model=stored.model,
        scenario=stored.scenario if scenario is None else _scenario(scenario, {}, None),
        method=stored.method,
        step=stored.step,
        jacobian_every=stored.jacobian_every,
    )


def _from_library(name: str, scenario: str | None) -> Subject:
    entry = NAMED_MODELS[name]
    return Subject(
        name=name,
        model=_as_model(entry.component.made(), name),
        scenario=_scenario(scenario, entry.scenarios, None),
        outputs=tuple(map(parse_path, entry.outputs)),
        totals={key: parse_path(path) for key, path in entry.totals.items()},
        panels=entry.panels,
        method=entry.method,
        step=entry.step,
    )


def _scenario(text: str | None, named: Mapping[str, Target], module: ModuleType | None) -> Scenario:
    """A scenario by name, from a file of Python or JSON, or the default: the first name, `scenario` of the module."""
    if text is None:
        if named:
            return next(iter(named.values())).made()
        found = getattr(module, "scenario", None)
        return Scenario() if found is None else _as_scenario(found, "scenario")
    if text in named:
        return named[text].made()
    if text.endswith(".json"):
        from propermodel.modelling.documents import read_scenario

        return read_scenario(text)
    file, mark, name = text.rpartition(":")
    if mark and file.endswith(".py"):
        return _as_scenario(_member(import_file(file), name, file), text)
    if module is not None and hasattr(module, text):
        return _as_scenario(getattr(module, text), text)
    known = [*named, *(_scenarios(module) if module else ())]
    offer = f"one of {', '.join(known)}; " if known else ""
    raise CommandError.of(
        "command/unknown-scenario",
        f"there is no scenario '{text}'",
        help=nearest(text, known) or f"give {offer}file.py:function; or a JSON document",
    )


def import_file(file: str) -> ModuleType:
    """The module of a Python file, which can import its neighbours.

    Raises:
        CommandError: there is no such file, or it cannot be imported.
    """
    path = FilePath(file).resolve()
    if not path.is_file():
        raise CommandError.of(
            "command/file", f"there is no file '{file}'", help="check the path; it counts from the working directory"
        )
    folder = str(path.parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None  # a .py file always has one, and a loader
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[path.stem] = module
    try:
        specification.loader.exec_module(module)
    except ProperModelError:
        raise
    except Exception as error:
        raise CommandError(
            [
                Diagnostic(
                    "command/import",
                    f"the file cannot be imported: {type(error).__name__}: {error}",
                    source=_where(error, path, file),
                    help="run the file with python first: it must import without errors",
                )
            ]
        ) from error
    return module


def _where(error: BaseException, path: FilePath, file: str) -> Source:
    """The last line of the file that led to an error."""
    if isinstance(error, SyntaxError):
        return Source(portable_file(error.filename or file), error.lineno or 0)
    lines = [
        lineno for frame, lineno in traceback.walk_tb(error.__traceback__) if frame.f_code.co_filename == str(path)
    ]
    return Source(portable_file(str(path)), lines[-1] if lines else 0)


def _member(module: ModuleType, name: str, file: str) -> Any:
    if not hasattr(module, name):
        known = [n for n in vars(module) if not n.startswith("_")]
        raise CommandError.of(
            "command/unknown-name", f"'{file}' has no '{name}'", help=nearest(name, known) or _list(_components(module))
        )
    return getattr(module, name)


def _list(names: list[str]) -> str:
    return f"it has {', '.join(names)}" if names else ""


def _components(module: ModuleType) -> list[str]:
    """The components that a module defines itself."""
    return [
        name
        for name, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, Component) and value.__module__ == module.__name__
    ]


def _systems(module: ModuleType) -> list[str]:
    """The components of a module that are wired of parts and are no part of another component there."""
    members: dict[str, type[Component]] = {name: getattr(module, name) for name in _components(module)}
    parts = {
        type(part)
        for member in members.values()
        for declared in member.declarations.values()
        for part in (declared if isinstance(declared, Repeated) else (declared,))
    }
    return [name for name, member in members.items() if member.connections and member not in parts]


def _scenarios(module: ModuleType) -> list[str]:
    """The scenarios of a module, and the functions that say they give one."""

    def gives_scenario(value: Any) -> bool:
        return getattr(value, "__annotations__", {}).get("return") in {Scenario, "Scenario"}

    return [
        name
        for name, value in vars(module).items()
        if isinstance(value, Scenario) or (gives_scenario(value) and value.__module__ == module.__name__)
    ]


def _as_model(value: Any, text: str) -> Model:
    made = value() if callable(value) else value
    if isinstance(made, Component):
        made = elaborate(made)
    if not isinstance(made, Model):
        raise CommandError.of(
            "command/model",
            f"'{text}' gives {type(made).__name__}, which is no component or model",
            help="name a Component class, a Model, or a function that gives one",
        )
    return made


def _as_scenario(value: Any, text: str) -> Scenario:
    made = value() if callable(value) else value
    if not isinstance(made, Scenario):
        raise CommandError.of(
            "command/scenario",
            f"'{text}' gives {type(made).__name__}, which is no scenario",
            help="name a Scenario or a function that gives one",
        )
    return made
