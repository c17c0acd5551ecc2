"""Masses, springs, dampers and levers that move in a straight line."""

from __future__ import annotations

from propermodel.expressions import Expr, ExprLike, log, maximum, tanh, where
from propermodel.modelling import (
    Compliance,
    Component,
    Inertia,
    Input,
    MultiportCompliance,
    Parameter,
    Port,
    Resistance,
    Rotation,
    State,
    Thermal,
    Transformer,
    Translation,
    ZeroJunction,
    bond,
    connect,
    parameter,
)


class Mass(Inertia):
    """A rigid mass."""

    flange = Port(Translation)
    mass: Parameter = parameter("kg", low=0.0)
    start_velocity: Parameter = parameter("m/s", default=0.0)

    def momentum(self, flow: Expr) -> Expr:
        return self.mass * flow

    def start(self) -> Expr:
        """The momentum at the start."""
        return self.mass * self.start_velocity


class Spring(Compliance):
    """A linear spring between two flanges."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m", low=0.0)
    start_compression: Parameter = parameter("m", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement

    def start(self) -> Expr:
        """The compression at the start."""
        return self.start_compression


class HardeningSpring(Compliance):
    """A spring that grows stiffer, F = k x + k_3 x^3 (Duffing)."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m")
    cubic_stiffness: Parameter = parameter("N/m3", low=0.0)
    start_compression: Parameter = parameter("m", default=0.0)

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * displacement + self.cubic_stiffness * displacement**3.0

    def energy(self, displacement: Expr) -> Expr:
        """The integral of force over compression."""
        square = displacement * displacement
        return 0.5 * self.stiffness * square + 0.25 * self.cubic_stiffness * square * square

    def start(self) -> Expr:
        """The compression at the start."""
        return self.start_compression


class ElasticStop(Compliance):
    """A spring that touches only after a gap has closed."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    stiffness: Parameter = parameter("N/m", low=0.0)
    gap: Parameter = parameter("m", default=0.0, doc="at the start")

    def effort(self, displacement: Expr) -> Expr:
        return self.stiffness * maximum(displacement - self.gap, 0.0)

    def energy(self, displacement: Expr) -> Expr:
        """Nothing before it touches."""
        pressed = maximum(displacement - self.gap, 0.0)
        return 0.5 * self.stiffness * pressed * pressed


class Damper(Resistance):
    """A linear damper between two flanges."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.damping * flow


