"""A server of a small folder, for all tests of this room."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import propermodel as pm
from propermodel.catalogue.finding import load_subject
from tests.studio.client import Client, Running

ROOT = Path(__file__).parents[2]

TROUBLE = '''"""Models that do not end well, with scenarios for them and for others."""

import os
from pathlib import Path

import propermodel as pm


class Mass(pm.Inertia):
    """A mass of 1 kg."""

    flange = pm.Port(pm.Translation)

    def momentum(self, flow: pm.Expr) -> pm.Expr:
        return pm.quantity(1.0, "kg") * flow


class Brittle(pm.Resistance):
    """A resistance whose law has no value for speeds above 1 m/s."""

    port = pm.Port(pm.Translation)

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return pm.quantity(1.0, "N.s/m") * flow * pm.sqrt(1.0 - flow / pm.quantity(1.0, "m/s"))


class Breaking(pm.Component):
    """A mass that is pulled until its law breaks."""

    mass = Mass()
    brittle = Brittle()
    pull = pm.Port(pm.Translation)
    connections = (
        pm.connect(pull, mass.flange, brittle.port),
        pm.prescribed_effort(pull),
    )


class Crash(pm.Component):
    """A model whose file is fine, but whose making raises."""

    mass = Mass()
    connections = (pm.connect(mass.flange, Brittle().port),) if False else ()

    def __init__(self) -> None:
        raise ValueError("no such thing")


def hard_pull() -> pm.Scenario:
    return pm.Scenario(name="hard pull", stop=5.0, inputs={"pull.effort": 10.0})


def endless() -> pm.Scenario:
    """A scenario that goes on and on, and says which process has asked for it."""
    Path("process.txt").write_text(str(os.getpid()), encoding="utf-8")
    return pm.Scenario(name="endless", stop=1e7, inputs={"road.flow": 0.1})
'''


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Models in Python and as documents, a scenario, and things that must stay out of reach."""
    root = tmp_path_factory.mktemp("studio") / "models"
    (root / "inner").mkdir(parents=True)
    shutil.copy(ROOT / "tests" / "cli" / "quarter_car.py", root / "car.py")
    (root / "trouble.py").write_text(TROUBLE, encoding="utf-8")
    subject = load_subject(f"{root / 'car.py'}:QuarterCar")
    pm.write_model(subject.model, root / "inner" / "car.json")
    pm.write_scenario(subject.scenario, root / "inner" / "waves.json")
    (root.parent / "secret.py").write_text("raise SystemExit", encoding="utf-8")
    (root / "way_out.py").symlink_to(root.parent / "secret.py")
    (root / "way_out").symlink_to(root.parent)
    (root / "notes.json").write_text("{}", encoding="utf-8")
    return root


@pytest.fixture(scope="session")
def studio(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    """A client that has been let in, of a server whose folder is trusted."""
    with Running(folder, tmp_path_factory.mktemp("trust") / "trust.json") as client:
        assert client.post("/api/trust", {}).json == {"trusted": True}
        yield client
