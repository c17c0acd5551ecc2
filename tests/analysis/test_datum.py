"""Storage measured about a point, against energies about that point and models without weight."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import propermodel as pm
from propermodel.library.mechanics.rotation import RotatingInertia
from propermodel.library.mechanics.translation import Damper, Fixed, GasSpring, Lever, Mass, Spring
from propermodel.library.thermal import WallConductance
from tests.physics.systems import Push, Shaking, SinePush, scenario, system

G = 9.81


def drive(compiled: pm.CompiledModel, stop: float, every: float = 0.01, step: float = 1e-3, **given) -> pm.Trajectory:
    run = pm.simulate(
        compiled, scenario(stop, **given), method=pm.Method.RK4, step=step, record_every=every, integrals_every=stop
    )
    assert run.ending.is_complete
    return run


def total_variation(values: np.ndarray) -> float:
    return float(np.sum(np.abs(np.diff(values))))


def path(text: str) -> pm.Path:
    return pm.Path(tuple(text.split(".")))


class Weight(pm.EffortSource):
    flange = pm.Port(pm.Translation)
    mass: pm.Parameter = pm.parameter("kg")

    def effort(self) -> pm.Expr:
        return self.mass * pm.quantity(G, "m/s2")


def hanging() -> pm.Component:
    mass, spring, damper = Mass(mass=2.0), Spring(stiffness=50.0), Damper(damping=0.5)
    weight, ground, push = Weight(mass=2.0), Fixed(), SinePush(force=1.0, frequency=0.7)
    return system(
        pm.connect(mass.flange, spring.a, damper.a, weight.flange, push.flange),
        pm.connect(spring.b, damper.b, ground.flange),
        mass=mass,
        spring=spring,
        damper=damper,
        weight=weight,
        ground=ground,
        push=push,
    )


def test_a_preloaded_spring_counts_by_its_energy_about_the_rest():
    compiled = pm.compile_model(pm.elaborate(hanging()))
    rest = pm.find_equilibrium(compiled, scenario(1.0))
    start = {"spring.port.displacement": rest["spring.displacement"]}
    assert start["spring.port.displacement"] == pytest.approx(-2.0 * G / 50.0)
    run = drive(pm.measure_about(compiled, rest), 10.0, every=1e-3, initial=start)
    ranking = pm.rank_activity(run)
    away = run["spring.port.displacement"] - rest["spring.displacement"]
    assert ranking.row(path("spring")).activity == pytest.approx(total_variation(25.0 * away**2), rel=1e-5)
    assert ranking.row(path("mass")).activity == pytest.approx(total_variation(run["mass.flange.flow"] ** 2), rel=1e-5)
    assert ranking.row(path("damper")).activity == pytest.approx(run.work("damper.port"), rel=1e-12)
    assert "storage: measured about the equilibrium in scenario scenario" in ranking.datums
    # The whole power of the preload is far more, and the balance of the run is closed by whole powers.
    plain = pm.rank_activity(drive(compiled, 10.0, initial=start)).row(path("spring"))
    assert plain.activity > 5.0 * ranking.row(path("spring")).activity
    assert run.activity("spring.port") == pytest.approx(plain.activity, rel=1e-12)
    assert pm.energy_balance(run).relative_residual < 1e-9


def test_a_mass_counts_from_the_velocity_at_which_it_coasts():
    mass, push = Mass(mass=3.0, start_velocity=20.0), SinePush(force=-6.0, frequency=0.5)
    compiled = pm.compile_model(pm.elaborate(system(pm.connect(mass.flange, push.flange), mass=mass, push=push)))
    ranking = pm.rank_activity(drive(pm.measure_about(compiled, scenario(2.0)), 2.0))
    # v - 20 = a (1 - cos(pi t)) with a = 2/pi, up to 2 a and back: twice m (2 a)^2 / 2.
    assert ranking.total == pytest.approx(2.0 * 0.5 * 3.0 * (4.0 / np.pi) ** 2, rel=1e-6)
    assert ranking.datums[-1] == "storage: measured about the start of scenario scenario"


def half_car(weighs: bool) -> pm.Component:
    """Heave and pitch on two struts and wheels; weights and preloads are written out, or left out with each other."""
    body, pitch = Mass(mass=900.0), RotatingInertia(inertia=1100.0)
    connections, parts = [], {"body": body, "pitch": pitch}
    arms = {"front": 1.1, "rear": -1.5}
    loads = {"front": 900.0 * 1.5 / 2.6, "rear": 900.0 * 1.1 / 2.6}  # kg
    for side, arm in arms.items():
        carried, standing = (G * load if weighs else 0.0 for load in (loads[side], loads[side] + 45.0))
        own = {
            "road": Shaking(velocity=0.2 if side == "front" else 0.15, frequency=1.7),
            "tyre": Spring(stiffness=1.8e5, start_compression=standing / 1.8e5),
            "wheel": Mass(mass=45.0),
            "spring": Spring(stiffness=2.2e4, start_compression=carried / 2.2e4),
            "damper": Damper(damping=1.4e3),
            "lever": Lever(),
            **({"weight": Weight(mass=45.0)} if weighs else {}),
        }
        connections += [
            pm.connect(own["road"].flange, own["tyre"].a),
            pm.connect(own["tyre"].b, own["wheel"].flange, own["spring"].a, own["damper"].a)
            if not weighs
            else pm.connect(own["tyre"].b, own["wheel"].flange, own["spring"].a, own["damper"].a, own["weight"].flange),
            pm.connect(own["spring"].b, own["damper"].b, own["lever"].point),
            pm.connect(own["lever"].base, body.flange),
            pm.connect(own["lever"].rotation, pitch.shaft),
            pm.connect(pm.quantity(arm, "m"), own["lever"].arm),
        ]
        parts |= {f"{side}_{name}": part for name, part in own.items()}
    if weighs:
        parts["weight"] = Weight(mass=900.0)
        connections.append(pm.connect(parts["weight"].flange, body.flange))
    return system(*connections, **parts)


def test_a_car_with_its_weight_ranks_as_one_without():
    light = pm.compile_model(pm.elaborate(half_car(False)))
    heavy = pm.compile_model(pm.elaborate(half_car(True)))
    rest = pm.find_equilibrium(heavy, scenario(1.0))
    reference = pm.rank_activity(drive(light, 4.0))
    about = pm.rank_activity(drive(pm.measure_about(heavy, rest), 4.0))
    assert [row.path for row in about.rows] == [row.path for row in reference.rows]
    for row, expected in zip(about.rows, reference.rows, strict=True):
        assert row.index == pytest.approx(expected.index, rel=1e-6)
        assert dict(row.ports) == pytest.approx(dict(expected.ports), rel=1e-6)
    plain = pm.rank_activity(drive(heavy, 4.0))
    assert plain.rows[0].path == path("front_spring") != reference.rows[0].path
    assert plain.row(path("front_tyre")).index > 2.0 * reference.row(path("front_tyre")).index


def test_a_field_counts_by_what_it_could_do_about_the_point():
    gas, wall = GasSpring(gas_volume=1e-3, piston_area=2e-3, static_pressure=2e6), WallConductance(conductance=5.0)
    mass, load, ground = Mass(mass=50.0), Push(force=-800.0), Fixed()
    compiled = pm.compile_model(
        pm.elaborate(
            system(
                pm.connect(mass.flange, gas.a, load.flange),
                pm.connect(gas.b, ground.flange),
                pm.connect(gas.wall, wall.port),
                gas=gas,
                wall=wall,
                mass=mass,
                load=load,
                ground=ground,
            )
        )
    )
    begin = {"gas.compression": 0.05, "gas.temperature": 310.0}
    at = scenario(1.0, initial=begin)
    run = drive(pm.measure_about(compiled, at), 1.0, every=1e-3, initial=begin)
    left = run["gas.energy"]
    for port in ("port", "wall"):
        left = left - run[f"gas.{port}.effort"][0] * run[f"gas.{port}.displacement"]
    assert abs(run["gas.port.effort"][0]) > 100.0
    assert pm.rank_activity(run).row(path("gas")).activity == pytest.approx(total_variation(left), rel=1e-4)


def test_parts_that_only_carry_their_load_can_be_chosen():
    compiled = pm.compile_model(pm.elaborate(half_car(True)))
    chosen = pm.measure_about(compiled, scenario(1.0), of=["front_spring", "rear_spring"])
    run = drive(chosen, 1.0)
    every = pm.rank_activity(drive(pm.measure_about(compiled, scenario(1.0)), 1.0))
    ranking = pm.rank_activity(run)
    assert ranking.datums[-1].endswith("in front_spring, rear_spring")
    assert ranking.row(path("front_spring")).activity == every.row(path("front_spring")).activity
    assert ranking.row(path("front_tyre")).activity == run.activity("front_tyre.port")
    with pytest.raises(pm.ProperModelError) as caught:
        pm.measure_about(compiled, scenario(1.0), of=["front_sprig"])
    assert str(caught.value) == (
        "error[activity/no-storage]: there is no storage in 'front_sprig' to be measured about a point\n"
        "  help: did you mean 'front_spring'?"
    )


def test_runs_about_different_points_are_not_ranked_together():
    compiled = pm.compile_model(pm.elaborate(hanging()))
    about = pm.measure_about(compiled, pm.find_equilibrium(compiled, scenario(1.0)))
    with pytest.raises(pm.ProperModelError, match="measure storage about different points: none and equilibrium in"):
        pm.rank_activity([drive(compiled, 0.1), drive(about, 0.1)])


def test_another_process_measures_about_the_same_point():
    compiled = pm.compile_model(pm.elaborate(hanging()))
    about = pm.measure_about(compiled, pm.find_equilibrium(compiled, scenario(1.0)))
    assert pickle.loads(pickle.dumps(about)).system.datum == about.system.datum
