"""What `import propermodel` gives, and what it leaves for later."""

import ast
import subprocess
import sys
from pathlib import Path

import propermodel

HEAVY = ("pint", "scipy", "pandas", "xarray", "matplotlib", "typer", "rich", "llvmlite")


def test_importing_is_light():
    code = f"import sys, propermodel; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


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
