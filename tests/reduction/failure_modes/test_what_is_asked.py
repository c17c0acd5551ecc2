"""Static preload, blindness for outputs, cancelling pairs, and an error that nothing bounds (modes 1, 2, 4 and 17)."""

from __future__ import annotations

import math

import pytest

from propermodel.analysis.activity import rank_activity
from propermodel.diagnostics import parse_path
from propermodel.expressions import Expr, sin, time, where
from propermodel.library.mechanics.translation import Damper, Fixed, Mass, Spring
from propermodel.modelling import (
    Component,
    EffortSource,
    Parameter,
    Port,
    Resistance,
    Translation,
    connect,
    elaborate,
    parameter,
    quantity,
)
from propermodel.modelling.model import ConstantEffort, ZeroEffort
from propermodel.reduction.plan import Verdict, plan_reduction
from propermodel.reduction.prediction import predict_errors
from propermodel.reduction.search import find_proper_model
from propermodel.reduction.single import Refusal
from tests.parts import Capacitor, Coil, Ground, Resistor
from tests.physics.systems import Drag, Shaking, SineVoltage, compiled, run, scenario, system
from tests.reduction.failure_modes.plain import error_without, plain_mora, rows_of
from tests.reduction.rigs import preloaded, quarter_car

TYRE_FORCE = "tyre.a.effort"


# -- 1: a preload does no work -------------------------------------------------------------------------------------


def test_a_preload_is_refused_where_plain_mora_lets_the_body_fall():
    full = compiled(preloaded())
    r = run(full, 2.0, step=5e-4, every=1e-3)
    plain = plain_mora(r, 0.95)
    assert ZeroEffort(parse_path("spring.port")) in plain
    assert error_without(r, plain, "body.flange.flow") > 1.0
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.95, tolerance=0.2)
    assert error_without(r, reduction.removals, "body.flange.flow") < 0.2
    decision = next(d for d in reduction.decisions if str(d.row.path) == "spring")
    assert decision.verdict is Verdict.REFUSED
    way = next(way for way in decision.ways if way.removal == ZeroEffort(parse_path("spring.port")))
    assert way.missing == pytest.approx(1.0)  # of the most active term at the body: the weight


class ParkingBrake(Resistance):
    """Grips after the first second."""

    flange = Port(Translation)

    def effort(self, flow: Expr) -> Expr:
        return where(time > quantity(1.0, "s"), quantity(1e6, "N.s/m"), quantity(0.0, "N.s/m")) * flow


class Manoeuvre(EffortSource):
    """Pushes to and fro for a second; then only the slope pulls."""

    flange = Port(Translation)
    slope: Parameter = parameter("N")

    def effort(self) -> Expr:
        phase = time * quantity(2.0 * math.pi, "1/s")
        return -where(time > quantity(1.0, "s"), self.slope, quantity(1000.0, "N") * sin(phase))


def parked(slope: float) -> Component:
    """A car that is moved against drag, and then held on a slope."""
    push, car, drag, brake = Manoeuvre(slope=slope), Mass(mass=100.0), Drag(damping=5000.0), ParkingBrake()
    return system(
        connect(push.flange, car.flange, drag.flange, brake.flange), push=push, car=car, drag=drag, brake=brake
    )


def test_a_brake_that_holds_without_moving_is_refused_as_a_preload():
    full = compiled(parked(slope=1000.0))
    r = run(full, 2.0, step=5e-5, every=1e-3)
    plain = plain_mora(r, 0.9)
    assert "brake" in rows_of(plain)
    assert error_without(r, plain, "car.flange.flow") > 0.2  # it rolls away
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.9)
    brake = next(d for d in reduction.decisions if str(d.row.path) == "brake")
    assert brake.cause is Refusal.PRELOAD
    assert "a preload that does no work but must not be dropped" in brake.reason
    assert "of the greatest effort: a preload" in reduction.explain("brake")


def test_a_brake_that_has_nothing_to_hold_goes():
    full = compiled(parked(slope=0.0))
    r = run(full, 2.0, step=5e-5, every=1e-3)
    reduction = plan_reduction(full, r, rank_activity(r), threshold=0.9)
    assert "brake" in rows_of(reduction.removals)


def mixer(preload: float) -> Component:
    shaker, mass, spring = Shaking(velocity=2.0, frequency=2.0), Mass(mass=10.0), Spring(stiffness=1e4)
    ground, slow, holder = Fixed(), Spring(stiffness=0.5, start_compression=preload / 0.5), Damper(damping=30.0)
    return system(
        connect(shaker.flange, holder.a),
        connect(holder.b, mass.flange, spring.a, slow.a),
        connect(spring.b, slow.b, ground.flange),
        shaker=shaker,
        mass=mass,
        spring=spring,
        ground=ground,
        slow=slow,
        holder=holder,
    )


