"""Sensitivities as a readable table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from propermodel.analysis.sensitivities import Sensitivities

MOST_ROWS = 8  # of a ranking whose indices are shown


def sensitivity_table(found: Sensitivities) -> str:
    """The outputs at the end, then the activity indices that change most, with the effect of every parameter."""
    lines = [f"{found.compiled.model.name}, scenario {found.scenario.name}: {found.ending.message}"]
    if found.ending.is_complete:
        lines += _aligned([("at the end", "value", "with respect to", "derivative", "relative"), *_outputs(found)])
        indices = _indices(found)
        if indices:
            lines += _aligned([("activity index", "value", "with respect to", "points per %", "relative"), *indices])
    lines.extend(f"  note: {note}" for note in found.notes)
    return "\n".join(lines)


def _outputs(found: Sensitivities) -> list[tuple[str, ...]]:
    relative = found.relative(found.final)
    rows: list[tuple[str, ...]] = []
    for i, path in enumerate(found.outputs):
        unit = found.output_units[i]
        for k, parameter in enumerate(found.parameters):
            slope = f"{found.final.slopes[i, k]:.5g} {per_unit(unit, found.parameter_units[k])}"
            value = f"{found.final.values[i]:.5g} {unit}".rstrip()
            first = (str(path), value) if k == 0 else ("", "")
            rows.append((*first, str(parameter), slope.rstrip(), _number(float(relative[i, k]))))
    return rows


def _indices(found: Sensitivities) -> list[tuple[str, ...]]:
    """The rows whose index changes most with one percent of a parameter, largest first."""
    indices = found.indices
    if not np.isfinite(indices.slopes).all():
        return []
    points = indices.slopes * found.parameter_values
    relative = found.relative(indices)
    order = sorted(range(len(found.rows)), key=lambda i: (-float(np.abs(points[i]).max()), found.rows[i]))
    rows: list[tuple[str, ...]] = []
    for i in order[:MOST_ROWS]:
        if not points[i].any():
            break
        for k, parameter in enumerate(found.parameters):
            first = (str(found.rows[i]), f"{indices.values[i]:.3%}") if k == 0 else ("", "")
            rows.append((*first, str(parameter), _number(float(points[i, k])), _number(float(relative[i, k]))))
    return rows


def per_unit(unit: str, parameter_unit: str) -> str:
    """The unit of a derivative, `m/s per kg`."""
    return unit if parameter_unit in ("", "1") else f"{unit or '1'} per {parameter_unit}"


def _number(value: float) -> str:
    return f"{round(value, 4) + 0.0:+.4f}" if np.isfinite(value) else "-"


def _aligned(rows: list[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    is_right = (False, True, False, True, True)
    return [
        "  "
        + "  ".join(
            f"{text:>{width}}" if right else f"{text:<{width}}"
            for text, width, right in zip(row, widths, is_right, strict=True)
        ).rstrip()
        for row in rows
    ]
