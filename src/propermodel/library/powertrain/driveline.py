"""Transfer case and inter-axle case of a 6x6 truck, ideal in speed and lossy in torque."""

from __future__ import annotations

from propermodel.library.mechanics.rotation import Differential, LossyGear
from propermodel.modelling import Component, Parameter, Port, Rotation, connect, parameter


class Driveline(Component):
    """Half of the torque to the front axle, a quarter to each rear axle; at every split the mean of the speeds."""

    drive = Port(Rotation)
    front = Port(Rotation)
    rear_front = Port(Rotation)
    rear_rear = Port(Rotation)
    transfer_ratio: Parameter = parameter(
        "1", default=1.0, low=0.0, source="single-speed transfer case, its drop is in the gears", status="published"
    )
    inter_axle_ratio: Parameter = parameter("1", default=1.0, low=0.0, status="published")
    transfer_efficiency: Parameter = parameter("1", default=0.98, low=0.0, high=1.0, status="estimated")
    inter_axle_efficiency: Parameter = parameter("1", default=0.985, low=0.0, high=1.0, status="estimated")
    front_share: Parameter = parameter(
        "1", default=0.5, low=0.0, high=1.0, source="Louca and Yildir 2006", status="published"
    )

    transfer_case = LossyGear(ratio=transfer_ratio, efficiency=transfer_efficiency)
    transfer_split = Differential(share=front_share)
    inter_axle_case = LossyGear(ratio=inter_axle_ratio, efficiency=inter_axle_efficiency)
    inter_axle_split = Differential()

    connections = (
        connect(drive, transfer_case.a),
        connect(transfer_case.b, transfer_split.drive),
        connect(transfer_split.left, front),
        connect(transfer_split.right, inter_axle_case.a),
        connect(inter_axle_case.b, inter_axle_split.drive),
        connect(inter_axle_split.left, rear_front),
        connect(inter_axle_split.right, rear_rear),
    )
