"""Columns for pictures: least and greatest value of every interval, so that no peak is lost."""

from __future__ import annotations

import base64

import numpy as np

from propermodel.codegen.machine import FloatArray


def extremes(time: FloatArray, values: FloatArray, edges: FloatArray) -> FloatArray:
    """Two values for each interval between edges, in the order in which they come: its least and its greatest.

    An interval without a row has the interpolated values at its edges.
    """
    count = len(edges) - 1
    firsts = np.searchsorted(time, edges[:-1])
    lasts = np.searchsorted(time, edges[1:], side="right")
    found = np.column_stack([np.interp(edges[:-1], time, values), np.interp(edges[1:], time, values)])
    for number in range(count):
        part = values[firsts[number] : lasts[number]]
        if len(part):
            low, high = int(np.argmin(part)), int(np.argmax(part))
            found[number] = (part[low], part[high]) if low <= high else (part[high], part[low])
    return found.ravel()


def packed(values: FloatArray) -> str:
    """Values as base64 of little-endian float32; what is no finite number becomes NaN, a gap."""
    with np.errstate(over="ignore"):
        narrow = np.asarray(values, dtype="<f4")
    narrow[~np.isfinite(narrow)] = np.nan
    return base64.b64encode(narrow.tobytes()).decode("ascii")


def exactly_packed(values: FloatArray) -> str:
    """Values as base64 of little-endian float64."""
    return base64.b64encode(np.asarray(values, dtype="<f8").tobytes()).decode("ascii")
