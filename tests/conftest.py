"""What all tests share: reproducible search for counterexamples, and no screen."""

import os

from hypothesis import settings

# Before anything imports Matplotlib; child processes inherit it.
os.environ["MPLBACKEND"] = "Agg"
# Before anything imports NumPy: threads make the algebra of small matrices slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Compiling a model takes longer once than ever after, so a deadline would only measure the first example.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")
