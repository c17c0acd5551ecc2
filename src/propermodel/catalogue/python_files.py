"""Files of Python, which are run to find the components and scenarios in them."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from pathlib import Path as FilePath
from types import ModuleType
from typing import Any

from propermodel.catalogue.faults import CatalogueError
from propermodel.diagnostics import Diagnostic, ProperModelError, Source, nearest, portable_file
from propermodel.modelling import Component, Scenario
from propermodel.modelling.components import Repeated


def import_file(file: str) -> ModuleType:
    """The module of a Python file, which can import its neighbours.

    Raises:
        CatalogueError: there is no such file, or it cannot be imported.
    """
    path = FilePath(file).resolve()
    if not path.is_file():
        raise CatalogueError.of(
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
        raise CatalogueError(
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


def member_of(module: ModuleType, name: str, file: str) -> Any:
    """What a module calls by a name.

    Raises:
        CatalogueError: nothing.
    """
    if not hasattr(module, name):
        known = [n for n in vars(module) if not n.startswith("_")]
        raise CatalogueError.of(
            "command/unknown-name",
            f"'{file}' has no '{name}'",
            help=nearest(name, known) or _list(components_of(module)),
        )
    return getattr(module, name)


def _list(names: list[str]) -> str:
    return f"it has {', '.join(names)}" if names else ""


def components_of(module: ModuleType) -> list[str]:
    """The components that a module defines itself."""
    return [
        name
        for name, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, Component) and value.__module__ == module.__name__
    ]


def systems_of(module: ModuleType) -> list[str]:
    """The components of a module that are wired of parts and are no part of another component there."""
    members: dict[str, type[Component]] = {name: getattr(module, name) for name in components_of(module)}
    parts = {
        type(part)
        for member in members.values()
        for declared in member.declarations.values()
        for part in (declared if isinstance(declared, Repeated) else (declared,))
    }
    return [name for name, member in members.items() if member.connections and member not in parts]


def scenarios_of(module: ModuleType) -> list[str]:
    """The scenarios of a module, and the functions that say they give one."""

    def gives_scenario(value: Any) -> bool:
        return getattr(value, "__annotations__", {}).get("return") in {Scenario, "Scenario"}

    return [
        name
        for name, value in vars(module).items()
        if isinstance(value, Scenario) or (gives_scenario(value) and value.__module__ == module.__name__)
    ]
