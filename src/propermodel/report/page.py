"""The page of a reduction: one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import gzip
import html
import json
from importlib import resources
from pathlib import Path as FilePath
from typing import Any

from propermodel.report.plain import finite

Json = Any

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<noscript>This report draws itself, and needs scripts; it loads nothing from elsewhere.</noscript>
<div id="app"></div>
<script type="application/json" id="data">{data}</script>
<!-- What places the graph: ELK (elkjs, EPL-2.0, https://github.com/kieler/elkjs), unmodified and compressed. -->
<script type="text/plain" id="elk">{elk}</script>
<script>{script}</script>
</body>
</html>
"""
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' blob:; worker-src blob:; style-src 'unsafe-inline'; img-src data:"
)


def write_page(data: Json, file: FilePath) -> None:
    """Write a page with this data as one HTML file."""
    file.write_text(page_text(data), encoding="utf-8")


def page_text(data: Json) -> str:
    """The HTML of a page with this data, as the front end reads it."""
    report = resources.files("propermodel.report") / "assets"
    elk = (resources.files("propermodel.drawing") / "assets" / "elk-worker.min.js").read_bytes()
    # A "<" could end the element that holds the data.
    text = json.dumps(finite(data), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return _PAGE.format(
        policy=_POLICY,
        title=html.escape(f"{data['model']}: {data['scenario']}"),
        style=(report / "report.css").read_text(encoding="utf-8"),
        data=text,
        elk=base64.b64encode(gzip.compress(elk, mtime=0)).decode("ascii"),
        script=(report / "report.js").read_text(encoding="utf-8"),
    )
