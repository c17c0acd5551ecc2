"""A seven-speed automatic transmission: ratio and efficiency move continuously while it shifts."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, clip, time
from propermodel.library.mechanics.rotation import (
    ModulatedGear,
    RotatingInertia,
    TorqueDrivenLoss,
    ViscousFriction,
)
from propermodel.modelling import (
    Component,
    Input,
    Output,
    Parameter,
    Port,
    Rotation,
    SignalBlock,
    Transformer,
    connect,
    parameter,
    table,
)

GEARS = (1, 2, 3, 4, 5, 6, 7)
RATIOS = (6.93, 4.18, 2.24, 1.69, 1.20, 0.90, 0.78)
EFFICIENCIES = (0.95, 0.96, 0.97, 0.97, 0.975, 0.975, 0.97)


class RatioShift(SignalBlock):
    """Ratio and torque efficiency, from those of one gear to those of the next as 3 y^2 - 2 y^3 over the shift time."""

    from_gear = Input("1")
    to_gear = Input("1")
    shift_start = Input("s")
    ratio = Output("1")
    efficiency = Output("1")
    shift_time: Parameter = parameter("s", default=0.6, low=0.0, status="estimated")
    ratios = table(
        "1", ("1",), [GEARS], RATIOS, source="Allison MD 3070PT / 3700 SP, transfer case drop included; published*"
    )
    efficiencies = table("1", ("1",), [GEARS], EFFICIENCIES, source="estimated")

    def outputs(self) -> dict[Expr, ExprLike]:
        y = clip((time - self.shift_start) / self.shift_time, 0.0, 1.0)
        share = y * y * (3.0 - 2.0 * y)
        before, after = self.ratios(self.from_gear), self.ratios(self.to_gear)
        kept_before, kept_after = self.efficiencies(self.from_gear), self.efficiencies(self.to_gear)
        return {
            self.ratio: before + (after - before) * share,
            self.efficiency: kept_before + (kept_after - kept_before) * share,
        }


class StepUp(Transformer):
    """From the output shaft to the turbine shaft: omega_b = ratio * omega_a."""

    a = Port(Rotation)
    b = Port(Rotation)
    ratio = Input("1")

    def modulus(self) -> Expr:
        return self.ratio


class DrivetrainInertia(Component):
    """What turns with the output shaft, and the turbine on the lossless side of the gears: one energy element."""

    energy_group = True

    shaft = Port(Rotation)
    ratio = Input("1")
    output_inertia: Parameter = parameter(
        "kg.m2",
        default=1.02,
        low=0.0,
        source="gear set 0.50 (Chrono), shaft 0.02, cases 0.30, differentials 0.12, prop shafts 0.08",
        status="derived",
    )
    turbine_inertia: Parameter = parameter(
        "kg.m2", default=0.10, low=0.0, source="NREL ADVISOR, smaller unit; with half the oil", status="estimated"
    )

    output_side = RotatingInertia(inertia=output_inertia)
    step_up = StepUp()
    turbine = RotatingInertia(inertia=turbine_inertia)

    connections = (
        connect(shaft, output_side.shaft, step_up.a),
        connect(step_up.b, turbine.shaft),
        connect(ratio, step_up.ratio),
    )


class Transmission(Component):
    """Gears that are ideal in speed and lossy in torque, churning on the turbine side, and the drivetrain inertia."""

    turbine = Port(Rotation)
    output = Port(Rotation)
    from_gear = Input("1")
    to_gear = Input("1")
    shift_start = Input("s")
    ratio = Output("1")
    efficiency = Output("1")
    churning_damping: Parameter = parameter(
        "N.m.s/rad", default=0.05, low=0.0, source="6 kW with the charging pump at 2200 rpm", status="estimated"
    )

    shift = RatioShift()
    churning = ViscousFriction(damping=churning_damping)
    gear = ModulatedGear()
    loss = TorqueDrivenLoss()
    inertia = DrivetrainInertia()

    connections = (
        connect(turbine, churning.shaft, gear.a),
        connect(gear.b, loss.shaft, inertia.shaft, output),
        connect(from_gear, shift.from_gear),
        connect(to_gear, shift.to_gear),
        connect(shift_start, shift.shift_start),
        connect(shift.ratio, gear.ratio, inertia.ratio, ratio),
        connect(shift.efficiency, loss.efficiency, efficiency),
        connect(gear.b.effort, loss.torque),
    )
