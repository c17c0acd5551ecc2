"""How tests call commands, as a user types them."""

from pathlib import Path

from typer.testing import CliRunner, Result

from propermodel.cli.app import app

FILE = Path(__file__).with_name("quarter_car.py")


MODEL = f"{FILE}:QuarterCar"


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def succeed(*arguments: object) -> str:
    done = invoke(*arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


def fail(code: int, *arguments: object) -> str:
    done = invoke(*arguments)
    assert done.exit_code == code, done.output
    assert "Traceback" not in done.output
    return done.stderr


def _model():
    from propermodel.catalogue.finding import load_subject

    return load_subject(MODEL).model
