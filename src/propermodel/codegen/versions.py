"""What a measurement was made with."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version


def package_version() -> str:
    """The version of this package; sources that are not installed have none."""
    try:
        return version("propermodel")
    except PackageNotFoundError:
        return "(not installed)"


def versions() -> dict[str, str]:
    """Versions of this package and of what makes its numbers, the platform and the processor."""
    from llvmlite import binding

    return {
        "propermodel": package_version(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "llvmlite": version("llvmlite"),
        "llvm": ".".join(str(part) for part in binding.llvm_version_info),
        "platform": platform.platform(),
        "cpu": binding.get_host_cpu_name(),
    }
