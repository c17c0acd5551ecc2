"""`propermodel rank FILE --map MAP`: activity from efforts and flows that another tool has recorded."""

from __future__ import annotations

import tomllib
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from propermodel.diagnostics import ReductionError

if TYPE_CHECKING:
    from propermodel.analysis.ranking import ActivityRanking
    from propermodel.analysis.windows import Windows


def rank_file(recording: str, map_file: FilePath, windows: Windows | None) -> ActivityRanking:
    """The ranking of a recording whose columns a map gives to elements.

    Raises:
        ReductionError: the map or the recording cannot be read, or they do not fit.
    """
    from propermodel.analysis.recorded import RecordedElement, rank_recorded

    read = _read_map(map_file)
    units = read.get("units", {})
    elements: dict[str, RecordedElement] = {}
    for path, given in read["elements"].items():
        try:
            pairs = given["ports"] if "ports" in given else [[given["effort"], given["flow"]]]
            ports = tuple((str(effort), str(flow)) for effort, flow in pairs)
        except (KeyError, TypeError, ValueError):
            raise _fault(map_file, f"elements.{path} does not name its columns") from None
        used = tuple((name, str(units[name])) for port in ports for name in port if name in units)
        elements[path] = RecordedElement(ports=ports, kind=str(given.get("kind", "")), units=used)
    time, name = str(read.get("time", "time_s")), str(read.get("name", FilePath(recording).stem))
    return rank_recorded(recording, elements, time=time, windows=windows, name=name)


def _read_map(file: FilePath) -> dict[str, Any]:
    try:
        read = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise _fault(file, str(error).splitlines()[0]) from error
    if not isinstance(read.get("elements"), dict) or not isinstance(read.get("units", {}), dict):
        raise _fault(file, "it has no table of elements")
    return read


def _fault(file: FilePath, message: str) -> ReductionError:
    return ReductionError.of(
        "activity/map",
        f"'{file}' is no map of elements: {message}",
        help='write for each: [elements."front.spring"], effort = "force", flow = "speed"',
    )
