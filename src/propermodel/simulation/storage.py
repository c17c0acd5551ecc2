"""Trajectories as files: arrays of NumPy with a JSON header that holds the model and the scenario.

The file is an `.npz` archive, read without pickles: `header` (JSON in UTF-8), `time`, `columns`, `integral_times`,
`integrals` and `activities`.
"""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, cast

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import DocumentError, Path, Source, one_of, portable_file
from propermodel.expressions.core import Expr
from propermodel.modelling.documents import (
    from_document,
    from_scenario_document,
    to_document,
    to_scenario_document,
)
from propermodel.modelling.model import Model, Scenario
from propermodel.simulation.trajectory import Ending, EventRecord, RunStatus, Statistics, Trajectory, observable_path

FORMAT = "propermodel-trajectory"
VERSION = 1
LARGEST_HEADER = 256 * 1024 * 1024  # bytes

_ARRAYS = ("time", "columns", "integral_times", "integrals", "activities")


@dataclass(frozen=True, eq=False, kw_only=True)
class StoredTrajectory:
    """A run read from a file: `stored[observable]` is a column over `time`, as in the run that was saved."""

    model: Model
    scenario: Scenario
    method: str
    step: float
    jacobian_every: int
    time: FloatArray
    units: Mapping[Path, str]
    integral_times: FloatArray
    ending: Ending
    statistics: Statistics
    events: tuple[EventRecord, ...]
    _columns: FloatArray
    _entries: Mapping[Path, int]
    _integrals: FloatArray
    _activities: FloatArray
    _powers: Mapping[Path, int]

    @property
    def paths(self) -> tuple[Path, ...]:
        """Every stored observable."""
        return tuple(self._entries)

    def __contains__(self, observable: Expr | Path | str) -> bool:
        return observable_path(observable) in self._entries

    def __getitem__(self, observable: Expr | Path | str) -> FloatArray:
        """A stored column, by observable, path or text.

        Raises:
            DocumentError: the file holds no such column.
        """
        path = observable_path(observable)
        if path.name == "power" and path not in self._entries:
            return self[path.parent / "effort"] * self[path.parent / "flow"]
        return self._columns[:, self._find(path, self._entries, "observable")]

    def unit(self, observable: Expr | Path | str) -> str:
        """The unit of a stored observable."""
        path = observable_path(observable)
        return self.units.get(path, "W" if path.name == "power" else "")

    def work(self, entry: Path) -> FloatArray:
        """The integral of the power of a bond or row over `integral_times`, J."""
        return self._integrals[:, self._find(entry, self._powers, "bond or row")]

    def activity(self, entry: Path) -> FloatArray:
        """The activity of a bond or row over `integral_times`, J."""
        return self._activities[:, self._find(entry, self._powers, "bond or row")]

    def _find(self, path: Path, known: Mapping[Path, int], what: str) -> int:
        if path not in known:
            raise DocumentError.of(
                "document/column",
                f"the file holds no {what} '{path}'",
                help=one_of(str(path), map(str, known)),
            )
        return known[path]


def save_trajectory(
    trajectory: Trajectory,
    file: str | os.PathLike[str],
    *,
    only: Iterable[Expr | Path | str] | None = None,
) -> None:
    """Write a run to a file.

    Args:
        trajectory: The run, complete or not.
        file: Where to; by convention ending in `.npz`.
        only: The observables to keep; by default all that were recorded.
    """
    known = trajectory.compiled.lowered.observables
    chosen = trajectory.paths if only is None else _columns_of(only, known)
    kept = list(dict.fromkeys(trajectory.recorded[known[path].index] for path in chosen))
    place = {column: position for position, column in enumerate(kept)}
    header = {
        "format": FORMAT,
        "version": VERSION,
        "name": trajectory.compiled.model.name,
        "method": trajectory.method.value,
        "step_s": trajectory.step,
        "jacobian_every": trajectory.jacobian_every,
        "ending": {
            "status": trajectory.ending.status.value,
            "message": trajectory.ending.message,
            "time_s": trajectory.ending.time,
            "path": list(trajectory.ending.path),
        },
        "events": [
            [event.time, list(event.element), _number(event.energy_before), _number(event.energy_after)]
            for event in trajectory.events
        ],
        "statistics": {
            "steps": trajectory.statistics.steps,
            "wall_s": trajectory.statistics.wall_s,
            "build_s": trajectory.statistics.build_s,
        },
        "columns": [
            [list(path), trajectory.unit(path), place[trajectory.recorded[known[path].index]]] for path in chosen
        ],
        "powers": [[p.kind, list(p.path)] for p in trajectory.compiled.lowered.powers],
        "scenario": to_scenario_document(trajectory.scenario),
        "model": to_document(trajectory.compiled.model),
    }
    text = json.dumps(header, allow_nan=False).encode()
    target = FilePath(file)
    partial = target.with_name(f"{target.name}.part")
    with partial.open("wb") as stream:
        np.savez_compressed(
            stream,
            header=np.frombuffer(text, dtype=np.uint8),
            time=trajectory.time,
            columns=trajectory.columns[:, kept],
            integral_times=trajectory.integral_times,
            integrals=trajectory.integrals,
            activities=trajectory.activities,
        )
    partial.replace(target)


