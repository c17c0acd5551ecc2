"""The pictures that the tests of the drawing code share with those of Python.

`python -m tests.drawing.pictures` writes them again, after a change of what a picture tells.
"""

import json
from collections.abc import Callable
from pathlib import Path

from propermodel import Model, compile_model
from propermodel.catalogue.finding import load_subject
from propermodel.drawing.depict import depict

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "web" / "test" / "pictures"


def _example(name: str) -> Callable[[], Model]:
    return lambda: load_subject(str(ROOT / "examples" / f"{name}.py")).model


MODELS: dict[str, Callable[[], Model]] = {
    "quarter_car": _example("quarter_car"),
    "buck_converter": _example("buck_converter"),
    "hydraulic_press": _example("hydraulic_press"),
    "half_car": lambda: load_subject("half-car").model,
    "truck": lambda: load_subject("truck").model,
}


def text_of(name: str) -> str:
    """The document of a picture as it is in its file."""
    return json.dumps(depict(compile_model(MODELS[name]())).document(), indent=1) + "\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name in MODELS:
        (FOLDER / f"{name}.json").write_text(text_of(name), encoding="utf-8")
