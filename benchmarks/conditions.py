"""Under which conditions something was measured."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from benchmarks.measure import Json

PACKAGES = ("llvmlite", "numpy", "scipy", "scikit-sundae", "numba", "casadi", "jax", "diffrax")


def conditions() -> Json:
    """Processor, system and versions."""
    return {
        "processor": _processor(),
        "registers": _registers(),
        "cores": os.cpu_count() or 1,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "packages": {name: found for name in PACKAGES if (found := _version(name))},
        "gcc": _gcc(),
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
    }


def load() -> float | None:
    """How many programs wanted to run during the last minute, where the system tells."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def _cpu_info(key: str) -> str:
    file = Path("/proc/cpuinfo")
    found = re.search(rf"^{key}\s*: (.*)$", file.read_text(), re.MULTILINE) if file.exists() else None
    return found[1] if found else ""


def _processor() -> str:
    return _cpu_info("model name") or platform.processor() or platform.machine()


def _registers() -> str:
    from propermodel.codegen.llvm_compiler import vector_lanes

    return f"{vector_lanes()} numbers"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _gcc() -> str:
    try:
        answer = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True, check=True)
    except (FileNotFoundError, subprocess.CalledProcessError):
        return ""
    return answer.stdout.strip()
