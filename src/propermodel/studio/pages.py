"""The page and what it loads: files of the package, each by its own name."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable

from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from propermodel.studio.faults import StudioError

_INDEX = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>propermodel studio</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/assets/studio.css">
</head>
<body>
<noscript>The studio draws models and runs in this page, and needs scripts; it loads nothing from elsewhere.</noscript>
<div id="app"></div>
<script defer src="/assets/studio.js"></script>
</body>
</html>
"""


def _assets() -> dict[str, tuple[Traversable, str]]:
    """What can be loaded, with its type."""
    studio = resources.files("propermodel.studio") / "assets"
    drawing = resources.files("propermodel.drawing") / "assets"
    script, style = "text/javascript; charset=utf-8", "text/css; charset=utf-8"
    return {
        "studio.js": (studio / "studio.js", script),
        "studio.css": (studio / "studio.css", style),
        "elk-worker.min.js": (drawing / "elk-worker.min.js", script),
    }


async def index(_: Request) -> Response:
    """The page."""
    return HTMLResponse(_INDEX)


async def asset(request: Request) -> Response:
    """A file that the page loads."""
    found = _assets().get(request.path_params["name"])
    if found is None or not found[0].is_file():
        raise StudioError.with_status(
            404, "studio/page", f"there is no '{request.url.path[:200]}' here", help="open the page of the studio, /"
        )
    return Response(found[0].read_bytes(), media_type=found[1], headers={"Cache-Control": "no-cache"})
