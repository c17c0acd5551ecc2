"""`propermodel reduce --tolerance`: the smallest model whose outputs stay within tolerances."""

from __future__ import annotations

import json
import math
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import typer

from propermodel.diagnostics import Path, SimulationError, nearest, one_of, parse_path

if TYPE_CHECKING:
    from collections.abc import Sequence

    from propermodel.analysis.comparison import OutputError
    from propermodel.analysis.tolerances import Tolerance
    from propermodel.catalogue.subject import Subject
    from propermodel.compiler import CompiledModel
    from propermodel.reduction.candidates import Candidate, ProperModelSearch


def reduce_within(
    subject: Subject,
    tolerances: Sequence[str],
    ranges: Sequence[str],
    out: FilePath,
    *,
    results: FilePath | None,
    as_json: bool,
) -> None:
    """Search, write the front and the recommended model with its certificate, and print them."""
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.ranges import parse_ranges
    from propermodel.cli.tables import Screen
    from propermodel.compiler import compile_model
    from propermodel.modelling.documents import write_model
    from propermodel.reduction.certificate_files import write_certificate
    from propermodel.reduction.certify import certify
    from propermodel.reduction.search import find_proper_model
    from propermodel.report.page import write_page
    from propermodel.report.page_data import page_data, subject_of_certified

    compiled = compile_model(subject.model)
    wanted = _tolerances(compiled, subject, tolerances)
    moving = parse_ranges(subject, ranges)
    with ProgressBars() as bars:
        found = find_proper_model(
            subject.model,
            subject.scenario,
            wanted,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            step_tolerance=subject.tolerance,
            results=results,
            progress=lambda candidate, simulations: bars(f"{simulations} simulations, {len(candidate.rows)} rows go"),
        )
    out.mkdir(parents=True, exist_ok=True)
    report = _report(found)
    (out / "search.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    certified = None if found.recommended is None else certify(found, ranges=moving or None)
    if certified is None:
        write_model(found.reduced(), out / "reduced_model.json")
    else:
        write_certificate(certified, out)
        page = subject_of_certified(certified, search=found, totals=subject.totals, panels=subject.panels)
        write_page(page_data(page), out / "report.html")
    if as_json:
        typer.echo(json.dumps(report, indent=2))
        return
    screen = Screen()
    screen.print(*str(found).splitlines(), "")
    files = [
        ("search.json", "every model that was tried, with its errors"),
        ("reduced_model.json", "the certified model, to be run and reduced further"),
    ]
    if certified is not None:
        screen.print(*(f"warning: {warning}" for warning in certified.certificate.warnings))
        files.insert(0, ("report.html", "everything of this search in one page, to be mailed and opened anywhere"))
        files.append(("certificate.json", "what it rests on; propermodel verify repeats it"))
    for name, meaning in files:
        screen.print(f"{(out / name).as_posix()}  {meaning}")


def _tolerances(compiled: CompiledModel, subject: Subject, texts: Sequence[str]) -> dict[Path, Tolerance]:
    """Outputs with their tolerances, each written `body.flange.flow=2%` or `fuel.mass=final:0.2%,largest:1%`."""
    from propermodel.analysis.tolerances import Tolerance

    found: dict[Path, dict[str, float]] = {}
    for text in texts:
        name, _, shares = text.partition("=")
        parsed = [_share(text, part) for part in shares.split(",")]
        given = found.setdefault(_output(compiled, subject, name), {})
        for feature, share in parsed:
            if feature in given:
                raise _no_tolerance(f"the {feature} of '{name}' is given twice")
            given[feature] = share
    return {path: Tolerance(**given) for path, given in found.items()}


def _share(text: str, part: str) -> tuple[str, float]:
    """A feature with its share; without a name it is the root mean square."""
    from propermodel.analysis.comparison import Feature

    name, _, share = part.rpartition(":")
    feature = name.strip().replace("-", "_") or Feature.RMS.value
    try:
        value = float(share.strip().removesuffix("%")) * (0.01 if share.strip().endswith("%") else 1.0)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise _no_tolerance(f"'{text}' is no output with a tolerance")
    if feature not in set(Feature):
        raise _no_tolerance(f"'{name}' is no feature of an output", nearest(feature, [f.value for f in Feature]))
    return feature, value


def _no_tolerance(message: str, help: str = "") -> SimulationError:
    from propermodel.analysis.comparison import Feature

    features = ", ".join(feature.value for feature in Feature)
    cure = "write --tolerance body.flange.flow=2% (rms, as a share of the range), or name features: "
    return SimulationError.of(
        "simulation/tolerance", message, help=help or f"{cure}fuel=final:0.2%,largest:1%; there are {features}"
    )


def _output(compiled: CompiledModel, subject: Subject, name: str) -> Path:
    """An output by path; a last name will do where it is the only one."""
    path = parse_path(name.strip())
    known = compiled.lowered.observables
    if path not in known:
        offered = dict.fromkeys((*subject.outputs, *subject.totals.values(), *known))
        ending = [candidate for candidate in offered if candidate[-len(path) :] == tuple(path)]
        if len(ending) != 1:
            raise SimulationError.of(
                "simulation/unknown-observable",
                f"{f'{len(ending)} observables end' if ending else 'no observable ends'} with '{path}'",
                help=one_of(str(path), map(str, ending or offered)),
            )
        (path,) = ending
    return path


def _report(found: ProperModelSearch) -> dict[str, object]:
    return {
        "model": found.model.name,
        "scenarios": list(found.scenarios),
        "tolerances": {
            str(path): {feature.value: share for feature, share in tolerance.shares.items()}
            for path, tolerance in found.tolerances.items()
        },
        "rows": found.rows,
        "states": found.states,
        "simulations": found.simulations,
        "candidates": [_candidate(candidate) for candidate in found.candidates],
        "smallest": None if found.best is None else found.candidates.index(found.best),
        "recommended": None if found.recommended is None else found.candidates.index(found.recommended),
        "notes": list(found.notes),
    }


def _candidate(candidate: Candidate) -> dict[str, object]:
    from propermodel.modelling.removal_words import removal_text

    return {
        "rows_gone": [str(path) for path in candidate.rows],
        "removals": [removal_text(removal) for removal in candidate.removals],
        "states": candidate.states,
        "predicted_over_tolerance": candidate.predicted,
        "measured_over_tolerance": candidate.score if candidate.comparisons else None,
        "verdict": candidate.verdict.value,
        "why": candidate.why,
        "fragile": [str(path) for path in candidate.fragile],
        "seconds_per_simulated_second": candidate.cost if math.isfinite(candidate.cost) else None,
        "errors": {
            scenario: {str(output.path): _errors(output) for output in comparison.outputs}
            for scenario, comparison in candidate.comparisons.items()
        },
    }


def _errors(output: OutputError) -> dict[str, object]:
    from propermodel.analysis.comparison import Feature
    from propermodel.analysis.features import Undefined

    found = {feature: output.of(feature) for feature in Feature}
    return {feature.value: value.why if isinstance(value, Undefined) else value for feature, value in found.items()}
