"""The folder that is served: which files a page may name, and whether its Python files may be run."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path as FilePath

from platformdirs import user_data_path

from propermodel.catalogue.named import NAMED_MODELS
from propermodel.diagnostics import nearest
from propermodel.modelling.files import partial_file
from propermodel.studio.faults import StudioError

RUNS = "propermodel-runs"  # where jobs are kept
_SUFFIXES = (".py", ".json")


@dataclass(frozen=True)
class Named:
    """A model or scenario that a page has named: the text for the catalogue, and the file that it is in."""

    text: str
    file: FilePath | None

    @property
    def is_python(self) -> bool:
        """Whether opening it runs a program."""
        return self.file is not None and self.file.suffix == ".py"


class Folder:
    """A folder below which files may be named; nothing else can be reached, by no name and no link."""

    def __init__(self, root: FilePath) -> None:
        self.root = root.resolve(strict=True)

    def file(self, name: str) -> FilePath:
        """The regular file of this name in the folder, links followed.

        Raises:
            StudioError: there is none, or it lies outside the folder.
        """
        try:
            path = (self.root / name).resolve(strict=True)
            is_file = path.is_file()
        except (OSError, ValueError, RuntimeError):  # missing, a null character, a ring of links
            path, is_file = self.root / "missing", False
        # What is outside is refused alike whether it exists or not.
        if _leaves(name) or not path.is_relative_to(self.root):
            raise StudioError.with_status(
                403,
                "studio/outside",
                f"'{name[:200]}' is not inside the folder that is served",
                help=f"name a file below {self.root.name}, with / between folders",
            )
        if not is_file:
            raise StudioError.with_status(
                404, "studio/file", f"the folder has no file '{name[:200]}'", help="check its name, or reload the list"
            )
        return path

    def model(self, text: str) -> Named:
        """The model that a page names as on the command line: a name of the library, or a file in the folder.

        Raises:
            StudioError: it is neither, or lies outside the folder.
        """
        if text in NAMED_MODELS:
            return Named(text, None)
        return self._in_file(text, f"there is no model '{text[:200]}'", NAMED_MODELS)

    def scenario(self, text: str, known: Iterable[str] = ()) -> Named:
        """The scenario that a page names: one of the model's own, or a file in the folder."""
        known = tuple(known)
        if text in known or not text.partition(":")[0].endswith(_SUFFIXES):
            return Named(text, None)
        return self._in_file(text, f"there is no scenario '{text[:200]}'", known)

    def _in_file(self, text: str, missing: str, known: Iterable[str]) -> Named:
        name, mark, member = text.rpartition(":")
        name = name if mark and name.endswith(".py") and member.isidentifier() else text
        if not name.endswith(_SUFFIXES):
            raise StudioError.with_status(
                404,
                "studio/model",
                missing,
                help=nearest(text[:200], known) or "give a name of the library, file.py:Class or a JSON document",
            )
        path = self.file(name)
        if path.suffix not in _SUFFIXES:
            raise StudioError.with_status(404, "studio/file", missing, help="give a file of Python or JSON")
        inside = path.relative_to(self.root).as_posix()
        return Named(f"{inside}:{member}" if name != text else inside, path)


def _leaves(name: str) -> bool:
    """Whether a name is none of a file below: absolute, with a drive, or going up."""
    parts = name.replace("\\", "/").split("/")
    return not name or name.startswith(("/", "\\")) or ".." in parts or ":" in name or "\0" in name


class Trust:
    """In which folders the user has agreed to run Python files; kept with the user, never in the folder."""

    def __init__(self, file: FilePath | None = None) -> None:
        self._file = user_data_path("propermodel") / "trusted_folders.json" if file is None else file

    def covers(self, folder: Folder) -> bool:
        """Whether the user has agreed for this folder."""
        return str(folder.root) in self._folders()

    def add(self, folder: Folder) -> None:
        """Remember that the user has agreed.

        Raises:
            OSError: it cannot be written down.
        """
        folders = self._folders()
        if str(folder.root) in folders:
            return
        self._file.parent.mkdir(parents=True, exist_ok=True)
        partial = partial_file(self._file)
        partial.write_text(json.dumps([*folders, str(folder.root)], indent=2) + "\n", encoding="utf-8")
        partial.replace(self._file)

    def check(self, folder: Folder, *named: Named) -> None:
        """Refuse to run what the user has not agreed to.

        Raises:
            StudioError: one of these is a program, and the folder is not trusted.
        """
        programs = [item for item in named if item.is_python]
        if programs and not self.covers(folder):
            raise StudioError.with_status(
                403,
                "studio/untrusted",
                f"opening '{programs[0].text}' runs it as a program on this machine",
                help="agree once for this folder, if you know who wrote its Python files",
            )

    def _folders(self) -> list[str]:
        try:
            found = json.loads(self._file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return []  # nobody has agreed to anything
        return [item for item in found if isinstance(item, str)] if isinstance(found, list) else []
