"""Certificates in files: `certificate.json` beside the documents of the models and scenarios that it speaks of.

Files are taken only from the folder of the certificate, and only as they were when it was written.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path as FilePath
from typing import Any

from propermodel.diagnostics import DocumentError
from propermodel.modelling.documents import read_model, read_scenario, write_model, write_scenario
from propermodel.modelling.files import FileName, of_file, partial_file, read_bytes
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import LIMITS, Limits
from propermodel.modelling.model import Model, Scenario
from propermodel.reduction.certificate_document import (
    FileBeside,
    FilesBeside,
    from_certificate_document,
    to_certificate_document,
)
from propermodel.reduction.certify import CertifiedModel

FILE = "certificate.json"


def write_certificate(certified: CertifiedModel, folder: FileName) -> FilePath:
    """Write `certificate.json` into a folder, with both models and the scenarios beside it; gives its path."""
    place = FilePath(folder)
    place.mkdir(parents=True, exist_ok=True)
    several = len(certified.scenarios) > 1
    files = FilesBeside(
        full_model=_written(place / "full_model.json", certified.full, write_model),
        reduced_model=_written(place / "reduced_model.json", certified.reduced, write_model),
        scenarios=tuple(
            _written(place / (f"scenario_{number}.json" if several else "scenario.json"), scenario, write_scenario)
            for number, scenario in enumerate(certified.scenarios, 1)
        ),
    )
    path = place / FILE
    partial = partial_file(path)
    text = json.dumps(to_certificate_document(certified.certificate, files), indent=2, allow_nan=False)
    partial.write_text(text + "\n", encoding="utf-8", newline="\n")
    partial.replace(path)
    return path


def read_certificate(
    file: FileName,
    *,
    model: Model | None = None,
    scenarios: Iterable[Scenario] | None = None,
    limits: Limits = LIMITS,
) -> CertifiedModel:
    """The certified model of a file, with the documents beside it.

    Args:
        file: What `write_certificate` has written, or its folder.
        model: The full model, where it is not to be that of the file beside.
        scenarios: The scenarios, likewise.
        limits: What is read at most.

    Raises:
        DocumentError: a file cannot be read, is malformed, goes beyond a limit, or is no longer what it was when the
            certificate was written.
    """
    file = _certificate_at(FilePath(file))
    try:
        certificate, files = from_certificate_document(
            parse_json(read_bytes(file, limits.file_bytes, "file_bytes"), limits), limits=limits
        )
    except DocumentError as error:
        raise of_file(error, file) from error
    folder = file.parent
    if model is None:
        model = read_model(_unchanged(folder, files.full_model, limits), limits=limits)
        reduced = read_model(_unchanged(folder, files.reduced_model, limits), limits=limits)
        if reduced != model.without(certificate.removals):
            raise of_file(_mismatch(files.reduced_model), file)
    given = (
        [read_scenario(_unchanged(folder, beside, limits), limits=limits) for beside in files.scenarios]
        if scenarios is None
        else list(scenarios)
    )
    if len(given) != len(certificate.scenarios):
        raise of_file(
            DocumentError.of(
                "document/content",
                f"the certificate speaks of {len(certificate.scenarios)} scenarios; {len(given)} were given",
                where="scenarios",
                help=f"give them in this order: {', '.join(s.name for s in certificate.scenarios)}",
            ),
            file,
        )
    return CertifiedModel(certificate=certificate, full=model, scenarios=tuple(given))


def _certificate_at(given: FilePath) -> FilePath:
    """The certificate that a path names: itself, or the one in that folder.

    Raises:
        DocumentError: there is none.
    """
    path = given / FILE if given.is_dir() else given
    if not path.exists():
        raise of_file(
            DocumentError.of(
                "document/file",
                f"there is no certificate in '{given.as_posix()}'"
                if given.is_dir()
                else "there is no such certificate",
                help=f"propermodel reduce MODEL --out FOLDER writes a {FILE}: give it, or its folder",
            ),
            path,
        )
    return path


def _written(path: FilePath, value: Any, write: Callable[[Any, FileName], None]) -> FileBeside:
    write(value, path)
    return FileBeside(file=path.name, sha256=hashlib.sha256(path.read_bytes()).hexdigest())


def _unchanged(folder: FilePath, beside: FileBeside, limits: Limits) -> FilePath:
    """A file beside, if it is what it was.

    Raises:
        DocumentError: it cannot be read, or it has changed.
    """
    path = folder / beside.file
    try:
        digest = hashlib.sha256(read_bytes(path, limits.file_bytes, "file_bytes")).hexdigest()
    except DocumentError as error:
        raise of_file(error, path) from error
    if digest != beside.sha256:
        raise of_file(
            DocumentError.of(
                "document/digest",
                f"'{beside.file}' is not the file that was certified: its SHA-256 is another",
                help="put the original file beside the certificate, or name what to verify instead: "
                "propermodel verify certificate.json --model MODEL --scenario SCENARIO",
            ),
            path,
        )
    return path


def _mismatch(beside: FileBeside) -> DocumentError:
    return DocumentError.of(
        "document/content",
        f"'{beside.file}' is not the full model without what the certificate removes",
        where="removals",
        help="certify the reduced model again",
    )
