"""What a user writes: a quarter car on a wavy road, with its scenario; run by file name."""

import math

import propermodel as pm


class Spring(pm.Compliance):
    """A linear spring."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation)
    port = pm.Port(pm.Translation, between=(a, b))
    stiffness: pm.Parameter = pm.parameter("N/m", low=0.0)

    def effort(self, displacement: pm.Expr) -> pm.Expr:
        return self.stiffness * displacement


class Damper(pm.Resistance):
    """A linear damper."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation)
    port = pm.Port(pm.Translation, between=(a, b))
    damping: pm.Parameter = pm.parameter("N.s/m", low=0.0)

    def effort(self, flow: pm.Expr) -> pm.Expr:
        return self.damping * flow


class Mass(pm.Inertia):
    """A mass."""

    flange = pm.Port(pm.Translation)
    mass: pm.Parameter = pm.parameter("kg", low=0.0)

    def momentum(self, flow: pm.Expr) -> pm.Expr:
        return self.mass * flow


class SpringDamper(pm.Component):
    """A spring and a damper in parallel."""

    a = pm.Port(pm.Translation)
    b = pm.Port(pm.Translation)
    stiffness: pm.Parameter = pm.parameter("N/m")
    damping: pm.Parameter = pm.parameter("N.s/m")

    spring = Spring(stiffness=stiffness)
    damper = Damper(damping=damping)

    connections = (
        pm.connect(a, spring.a, damper.a),
        pm.connect(b, spring.b, damper.b),
    )


class QuarterCar(pm.Component):
    """Body on a suspension on a wheel on a tyre; the road moves the tyre."""

    road = pm.Port(pm.Translation)
    body_mass: pm.Parameter = pm.parameter("kg", default=1200.0, low=100.0, source="a weighbridge", status="estimated")

    body = Mass(mass=body_mass)
    wheel = Mass(mass=80.0)
    suspension = SpringDamper(stiffness=2.0e4, damping=1.5e3)
    tyre = SpringDamper(stiffness=2.4e5, damping=1.5e2)

    connections = (
        pm.connect(road, tyre.a),
        pm.connect(tyre.b, wheel.flange, suspension.a),
        pm.connect(suspension.b, body.flange),
        pm.prescribed_flow(road),
    )


class Unfinished(pm.Component):
    """Two ports are left unconnected."""

    body = Mass(mass=1.0)
    spring = Spring(stiffness=1.0)

    connections = (pm.connect(body.flange, spring.a),)


def waves(stop: float = 10.0) -> pm.Scenario:
    """One wave a second."""
    times = [0.01 * k for k in range(round(stop / 0.01) + 1)]
    speeds = [0.2 * math.sin(2.0 * math.pi * time) for time in times]
    return pm.Scenario(name="waves", stop=stop, inputs={pm.Path(("road", "flow")): pm.table_values([times], speeds)})


def bouncing() -> pm.Scenario:
    """The wheel is given a push, which the reduced model cannot feel."""
    return pm.Scenario(name="bouncing", stop=4.0, initial={pm.Path(("wheel", "momentum")): 8.0})


scenario = waves
