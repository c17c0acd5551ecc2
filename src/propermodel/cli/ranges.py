"""Ranges of parameters as they are written on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from propermodel.cli.faults import CommandError
from propermodel.diagnostics import Path

if TYPE_CHECKING:
    from collections.abc import Iterable

    from propermodel.catalogue.subject import Subject


def parse_ranges(subject: Subject, texts: Iterable[str]) -> dict[Path, float | tuple[float, float]]:
    """Ranges written `body.mass=10%` or `body.mass=0.9 t..1.5 t`: shares, or least and greatest values in SI.

    Raises:
        CommandError: a text is no range, or names no parameter.
    """
    from propermodel.cli.options import parse_settings

    found: dict[Path, float | tuple[float, float]] = {}
    for text in texts:
        name, _, limits = text.partition("=")
        low, dots, high = limits.partition("..")
        if dots:
            ends = [parse_settings(subject, [f"{name}={end.strip()}"]) for end in (low, high)]
            ((path, least),), ((_, greatest),) = (end.items() for end in ends)
            found[path] = (least, greatest)
        elif limits.strip().endswith("%"):
            (path,) = parse_settings(subject, [f"{name}=0"])
            found[path] = _share(text, limits)
        else:
            raise _no_range(text)
    return found


def _share(text: str, limits: str) -> float:
    try:
        return float(limits.strip().removesuffix("%")) * 0.01
    except ValueError:
        raise _no_range(text) from None


def _no_range(text: str) -> CommandError:
    return CommandError.of(
        "command/range",
        f"'--range {text}' is no range of a parameter",
        help="write --range body.mass=10% to both sides of its value, or its ends: --range body.mass=0.9t..1.5t",
    )
