"""Where the ports and junctions that a class body wires stand in its model."""

from __future__ import annotations

from typing import Any

from propermodel.diagnostics import Involved, ModelError, Path, Source
from propermodel.modelling.components import Component
from propermodel.modelling.elements import Junction
from propermodel.modelling.ports import Port, VectorPort


def place_of(cls: type[Component], item: Port[Any] | VectorPort | Component, source: Source) -> Path:
    """The path of a port of a component or of one of its direct parts, or of a junction.

    Raises:
        ModelError: it belongs to something else.
    """
    root = item.root
    if isinstance(item, Component) and not isinstance(item, Junction):
        raise ModelError.of(
            "model/bond",
            f"{cls.__name__} bonds the part '{cls.names.get(id(root), type(item).__name__)}', which is not a junction",
            source=source,
            help="name one of its ports",
        )
    name = cls.names.get(id(root))
    if name is None:
        raise ModelError.of(
            "model/foreign-reference",
            f"{cls.__name__} connects a port of something that is not one of its direct parts",
            source=source,
            involved=(Involved(cls.__name__, "is declared here", cls.defined_at),),
            help="connections reach into the ports of direct parts only",
        )
    return Path((name,)) + item.path
