"""`propermodel report`: the page of a certified model."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer


def report(
    certificate: Annotated[str, typer.Argument(help="A certificate, or the folder of a reduction.", metavar="FILE")],
    output: Annotated[
        FilePath | None,
        typer.Option(
            "-o", "--output", help="The HTML file to write; by default report.html beside it.", metavar="FILE"
        ),
    ] = None,
) -> None:
    """Run a reduced model beside the full one again, and write what there is to know of it as one page."""
    from propermodel.reduction.certificate_files import read_certificate
    from propermodel.report.page import write_page
    from propermodel.report.page_data import page_data, subject_of_certified

    given = FilePath(certificate)
    certified = read_certificate(given)
    page = output or (given if given.is_dir() else given.parent) / "report.html"
    page.parent.mkdir(parents=True, exist_ok=True)
    write_page(page_data(subject_of_certified(certified)), page)
    typer.echo(f"{page.as_posix()}  {page.stat().st_size / 1e6:.1f} MB, needs nothing else")
