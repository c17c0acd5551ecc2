"""The command line."""

import os


def main() -> None:
    """The entry point of `propermodel`."""
    # Linear algebra is of many small matrices here, for which threads only wait for each other; runs are what goes on
    # side by side. It counts before NumPy is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from propermodel.cli.app import app

    app()
