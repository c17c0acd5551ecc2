"""A model with its scenario and what is asked of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from propermodel.compiler import Method
from propermodel.diagnostics import Path
from propermodel.modelling import Model, Scenario
from propermodel.report.panels import Panel
from propermodel.simulation.choosing import Choice
from propermodel.simulation.stepping import DEFAULT_TOLERANCE


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A model with its scenario and what is asked of it."""

    name: str
    model: Model
    scenario: Scenario
    outputs: tuple[Path, ...] = ()
    totals: Mapping[str, Path] = field(default_factory=dict[str, Path])
    panels: tuple[Panel, ...] = ()
    method: Choice = Method.SEMI_IMPLICIT
    step: float | None = None
    jacobian_every: int = 1
    tolerance: float = DEFAULT_TOLERANCE


def changed(
    subject: Subject,
    *,
    until: float | None = None,
    method: Choice | None = None,
    step: float | None = None,
    jacobian_every: int | None = None,
    tolerance: float | None = None,
    parameters: Mapping[Path, float] | None = None,
    outputs: tuple[Path, ...] = (),
) -> Subject:
    """The subject with what somebody asks for in place of its own; parameters, in SI, add to those of its scenario."""
    scenario = subject.scenario
    if until is not None:
        scenario = replace(scenario, stop=until)
    if parameters:
        scenario = replace(scenario, parameters={**scenario.parameters, **parameters})
    return replace(
        subject,
        scenario=scenario,
        method=subject.method if method is None else method,
        step=subject.step if step is None else step,
        jacobian_every=subject.jacobian_every if jacobian_every is None else jacobian_every,
        tolerance=subject.tolerance if tolerance is None else tolerance,
        outputs=outputs or subject.outputs,
    )