class DegressiveDamper(Resistance):
    """A shock absorber whose force grows ever less with speed, F = c v / (1 + d |v|), d for either direction."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    damping: Parameter = parameter("N.s/m", low=0.0, doc="slope at zero speed")
    degressivity_compression: Parameter = parameter("s/m", low=0.0)
    degressivity_rebound: Parameter = parameter("s/m", low=0.0)

    def effort(self, flow: Expr) -> Expr:
        degressivity = where(flow > 0.0, self.degressivity_compression, self.degressivity_rebound)
        return self.damping * flow / (1.0 + degressivity * abs(flow))


class SpringDamper(Component):
    """A linear spring and damper in parallel between two flanges."""

    a = Port(Translation)
    b = Port(Translation)
    stiffness: Parameter = parameter("N/m", low=0.0)
    damping: Parameter = parameter("N.s/m", low=0.0)

    spring = Spring(stiffness=stiffness)
    damper = Damper(damping=damping)

    connections = (
        connect(a, spring.a, damper.a),
        connect(b, spring.b, damper.b),
    )


class Friction(Resistance):
    """Dry friction between two flanges, smoothed over a width of velocity: F = F_c tanh(v / v_width)."""

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    force: Parameter = parameter("N", low=0.0)
    width: Parameter = parameter("m/s", default=0.01, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return self.force * tanh(flow / self.width)


class QuadraticDrag(Resistance):
    """Aerodynamic drag, F = rho C_d A v |v| / 2."""

    flange = Port(Translation)
    drag_area: Parameter = parameter("m2", low=0.0, doc="drag coefficient times frontal area")
    air_density: Parameter = parameter("kg/m3", default=1.2, low=0.0)

    def effort(self, flow: Expr) -> Expr:
        return 0.5 * self.air_density * self.drag_area * flow * abs(flow)


class GasSpring(MultiportCompliance):
    """Ideal gas under a piston between two flanges: a field that stores work at its flanges and heat at its wall.

    Force counts from the pressure that carries the static load, temperature from ambient, so the stored energy is what
    the gas could still do against both. With V = V_0 - A x, p = m R T / V:

        dE = (p - p_0) A dx + (T - T_a) dS,   E = m u(T) + p_0 V - T_a S + constant
    """

    a = Port(Translation)
    b = Port(Translation)
    port = Port(Translation, between=(a, b))
    wall = Port(Thermal)
    gas_volume: Parameter = parameter("m3", low=0.0, doc="at rest")
    piston_area: Parameter = parameter("m2", low=0.0)
    static_pressure: Parameter = parameter("Pa", low=0.0, doc="absolute, at rest")
    ambient_temperature: Parameter = parameter("K", default=300.0, low=0.0)
    heat_capacity_ratio: Parameter = parameter("1", default=1.4, low=1.0, source="diatomic gas", status="published")
    compression = State("m")
    temperature = State("K", start=ambient_temperature)

    def gas_constant(self) -> Expr:
        """Mass times gas constant, J/K, from the state at rest."""
        return self.static_pressure * self.gas_volume / self.ambient_temperature

    def volume(self) -> Expr:
        """The present gas volume."""
        return self.gas_volume - self.piston_area * self.compression

    def entropy(self) -> Expr:
        """Entropy above the state at rest."""
        gas = self.gas_constant()
        heat = gas / (self.heat_capacity_ratio - 1.0) * log(self.temperature / self.ambient_temperature)
        return heat + gas * log(self.volume() / self.gas_volume)

    def displacements(self) -> dict[Expr, ExprLike]:
        """Compression, and entropy."""
        return {self.port.displacement: self.compression, self.wall.displacement: self.entropy()}

    def efforts(self) -> dict[Expr, ExprLike]:
        """Force above the static one, and temperature above ambient."""
        pressure = self.gas_constant() * self.temperature / self.volume()
        return {
            self.port.effort: (pressure - self.static_pressure) * self.piston_area,
            self.wall.effort: self.temperature - self.ambient_temperature,
        }

    def energy(self) -> Expr:
        """What the gas could still do against static pressure and ambient temperature."""
        heat_capacity = self.gas_constant() / (self.heat_capacity_ratio - 1.0)
        inner = heat_capacity * (self.temperature - self.ambient_temperature)
        displaced = self.static_pressure * (self.volume() - self.gas_volume)
        return inner + displaced - self.ambient_temperature * self.entropy()


class LeverArm(Transformer):
    """Rotation into translation across an arm, which may change: v = arm * omega."""

    a = Port(Rotation)
    b = Port(Translation)
    arm = Input("m")

    def modulus(self) -> Expr:
        return self.arm


class Lever(Component):
    """A point of a rotating body: it has the velocity of the base plus arm times angular velocity."""

    base = Port(Translation)
    rotation = Port(Rotation)
    point = Port(Translation)
    arm = Input("m")

    lever_arm = LeverArm()
    total = ZeroJunction()

    connections = (
        connect(rotation, lever_arm.a),
        bond(base, total),
        bond(lever_arm.b, total),
        bond(total, point),
        connect(arm, lever_arm.arm),
    )


class Share(Transformer):
    """A share of a velocity, v_b = share * v_a; the share may change and may be zero."""

    a = Port(Translation)
    b = Port(Translation)
    share = Input("1")

    def modulus(self) -> Expr:
        return self.share


class Projection(Component):
    """The velocity along a direction, from two perpendicular ones: v = first_share v_1 + second_share v_2."""

    first = Port(Translation)
    second = Port(Translation)
    along = Port(Translation)
    first_share = Input("1")
    second_share = Input("1")

    of_first = Share()
    of_second = Share()
    total = ZeroJunction()

    connections = (
        connect(first, of_first.a),
        connect(second, of_second.a),
        bond(of_first.b, total),
        bond(of_second.b, total),
        bond(total, along),
        connect(first_share, of_first.share),
        connect(second_share, of_second.share),
    )
