"""A plate on a spring is pulled towards another one by its charge.

The plates are a compliance with two ports, a C-field: its energy q^2 (d - x) / (2 epsilon A) depends on charge and
approach, and voltage and force are its two derivatives. Written as an energy the law cannot violate reciprocity.
Above a third of the gap no equilibrium is left: the voltage for that, 2.59 V here, is the pull-in voltage.
"""

import propermodel as pm
from propermodel.library.electrical import Ground, Resistor, VoltageSource
from propermodel.library.mechanics.translation import Fixed, Mass, SpringDamper


class Plates(pm.MultiportCompliance):
    """Two parallel plates that may approach each other."""

    pin_a = pm.Port(pm.Electrical)
    pin_b = pm.Port(pm.Electrical)
    voltage = pm.Port(pm.Electrical, between=(pin_a, pin_b))
    plate_a = pm.Port(pm.Translation)
    plate_b = pm.Port(pm.Translation)
    force = pm.Port(pm.Translation, between=(plate_a, plate_b))
    area: pm.Parameter = pm.parameter("m2", low=0.0)
    gap: pm.Parameter = pm.parameter("m", low=0.0)
    permittivity: pm.Parameter = pm.parameter("F/m", default=8.8541878128e-12, source="CODATA 2018")
    charge = pm.State("C")
    approach = pm.State("m")

    def displacements(self) -> dict[pm.Expr, pm.Expr]:
        """The coordinates are charge and approach."""
        return {self.voltage.displacement: self.charge, self.force.displacement: self.approach}

    def energy(self) -> pm.Expr:
        """The energy of the field between the plates."""
        return self.charge * self.charge * (self.gap - self.approach) / (2.0 * self.permittivity * self.area)


class ElectrostaticSwitch(pm.Component):
    """A moving plate on a spring above a fixed one, charged through a resistor."""

    voltage = pm.Input("V")

    supply = VoltageSource()
    feed = Resistor(resistance=5e7)
    plates = Plates(area=4e-8, gap=2e-6)
    moving = Mass(mass=1e-9)
    suspension = SpringDamper(stiffness=1.0, damping=3e-5)
    frame = Fixed()
    ground = Ground()

    connections = (
        pm.connect(voltage, supply.voltage),
        pm.connect(supply.pin, feed.a),
        pm.connect(feed.b, plates.pin_a),
        pm.connect(plates.pin_b, ground.pin),
        pm.connect(plates.plate_a, moving.flange, suspension.a),
        pm.connect(plates.plate_b, suspension.b, frame.flange),
    )


OUTPUTS = ("plates.approach", "plates.voltage.effort")


def scenario() -> pm.Scenario:
    """Two volts, below the pull-in voltage."""
    return pm.Scenario(name="below pull-in", stop=2e-3, inputs={"voltage": 2.0})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=5e-7, record_every=1e-5)


if __name__ == "__main__":
    answer = run(pm.elaborate(ElectrostaticSwitch()))
    print(f"the plate settles {1e6 * answer['plates.approach'][-1]:.3f} um closer")
    print(pm.energy_balance(answer))
    print(pm.rank_activity(answer))
