"""The models in a folder, found by reading: no Python file is run, and of documents only the beginning is read."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path as FilePath

from propermodel.catalogue.named import NAMED_MODELS
from propermodel.modelling.documents import MODEL_FORMAT, SCENARIO_FORMAT
from propermodel.studio.folder import RUNS

MOST_FILES = 400
MOST_FOLDERS = 2000
_MOST_BYTES = 2**20  # of a Python file
_HEAD_BYTES = 4096  # of a document: its format is written first
_FORMAT = re.compile(rb'"format"\s*:\s*"([\w-]+)"')
_SKIPPED = {RUNS, "node_modules", "__pycache__", "site-packages", "build", "dist"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelEntry:
    """A model that can be opened; `id` is what the command line would take."""

    id: str
    name: str
    kind: str  # library, document or python
    file: str | None
    scenarios: tuple[str, ...]
    note: str


def library_entries() -> list[ModelEntry]:
    """The models that have names."""
    return [
        ModelEntry(
            id=name,
            name=entry.title,
            kind="library",
            file=None,
            scenarios=tuple(entry.scenarios),
            note=entry.description,
        )
        for name, entry in NAMED_MODELS.items()
    ]


class Listing:
    """What a folder holds; a file that has not changed is not read again."""

    def __init__(self, root: FilePath) -> None:
        self._root = root
        self._known: dict[FilePath, tuple[tuple[int, int], _Found]] = {}

    def entries(self) -> list[ModelEntry]:
        """The models, those of the library first."""
        files = {path: self._found(path) for path in _files(self._root)}
        documents = [path.relative_to(self._root).as_posix() for path, found in files.items() if found.is_scenario]
        entries = library_entries()
        for path, found in sorted(files.items()):
            name = path.relative_to(self._root).as_posix()
            if found.is_model:
                entry = ModelEntry(
                    id=name, name=path.stem, kind="document", file=name, scenarios=tuple(documents), note="document"
                )
                entries.append(entry)
            entries.extend(
                ModelEntry(
                    id=f"{name}:{system.name}",
                    name=system.name,
                    kind="python",
                    file=name,
                    scenarios=found.scenarios,
                    note=system.note,
                )
                for system in found.systems
            )
        return entries

    def _found(self, path: FilePath) -> _Found:
        try:
            status = path.stat()
            stamp = (status.st_mtime_ns, status.st_size)
            known = self._known.get(path)
            if known is None or known[0] != stamp:
                known = self._known[path] = (stamp, _look(path, status.st_size))
        except OSError:  # gone since it was listed, or not ours to read
            return _Found()
        return known[1]


@dataclass(frozen=True, slots=True)
class _System:
    name: str
    note: str


@dataclass(frozen=True, slots=True)
class _Found:
    """What one file holds."""

    systems: tuple[_System, ...] = ()
    scenarios: tuple[str, ...] = ()
    is_model: bool = False
    is_scenario: bool = False


def _files(root: FilePath) -> Iterator[FilePath]:
    """Python files and documents below a folder, no links followed, up to a number."""
    count = 0
    for number, (folder, inner, names) in enumerate(os.walk(root)):
        if number > MOST_FOLDERS:
            return
        inner[:] = sorted(
            name
            for name in inner
            if not name.startswith(".")
            and name not in _SKIPPED
            and not (FilePath(folder) / name / "pyvenv.cfg").exists()
        )
        for name in sorted(names):
            path = FilePath(folder) / name
            if name.endswith((".py", ".json")) and not name.startswith(".") and not path.is_symlink():
                count += 1
                if count > MOST_FILES:
                    return
                yield path


def _look(path: FilePath, size: int) -> _Found:
    if path.suffix == ".json":
        with path.open("rb") as stream:
            formats = _FORMAT.search(stream.read(_HEAD_BYTES))
        name = formats[1].decode() if formats else ""
        return _Found(is_model=name == MODEL_FORMAT, is_scenario=name == SCENARIO_FORMAT)
    if size > _MOST_BYTES:
        return _Found()
    try:
        tree = ast.parse(path.read_bytes())
        return _systems_in(tree) if _uses_package(tree) else _Found()
    except (SyntaxError, ValueError, RecursionError, MemoryError):  # no Python, or made to break its parser
        return _Found()


def _uses_package(tree: ast.Module) -> bool:
    return any(
        (isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "propermodel")
        or (isinstance(node, ast.Import) and any(n.name.partition(".")[0] == "propermodel" for n in node.names))
        for node in tree.body
    )


def _systems_in(tree: ast.Module) -> _Found:
    """Classes that are wired of parts and are no part of another one, models by name, and scenarios."""
    wired: dict[str, ast.ClassDef] = {}
    used: set[str] = set()
    systems: list[_System] = []
    scenarios: list[str] = []
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            if any("connections" in _targets(item) for item in node.body):
                wired[node.name] = node
            used.update(name for item in node.body for name in _called(item))
        elif isinstance(node, ast.FunctionDef) and _gives_scenario(node):
            scenarios.append(node.name)
        for name in _targets(node):
            if name == "model":
                systems.append(_System(name, "model as plain data"))
            elif isinstance(node, ast.Assign | ast.AnnAssign) and _is_scenario(node.value):
                scenarios.append(name)
    systems.extend(_System(name, _first_line(node)) for name, node in wired.items() if name not in used)
    return _Found(systems=tuple(systems), scenarios=tuple(scenarios))


def _targets(node: ast.stmt) -> list[str]:
    """The names that a statement gives a value."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


def _called(node: ast.stmt) -> Iterator[str]:
    for inner in ast.walk(node):
        if isinstance(inner, ast.Call) and isinstance(inner.func, ast.Name):
            yield inner.func.id


def _gives_scenario(node: ast.FunctionDef) -> bool:
    gives = node.returns
    name = gives.value if isinstance(gives, ast.Constant) else ast.unparse(gives) if gives is not None else ""
    needs = len(node.args.args) + len(node.args.posonlyargs) - len(node.args.defaults)
    return isinstance(name, str) and name.rpartition(".")[2] == "Scenario" and needs <= 0


def _is_scenario(value: ast.expr | None) -> bool:
    return isinstance(value, ast.Call) and ast.unparse(value.func).rpartition(".")[2] == "Scenario"


def _first_line(node: ast.ClassDef) -> str:
    return (ast.get_docstring(node) or "").partition("\n")[0]
