"""Pictures as SVG, without a browser."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from propermodel.diagnostics import Path, one_of, parse_path
from propermodel.drawing.javascript import DrawingError, run_drawing
from propermodel.drawing.picture import Picture

Theme = Literal["light", "dark"]


def to_svg(
    picture: Picture,
    *,
    depth: int = 1,
    open: Iterable[Path | str] = (),
    theme: Theme = "light",
    legend: bool = True,
    signals: bool = True,
) -> str:
    """Draw a picture.

    Args:
        picture: What is drawn.
        depth: How many levels of the hierarchy are open; what is deeper is one box for each group.
        open: Groups that are open beside those, with the groups around them.
        theme: Colours for a light or a dark page.
        legend: Whether the signs are explained below the drawing.
        signals: Whether signals between sensors, controllers and modulated elements are drawn.

    Returns:
        The text of an SVG file, complete in itself.

    Raises:
        DrawingError: a group does not exist, or the JavaScript engine is not installed.
    """
    opened: dict[str, None] = {}
    for group in open:
        path = parse_path(group) if isinstance(group, str) else group
        if path not in picture.groups:
            raise DrawingError.of(
                "drawing/unknown-group",
                f"there is no group '{path}' to open",
                help=one_of(str(path), [str(group) for group in picture.groups if group]),
            )
        opened.update((str(Path(path[:length])), None) for length in range(1, len(path) + 1))
    document = picture.document()
    if not signals:
        document["signals"] = []
    options = {"depth": depth, "open": list(opened), "theme": theme, "legend": legend, "direction": "RIGHT"}
    return run_drawing(document, options)
