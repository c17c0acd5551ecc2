"""Fields in every causality: integral, mixed and derivative, against closed forms and SciPy on equations by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from propermodel.analysis.balance import energy_balance
from propermodel.compiler import Backend
from propermodel.diagnostics import SimulationError
from propermodel.expressions import Expr, ExprLike, exp, log, sin, time
from propermodel.library.electrical import CoupledInductors, Ground, Resistor
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    EffortSource,
    Electrical,
    FlowSource,
    Hydraulic,
    MultiportCompliance,
    MultiportInertia,
    Parameter,
    Port,
    State,
    Thermal,
    Translation,
    connect,
    elaborate,
    parameter,
)
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import Coordinate, Storage
from tests.physics.systems import close, compiled, run, system

BACKENDS = list(Backend)


class Voltage(EffortSource):
    pin = Port(Electrical)
    mean: Parameter = parameter("V")
    swing: Parameter = parameter("V", default=0.0)
    pulsation: Parameter = parameter("rad/s", default=1.0)

    def effort(self) -> Expr:
        return self.mean + self.swing * sin(self.pulsation * time)


class Current(FlowSource):
    """Gives a current to the pin."""

    pin = Port(Electrical)
    swing: Parameter = parameter("A")
    pulsation: Parameter = parameter("rad/s")

    def flow(self) -> Expr:
        return -self.swing * sin(self.pulsation * time)


class Plates(MultiportCompliance):
    """Two plates, one fixed and grounded: energy q^2 (d - x) / (2 epsilon A), its second part their stiffness."""

    pin = Port(Electrical)
    plate = Port(Translation)
    constant: Parameter = parameter("F.m", doc="permittivity times area")
    gap: Parameter = parameter("m")
    charge = State("C")
    approach = State("m")

    def displacements(self) -> dict[Expr, ExprLike]:
        return {self.pin.displacement: self.charge, self.plate.displacement: self.approach}

    def energy(self) -> Expr:
        return self.charge * self.charge * (self.gap - self.approach) / (2.0 * self.constant)

    def limits(self) -> dict[Expr, tuple[ExprLike, ExprLike]]:
        return {self.approach: (-1.0 * self.gap, self.gap)}


def switch(voltage: Voltage) -> Component:
    """Plates that a source feeds directly: the voltage is given, the charge follows."""
    plates, mass, spring = Plates(constant=2.0, gap=1.5), Mass(mass=0.5), Spring(stiffness=30.0)
    damper, wall = Damper(damping=0.8), Fixed()
    return system(
        connect(voltage.pin, plates.pin),
        connect(plates.plate, mass.flange, spring.a, damper.a),
        connect(spring.b, damper.b, wall.flange),
        voltage=voltage,
        plates=plates,
        mass=mass,
        spring=spring,
        damper=damper,
        wall=wall,
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_plates_driven_by_a_voltage_follow_their_charge(backend: Backend):
    model = switch(Voltage(mean=1.0, swing=0.5, pulsation=4.0))
    made = compiled(model, backend)
    assert [str(path) for path in made.system.causal.derivative] == ["plates"]
    assert sorted(str(s.path) for s in made.system.states) == [
        "mass.momentum",
        "plates.approach",
        "spring.displacement",
    ]
    r = run(made, 2.0, step=1e-3)

    def by_hand(t: float, y: np.ndarray) -> list[float]:
        x, v = y
        u = 1.0 + 0.5 * math.sin(4.0 * t)
        return [v, (u * u * 2.0 / (2.0 * (1.5 - x) ** 2) - 30.0 * x - 0.8 * v) / 0.5]

    hand = solve_ivp(by_hand, (0.0, 2.0), [0.0, 0.0], t_eval=r.time, rtol=1e-11, atol=1e-13)
    x, v = hand.y
    u, rate = 1.0 + 0.5 * np.sin(4.0 * r.time), 2.0 * np.cos(4.0 * r.time)
    close(r["plates.approach"], x, 1e-7)
    close(r["plates.charge"], u * 2.0 / (1.5 - x), 1e-7)
    close(r["plates.pin.flow"], rate * 2.0 / (1.5 - x) + u * 2.0 * v / (1.5 - x) ** 2, 1e-6)


def test_the_energy_of_plates_driven_by_a_voltage_balances():
    r = run(switch(Voltage(mean=1.0, swing=0.5, pulsation=4.0)), 2.0, step=1e-4, initial={"plates.charge": 4.0 / 3.0})
    balance = energy_balance(r)
    assert abs(balance.wiring_residual) < 1e-12
    assert balance.relative_residual < 1e-6


def test_the_range_of_a_coordinate_ends_a_run_that_leaves_it():
    plates, mass, wall = Plates(constant=2.0, gap=1.5), Mass(mass=0.5, start_velocity=3.0), Voltage(mean=0.0)
    model = system(
        connect(wall.pin, plates.pin), connect(plates.plate, mass.flange), wall=wall, plates=plates, mass=mass
    )
    made = compiled(model)
    (approach,) = (s for s in made.system.states if s.path.name == "approach")
    with pytest.raises(AssertionError, match=r"plates.approach = .* has left the range"):
        run(made, 2.0)
    assert approach.kind.value == "displacement"


def test_limits_of_a_field_are_in_its_document():
    model = elaborate(switch(Voltage(mean=1.0)))
    again = from_document(to_document(model))
    assert again == model
    behaviour = next(p for p in again.root.definition.parts if p.name == "plates").definition.behaviour
    assert isinstance(behaviour, Storage)
    assert all(isinstance(c, Coordinate) for c in behaviour.coordinates)
    assert behaviour.coordinates[1].high != behaviour.coordinates[0].high


# -- coupled coils ------------------------------------------------------------------------------------------

L1, L2, M = 20e-3, 5e-3, 8e-3


class Coils(MultiportInertia):
    """The same coils with their currents as coordinates, so that inductances need no inverse."""

    first = Port(Electrical)
    second = Port(Electrical)
    own_first: Parameter = parameter("H")
    own_second: Parameter = parameter("H")
    mutual: Parameter = parameter("H")
    current_first = State("A")
    current_second = State("A")

    def momenta(self) -> dict[Expr, ExprLike]:
        return {
            self.first.momentum: self.own_first * self.current_first + self.mutual * self.current_second,
            self.second.momentum: self.mutual * self.current_first + self.own_second * self.current_second,
        }

    def flows(self) -> dict[Expr, ExprLike]:
        return {self.first.flow: self.current_first, self.second.flow: self.current_second}

    def energy(self) -> Expr:
        i, j = self.current_first, self.current_second
        return 0.5 * (self.own_first * i * i + 2.0 * self.mutual * i * j + self.own_second * j * j)


def grounded(coils: CoupledInductors, first: Component, second: Component) -> Component:
    """A part at each coil, whose other ends are on ground."""
    ground = Ground()
    loads = {"first": first, "second": second}
    on_ground = [part.b for part in loads.values() if isinstance(part, Resistor)]
    return system(
        connect(first.a if isinstance(first, Resistor) else first.pin, coils.primary_a),  # pyright: ignore[reportAttributeAccessIssue]
        connect(second.a if isinstance(second, Resistor) else second.pin, coils.secondary_a),  # pyright: ignore[reportAttributeAccessIssue]
        connect(ground.pin, coils.primary_b, coils.secondary_b, *on_ground),
        coils=coils,
        ground=ground,
        **loads,
    )


def coupled(mutual: float = M) -> CoupledInductors:
    return CoupledInductors(primary_inductance=L1, secondary_inductance=L2, mutual_inductance=mutual)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_coil_that_a_current_drives_induces_in_the_other(backend: Backend):
    # i_1 = I sin(w t) is given; L2 di_2/dt + R i_2 = -M di_1/dt.
    r = run(
        grounded(coupled(), Current(swing=2.0, pulsation=300.0), Resistor(resistance=5.0)),
        0.02,
        backend=backend,
        step=1e-5,
    )

    def by_hand(t: float, y: np.ndarray) -> list[float]:
        return [(-M * 600.0 * math.cos(300.0 * t) - 5.0 * y[0]) / L2]

    hand = solve_ivp(by_hand, (0.0, 0.02), [0.0], t_eval=r.time, rtol=1e-11, atol=1e-13, max_step=1e-4)
    i, rate = hand.y[0], np.array([by_hand(t, y)[0] for t, y in zip(r.time, hand.y.T, strict=True)])
    close(r["coils.secondary.flow"], i, 1e-7)
    close(r["coils.primary.effort"], L1 * 600.0 * np.cos(300.0 * r.time) + M * rate, 1e-6)
    assert energy_balance(r).relative_residual < 1e-6


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
@pytest.mark.parametrize("backend", BACKENDS)
def test_coils_that_currents_drive_on_both_sides_have_the_voltages_of_their_inductances(backend: Backend):
    r = run(
        grounded(coupled(), Current(swing=2.0, pulsation=300.0), Current(swing=1.0, pulsation=500.0)),
        0.02,
        backend=backend,
        step=1e-5,
    )
    first, second = 600.0 * np.cos(300.0 * r.time), 500.0 * np.cos(500.0 * r.time)
    close(r["coils.primary.effort"], L1 * first + M * second, 1e-9)
    close(r["coils.secondary.effort"], M * first + L2 * second, 1e-9)
    # Half of L i^2 at the end is what the sources have done.
    i, j = 2.0 * math.sin(6.0), math.sin(10.0)
    balance = energy_balance(r)
    assert balance.stored == pytest.approx(0.5 * L1 * i * i + M * i * j + 0.5 * L2 * j * j, rel=1e-9)
    assert balance.relative_residual < 1e-6


def in_currents(mutual: float = M) -> Component:
    coils = Coils(own_first=L1, own_second=L2, mutual=mutual)
    drive, load, ground = Current(swing=2.0, pulsation=300.0), Resistor(resistance=5.0), Ground()
    return system(
        connect(drive.pin, coils.first),
        connect(load.a, coils.second),
        connect(load.b, ground.pin),
        coils=coils,
        drive=drive,
        load=load,
        ground=ground,
    )


@pytest.mark.filterwarnings("ignore:warning.equations/impulsive:propermodel.ModelWarning")
@pytest.mark.parametrize("backend", BACKENDS)
def test_coordinates_that_are_not_stored_move_with_those_that_are_decided(backend: Backend):
    one = run(in_currents(), 0.02, backend=backend, step=2e-5)
    other = run(grounded(coupled(), Current(swing=2.0, pulsation=300.0), Resistor(resistance=5.0)), 0.02, step=2e-5)
    close(one["coils.second.flow"], other["coils.secondary.flow"], 1e-7)
    close(one["coils.first.effort"], other["coils.primary.effort"], 1e-6)
    assert energy_balance(one).relative_residual < 1e-6


def test_coils_that_share_all_their_flux_are_refused_by_name():
    model = grounded(coupled(math.sqrt(L1 * L2)), Voltage(mean=1.0), Resistor(resistance=5.0))
    with pytest.raises(SimulationError) as caught:
        run(model, 0.1)
    (fault,) = caught.value.diagnostics
    assert fault.code == "simulation/singular-field"
    assert fault.message == (
        "the field coils does not determine what its ports primary and secondary do: its law is singular with "
        "mutual_inductance = 0.01 H, primary_inductance = 0.02 H, secondary_inductance = 0.005 H"
    )
    assert "transformer" in fault.help
    assert fault.source.file == "tests/physics/test_fields.py"


def test_coils_that_share_all_their_flux_are_refused_in_currents_as_well():
    coils = Coils(own_first=L1, own_second=L2, mutual=math.sqrt(L1 * L2))
    one, two, ground = Voltage(mean=1.0), Resistor(resistance=1.0), Ground()
    model = system(
        connect(one.pin, coils.first),
        connect(two.a, coils.second),
        connect(two.b, ground.pin),
        coils=coils,
        one=one,
        two=two,
        ground=ground,
    )
    with pytest.raises(SimulationError, match="singular-field"):
        run(model, 0.1)


def test_strong_coupling_short_of_one_runs():
    model = grounded(coupled(0.9999 * math.sqrt(L1 * L2)), Voltage(mean=1.0), Resistor(resistance=5.0))
    assert run(model, 1e-4, step=1e-7)["coils.secondary.flow"][-1] != 0.0


# -- a nonlinear field in the coordinates of its author -----------------------------------------------------


class Gas(MultiportCompliance):
    """An ideal gas above ambient, in volume and temperature; its pressure acts on oil, its entropy on a wall."""

    oil = Port(Hydraulic)
    heat = Port(Thermal)
    amount: Parameter = parameter("J/K", doc="amount times gas constant")
    heat_capacity: Parameter = parameter("J/K", doc="at constant volume")
    ambient: Parameter = parameter("K", default=300.0)
    ambient_pressure: Parameter = parameter("Pa", default=1e5)
    start_volume: Parameter = parameter("m3", default=1e-2)
    volume = State("m3", start=start_volume)
    temperature = State("K", start=ambient)

    def displacements(self) -> dict[Expr, ExprLike]:
        entropy = self.heat_capacity * log(self.temperature / self.ambient) + self.amount * log(
            self.volume / self.start_volume
        )
        return {self.oil.displacement: self.start_volume - self.volume, self.heat.displacement: entropy}

    def efforts(self) -> dict[Expr, ExprLike]:
        pressure = self.amount * self.temperature / self.volume - self.ambient_pressure
        return {self.oil.effort: pressure, self.heat.effort: self.temperature - self.ambient}

    def energy(self) -> Expr:
        """Internal energy less what ambient pressure and temperature give, from the start."""
        entropy = self.heat_capacity * log(self.temperature / self.ambient) + self.amount * log(
            self.volume / self.start_volume
        )
        pushed = self.ambient_pressure * (self.volume - self.start_volume)
        return self.heat_capacity * (self.temperature - self.ambient) - self.ambient * entropy + pushed


class Pressure(EffortSource):
    port = Port(Hydraulic)
    rise: Parameter = parameter("Pa")
    rate: Parameter = parameter("1/s", default=5.0)

    def effort(self) -> Expr:
        return self.rise * (1.0 - exp(-self.rate * time))


class NoHeat(FlowSource):
    port = Port(Thermal)

    def flow(self) -> ExprLike:
        return 0.0


@pytest.mark.parametrize("backend", BACKENDS)
def test_gas_under_a_given_pressure_follows_the_adiabatic_law(backend: Backend):
    # p V^gamma is constant; with p V = amount T and the start in ambient.
    amount, capacity = 1e5 * 1e-2 / 300.0, 2.5 * 1e5 * 1e-2 / 300.0
    gas, press, wall = Gas(amount=amount, heat_capacity=capacity), Pressure(rise=2e5), NoHeat()
    model = system(connect(press.port, gas.oil), connect(wall.port, gas.heat), gas=gas, press=press, wall=wall)
    r = run(model, 1.0, backend=backend, step=1e-3)
    pressure = 1e5 + 2e5 * (1.0 - np.exp(-5.0 * r.time))
    gamma = 1.0 + amount / capacity
    close(r["gas.volume"], 1e-2 * (1e5 / pressure) ** (1.0 / gamma), 1e-6)
    close(r["gas.temperature"], 300.0 * (pressure / 1e5) ** (1.0 - 1.0 / gamma), 1e-6)
    assert energy_balance(r).relative_residual < 1e-5


class Cubic(MultiportCompliance):
    """Two springs that stiffen together; nothing can be isolated."""

    a = Port(Translation)
    b = Port(Translation)
    stiffness: Parameter = parameter("N/m")
    length: Parameter = parameter("m")
    first = State("m")
    second = State("m")

    def energy(self) -> Expr:
        x, y = self.first / self.length, self.second / self.length
        unit = self.stiffness * self.length * self.length
        return unit * (0.5 * x * x + 0.5 * y * y + 0.25 * (x - y) * (x - y) * (x - y) * (x - y))


class Pull(EffortSource):
    flange = Port(Translation)
    force: Parameter = parameter("N")
    pulsation: Parameter = parameter("rad/s", default=2.0)

    def effort(self) -> Expr:
        return self.force * sin(self.pulsation * time)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_coordinate_that_cannot_be_isolated_is_solved_for(backend: Backend):
    field, pull, mass = Cubic(stiffness=40.0, length=0.1), Pull(force=6.0), Mass(mass=1.0)
    model = system(connect(pull.flange, field.a), connect(mass.flange, field.b), field=field, pull=pull, mass=mass)
    made = compiled(model, backend)
    # Both flanges are 1-junctions of one field port and one other: the source gives the effort at a.
    assert made.system.blocks
    r = run(made, 1.0, step=2e-3)

    def first(t: float, y: float) -> float:
        # The source gives effort F sin at the flange, so the field has the opposite one.
        return float(brentq(lambda x: 4.0 * (x + (x - y) ** 3) + 6.0 * math.sin(2.0 * t), -50.0, 50.0, xtol=1e-14))

    def by_hand(t: float, z: np.ndarray) -> list[float]:
        y, v = z[0] / 0.1, z[1]
        return [v, -4.0 * (y - (first(t, y) - y) ** 3)]

    hand = solve_ivp(by_hand, (0.0, 1.0), [0.0, 0.0], t_eval=r.time, rtol=1e-10, atol=1e-12)
    close(r["field.second"], hand.y[0], 1e-6)
    close(r["field.first"], [0.1 * first(t, y / 0.1) for t, y in zip(r.time, hand.y[0], strict=True)], 1e-6)
    assert energy_balance(r).relative_residual < 1e-5
