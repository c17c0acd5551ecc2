"""Faults of drawing."""

from __future__ import annotations

import sys
import threading
from unittest.mock import patch

import propermodel as pm
from propermodel.drawing import javascript
from propermodel.drawing.picture import Picture, PictureBond, Strokes
from tests.faults.case import Case
from tests.faults.quarter import quarter


def without_engine() -> object:
    # A module that is None cannot be imported, and a new thread has no engine yet.
    with patch.dict(sys.modules, {"quickjs": None}), patch.object(javascript, "_local", threading.local()):
        return pm.to_svg(pm.depict(quarter()))


def bond_to_nothing() -> object:
    mass, wall = pm.Path(("mass",)), pm.Path(("wall",))
    loose = PictureBond(name=mass, tail=mass, head=wall, domain="", effort_into=None, strokes=Strokes.NONE)
    return pm.to_svg(Picture(name="loose", groups=(pm.Path(),), nodes=(), bonds=(loose,), signals=()))


CASES = (
    Case(code="drawing/javascript", run=without_engine, names=("quickjs-ng",), cure="pip install 'propermodel[draw]'"),
    Case(
        code="drawing/failed",
        run=bond_to_nothing,
        names=(
            "cannot be drawn",
            "mass",
        ),
        cure="that `depict` made",
    ),
    Case(
        code="drawing/unknown-group",
        run=lambda: pm.to_svg(pm.depict(quarter()), open=["rode"]),
        names=("rode",),
        cure="road",
    ),
)
