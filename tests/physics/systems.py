"""How the tests of physics build small systems, run them, and look at their linear part."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from propermodel.codegen.build import build_machine
from propermodel.codegen.machine import FloatArray
from propermodel.compiler import Backend, CompiledModel, Method, compile_model
from propermodel.diagnostics import parse_path
from propermodel.expressions import Expr, ExprLike, sin, time
from propermodel.modelling import (
    Component,
    EffortSource,
    Electrical,
    FlowSource,
    Gyrator,
    Model,
    MultiportResistance,
    Parameter,
    Port,
    Resistance,
    Rotation,
    Scenario,
    TableValues,
    Thermal,
    Transformer,
    Translation,
    elaborate,
    parameter,
)
from propermodel.simulation.simulate import simulate
from propermodel.simulation.start import begin
from propermodel.simulation.trajectory import Trajectory


def system(*connections: Any, **parts: Any) -> Component:
    """A component of these parts and connections."""
    return type("System", (Component,), {**parts, "connections": connections})()


def compiled(model: Component | Model | CompiledModel, backend: Backend = Backend.NATIVE) -> CompiledModel:
    if isinstance(model, CompiledModel):
        return model
    return compile_model(elaborate(model) if isinstance(model, Component) else model, backend=backend)


def scenario(
    stop: float,
    initial: Mapping[str, float] | None = None,
    inputs: Mapping[str, float | TableValues] | None = None,
    parameters: Mapping[str, float] | None = None,
    start: float = 0.0,
) -> Scenario:
    """A scenario with paths as text."""
    return Scenario(
        start=start,
        stop=stop,
        initial={parse_path(p): v for p, v in (initial or {}).items()},
        inputs={parse_path(p): v for p, v in (inputs or {}).items()},
        parameters={parse_path(p): v for p, v in (parameters or {}).items()},
    )


def run(
    model: Component | Model | CompiledModel,
    stop: float,
    *,
    step: float = 1e-3,
    method: Method = Method.RK4,
    every: float | None = None,
    backend: Backend = Backend.NATIVE,
    jacobian_every: int = 1,
    **given: Any,
) -> Trajectory:
    """A run with RK4, recorded at a hundred instants; it must reach its end."""
    trajectory = simulate(
        compiled(model, backend),
        scenario(stop, **given),
        method=method,
        step=step,
        jacobian_every=jacobian_every,
        record_every=stop / 100.0 if every is None else every,
        integrals_every=stop / 10.0,
    )
    assert trajectory.ending.is_complete, trajectory.ending.message
    return trajectory


def state_matrix(model: Component | Model | CompiledModel, **given: Any) -> FloatArray:
    """The matrix A of dx/dt = A x + b: exact for a linear model, as unit steps lose only rounding."""
    made = compiled(model)
    memory = begin(made, scenario(1.0, **given))
    machine = build_machine(made.lowered.program, Method.EULER, backend=Backend.INTERPRETED)  # nothing to build
    memory.state[:] = 0.0
    base = machine.rates(memory)[0].copy()
    columns: list[FloatArray] = []
    for index in range(len(memory.state)):
        memory.state[:] = 0.0
        memory.state[index] = 1.0
        columns.append(machine.rates(memory)[0] - base)
    return np.array(columns).T.reshape(len(memory.state), len(memory.state))


def eigenvalues(model: Component | Model | CompiledModel, **given: Any) -> FloatArray:
    """The eigenvalues of a linear model, by real then imaginary part."""
    found = np.linalg.eigvals(state_matrix(model, **given))
    return np.array(sorted(found, key=lambda x: (round(x.real, 6), x.imag)))


def close(found: FloatArray | float, expected: FloatArray | float, tolerance: float = 1e-8) -> None:
    """Equal to within a share of the range of what is expected."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    scale = max(float(np.ptp(expected)), float(np.max(np.abs(expected))) * 1e-3) or 1.0
    worst = float(np.max(np.abs(found - expected))) / scale
    assert worst <= tolerance, f"differs by {worst:.3g} of the range"


# -- sources that move with time; all act on their surroundings in the positive direction ------------------


class Push(EffortSource):
    flange = Port(Translation)
    force: Parameter = parameter("N")

    def effort(self) -> Expr:
        return -self.force


class SinePush(EffortSource):
    flange = Port(Translation)
    force: Parameter = parameter("N")
    frequency: Parameter = parameter("Hz")

    def effort(self) -> Expr:
        return -self.force * sin(2.0 * math.pi * self.frequency * time)


class Shaking(FlowSource):
    """Moves with the velocity amplitude times sin(2 pi f t)."""

    flange = Port(Translation)
    velocity: Parameter = parameter("m/s")
    frequency: Parameter = parameter("Hz")

    def flow(self) -> Expr:
        return self.velocity * sin(2.0 * math.pi * self.frequency * time)


class Moving(FlowSource):
    flange = Port(Translation)
    velocity: Parameter = parameter("m/s")

    def flow(self) -> Expr:
        return self.velocity


class Drive(EffortSource):
    shaft = Port(Rotation)
    torque: Parameter = parameter("N.m")

    def effort(self) -> Expr:
        return -self.torque


# -- elements that the library has no use for ---------------------------------------------------------------


class CubicDamper(Resistance):
    """F = c v^3: monotone, and only its effort is offered."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    factor: Parameter = parameter("N.s3/m3")

    def effort(self, flow: Expr) -> Expr:
        return self.factor * flow * flow * flow


class Wall(MultiportResistance):
    """Heat flows from the warm to the cold side and makes entropy: Q = hA (T_a - T_b)."""

    a = Port(Thermal)
    b = Port(Thermal)
    conductance: Parameter = parameter("W/K")
    ambient_temperature: Parameter = parameter("K", default=300.0)

    def laws(self) -> tuple[dict[Expr, ExprLike], ...]:
        heat = self.conductance * (self.a.effort - self.b.effort)
        return (
            {
                self.a.flow: heat / (self.a.effort + self.ambient_temperature),
                self.b.flow: -heat / (self.b.effort + self.ambient_temperature),
            },
        )


class UnitLever(Transformer):
    a = Port(Translation)
    b = Port(Translation)

    def modulus(self) -> float:
        return 1.0


class Drag(Resistance):
    """Friction against the ground that grows with speed."""

    flange = Port(Translation)
    damping: Parameter = parameter("N.s/m")

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class VoiceCoil(Gyrator):
    """Force on a conductor: F = constant i."""

    a = Port(Electrical)
    b = Port(Translation)
    constant: Parameter = parameter("V.s/m")

    def modulus(self) -> Expr:
        return self.constant


class SineVoltage(EffortSource):
    a = Port(Electrical)
    b = Port(Electrical)
    port = Port(Electrical, between=(a, b))
    voltage: Parameter = parameter("V")
    frequency: Parameter = parameter("Hz")

    def effort(self) -> Expr:
        return self.voltage * sin(2.0 * math.pi * self.frequency * time)
