"""`propermodel verify`: a certificate repeated."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from propermodel.cli.faults import FAULTS_FOUND
from propermodel.cli.options import AsJson


def verify(
    certificate: Annotated[str, typer.Argument(help="A certificate, or the folder of a reduction.", metavar="FILE")],
    model: Annotated[
        str | None,
        typer.Option(
            "--model", help="The full model, where it is not the one beside the certificate.", metavar="MODEL"
        ),
    ] = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            "--scenario", help="A scenario likewise; all, in the order of the certificate.", metavar="SCENARIO"
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a reduced model and the full one again, and compare every number with its certificate.

    Ends with 0 if the certificate holds, with 1 if a number is another or an error is beyond its tolerance.
    """
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.tables import Screen
    from propermodel.reduction.certificate_files import read_certificate
    from propermodel.reduction.verify import verify_certificate

    subject = None if model is None else load_subject(model)
    scenarios = [load_subject(model, text).scenario for text in scenario] if model and scenario else None
    if scenario and not model:
        from propermodel.modelling.documents import read_scenario

        scenarios = [read_scenario(text) for text in scenario]
    certified = read_certificate(certificate, model=None if subject is None else subject.model, scenarios=scenarios)
    verification = verify_certificate(certified)
    if as_json:
        report = {
            "model": verification.recorded.model,
            "holds": verification.holds,
            "within": verification.found.is_within,
            "error_over_tolerance": verification.found.score,
            "warnings": list(verification.found.warnings),
            "checks": [
                {"what": c.what, "recorded": c.recorded, "found": c.found, "holds": c.holds}
                for c in verification.checks
            ],
        }
        typer.echo(json.dumps(report, indent=2))
    else:
        Screen().print(*str(certified).splitlines(), "", *str(verification).splitlines())
    if not verification.holds:
        raise typer.Exit(FAULTS_FOUND)
