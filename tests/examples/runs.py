"""The examples of the gallery, loaded as the command line loads them and run once per test session."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import patch

import propermodel as pm
from propermodel.catalogue.finding import load_subject
from propermodel.catalogue.subject import Subject
from propermodel.simulation.trajectory import Trajectory

FOLDER = Path(__file__).parents[2] / "examples"
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("[a-z]*.py")))


def module(name: str) -> ModuleType:
    return import_module(f"examples.{name}")


@cache
def subject(name: str) -> Subject:
    return load_subject(str(FOLDER / f"{name}.py"))


@cache
def run_of(name: str) -> tuple[Trajectory, Mapping[str, Any]]:
    """The run of an example's scenario, and the options that its author simulates it with."""
    with patch.object(pm, "simulate", wraps=pm.simulate) as asked:
        run = module(name).run(subject(name).model)
    asked.assert_called_once()
    return run, asked.call_args.kwargs


def answer(name: str) -> Trajectory:
    """The run of an example's scenario."""
    return run_of(name)[0]
