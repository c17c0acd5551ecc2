"""`propermodel reduce --tolerance`: the smallest model whose outputs stay within tolerances."""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import typer

from propermodel.diagnostics import Path, SimulationError, one_of, parse_path

if TYPE_CHECKING:
    from collections.abc import Sequence

    from propermodel.cli.models import Subject
    from propermodel.compiler import CompiledModel
    from propermodel.reduction.search import Candidate, ProperModelSearch


def reduce_within(subject: Subject, tolerances: Sequence[str], out: FilePath, *, as_json: bool) -> None:
    """Search, write the front and the recommended model, and print them."""
    from propermodel.cli.progress import ProgressBars
    from propermodel.cli.tables import Screen
    from propermodel.compiler import compile_model
    from propermodel.modelling.documents import write_model
    from propermodel.reduction.search import find_proper_model

    compiled = compile_model(subject.model)
    wanted = dict(_tolerance(compiled, subject, text) for text in tolerances)
    with ProgressBars() as bars:
        found = find_proper_model(
            subject.model,
            subject.scenario,
            wanted,
            method=subject.method,
            step=subject.step,
            jacobian_every=subject.jacobian_every,
            step_tolerance=subject.tolerance,
            progress=lambda candidate, simulations: bars(f"{simulations} simulations, {len(candidate.rows)} rows go"),
        )
    out.mkdir(parents=True, exist_ok=True)
    report = _report(found)
    (out / "search.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    write_model(found.reduced(), out / "reduced_model.json")
    if as_json:
        typer.echo(json.dumps(report, indent=2))
        return
    screen = Screen()
    screen.print(*str(found).splitlines(), "")
    for name, meaning in (
        ("search.json", "every model that was tried, with its errors"),
        ("reduced_model.json", "the recommended model, to be run and reduced further"),
    ):
        screen.print(f"{(out / name).as_posix()}  {meaning}")


def _tolerance(compiled: CompiledModel, subject: Subject, text: str) -> tuple[Path, float]:
    """An output with its tolerance, written `body.flange.flow=2%`; a last name will do where it is the only one."""
    name, sign, share = text.partition("=")
    try:
        value = float(share.removesuffix("%")) * (0.01 if share.endswith("%") else 1.0)
    except ValueError:
        value = 0.0
    if not sign or not value > 0.0:
        raise SimulationError.of(
            "simulation/tolerance",
            f"'{text}' is no output with a tolerance",
            help="write --tolerance body.flange.flow=2%, or a share of the range: body.flange.flow=0.02",
        )
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
    return path, value


def _report(found: ProperModelSearch) -> dict[str, object]:
    return {
        "model": found.model.name,
        "scenarios": list(found.scenarios),
        "tolerances_rms_over_range": {str(path): share for path, share in found.tolerances.items()},
        "rows": found.rows,
        "states": found.states,
        "simulations": found.simulations,
        "candidates": [_candidate(candidate) for candidate in found.candidates],
        "smallest": None if found.best is None else found.candidates.index(found.best),
        "recommended": None if found.recommended is None else found.candidates.index(found.recommended),
        "notes": list(found.notes),
    }


def _candidate(candidate: Candidate) -> dict[str, object]:
    from propermodel.report.summary import removal_text

    return {
        "rows_gone": [str(path) for path in candidate.rows],
        "removals": [removal_text(removal) for removal in candidate.removals],
        "states": candidate.states,
        "predicted_over_tolerance": candidate.predicted,
        "measured_over_tolerance": candidate.score if candidate.comparisons else None,
        "verdict": candidate.verdict.value,
        "why": candidate.why,
        "errors": {
            scenario: {
                str(output.path): {"rms": output.rms, "maximum": output.maximum, "final": output.final_error}
                for output in comparison.outputs
            }
            for scenario, comparison in candidate.comparisons.items()
        },
    }
