"""A weight on a spring that clicks through: three equilibria, of which one is unstable.

A bent leaf pushes away from its middle (a negative stiffness) until its ends hold it back (a positive cubic one). Under
a small weight there are still three places where forces balance. Which of them a run finds depends on where it starts;
`find_equilibrium` finds each of them, says what small deviations do there, and a run may begin at one:
`simulate(..., start="equilibrium")`.
"""

import propermodel as pm
from propermodel.library.mechanics.translation import Damper, Fixed, HardeningSpring, Mass, Weight


class ClickingSpring(pm.Component):
    """A mass of 50 g on a leaf that clicks 5 mm to either side."""

    mass = Mass(mass=0.05)
    weight = Weight(mass=0.05)
    leaf = HardeningSpring(stiffness=-1.0e3, cubic_stiffness=4.0e7)
    damper = Damper(damping=3.0)
    frame = Fixed()

    connections = (
        pm.connect(mass.flange, weight.flange, leaf.b, damper.b),
        pm.connect(frame.flange, leaf.a, damper.a),
    )


OUTPUTS = ("leaf.port.displacement", "mass.flange.flow")
LET_GO = -6.0e-4
STARTS = (-5.0e-3, 0.0, 5.0e-3)


def scenario(start: float = LET_GO) -> pm.Scenario:
    """Let go from a compression of the leaf, at rest."""
    return pm.Scenario(name="let go", stop=0.3, initial={"leaf.displacement": start})


def run(model: pm.Model) -> pm.Trajectory:
    """Simulate the scenario."""
    return pm.simulate(pm.compile_model(model), scenario(), method=pm.Method.RK4, step=1e-4, record_every=5e-4)


if __name__ == "__main__":
    answer = run(pm.elaborate(ClickingSpring()))
    for start in STARTS:
        rest = pm.find_equilibrium(answer.compiled, scenario(start))
        print(f"{rest.stability} equilibrium at {1e3 * rest['leaf.displacement']:.4f} mm")
        print(pm.linearise(answer.compiled, rest).modes())
    print(f"let go at {1e3 * LET_GO:.1f} mm,", end=" ")
    print(f"it comes to rest at {1e3 * answer.at_end('leaf.port.displacement'):.4f} mm")
    print(pm.energy_balance(answer))
