"""What feeds a hydraulic node from outside."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike
from propermodel.modelling import EffortSource, FlowSource, Hydraulic, Input, Parameter, Port, parameter


class OpenTank(EffortSource):
    """A tank at ambient pressure."""

    port = Port(Hydraulic)

    def effort(self) -> ExprLike:
        return 0.0


class PressureSource(EffortSource):
    """A prescribed gauge pressure."""

    port = Port(Hydraulic)
    pressure = Input("Pa")

    def effort(self) -> Expr:
        return self.pressure


class VolumeFlowSource(FlowSource):
    """A prescribed volume flow into whatever is connected."""

    port = Port(Hydraulic)
    volume_flow = Input("m3/s")

    def flow(self) -> Expr:
        return -self.volume_flow


class ConstantPressure(EffortSource):
    """A gauge pressure that is always the same."""

    port = Port(Hydraulic)
    pressure: Parameter = parameter("Pa")

    def effort(self) -> Expr:
        return self.pressure


class ConstantVolumeFlow(FlowSource):
    """A volume flow into whatever is connected that is always the same."""

    port = Port(Hydraulic)
    volume_flow: Parameter = parameter("m3/s")

    def flow(self) -> Expr:
        return -self.volume_flow
