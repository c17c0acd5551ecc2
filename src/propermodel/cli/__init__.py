"""The command line."""


def main() -> None:
    """The entry point of `propermodel`."""
    from propermodel.cli.app import app

    app()
