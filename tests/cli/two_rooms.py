"""A model in two parts, to be named on the command line."""

from propermodel import Component, Path, Scenario, connect
from propermodel.library.mechanics.translation import Fixed, Mass, Spring


class Oscillator(Component):
    mass = Mass(mass=1.0)
    spring = Spring(stiffness=1.0)
    wall = Fixed()

    connections = (connect(mass.flange, spring.b), connect(spring.a, wall.flange))


class TwoRooms(Component):
    left = Oscillator()
    right = Oscillator()


scenario = Scenario(initial={Path(("left", "mass", "momentum")): 1.0, Path(("right", "mass", "momentum")): 0.5})
