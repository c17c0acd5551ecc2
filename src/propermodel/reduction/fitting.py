"""A scenario for what is left of a model."""

from __future__ import annotations

from dataclasses import replace

from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path, SimulationError
from propermodel.modelling.model import Scenario
from propermodel.simulation.start import begin


def fitting_scenario(reduced: CompiledModel, scenario: Scenario) -> Scenario:
    """The scenario without starts and inputs for what a reduced model no longer has."""

    def starts(path: Path, value: float) -> bool:
        try:
            begin(reduced, replace(scenario, inputs={}, tables={}, parameters={}, initial={path: value}))
        except SimulationError:
            return False
        return True

    graph = reduced.graph
    return replace(
        scenario,
        inputs={path: value for path, value in scenario.inputs.items() if path in graph.tables},
        tables={path: value for path, value in scenario.tables.items() if path in graph.tables},
        parameters={path: value for path, value in scenario.parameters.items() if path in graph.parameters},
        initial={path: value for path, value in scenario.initial.items() if starts(path, value)},
    )