def _number(value: float) -> float | str:
    """A number as JSON, also where a failed run has none."""
    return value if math.isfinite(value) else str(value)


def _columns_of(observables: Iterable[Expr | Path | str], known: Container[Path]) -> tuple[Path, ...]:
    """The columns that observables need: a power is made of effort and flow."""
    found: dict[Path, None] = {}
    for path in map(observable_path, observables):
        if path.name == "power" and path not in known:
            found |= {path.parent / "effort": None, path.parent / "flow": None}
        else:
            found[path] = None
    return tuple(found)


def load_trajectory(file: str | os.PathLike[str]) -> StoredTrajectory:
    """The run that a file holds.

    Raises:
        DocumentError: the file cannot be read, or is no trajectory of this version.
    """
    try:
        with np.load(FilePath(file), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in ("header", *_ARRAYS)}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, AttributeError, TypeError) as error:
        raise _refused(file, "document/file", f"the file cannot be read as a trajectory: {error}") from error
    if arrays["header"].nbytes > LARGEST_HEADER:
        raise _refused(file, "document/size", f"its header has {arrays['header'].nbytes} bytes")
    try:
        header = json.loads(arrays.pop("header").tobytes().decode())
        if header["format"] != FORMAT:
            raise _refused(file, "document/format", f"its format is '{header['format']:.60}', not '{FORMAT}'")
        if header["version"] != VERSION:
            raise _refused(
                file,
                "document/version",
                f"its version is {header['version']!r:.20}; version {VERSION} is read",
            )
        return _opened(header, arrays)
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise _refused(file, "document/content", f"its header is damaged: {error}") from error


def _opened(header: dict[str, Any], arrays: Mapping[str, FloatArray]) -> StoredTrajectory:
    rows = [(_path(path), str(unit), int(column)) for path, unit, column in header["columns"]]
    powers = {_path(path): index for index, (kind, path) in enumerate(header["powers"]) if kind != "outside"}
    width = 1 + max((column for _, _, column in rows), default=-1)
    times, marks = len(arrays["time"]), len(arrays["integral_times"])
    expected = {
        "time": (times,),
        "columns": (times, width),
        "integral_times": (marks,),
        "integrals": (marks, len(header["powers"])),
        "activities": (marks, len(header["powers"])),
    }
    for name, shape in expected.items():
        if arrays[name].shape != shape or arrays[name].dtype != np.float64:
            raise ValueError(f"'{name}' is not an array of {shape} numbers")
    if any(column < 0 for _, _, column in rows):
        raise ValueError("a column has a negative number")
    ending, statistics = header["ending"], header["statistics"]
    return StoredTrajectory(
        model=from_document(header["model"]),
        scenario=from_scenario_document(header["scenario"]),
        method=str(header["method"]),
        step=float(header["step_s"]),
        jacobian_every=int(header.get("jacobian_every", 1)),
        time=arrays["time"],
        units={path: unit for path, unit, _ in rows},
        integral_times=arrays["integral_times"],
        ending=Ending(
            RunStatus(ending["status"]),
            str(ending["message"]),
            float(ending["time_s"]),
            _path(ending["path"]),
        ),
        statistics=Statistics(int(statistics["steps"]), float(statistics["wall_s"]), float(statistics["build_s"])),
        events=tuple(
            EventRecord(float(time), _path(path), float(before), float(after))
            for time, path, before, after in header.get("events", [])
        ),
        _columns=arrays["columns"],
        _entries={path: column for path, _, column in rows},
        _integrals=arrays["integrals"],
        _activities=arrays["activities"],
        _powers=powers,
    )


def _path(names: Any) -> Path:
    """A path from its names, which may themselves hold dots."""
    if not isinstance(names, list):
        raise TypeError(f"'{names!r:.60}' is not a list of names")
    return Path(str(name) for name in cast("list[Any]", names))


def _refused(file: str | os.PathLike[str], code: str, message: str) -> DocumentError:
    return DocumentError.of(code, message, source=Source(portable_file(os.fspath(file)), 0))
