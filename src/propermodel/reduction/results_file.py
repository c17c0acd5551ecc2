"""What runs of candidates came to, kept in a file, so that a search goes on where it stopped and others share results.

The first line says what model, scenarios, outputs and steps the results belong to; every further line is one run,
written when it is done. A line that a crash has cut short is dropped; a file of something else, or a broken one, is
refused.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path as FilePath
from threading import Lock
from typing import Any, cast

from propermodel.analysis.comparison import Comparison, Feature, OutputError
from propermodel.analysis.features import Peak, SignalFeatures, Undefined
from propermodel.diagnostics import Path, ReductionError, parse_path
from propermodel.modelling.documents import to_document, to_scenario_document
from propermodel.modelling.files import FileName
from propermodel.modelling.model import ConstantEffort, ConstantFlow, Freeze, Model, Removal
from propermodel.reduction.claim import Condition
from propermodel.reduction.watched_run import WatchedRun
from propermodel.simulation.stepping import Stepping

FORMAT, VERSION = "propermodel-search", 1


class KnownRuns:
    """Runs of candidates by what was removed and the number of the scenario; with a file they outlive the process."""

    def __init__(self, file: FilePath | None = None, runs: Mapping[tuple[str, int], WatchedRun] | None = None) -> None:
        self._file = file
        self._runs = dict(runs or {})
        self._writing = Lock()

    @classmethod
    def opened(cls, name: FileName, identity: str) -> KnownRuns:
        """The runs that a file holds; a new file where there is none.

        Raises:
            ReductionError: it holds something else, or is broken.
        """
        file = FilePath(name)
        if not file.exists():
            head = {"format": FORMAT, "version": VERSION, "identity": identity}
            file.write_text(json.dumps(head) + "\n", encoding="utf-8")
            return cls(file)
        text = file.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]
        lines = whole.splitlines()
        try:
            head = json.loads(lines[0])
            found = (head["format"], head["version"], head["identity"])
            runs = dict(map(_read_line, lines[1:]))
        except (IndexError, KeyError, TypeError, ValueError, AttributeError) as error:
            raise _refusal(file, f"is no file of a search, or is broken ({type(error).__name__})") from error
        if found != (FORMAT, VERSION, identity):
            raise _refusal(file, "belongs to another model, other scenarios, outputs or steps, or another release")
        if len(whole) < len(text):
            file.write_text(whole, encoding="utf-8")  # what a crash has cut short
        return cls(file, runs)

    def find(self, removals: Iterable[Removal], scenario: int) -> WatchedRun | None:
        """What a run came to; None if it is not known."""
        return self._runs.get((key_of(removals), scenario))

    def keep(self, removals: Iterable[Removal], scenario: int, run: WatchedRun) -> None:
        """Remember a run, and write it at once."""
        key = key_of(removals)
        with self._writing:
            self._runs[key, scenario] = run
            if self._file is not None:
                with self._file.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps({"removals": key, "scenario": scenario, **_run_data(run)}) + "\n")
                    stream.flush()
                    os.fsync(stream.fileno())


def identity_of(model: Model, conditions: Iterable[Condition], outputs: Iterable[Path], stepping: Stepping) -> str:
    """What results of a search depend on, as one digest; tolerances are not part of it."""
    parts = [
        to_document(model),
        *([to_scenario_document(c.scenario), c.record_every, c.integrals_every] for c in conditions),
        sorted(map(str, outputs)),
        [str(stepping.method), stepping.step, stepping.jacobian_every, stepping.tolerance],
    ]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def key_of(removals: Iterable[Removal]) -> str:
    """Removals in words, in one order."""
    return "; ".join(sorted(map(_words, removals)))


def _words(removal: Removal) -> str:
    place = removal.signal if isinstance(removal, Freeze) else removal.bond
    value = f" {removal.value!r}" if isinstance(removal, ConstantEffort | ConstantFlow | Freeze) else ""
    return f"{type(removal).__name__} {place}{value}"


def _refusal(file: FilePath, why: str) -> ReductionError:
    return ReductionError.of(
        "reduction/results-file",
        f"'{file.as_posix()}' {why}",
        help="name another file, or remove this one to begin anew",
    )


def _run_data(run: WatchedRun) -> dict[str, Any]:
    return {
        "failure": run.failure,
        "time": run.time,
        "wall_s": run.wall_s,
        "outputs": None if run.comparison is None else [_output_data(output) for output in run.comparison.outputs],
        "reached": {
            str(path): {feature.value: value for feature, value in reached.items()}
            for path, reached in run.reached.items()
        },
    }


def _read_line(line: str) -> tuple[tuple[str, int], WatchedRun]:
    data = json.loads(line)
    outputs = data["outputs"]
    run = WatchedRun(
        failure=str(data["failure"]),
        time=float(data["time"]),
        wall_s=float(data["wall_s"]),
        comparison=None if outputs is None else Comparison(tuple(map(_read_output, outputs))),
        reached={
            parse_path(path): {Feature(feature): float(value) for feature, value in reached.items()}
            for path, reached in data["reached"].items()
        },
    )
    return (str(data["removals"]), int(data["scenario"])), run


_NUMBERS = tuple(
    field.name for field in fields(OutputError) if field.name not in ("path", "unit", "reference", "other")
)


def _output_data(output: OutputError) -> dict[str, Any]:
    numbers = {name: getattr(output, name) for name in _NUMBERS}
    features = {name: _features_data(getattr(output, name)) for name in ("reference", "other")}
    return {"path": str(output.path), "unit": output.unit, **numbers, **features}


def _read_output(data: Mapping[str, Any]) -> OutputError:
    numbers = {name: float(data[name]) for name in _NUMBERS}
    features = {name: _read_features(data[name]) for name in ("reference", "other")}
    return OutputError(
        path=parse_path(data["path"]), unit=str(data["unit"]), **cast("dict[str, Any]", numbers | features)
    )


def _features_data(features: SignalFeatures) -> dict[str, Any]:
    found: dict[str, Any] = {"final": features.final}
    for name in ("peak", "rise", "settling"):
        match getattr(features, name):
            case Undefined(why):
                found[name] = {"why": why}
            case Peak(value, after):
                found[name] = {"value": value, "after": after}
            case number:
                found[name] = number
    return found


def _read_features(data: Mapping[str, Any]) -> SignalFeatures:
    def number(item: Any) -> float | Undefined:
        return Undefined(str(item["why"])) if isinstance(item, dict) else float(item)

    peak = data["peak"]
    return SignalFeatures(
        final=float(data["final"]),
        peak=Undefined(str(peak["why"])) if "why" in peak else Peak(float(peak["value"]), float(peak["after"])),
        rise=number(data["rise"]),
        settling=number(data["settling"]),
    )