def test_a_preload_becomes_a_constant_and_a_spring_without_preload_goes():
    loaded, unloaded = compiled(mixer(20.0)), compiled(mixer(0.0))
    found = []
    for full in (loaded, unloaded):
        r = run(full, 3.0, step=5e-4, every=1.5e-3)
        reduction = plan_reduction(full, r, rank_activity(r), threshold=0.97, tolerance=0.1)
        found.append({type(removal) for removal in reduction.removals if removal.bond == parse_path("slow.port")})
        assert not any(d.cause is Refusal.PRELOAD for d in reduction.decisions)
    assert found == [{ConstantEffort}, {ZeroEffort}]


# -- 2: activity does not know what is asked -----------------------------------------------------------------------


def test_an_output_keeps_its_element_where_plain_mora_is_blind_to_it():
    full = compiled(quarter_car(velocity=0.3, frequency=10.0))
    r = run(full, 2.0, step=5e-4, every=1e-3)
    plain = plain_mora(r)
    assert "body" in rows_of(plain)
    assert error_without(r, plain, "body.flange.flow", step=2e-4) > 0.2
    search = find_proper_model(full.model, scenario(2.0), {"body.flange.flow": 0.05}, step=5e-4)
    assert parse_path("body") not in search.recommended.rows
    reduction = plan_reduction(full, r, rank_activity(r), protected=["body.flange.flow"])
    decision = next(d for d in reduction.decisions if str(d.row.path) == "body")
    assert decision.cause is Refusal.OUTPUT


def test_an_output_elsewhere_lets_the_body_go():
    full = compiled(quarter_car(velocity=0.3, frequency=10.0))
    search = find_proper_model(full.model, scenario(2.0), {TYRE_FORCE: 0.05}, step=5e-4)
    assert parse_path("body") in search.recommended.rows


# -- 4: a pair that cancels ----------------------------------------------------------------------------------------


RESONANCE = 1.0 / (2.0 * math.pi * math.sqrt(0.1 * 1e-3))


def series_circuit(frequency: float) -> Component:
    """A resistor, a coil and a capacitor in series on an alternating voltage."""
    source, ground = SineVoltage(voltage=10.0, frequency=frequency), Ground()
    resistor, coil, capacitor = Resistor(resistance=10.0), Coil(inductance=0.1), Capacitor(capacitance=1e-3)
    return system(
        connect(source.a, resistor.a),
        connect(resistor.b, coil.a),
        connect(coil.b, capacitor.a),
        connect(capacitor.b, source.b, ground.pin),
        source=source,
        ground=ground,
        resistor=resistor,
        coil=coil,
        capacitor=capacitor,
    )


@pytest.mark.parametrize(("frequency", "goes"), [(RESONANCE, True), (0.5 * RESONANCE, False)])
def test_a_pair_that_cancels_goes_together(frequency, goes):
    periods, omega = 20.0 / frequency, 2.0 * math.pi * frequency
    # In resonance the current follows the voltage; at the start the capacitor holds what it does in steady state.
    given = {"capacitor.port.displacement": -1.0 / omega} if goes else {}
    model = elaborate(series_circuit(frequency))
    r = run(model, periods, step=periods / 4000, every=periods / 2000, initial=given)
    output = "resistor.port.flow"
    # Plain MORA takes the two one by one.
    assert rank_activity(r).row(parse_path("coil")).index > 0.1
    prediction = predict_errors(r, [output])
    pair = [ZeroEffort(parse_path("coil.port")), ZeroEffort(parse_path("capacitor.port"))]
    assert min(prediction.of([removal]).worst for removal in pair) > 0.05
    together = prediction.of(pair).worst
    assert (together < 1e-6) is goes
    assert together == pytest.approx(error_without(r, pair, output), rel=0.2, abs=1e-6)


# -- 17: nothing bounds the error ----------------------------------------------------------------------------------


def test_more_activity_kept_is_not_less_error_but_a_tolerance_is_kept():
    periods = 20.0 / RESONANCE
    given = {"capacitor.port.displacement": -1.0 / (2.0 * math.pi * RESONANCE)}
    model = elaborate(series_circuit(RESONANCE))
    r = run(model, periods, step=periods / 4000, every=periods / 2000, initial=given)
    output = "resistor.port.flow"
    less, more, all_but_none = (error_without(r, plain_mora(r, share), output) for share in (0.4, 0.6, 0.99))
    assert less < 0.02 < 0.2 < more  # it keeps more, and is worse
    assert all_but_none == 0.0
    search = find_proper_model(model, scenario(periods, initial=given), {output: 0.3}, step=periods / 4000)
    for candidate in search.front:  # chosen by errors that were measured, not by shares of activity
        assert error_without(r, candidate.removals, output) == pytest.approx(0.3 * candidate.score, abs=0.01)
