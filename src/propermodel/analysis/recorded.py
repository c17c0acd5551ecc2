"""Activity from efforts and flows that were recorded elsewhere: samples of any tool, ranked as runs are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from propermodel.analysis.activity import IDLE_BELOW
from propermodel.analysis.ranking import (
    ActivityRanking,
    RankedPart,
    RowContent,
    discretisation_of,
    index_changes,
    ranked_rows,
)
from propermodel.analysis.recorded_files import Columns, read_columns
from propermodel.analysis.windows import Window, Windows, windows_of
from propermodel.codegen.machine import FloatArray
from propermodel.diagnostics import Diagnostic, Faults, Path, ReductionError, one_of, parse_path
from propermodel.expressions.dimensions import product
from propermodel.expressions.units import parse_unit
from propermodel.modelling.files import FileName

COARSE = 0.05  # relative change of an activity from which samples are called too far apart


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedElement:
    """An element whose efforts and flows were recorded: the names of two columns for each of its ports.

    Power counts into the element at all ports, or out of it at all. Units stand in the names of columns
    (`force [kN]`), in the attributes of a netCDF file, or in `units`; without any, numbers are in SI.
    """

    ports: tuple[tuple[str, str], ...]  # effort, flow
    kind: str = ""
    units: tuple[tuple[str, str], ...] = ()  # column, unit


def rank_recorded(
    recording: FileName | Mapping[str, FloatArray],
    elements: Mapping[str, RecordedElement],
    *,
    time: str = "time_s",
    windows: Windows | None = None,
    idle_below: float = IDLE_BELOW,
    name: str = "recorded",
) -> ActivityRanking:
    """Rank elements by the efforts and flows that another tool has recorded.

    Efforts and flows are taken to be linear between samples, and the absolute value of their product is then integrated
    exactly. The same with every second sample tells by how much each index depends on the sampling. Oscillations that
    are faster than half the rate of the samples leave no trace in them, nor in this check.

    Args:
        recording: A CSV, Parquet (extra `parquet`) or netCDF (extra `data`) file, or columns by name.
        elements: What is ranked, by path.
        time: The column of time, s unless its name says another unit.
        windows: Windows that are ranked by themselves, as in `rank_activity`.
        idle_below: As in `rank_activity`.
        name: What the ranking calls the recording.

    Raises:
        ReductionError: the file cannot be read, columns are missing or no numbers, a product is no power, time does not
            grow, or nothing is active.
    """
    columns = Columns.of(recording) if isinstance(recording, Mapping) else read_columns(recording)
    samples = _samples(columns, elements, time)
    begin, end = float(samples.time[0]), float(samples.time[-1])
    half = samples.every_second()

    def part(part_name: str, window: Window, floor: float) -> tuple[RankedPart, dict[Path, float]]:
        activities, coarse = samples.activities(window), half.activities(window)
        return RankedPart(
            name=part_name,
            scenario=name,
            window=window,
            activities=activities,
            changes=index_changes(activities, coarse),
            is_idle=not sum(activities.values()) > floor * (window[1] - window[0]),
        ), coarse

    whole, coarse = part(name, (begin, end), 0.0)
    if whole.is_idle:
        raise ReductionError.of(
            "activity/none",
            f"nothing is active in scenario '{name}': no element exchanges energy",
            help="look at the columns that elements name: one factor of every power is zero",
        )
    floor = idle_below * whole.total / (end - begin)
    found = () if windows is None else windows_of(windows, begin, end)
    parts = tuple(part(f"{name}, {a:g} to {b:g} s", (a, b), floor)[0] for a, b in found)
    total_change = sum(coarse.values()) / whole.total - 1.0
    return ActivityRanking(
        rows=ranked_rows(samples.contents(elements), whole.activities, whole.changes, parts),
        total=whole.total,
        window=(begin, end),
        scenario=name,
        datums=("recorded efforts and flows: those of the tool that recorded them",),
        discretisation=discretisation_of("with every second sample only", whole.changes, parts, total_change),
        parts=parts,
        notes=_notes(whole.activities, coarse, parts),
    )


def _notes(
    activities: Mapping[Path, float], coarse: Mapping[Path, float], parts: Sequence[RankedPart]
) -> tuple[str, ...]:
    notes = [
        f"the samples are too far apart for {path}: with every second one its activity changes by {change:.0%}"
        for path, activity in activities.items()
        if activity > 0.0 and (change := abs(coarse[path] / activity - 1.0)) > COARSE
    ]
    idle = [part.name for part in parts if part.is_idle]
    return (*notes, *([f"idle: {'; '.join(idle)}"] if idle else []))


# -- samples -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Samples:
    """Efforts and flows of all ports over time, in SI."""

    time: FloatArray
    ports: Mapping[Path, tuple[tuple[FloatArray, FloatArray], ...]]

    def every_second(self) -> _Samples:
        """Half of the samples; the last stays."""
        chosen = np.unique(np.append(np.arange(0, len(self.time), 2), len(self.time) - 1))
        ports = {path: tuple((e[chosen], f[chosen]) for e, f in pairs) for path, pairs in self.ports.items()}
        return _Samples(self.time[chosen], ports)

    def activities(self, window: Window) -> dict[Path, float]:
        """The activity of each element, its ports together, J."""
        return {path: self._activity(pairs, window) for path, pairs in self.ports.items()}

    def contents(self, elements: Mapping[str, RecordedElement]) -> list[RowContent]:
        """What each row is; ports are numbered where an element has several."""
        window = float(self.time[0]), float(self.time[-1])
        found: list[RowContent] = []
        for text, element in elements.items():
            path = parse_path(text)
            pairs = self.ports[path]
            names = [path] if len(pairs) == 1 else [path / f"port{number}" for number in range(1, len(pairs) + 1)]
            ports = tuple((n, self._activity([pair], window)) for n, pair in zip(names, pairs, strict=True))
            found.append(RowContent(path=path, kind=element.kind, elements=(path,), ports=ports))
        return found

    def _activity(self, pairs: Sequence[tuple[FloatArray, FloatArray]], window: Window) -> float:
        inside = self.time[(self.time > window[0]) & (self.time < window[1])]
        time = np.concatenate(([window[0]], inside, [window[1]]))
        constant, linear, square = np.zeros((3, len(time) - 1))
        for recorded_effort, recorded_flow in pairs:
            effort, flow = (np.interp(time, self.time, values) for values in (recorded_effort, recorded_flow))
            constant += effort[:-1] * flow[:-1]
            linear += effort[:-1] * np.diff(flow) + flow[:-1] * np.diff(effort)
            square += np.diff(effort) * np.diff(flow)
        return float(np.sum(absolute_integral(constant, linear, square) * np.diff(time)))


def absolute_integral(constant: FloatArray, linear: FloatArray, square: FloatArray) -> FloatArray:
    """The integrals of |constant + linear s + square s^2| for s from 0 to 1."""
    inner = linear**2 - 4.0 * constant * square
    middle = -0.5 * (linear + np.copysign(np.sqrt(np.maximum(inner, 0.0)), linear))
    with np.errstate(all="ignore"):
        roots = np.stack([middle / square, constant / middle])
    # Without roots inside, the interval is one piece.
    roots = np.where(np.isfinite(roots) & (inner > 0.0), np.clip(roots, 0.0, 1.0), 0.0)
    edges = np.concatenate([np.zeros((1, len(constant))), np.sort(roots, axis=0), np.ones((1, len(constant)))])
    until = edges * (constant + edges * (linear / 2.0 + edges * square / 3.0))
    return np.sum(np.abs(np.diff(until, axis=0)), axis=0)


# -- from columns to samples -------------------------------------------------------------------------------


def _samples(columns: Columns, elements: Mapping[str, RecordedElement], time: str) -> _Samples:
    faults = Faults(ReductionError)
    if not elements:
        faults.add(_fault("no element is named", "name elements with their columns of effort and flow"))
    instants = _column(columns, time, "", faults, "s")
    ports: dict[Path, tuple[tuple[FloatArray, FloatArray], ...]] = {}
    for text, element in elements.items():
        given = dict(element.units)
        pairs: list[tuple[FloatArray, FloatArray]] = []
        for effort, flow in element.ports:
            pairs.append(
                (_column(columns, effort, text, faults, given=given), _column(columns, flow, text, faults, given=given))
            )
            _check_power(columns, effort, flow, text, faults, given)
        if not pairs:
            faults.add(_fault(f"{text} has no ports", "give the columns of its effort and flow", text))
        ports[parse_path(text)] = tuple(pairs)
    faults.raise_if_any()
    if len(instants) < 3 or not np.all(np.diff(instants) > 0.0):
        raise ReductionError(
            [_fault(f"the column {time} does not grow from sample to sample", "give at least three samples in order")]
        )
    return _Samples(instants, ports)


def _column(
    columns: Columns,
    name: str,
    element: str,
    faults: Faults,
    default: str = "",
    given: Mapping[str, str] | None = None,
) -> FloatArray:
    """A column in SI; what is wrong with it is noted."""
    key = columns.find(name)
    if key is None:
        faults.add(_fault(f"there is no column '{name}'", one_of(name, columns.values), element))
        return np.zeros(0)
    unit = (given or {}).get(name, columns.units[key] or default)
    values = columns.values[key]
    if not np.isfinite(values).all():
        at = int(np.flatnonzero(~np.isfinite(values))[0])
        faults.add(_fault(f"the column '{name}' is no number in row {at + 1}", "fill or cut such rows", element))
    with faults.collecting():
        return values * parse_unit(unit).factor
    return values


def _check_power(
    columns: Columns, effort: str, flow: str, element: str, faults: Faults, given: Mapping[str, str]
) -> None:
    """Effort times flow is power, where both have units."""
    units = [given.get(name, columns.units.get(columns.find(name) or "", "")) for name in (effort, flow)]
    if not all(units):
        return
    with faults.collecting():
        first, second = (parse_unit(unit).dimension for unit in units)
        if product(first, second) != parse_unit("W").dimension:
            message = f"'{effort}' in {units[0]} times '{flow}' in {units[1]} is no power"
            faults.add(_fault(message, "name the column of the effort and that of its own flow", element))


def _fault(message: str, cure: str, where: str = "") -> Diagnostic:
    return Diagnostic("activity/recorded", message, where=where, help=cure)
