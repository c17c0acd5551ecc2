"""Trajectories as files: arrays of NumPy with a JSON header that holds the model and the scenario.

The file is an `.npz` archive, read without pickles: `header` (JSON in UTF-8), `time`, `columns`, `integral_times`,
`integrals` and `activities`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from propermodel.codegen.machine import FloatArray, Method
from propermodel.diagnostics import DocumentError, Path, ProperModelError, one_of
from propermodel.expressions.core import Expr
from propermodel.modelling.documents import SharedEntries, opened
from propermodel.modelling.files import FileName, check_size, of_file, open_file, partial_file
from propermodel.modelling.json_text import parse_json
from propermodel.modelling.limits import LIMITS, Limits
from propermodel.modelling.model import Model, Scenario
from propermodel.modelling.schema import Place, malformed
from propermodel.simulation.archives import read_arrays
from propermodel.simulation.trajectory import (
    Ending,
    EventRecord,
    Statistics,
    TableUse,
    Trajectory,
    observable_path,
)
from propermodel.simulation.trajectory_format import HEADER, Header

FORMAT = "propermodel-trajectory"
VERSION = 1

_ARRAYS = ("time", "columns", "integral_times", "integrals", "activities")


@dataclass(frozen=True, eq=False, kw_only=True)
class StoredTrajectory:
    """A run read from a file: `stored[observable]` is a column over `time`, as in the run that was saved."""

    model: Model
    scenario: Scenario
    method: Method
    step: float
    jacobian_every: int
    time: FloatArray
    units: Mapping[Path, str]
    integral_times: FloatArray
    ending: Ending
    statistics: Statistics
    events: tuple[EventRecord, ...]
    notes: tuple[str, ...]
    outside_tables: tuple[TableUse, ...]
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
    file: FileName,
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
    header = Header(
        method=trajectory.method,
        step=trajectory.step,
        jacobian_every=trajectory.jacobian_every,
        ending=trajectory.ending,
        statistics=trajectory.statistics,
        events=trajectory.events,
        notes=trajectory.notes,
        outside_tables=trajectory.outside_tables,
        columns=tuple((path, trajectory.unit(path), place[trajectory.recorded[known[path].index]]) for path in chosen),
        powers=tuple((power.kind, power.path) for power in trajectory.compiled.lowered.powers),
        scenario=trajectory.scenario,
        model=trajectory.compiled.model,
    )
    document = {"format": FORMAT, "version": VERSION, **HEADER.write(header, SharedEntries())}
    text = json.dumps(document, allow_nan=False).encode()
    partial = partial_file(file)
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
    partial.replace(file)


def _columns_of(observables: Iterable[Expr | Path | str], known: Container[Path]) -> tuple[Path, ...]:
    """The columns that observables need: a power is made of effort and flow."""
    found: dict[Path, None] = {}
    for path in map(observable_path, observables):
        if path.name == "power" and path not in known:
            found |= {path.parent / "effort": None, path.parent / "flow": None}
        else:
            found[path] = None
    return tuple(found)


def load_trajectory(file: FileName, *, limits: Limits = LIMITS) -> StoredTrajectory:
    """The run that a file holds.

    Raises:
        DocumentError: the file cannot be read, is no trajectory of this version, or goes beyond a limit.
    """
    try:
        with open_file(file) as stream:
            check_size(os.fstat(stream.fileno()).st_size, limits.trajectory_bytes, "trajectory_bytes")
            arrays = dict(read_arrays(stream, ("header", *_ARRAYS), limits.trajectory_bytes))
        document = parse_json(arrays.pop("header").tobytes(), limits)
        top = Place("", SharedEntries(limits))
        return _stored(HEADER.read(opened(document, FORMAT, top), top), cast("Mapping[str, FloatArray]", arrays))
    except ProperModelError as error:
        raise of_file(error, file) from error


def _stored(header: Header, arrays: Mapping[str, FloatArray]) -> StoredTrajectory:
    times, marks = len(arrays["time"]), len(arrays["integral_times"])
    width = 1 + max((column for _, _, column in header.columns), default=-1)
    expected = {
        "time": (times,),
        "columns": (times, width),
        "integral_times": (marks,),
        "integrals": (marks, len(header.powers)),
        "activities": (marks, len(header.powers)),
    }
    for name, shape in expected.items():
        if arrays[name].shape != shape or arrays[name].dtype != np.float64:
            raise malformed(name, f"expected an array of {shape} numbers, found one of {arrays[name].shape}")
    return StoredTrajectory(
        model=header.model,
        scenario=header.scenario,
        method=header.method,
        step=header.step,
        jacobian_every=header.jacobian_every,
        time=arrays["time"],
        units={path: unit for path, unit, _ in header.columns},
        integral_times=arrays["integral_times"],
        ending=header.ending,
        statistics=header.statistics,
        events=header.events,
        notes=header.notes,
        outside_tables=header.outside_tables,
        _columns=arrays["columns"],
        _entries={path: column for path, _, column in header.columns},
        _integrals=arrays["integrals"],
        _activities=arrays["activities"],
        _powers={path: index for index, (kind, path) in enumerate(header.powers) if kind != "outside"},
    )
