"""From a name, a file or a document to a model and its scenario."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from types import ModuleType
from typing import Any

from propermodel.catalogue.faults import CatalogueError
from propermodel.catalogue.named import NAMED_MODELS, Target
from propermodel.catalogue.python_files import components_of, import_file, member_of, scenarios_of, systems_of
from propermodel.catalogue.subject import Subject
from propermodel.diagnostics import nearest, parse_path
from propermodel.modelling import Component, Model, Scenario, elaborate


def load_subject(text: str, scenario: str | None = None) -> Subject:
    """The model that `text` names, with the scenario that `scenario` names (by default the model's own).

    Raises:
        CatalogueError: there is no such model or scenario.
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
        model = _as_model(member_of(module, name, file), text)
        return Subject(name=model.name, model=model, scenario=_scenario(scenario, {}, module))
    if text.endswith(".py"):
        module = import_file(text)
        systems = systems_of(module)
        if len(systems) == 1:
            model = _as_model(getattr(module, systems[0]), text)
            return Subject(name=model.name, model=model, scenario=_scenario(scenario, {}, module))
        raise CatalogueError.of(
            "command/model",
            f"'{text}' is a file of components: say which one is the model",
            help="one of " + ", ".join(f"{text}:{n}" for n in components_of(module)) if components_of(module) else "",
        )
    raise CatalogueError.of(
        "command/unknown-model",
        f"there is no model '{text}'",
        help=nearest(text, NAMED_MODELS) or f"give one of {', '.join(NAMED_MODELS)}; file.py:Class; or a JSON document",
    )


def scenario_names(text: str) -> tuple[str, ...]:
    """What the scenarios that come with a model are called, the default first.

    Raises:
        CatalogueError: a file of Python cannot be imported.
    """
    if text in NAMED_MODELS:
        return tuple(NAMED_MODELS[text].scenarios)
    file = text.rpartition(":")[0] or text
    if not file.endswith(".py"):
        return ()
    names = scenarios_of(import_file(file))
    return tuple(sorted(names, key=lambda name: name != "scenario"))


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
        return _as_scenario(member_of(import_file(file), name, file), text)
    if module is not None and hasattr(module, text):
        return _as_scenario(getattr(module, text), text)
    known = [*named, *(scenarios_of(module) if module else ())]
    offer = f"one of {', '.join(known)}; " if known else ""
    raise CatalogueError.of(
        "command/unknown-scenario",
        f"there is no scenario '{text}'",
        help=nearest(text, known) or f"give {offer}file.py:function; or a JSON document",
    )


def _as_model(value: Any, text: str) -> Model:
    made = value() if callable(value) else value
    if isinstance(made, Component):
        made = elaborate(made)
    if not isinstance(made, Model):
        raise CatalogueError.of(
            "command/model",
            f"'{text}' gives {type(made).__name__}, which is no component or model",
            help="name a Component class, a Model, or a function that gives one",
        )
    return made


def _as_scenario(value: Any, text: str) -> Scenario:
    made = value() if callable(value) else value
    if not isinstance(made, Scenario):
        raise CatalogueError.of(
            "command/scenario",
            f"'{text}' gives {type(made).__name__}, which is no scenario",
            help="name a Scenario or a function that gives one",
        )
    return made
