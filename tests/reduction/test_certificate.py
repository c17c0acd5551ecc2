"""Certificates: what they say against runs of one's own, what is lost told, and every change of a file noticed."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import propermodel as pm
from examples.quarter_car import QuarterCar, scenario
from propermodel.analysis.comparison import Feature
from propermodel.analysis.spectral_change import spectral_change
from propermodel.diagnostics import DocumentError, parse_path
from propermodel.reduction.candidates import Candidate, Verdict
from propermodel.reduction.certificate_document import from_certificate_document, to_certificate_document
from propermodel.reduction.certify import CertifiedModel, make_certificate
from propermodel.reduction.claim import Claim, Condition
from propermodel.simulation.stepping import Stepping
from tests.modelling.test_fuzz import opened
from tests.parts import Damper, Fixed, Mass, Spring
from tests.physics.systems import SinePush, system
from tests.strangers import changed_documents

RK4 = pm.Method.RK4
OUTPUT = parse_path("body.flange.flow")
TOLERANCES = {OUTPUT: pm.Tolerance(rms=0.05, peak=0.1)}


@pytest.fixture(scope="module")
def certified() -> CertifiedModel:
    search = pm.find_proper_model(pm.elaborate(QuarterCar()), scenario(), TOLERANCES, method=RK4, step=1e-3)
    return pm.certify(search)


@pytest.fixture
def folder(certified: CertifiedModel, tmp_path: Path) -> Path:
    pm.write_certificate(certified, tmp_path)
    return tmp_path


def certified_by_hand(
    model: pm.Model, removals: list[pm.Removal], run: pm.Scenario, outputs: list[str], step: float = 1e-4
) -> CertifiedModel:
    """The certificate of removals that somebody chose."""
    claim = Claim(
        model=model,
        removals=tuple(removals),
        conditions=(Condition(scenario=run, record_every=run.stop / 1000.0, integrals_every=run.stop),),
        outputs=tuple(map(parse_path, outputs)),
        tolerances={},
        stepping=Stepping(RK4, step),
    )
    return make_certificate(claim, claim.pairs(), method="choice", removed=())


# -- what it says -----------------------------------------------------------------------------------------


def test_errors_and_sizes_are_those_of_runs_of_ones_own(certified: CertifiedModel):
    full = pm.simulate(pm.compile_model(certified.full), scenario(), method=RK4, step=1e-3, record_every=5e-3)
    reduced = pm.simulate(pm.compile_model(certified.reduced), scenario(), method=RK4, step=1e-3, record_every=5e-3)
    (own,) = pm.compare(full, reduced, [OUTPUT]).outputs
    certificate = certified.certificate
    (said,) = certificate.scenarios[0].outputs
    assert said.errors == {feature: own.of(feature) for feature in Feature}
    assert said.errors[Feature.RMS] <= 0.05
    assert certificate.score == pytest.approx(max(own.rms / 0.05, own.of(Feature.PEAK) / 0.1))
    assert (certificate.full.states, certificate.reduced.states) == (4, len(reduced.compiled.system.states))
    assert certificate.scenarios[0].full.supplied == pytest.approx(pm.energy_balance(full).supplied)
    gone = {row.path for row in full.compiled.system.rows} - {row.path for row in reduced.compiled.system.rows}
    assert {row.row for row in certificate.removed} == gone


def test_every_row_says_what_replaces_it_and_what_was_predicted(certified: CertifiedModel):
    for row in certified.certificate.removed:
        assert row.alone[OUTPUT] > 0.0
        assert "(rms, predicted)" in row.why
        assert "(measured)" in row.why
        assert row.removals or "idle" in row.why
    assert "wheel" in str(certified)
    assert "to repeat it: propermodel verify" in str(certified)


def test_a_massless_wheel_gives_fewer_states_and_a_faster_mode():
    made = certified_by_hand(
        pm.elaborate(QuarterCar()), [pm.ZeroEffort(parse_path("wheel.flange"))], scenario(), [str(OUTPUT)]
    )
    # Without mass the forces at the wheel add up to nothing: its speed follows from both compressions and the body's.
    k, c, kt, ct, m = 2.0e4, 1.5e3, 2.4e5, 1.5e2, 1200.0
    wheel = np.array([kt, -k, c]) / (c + ct)
    body = np.array([0.0, 0.0, 1.0])
    matrix = np.array([-wheel, wheel - body, (k * np.array([0.0, 1.0, 0.0]) + c * (wheel - body)) / m])
    change = made.certificate.scenarios[0].spectra[-1]
    assert (change.full.order, change.reduced.order) == (4, 3)
    assert change.reduced.radius == pytest.approx(np.abs(np.linalg.eigvals(matrix)).max(), rel=1e-9)
    assert change.is_stiffer
    assert any("fewer states but stiffer" in warning for warning in made.certificate.warnings)


def two_masses(damping: float) -> pm.Model:
    """Two masses of 1 kg on a soft spring to the ground, and a stiff one between them."""
    ground, link, soft = Fixed(), Spring(stiffness=1.0e4), Spring(stiffness=100.0)
    near, far, damper, push = (
        Mass(mass=1.0),
        Mass(mass=1.0),
        Damper(damping=damping),
        SinePush(force=1.0, frequency=1.0),
    )
    drag = Damper(damping=20.0)
    return pm.elaborate(
        system(
            pm.connect(ground.flange, soft.a, drag.a),
            pm.connect(soft.b, drag.b, near.flange, link.a, damper.a, push.flange),
            pm.connect(link.b, damper.b, far.flange),
            ground=ground,
            link=link,
            soft=soft,
            near=near,
            far=far,
            damper=damper,
            drag=drag,
            push=push,
        )
    )


RIGID = [pm.ZeroFlow(parse_path("link.port")), pm.ZeroEffort(parse_path("damper.port"))]


@pytest.mark.parametrize(("damping", "nature"), [(-2.0, "lightly damped"), (-30.0, "unstable")])
def test_a_critical_mode_that_is_lost_is_told(damping: float, nature: str):
    made = certified_by_hand(two_masses(damping), list(RIGID), pm.Scenario(stop=0.5), ["near.flange.flow"])
    change = made.certificate.scenarios[0].spectra[0]
    a = np.array(  # momenta of both masses, displacements of both springs
        [
            [-20.0 - damping, damping, -1.0e4, -100.0],
            [damping, -damping, 1.0e4, 0.0],
            [1.0, -1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
        ]
    )
    expected = max(np.linalg.eigvals(a), key=lambda value: value.imag)
    (lost,) = change.lost
    assert lost.nature == nature
    assert complex(lost.real, lost.imaginary) == pytest.approx(complex(expected), rel=1e-6)
    assert any(f"lost on scenario at 0 s: {nature} mode" in warning for warning in made.certificate.warnings)
    assert change.gained == ()


def test_a_well_damped_mode_may_go_without_a_word():
    made = certified_by_hand(two_masses(60.0), list(RIGID), pm.Scenario(stop=0.5), ["near.flange.flow"])
    assert all(change.lost == () for change in made.certificate.scenarios[0].spectra)


def test_a_mode_that_becomes_unstable_is_told():
    stable = pm.compile_model(two_masses(0.5))
    growing = pm.compile_model(two_masses(-30.0))
    before, after = (pm.linearise(compiled, pm.Scenario(stop=1.0), inputs=()) for compiled in (stable, growing))
    (gained,) = spectral_change(before, after, window=1.0).gained
    assert gained.nature == "unstable"


def pushed(spring: Spring, damper: Damper, push: SinePush) -> pm.Model:
    """A mass of 1 kg on a spring and a damper."""
    mass, ground = Mass(mass=1.0), Fixed()
    return pm.elaborate(
        system(
            pm.connect(ground.flange, spring.a, damper.a),
            pm.connect(spring.b, damper.b, mass.flange, push.flange),
            push=push,
            mass=mass,
            spring=spring,
            damper=damper,
            ground=ground,
        )
    )


def test_what_drifts_more_slowly_than_the_window_is_no_lost_oscillation():
    # A swing of 63 s with a damping ratio of 0.05: the spring that makes it is lost with it.
    model = pushed(Spring(stiffness=0.01), Damper(damping=0.01), SinePush(force=1.0, frequency=1.0))
    reduced = model.without([pm.ZeroEffort(parse_path("spring.port"))])
    both = [pm.linearise(pm.compile_model(m), pm.Scenario(stop=1.0), inputs=()) for m in (model, reduced)]
    assert spectral_change(*both, window=5.0).lost == ()
    (lost,) = spectral_change(*both, window=50.0).lost
    assert lost.nature == "lightly damped"
    assert abs(complex(lost.real, lost.imaginary)) == pytest.approx(0.1, rel=1e-6)


def test_what_grows_more_slowly_than_the_window_is_not_unstable_in_it():
    slow, held = (pm.linearise(pm.compile_model(two_masses(d)), pm.Scenario(stop=1.0), inputs=()) for d in (-30.0, 0.5))
    assert [mode.nature for mode in spectral_change(held, slow, window=1.0).gained] == ["unstable"]
    assert spectral_change(held, slow, window=1e-3).gained == ()


def test_removals_that_cancel_each_other_are_fragile():
    # A mass and a spring in resonance: their forces add up to nothing, so both may go, and neither alone.
    push = SinePush(force=1.0, frequency=10.0 / (2.0 * np.pi))
    model = pushed(Spring(stiffness=100.0), Damper(damping=5.0), push)
    search = pm.find_proper_model(model, pm.Scenario(stop=60.0), {"mass.flange.flow": 0.1}, method=RK4, step=1e-3)
    both = (pm.ZeroEffort(parse_path("mass.flange")), pm.ZeroEffort(parse_path("spring.port")))
    rows = (parse_path("mass"), parse_path("spring"))
    chosen = Candidate(rows=rows, removals=both, predicted=0.5, score=0.5, verdict=Verdict.WITHIN, why="", states=0)
    made = pm.certify(search, chosen)
    (error,) = made.certificate.scenarios[0].outputs
    assert error.errors[Feature.RMS] < 0.1
    assert {str(row.row) for row in made.certificate.removed if row.is_fragile} == {"mass", "spring"}
    assert any("fragile: without mass alone" in warning for warning in made.certificate.warnings)


def test_a_search_that_found_nothing_has_nothing_to_certify():
    model = pm.elaborate(QuarterCar())
    search = pm.find_proper_model(
        model, scenario(), {OUTPUT: pm.Tolerance(largest=1e-9)}, method=RK4, step=1e-3, most_simulations=1
    )
    assert search.best is None
    with pytest.raises(pm.ProperModelError, match="nothing to certify"):
        pm.certify(search)


# -- repeated ---------------------------------------------------------------------------------------------


def test_a_certificate_is_read_as_it_was_written_and_holds(certified: CertifiedModel, folder: Path):
    again = pm.read_certificate(folder / "certificate.json")
    assert again.certificate == certified.certificate
    assert again.full == certified.full
    assert again.reduced == pm.read_model(folder / "reduced_model.json")
    verification = pm.verify_certificate(again)
    assert verification.holds
    assert verification.failed == ()
    assert len(verification.checks) > 30
    assert "the certificate holds" in str(verification)


def changed(folder: Path, change: Callable[[dict[str, Any]], None]) -> CertifiedModel:
    file = folder / "certificate.json"
    document = json.loads(file.read_text())
    change(document)
    file.write_text(json.dumps(document))
    return pm.read_certificate(file)


def test_a_number_that_was_improved_is_found(folder: Path):
    def flatter(document: dict[str, Any]) -> None:
        document["scenarios"][0]["outputs"][0]["errors"]["mean"] *= 0.5

    verification = pm.verify_certificate(changed(folder, flatter))
    assert not verification.holds
    assert [check.what for check in verification.failed] == ["mean of body.flange.flow on waves"]
    assert "NOT as recorded" in str(verification)


def test_another_model_does_not_hold(folder: Path):
    heavier = replace(scenario(), parameters={parse_path("body.mass"): 1500.0})
    other = pm.read_certificate(folder / "certificate.json", scenarios=[heavier])
    verification = pm.verify_certificate(other)
    assert not verification.holds
    assert verification.failed


def test_more_removals_than_certified_do_not_hold(folder: Path):
    other = pm.read_certificate(folder / "certificate.json")
    certificate = other.certificate
    bolder = replace(
        other,
        certificate=replace(
            certificate, removals=(*certificate.removals, pm.ZeroEffort(parse_path("suspension.damper.port")))
        ),
    )
    verification = pm.verify_certificate(bolder)
    assert not verification.found.is_within
    assert "NOT within the tolerances" in str(verification)


# -- files of strangers -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "code"), [("full_model.json", "document/digest"), ("scenario.json", "document/digest")]
)
def test_a_file_beside_that_has_changed_is_named(folder: Path, name: str, code: str):
    file = folder / name
    file.write_text(file.read_text() + " ")
    with pytest.raises(DocumentError) as caught:
        pm.read_certificate(folder / "certificate.json")
    assert caught.value.diagnostics[0].code == code
    assert name in str(caught.value)
    file.unlink()
    with pytest.raises(DocumentError, match="No such file"):
        pm.read_certificate(folder / "certificate.json")


def set_at(*keys: Any, to: Any) -> Callable[[dict[str, Any]], None]:
    def change(document: dict[str, Any]) -> None:
        place: Any = document
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = to

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (set_at("files", "full_model", "file", to="../../secret.json"), "not the name of a file beside"),
        (set_at("files", "scenarios", to=[]), "a file for every scenario"),
        (set_at("scenarios", to=[]), "says nothing"),
        (set_at("summary", "within", to=False), "the summary is not what the numbers"),
        (set_at("scenarios", 0, "record_every", to=1e-9), "too many instants"),
        (set_at("scenarios", 0, "record_every", to=0.0), "above zero"),
        (set_at("stepping", "step", to=-1.0), "must be positive"),
        (set_at("stepping", "method", to="rk5"), "did you mean"),
        (set_at("tolerances", to={"a.b": {"rms": 0.1}}), "no measured error"),
        (set_at("tolerances", "body.flange.flow", "rms", to=0.0), "a share above zero"),
        (set_at("removals", to=[]), "not the full model without"),
        (set_at("predicted", to=True), "expected a number"),
        (set_at("surprise", to=1), "unknown entry"),
        (set_at("version", to=2), "version 1 is read"),
    ],
)
def test_what_does_not_fit_is_refused(folder: Path, change: Callable[[dict[str, Any]], None], message: str):
    with pytest.raises(DocumentError) as caught:
        changed(folder, change)
    assert message in str(caught.value)
    assert "certificate.json" in str(caught.value)


@cache
def original() -> Any:
    """The document of a certificate."""
    search = pm.find_proper_model(pm.elaborate(QuarterCar()), scenario(), {OUTPUT: 0.01}, method=RK4, step=1e-3)
    with TemporaryDirectory() as folder:
        made = pm.certify(search, ranges={"body.mass": 0.1}, samples=4)
        return json.loads(pm.write_certificate(made, folder).read_text())


@given(st.deferred(lambda: changed_documents(original())))
@settings(max_examples=60)
def test_changed_certificates_are_refused_or_read(document: Any):
    read = opened(document, from_certificate_document)
    if read is None:
        return
    certificate, files = read
    again = json.loads(json.dumps(to_certificate_document(certificate, files)))
    assert from_certificate_document(again) == (certificate, files)
    assert str(certificate)
