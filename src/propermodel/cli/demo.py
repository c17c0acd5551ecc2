"""`propermodel demo`: a study that shows what the package does."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from propermodel.cli.options import AsJson, Until, configured

SUBJECT = "truck"


def demo(
    out: Annotated[FilePath, typer.Option("--out", help="Folder for the files.", metavar="DIR", file_okay=False)],
    until: Until = None,
    as_json: AsJson = False,
) -> None:
    """Reduce the hybrid truck on its mission, and write the study."""
    from propermodel.catalogue.finding import load_subject
    from propermodel.cli.reduce import reduce_subject
    from propermodel.report.options import StudyOptions

    subject = configured(load_subject(SUBJECT), until=until)
    options = StudyOptions(
        outputs=subject.outputs, totals=subject.totals, panels=subject.panels, method=subject.method, step=subject.step
    )
    reduce_subject(subject, options, out, as_json=as_json)
