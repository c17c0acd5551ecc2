"""Two-ports that a smaller model turns round although their modulus passes zero: it has no solution there.

A model without some of its inertias may have to find the speed of a crank from that of its piston. At a dead centre it
cannot, whatever the starting values; equations show it before anything is simulated.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from propermodel.bondgraph.parameters import parameter_values
from propermodel.causality.vanishing import dividing_two_ports, without_signals
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Path
from propermodel.expressions.core import TIME, Expr, leaves
from propermodel.modelling.model import TwoPort
from propermodel.simulation.evaluation import Evaluation
from propermodel.simulation.trajectory import Trajectory


def divisions_by_zero(reduced: CompiledModel, runs: Iterable[Trajectory]) -> tuple[Path, ...]:
    """The two-ports that a reduced model divides by, and the full one does not, whose modulus passes zero in a run.

    Args:
        reduced: A model without some of the elements of the full one.
        runs: Runs of the full model with all observables recorded.
    """
    found: set[Path] = set()
    for run in runs:
        known = {element.path for element in dividing_two_ports(run.compiled.system.causal)}
        for element in dividing_two_ports(reduced.system.causal):
            if element.path not in known and isinstance(element.behaviour, TwoPort):
                values = _along(run, without_signals(element.behaviour.modulus, reduced.graph))
                if np.min(values) <= 0.0 <= np.max(values):
                    found.add(element.path)
    return tuple(sorted(found))


def _along(run: Trajectory, expr: Expr) -> FloatArray:
    """The values of an expression along a run."""
    parameters = parameter_values(run.compiled.graph.parameters, run.scenario.parameters)
    given: dict[Expr, FloatArray] = {TIME: run.time}
    for leaf in leaves(expr):
        if leaf in parameters:
            given[leaf] = np.full_like(run.time, parameters[leaf])
        elif leaf.data.path in run:
            given[leaf] = run[leaf.data.path]
    return Evaluation(run.compiled.lowered, run.memory).values([expr], given)[0]
