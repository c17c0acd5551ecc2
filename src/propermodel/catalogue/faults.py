"""What can be wrong with the name of a model or scenario."""

from __future__ import annotations

from propermodel.diagnostics import ProperModelError


class CatalogueError(ProperModelError):
    """What was named does not exist, or is no model or scenario."""
