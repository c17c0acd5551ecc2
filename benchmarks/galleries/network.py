"""What a system of a gallery is, in terms that favour no program: elements and couplings between nodes.

A node has the quantity that all who meet there share: a velocity in mechanics, a voltage, a pressure. Elements act
between two nodes, or between a node and the ground; their other quantity passes through them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GROUND = ""
INTERVALS = 500  # into which the window of every system is divided


class Kind(StrEnum):
    """The energy elements."""

    RESISTANCE = "R"  # e = value * f
    COMPLIANCE = "C"  # e = value * q, so the value is a stiffness
    INERTIA = "I"  # p = value * f


class Law(StrEnum):
    """How an element bends, x being its flow (a resistance) or displacement (a compliance) and s its `scale`."""

    LINEAR = "linear"  # e = value x
    HARDENING = "hardening"  # e = value x (1 + (x / s)^2)
    SATURATING = "saturating"  # e = value x / (1 + |x| / s)
    FRICTION = "friction"  # e = value s tanh(x / s)
    QUADRATIC = "quadratic"  # e = value x |x| / s


class Field(StrEnum):
    """What flows and pushes."""

    TRANSLATION = "translation"
    ROTATION = "rotation"
    ELECTRICAL = "electrical"
    HYDRAULIC = "hydraulic"

    @property
    def shares_flow(self) -> bool:
        """Whether what meets at a node has the flow in common."""
        return self in (Field.TRANSLATION, Field.ROTATION)


class Half(StrEnum):
    """One of the two factors of power."""

    EFFORT = "effort"
    FLOW = "flow"


@dataclass(frozen=True, slots=True)
class Place:
    """Two nodes of one field, in order."""

    field: Field
    a: str
    b: str = GROUND


@dataclass(frozen=True, slots=True)
class Element:
    """An element that stores or dissipates."""

    name: str
    kind: Kind
    place: Place
    value: float
    law: Law = Law.LINEAR
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class Coupling:
    """A transformer (e_1 = m e_2, f_2 = m f_1) or gyrator (e_1 = m f_2, e_2 = m f_1); power passes from 1 to 2."""

    name: str
    first: Place
    second: Place
    modulus: float
    is_gyrator: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """What is imposed at a node: one value for all time, or values at the ends of all intervals.

    At a node that shares the imposed quantity the node has it; otherwise it acts into the node.
    """

    name: str
    node: str
    half: Half
    values: FloatArray | float


@dataclass(frozen=True, slots=True)
class Output:
    """The effort or flow of an element."""

    element: str
    half: Half


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """A system, what is done to it, and what is asked of it; it begins in equilibrium with its constant drives."""

    name: str
    family: str
    elements: tuple[Element, ...]
    couplings: tuple[Coupling, ...] = ()
    drives: tuple[Drive, ...]
    outputs: tuple[Output, ...]
    stop: float  # s

    @property
    def is_biased(self) -> bool:
        """Whether something acts on it all the time."""
        return any(not isinstance(drive.values, np.ndarray) for drive in self.drives)

    @property
    def nodes(self) -> dict[str, Field]:
        """The field of every node but the ground."""
        places = [element.place for element in self.elements]
        for coupling in self.couplings:
            places += [coupling.first, coupling.second]
        return {node: place.field for place in places for node in (place.a, place.b) if node != GROUND}

    @property
    def instants(self) -> FloatArray:
        """The ends of all intervals, s."""
        return np.linspace(0.0, self.stop, INTERVALS + 1)

    def number(self, name: str) -> int:
        """Where an element stands."""
        return next(number for number, element in enumerate(self.elements) if element.name == name)

    def __iter__(self) -> Iterator[Element]:
        return iter(self.elements)
