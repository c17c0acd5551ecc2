"""Run in a process of its own: opens the documents in a folder where their authors' modules do not exist.

Reads `orders.json`, which gives options by name, and for each name `name.model.json` and `name.scenario.json`; runs the
model, writes it anew, and saves the run.
"""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import propermodel as pm
from propermodel.modelling.documents import read_model, read_scenario, write_model

LIBRARIES = ("propermodel.library", "examples", "tests")


def main(folder: Path) -> None:
    assert importlib.util.find_spec("examples") is None
    assert importlib.util.find_spec("tests") is None
    for name, options in json.loads((folder / "orders.json").read_text(encoding="utf-8")).items():
        model = read_model(folder / f"{name}.model.json")
        scenario = read_scenario(folder / f"{name}.scenario.json")
        write_model(model, folder / f"{name}.again.json")
        method = pm.Method(options.pop("method"))
        run = pm.simulate(pm.compile_model(model), scenario, method=method, **options)
        pm.save_trajectory(run, folder / f"{name}.npz")
    # Not even the parts of the library are needed.
    loaded = [module for module in sys.modules if module.startswith(LIBRARIES)]
    assert loaded == [], loaded


if __name__ == "__main__":
    main(Path(sys.argv[1]))
