"""How types of all rooms show themselves in notebooks, without knowing what draws them.

A type says `def _repr_html_(self): return notebook_html(self)`. What it looks like stands in `report.notebook`, far
above; it is found by name when a notebook asks for it, so that no room depends on pictures.
"""

from __future__ import annotations

from importlib import import_module

_DRAWS = "propermodel.report.notebook"


def notebook_html(thing: object) -> str | None:
    """The HTML of a thing; None where there is nothing to add to its text."""
    found: str | None = import_module(_DRAWS).html_of(thing)
    return found
