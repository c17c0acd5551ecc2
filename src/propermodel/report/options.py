"""How a study is made, and whether it can be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from propermodel.compiler import CompiledModel, Method
from propermodel.diagnostics import Diagnostic, Path, SimulationError, one_of
from propermodel.modelling.model import Scenario
from propermodel.report.panels import Panel
from propermodel.simulation.choosing import AUTO, Choice
from propermodel.simulation.stepping import DEFAULT_STEP, DEFAULT_TOLERANCE


@dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """How a study is made.

    `outputs` are protected and compared. `totals` are observables whose change over the run is reported, by name
    (`fuel_kg`). Without outputs, the efforts and flows of the most active storage are compared.
    """

    threshold: float = 0.99
    tolerance: float = 0.1  # of the local tests
    drop_driven: bool = True
    outputs: tuple[Path, ...] = ()
    totals: Mapping[str, Path] = field(default_factory=dict[str, Path])
    panels: tuple[Panel, ...] = ()  # of the figure of the mission
    method: Choice = Method.SEMI_IMPLICIT
    step: float | None = None
    jacobian_every: int = 1  # steps that an implicit method takes with one Jacobian
    step_tolerance: float = DEFAULT_TOLERANCE  # of a method that controls its steps
    speed_repeats: int = 5  # 0: not measured
    best_steps: bool = True
    integral_period: float | None = None  # at which integrals are kept, s; by default a hundredth of the scenario

    def record_every(self, scenario: Scenario) -> float:
        """The period of recording, s: at least a thousand rows of a short scenario."""
        period = min(0.1, (scenario.stop - scenario.start) / 1000.0)
        return period if self.method == AUTO or self.method.is_adaptive else max(self._step, period)

    def integrals_every(self, scenario: Scenario) -> float:
        """The period at which integrals are kept, s."""
        if self.integral_period is not None:
            return self.integral_period
        return max(self.record_every(scenario), min(1.0, (scenario.stop - scenario.start) / 100.0))

    @property
    def _step(self) -> float:
        return DEFAULT_STEP if self.step is None else self.step


def check_outputs(compiled: CompiledModel, outputs: tuple[Path, ...]) -> None:
    """See before a long run that every output exists.

    Raises:
        SimulationError: some do not.
    """
    known = compiled.lowered.observables
    unknown = [path for path in outputs if path not in known]
    if unknown:
        raise SimulationError(
            [
                Diagnostic(
                    "simulation/unknown-observable",
                    f"the model has no observable '{path}'",
                    help=one_of(str(path), map(str, known)),
                )
                for path in unknown
            ]
        )
