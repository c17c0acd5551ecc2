"""A folder for the tests of the studio in a browser, and what Python says that its pages must show.

`python -m tests.browser.studio` writes both to `out/browser`. With `window FROM TO` it prints how a part of the run of
the quarter car is ranked.
"""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

import propermodel as pm
from propermodel.analysis.activity import rank_activity
from propermodel.catalogue.finding import load_subject
from propermodel.compiler import CompiledModel, compile_quietly
from propermodel.diagnostics import parse_path
from propermodel.drawing.depict import depict
from propermodel.report.study import StudyOptions, run_study
from propermodel.simulation.trajectory import Trajectory
from tests.drawing.pictures import ROOT

FOLDER = ROOT / "out" / "browser" / "studio"
EXPECTED = ROOT / "out" / "browser" / "studio.json"
CAR = "quarter_car.py:QuarterCar"
STEP = 1e-3
THRESHOLD = 0.97
OUTPUTS = tuple(map(parse_path, ("body.flange.flow", "wheel.flange.flow")))
SPIKE = 7.0  # m/s, for one sample of the road

TROUBLE = '''"""A model whose run fails, scenarios that go on and on, and a road with a spike."""

import propermodel as pm
from propermodel.library.mechanics.translation import Mass, SpringDamper


class Brittle(pm.Resistance):
    """A resistance whose law has no value for speeds above 1 m/s."""

    port = pm.Port(pm.Translation)

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return pm.quantity(1.0, "N.s/m") * flow * pm.sqrt(1.0 - flow / pm.quantity(1.0, "m/s"))


class Breaking(pm.Component):
    """A mass that is pulled until its law breaks."""

    mass = Mass(mass=1.0)
    brittle = Brittle()
    pull = pm.Port(pm.Translation)
    connections = (
        pm.connect(pull, mass.flange, brittle.port),
        pm.prescribed_effort(pull),
    )


class Shaken(pm.Component):
    """A mass on a spring on a road that the scenario moves."""

    road = pm.Port(pm.Translation)
    tyre = SpringDamper(stiffness=1.0e4, damping=2.0e2)
    mass = Mass(mass=100.0)
    connections = (
        pm.connect(road, tyre.a),
        pm.prescribed_flow(road),
        pm.connect(tyre.b, mass.flange),
    )


def hard_pull() -> pm.Scenario:
    return pm.Scenario(name="hard pull", stop=5.0, inputs={"pull.effort": 10.0})


def endless() -> pm.Scenario:
    return pm.Scenario(name="endless", stop=1e7, inputs={"road.flow": 0.1})


def bump() -> pm.Scenario:
    road = pm.TableValues(((0.0, 4.999, 5.0, 5.001, 20.0),), (0.1, 0.1, SPIKE, 0.1, 0.1))
    return pm.Scenario(name="bump", stop=20.0, inputs={"road.flow": road})
'''.replace("SPIKE", str(SPIKE))


def car() -> tuple[CompiledModel, pm.Scenario]:
    subject = load_subject(str(FOLDER / CAR))
    return compile_quietly(subject.model), subject.scenario


def run_of_car() -> Trajectory:
    compiled, scenario = car()
    return pm.simulate(compiled, scenario, method=pm.Method.RK4, step=STEP, record_every=STEP, integrals_every=0.01)


def drawn(model: pm.Model) -> dict[str, object]:
    """What a page must draw of a model."""
    picture = depict(compile_quietly(model))
    return {
        "nodes": sorted(str(node.path) for node in picture.nodes),
        "strokes": {str(bond.name): "head" if bond.effort_into == bond.head else "tail" for bond in picture.bonds},
        "groups": [str(group) for group in picture.groups if group],
    }


def write() -> None:
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    shutil.copy(ROOT / "examples" / "quarter_car.py", FOLDER / "quarter_car.py")
    (FOLDER / "trouble.py").write_text(TROUBLE, encoding="utf-8")
    full = run_of_car()
    ranking = rank_activity(full)
    _, scenario = car()
    options = StudyOptions(outputs=OUTPUTS, threshold=THRESHOLD, method=pm.Method.RK4, step=STEP, speed_repeats=0)
    study = run_study(load_subject(str(FOLDER / CAR)).model, replace(scenario, stop=10.0), options)
    thresholds = [round(float(t), 3) for t in np.linspace(0.5, 1.0, 51)]
    expected = {
        "models": {
            "truck": drawn(load_subject("truck").model),
            "half-car": drawn(load_subject("half-car").model),
            CAR: drawn(load_subject(str(FOLDER / CAR)).model),
        },
        "rows": [(str(row.path), row.activity) for row in ranking.rows],
        "kept": [(threshold, len(ranking.kept_by(threshold))) for threshold in thresholds],
        "step": STEP,
        "values": [round(float(value), 8) for value in full[OUTPUTS[0]]],
        "reduction": {
            "threshold": THRESHOLD,
            "states": [len(run.compiled.system.states) for run in (study.full, study.reduced)],
            "gone": sorted(str(d.row.path) for d in study.reduction.decisions if d.verdict.value == "removed"),
            "outputs": {str(error.path): error.rms for error in study.comparison.outputs},
        },
        "spike": SPIKE,
    }
    EXPECTED.write_text(json.dumps(expected), encoding="utf-8")


def main(words: list[str]) -> None:
    if words[:1] == ["window"]:
        window = (float(words[1]), float(words[2]))
        ranking = rank_activity(run_of_car(), window=window)
        print(json.dumps([(str(row.path), row.activity) for row in ranking.rows]))
        return
    FilePath(FOLDER).parent.mkdir(parents=True, exist_ok=True)
    write()


if __name__ == "__main__":
    main(sys.argv[1:])
