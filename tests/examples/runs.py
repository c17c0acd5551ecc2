"""The examples of the gallery, loaded as the command line loads them and run once per test session."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

from propermodel.cli.models import Subject, load_subject
from propermodel.simulation.trajectory import Trajectory

FOLDER = Path(__file__).parents[2] / "examples"
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("[a-z]*.py")))


def module(name: str) -> ModuleType:
    return import_module(f"examples.{name}")


@cache
def subject(name: str) -> Subject:
    return load_subject(str(FOLDER / f"{name}.py"))


@cache
def answer(name: str) -> Trajectory:
    """The run of an example's scenario."""
    return module(name).run(subject(name).model)
