"""Every storage law of the library is the gradient of its energy."""

import pytest

from propermodel.diagnostics import Path
from propermodel.expressions.core import SymbolKind, leaves, symbol
from propermodel.expressions.derivatives import derivative
from propermodel.library.electrical import Capacitor, Inductor
from propermodel.library.hydraulics import GasVessel, OilChamber
from propermodel.library.mechanics.rotation import RotatingInertia, TorsionSpring
from propermodel.library.mechanics.translation import GasSpring, Mass, Spring
from propermodel.library.thermal import HeatCapacity
from propermodel.modelling import elaborate
from tests.library.laws import value_of

STORAGES = [
    (Mass(mass=12.0), {"momentum": 3.0}),
    (RotatingInertia(inertia=2.0), {"momentum": -3.0}),
    (Spring(stiffness=1e4), {"displacement": 0.02}),
    (TorsionSpring(stiffness=1e4), {"displacement": 0.02}),
    (OilChamber(volume=1e-3), {"displacement": 1e-6}),
    (Capacitor(capacitance=1e-3), {"displacement": 0.02}),
    (Inductor(inductance=1e-3), {"momentum": 0.02}),
    (HeatCapacity(capacity=500.0), {"displacement": 40.0}),
    (
        GasSpring(gas_volume=0.8e-3, piston_area=1.2e-3, static_pressure=3e6),
        {"compression": 0.1, "temperature": 340.0},
    ),
    (
        GasVessel(volume=0.12, gas_mass=16.64, liner_heat_capacity=9200.0),
        {"oil_volume": 0.03, "temperature": 340.0},
    ),
]
# Fields in coordinates of their own have no inverse.
INVERTIBLE = [(component, state) for component, state in STORAGES if len(state) == 1]


@pytest.mark.parametrize(("component", "state"), STORAGES, ids=[type(c).__name__ for c, _ in STORAGES])
def test_stored_energy_changes_by_effort_times_what_flows_in(component, state):
    storage = elaborate(component).root.definition.behaviour
    energy = dict(storage.outputs)
    for coordinate in storage.coordinates:
        c = symbol(SymbolKind.STATE, Path((coordinate.name,)), coordinate.unit)
        supplied = sum(
            value_of(energy[port], component, **state) * value_of(derivative(stored, c), component, **state)
            for port, stored in storage.stored
        )
        change = value_of(derivative(storage.energy, c), component, **state)
        assert change == pytest.approx(supplied, rel=1e-9)


@pytest.mark.parametrize(("component", "state"), INVERTIBLE, ids=[type(c).__name__ for c, _ in INVERTIBLE])
def test_the_inverse_law_gives_the_state_back(component, state):
    storage = elaborate(component).root.definition.behaviour
    driver = next(leaf for leaf in leaves(storage.inverse) if leaf.data.path.name in ("effort", "flow"))
    ((_, law),) = storage.outputs
    given = {driver.data.path.name: value_of(law, component, **state)}
    assert value_of(storage.inverse, component, **given) == pytest.approx(*state.values(), rel=1e-12)
