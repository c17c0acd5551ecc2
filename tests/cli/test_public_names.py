"""What `import propermodel` gives, and what it leaves for later."""

import ast
import subprocess
import sys
from pathlib import Path

import propermodel

# What models are simulated with, and what is only for some of its users.
ENGINE = {"numpy", "llvmlite"}
HEAVY = {"pint", "scipy", "pandas", "xarray", "matplotlib", "typer", "rich", "starlette", "sympy", "control"}

TRUCK = """
from propermodel import Method, Scenario, compile_model, elaborate, simulate
from propermodel.library.vehicle.mission import mission
from propermodel.library.vehicle.truck import HybridTruck
from dataclasses import replace
simulate(compile_model(elaborate(HybridTruck())), replace(mission("fmtv_mixed"), stop=1e-4), step=1e-4)
"""


def loaded_by(code: str) -> set[str]:
    """The packages that a new process has loaded after this."""
    code += "\nimport sys; print('loaded', *{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_importing_loads_nothing_heavy():
    loaded = loaded_by("import propermodel")
    assert "propermodel" in loaded
    assert not loaded & (ENGINE | HEAVY)


def test_simulating_loads_the_engine_only():
    loaded = loaded_by(TRUCK)
    assert loaded >= ENGINE
    assert not loaded & HEAVY


def test_every_public_name_is_there_and_listed():
    for name in propermodel.__all__:
        assert getattr(propermodel, name) is not None
    assert set(propermodel.__all__) <= set(dir(propermodel))
    assert isinstance(propermodel.__version__, str)


def test_names_imported_when_used_are_those_that_a_type_checker_sees():
    tree = ast.parse(Path(str(propermodel.__file__)).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {alias.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen == {name: f"propermodel.{module}" for name, module in propermodel._WHEN_USED.items()}


def test_an_unknown_name_is_an_attribute_error():
    assert not hasattr(propermodel, "simulat")
