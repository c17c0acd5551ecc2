"""The package as its users get it: what a browser is tested against comes from the wheel, not from the sources.

`python -m tests.browser.wheel` builds the wheel and unpacks it into `out/browser/wheel`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.drawing.pictures import ROOT

FOLDER = ROOT / "out" / "browser" / "wheel"
OPTIONS = ("--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet")


def install() -> None:
    """Put the wheel where `PYTHONPATH` finds it before the sources.

    Raises:
        RuntimeError: the package that is found is another one.
    """
    shutil.rmtree(FOLDER, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "pip", "install", *OPTIONS, "--target", str(FOLDER), str(ROOT)], check=True)
    where = subprocess.run(
        [sys.executable, "-P", "-c", "import propermodel; print(propermodel.__file__)"],
        env={**os.environ, "PYTHONPATH": str(FOLDER)},
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    if FOLDER not in Path(where).parents:
        raise RuntimeError(f"the browser would be tested against {where}, not against the wheel in {FOLDER}")


if __name__ == "__main__":
    install()
