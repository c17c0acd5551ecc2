"""What all tests share: reproducible search for counterexamples, no screen, and no code compiled earlier."""

import os
import shutil
import tempfile

import pytest
from hypothesis import settings

# Before anything imports Matplotlib; child processes inherit it.
os.environ["MPLBACKEND"] = "Agg"
# Before anything imports NumPy: threads make the algebra of small matrices slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Of this process and its children alone, so that no test meets what another version of the package has left.
CACHE = tempfile.mkdtemp(prefix="propermodel-tests-")
os.environ["PROPERMODEL_CACHE"] = CACHE


def pytest_unconfigure(config: pytest.Config) -> None:
    shutil.rmtree(CACHE, ignore_errors=True)


# Compiling a model takes longer once than ever after, so a deadline would only measure the first example.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")
