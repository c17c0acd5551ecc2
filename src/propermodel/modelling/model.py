"""The model as plain data: what a document holds, a program may build and the studio edits.

A `Part` is a named use of a `Definition` with values for its parameters. Expressions inside a definition use
symbols whose paths are relative to it, so a definition is shared by all its uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from propermodel.diagnostics import NO_SOURCE, Path, Source, parse_path
from propermodel.expressions.core import Expr
from propermodel.modelling.domains import DomainData
from propermodel.presentation import notebook_html


class Variable(StrEnum):
    """The two variables of a bond."""

    EFFORT = "effort"
    FLOW = "flow"

    @property
    def other(self) -> Variable:
        """The conjugate variable."""
        return Variable.FLOW if self is Variable.EFFORT else Variable.EFFORT


class JunctionKind(StrEnum):
    """0-junction (common effort) or 1-junction (common flow)."""

    ZERO = "0"
    ONE = "1"

    @property
    def common(self) -> Variable:
        """The variable that all bonds of the junction share."""
        return Variable.EFFORT if self is JunctionKind.ZERO else Variable.FLOW

    @property
    def dual(self) -> JunctionKind:
        """The other kind."""
        return JunctionKind.ONE if self is JunctionKind.ZERO else JunctionKind.ZERO


class ElementKind(StrEnum):
    """The energetic primitives."""

    RESISTANCE = "R"
    COMPLIANCE = "C"
    INERTIA = "I"
    EFFORT_SOURCE = "Se"
    FLOW_SOURCE = "Sf"
    TRANSFORMER = "TF"
    GYRATOR = "GY"

    @property
    def is_storage(self) -> bool:
        """Whether the element stores energy."""
        return self in (ElementKind.COMPLIANCE, ElementKind.INERTIA)

    @property
    def is_energetic(self) -> bool:
        """Whether the element stores or dissipates, so that it has a row in a ranking."""
        return self.is_storage or self is ElementKind.RESISTANCE


class Preference(StrEnum):
    """The causality that an author prefers for an element, where the model leaves a choice."""

    INTEGRAL = "integral"
    DERIVATIVE = "derivative"
    EFFORT = "effort"  # a resistance that gives its effort
    FLOW = "flow"  # a resistance that gives its flow

    @property
    def is_of_storage(self) -> bool:
        """Whether storage can have this causality."""
        return self in (Preference.INTEGRAL, Preference.DERIVATIVE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """One variable that a law gives."""

    port: str
    variable: Variable
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class ResistanceLaw:
    """One causality of a resistance: what it gives when the other variable of each port is known."""

    results: tuple[Result, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Resistive:
    """A resistance: a law for each causality it can take; while `locked` holds, its flow is held.

    `implicit` holds one expression per port that vanishes, 0 = g(efforts, flows); it serves where no law fits. Only
    what `converts` has ports on both true and pseudo bonds.
    """

    laws: tuple[ResistanceLaw, ...]
    locked: Expr | None = None
    implicit: tuple[Expr, ...] = ()
    converts: bool = False
    preference: Preference | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Coordinate:
    """One state: name, unit, start value and the range that it is meant to stay in."""

    name: str
    unit: str
    start: Expr
    low: Expr
    high: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class Storage:
    """A compliance or inertia in coordinates c: per port what it stores, q or p, and gives, e or f.

    `inverse` gives the coordinate from the port variable (one port only), for dependent storage.
    """

    kind: ElementKind
    coordinates: tuple[Coordinate, ...]
    stored: tuple[tuple[str, Expr], ...]
    outputs: tuple[tuple[str, Expr], ...]
    energy: Expr
    inverse: Expr | None = None
    preference: Preference | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerSource:
    """An effort or flow source with its value."""

    kind: ElementKind
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoPort:
    """Transformer (e_a = m e_b, f_b = m f_a) or gyrator (e_a = r f_b, e_b = r f_a).

    Power enters at a and leaves at b. A transformer of a mechanism knows the `position` whose rate it contributes to:
    the flows at b of all transformers with this position sum up to its rate.
    """

    kind: ElementKind
    modulus: Expr
    position: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Signal processing: outputs and derivatives of continuous states as expressions."""

    outputs: tuple[tuple[str, Expr], ...]
    states: tuple[Coordinate, ...] = ()
    derivatives: tuple[tuple[str, Expr], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampled:
    """A controller: discrete states and outputs (name, unit, start), updated together once a period."""

    period: Expr
    starts: tuple[tuple[str, str, Expr], ...]
    updates: tuple[tuple[str, Expr], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """What happens at the instant at which a condition becomes true: states and discrete values that get new values.

    With a `restitution`, an impulse acts through the port of the element: its flow becomes -restitution * flow.
    """

    condition: Expr
    changes: tuple[tuple[Expr, Expr], ...]  # the symbol of a state or discrete value, its value afterwards
    restitution: Expr | None = None
    source: Source = field(default=NO_SOURCE, compare=False)


Behaviour = Resistive | Storage | PowerSource | TwoPort | JunctionKind | Block | Sampled | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PortData:
    """A power port. `between` names two outer ports when the element acts on their difference."""

    name: str
    domain: str
    between: tuple[str, str] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterData:
    """A parameter: unit, default (an expression of parameters of the same definition), range, provenance."""

    name: str
    unit: str
    default: Expr | None = None
    low: float = float("-inf")
    high: float = float("inf")
    source: str = ""
    status: str = ""
    doc: str = ""


@dataclass(frozen=True, slots=True)
class TableValues:
    """The numbers of a table: one or two strictly growing grids, and the values in row-major order."""

    grids: tuple[tuple[float, ...], ...]
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TableSpec:
    """A table of a definition; its numbers can be exchanged at run time."""

    name: str
    unit: str
    coordinate_units: tuple[str, ...]
    extrapolation: str
    values: TableValues
    source: str = ""


class Direction(StrEnum):
    """Whether a signal port reads or gives."""

    INPUT = "input"
    OUTPUT = "output"


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalData:
    """A signal port."""

    name: str
    unit: str
    direction: Direction


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """Ports joined to one node; its junction follows from the domain."""

    ports: tuple[Path, ...]
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfArrow:
    """A bond from one port or junction to another; power is positive along it."""

    tail: Path
    head: Path
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Activation:
    """An activated bond: it carries one variable from its tail to its head, and takes no power at its tail."""

    tail: Path
    head: Path
    carries: Variable
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalLink:
    """A signal (an expression of observables and signals) that drives inputs or outputs."""

    value: Expr
    targets: tuple[Path, ...]
    source: Source = field(default=NO_SOURCE, compare=False)


class Opening(StrEnum):
    """What an open port of the root means."""

    FREE = "free"  # no effort on a shared-flow domain, no flow on a shared-effort domain
    FLOW = "flow"  # the scenario prescribes the flow
    EFFORT = "effort"  # the scenario prescribes the effort


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenPort:
    """How a port stands open when its component is the root of a model."""

    port: Path
    opening: Opening
    source: Source = field(default=NO_SOURCE, compare=False)


Connection = Node | HalfArrow | Activation | SignalLink | OpenPort


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """What a component class says, as data."""

    type_name: str
    doc: str
    ports: tuple[PortData, ...] = ()
    parameters: tuple[ParameterData, ...] = ()
    tables: tuple[TableSpec, ...] = ()
    signals: tuple[SignalData, ...] = ()
    behaviour: Behaviour = None
    discretes: tuple[tuple[str, str, Expr], ...] = ()  # name, unit and start of what events change and laws read
    events: tuple[Event, ...] = ()
    parts: tuple[Part, ...] = ()
    connections: tuple[Connection, ...] = ()
    is_energy_group: bool = False  # its elements are one row of a ranking
    source: Source = field(default=NO_SOURCE, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A named use of a definition; values are expressions of the surrounding definition's parameters."""

    name: str
    definition: Definition
    values: tuple[tuple[str, Expr], ...] = ()
    tables: tuple[tuple[str, TableValues], ...] = ()
    source: Source = field(default=NO_SOURCE, compare=False)


# Removals. A bond is named by the element's port it ends on.


@dataclass(frozen=True, slots=True)
class ZeroEffort:
    """The bond carries no effort: the term is missing from an effort sum."""

    bond: Path


@dataclass(frozen=True, slots=True)
class ZeroFlow:
    """The bond carries no flow: rigid, clamped, closed."""

    bond: Path


@dataclass(frozen=True, slots=True)
class ConstantEffort:
    """The element at the bond becomes a source of constant effort."""

    bond: Path
    value: float


@dataclass(frozen=True, slots=True)
class ConstantFlow:
    """The element at the bond becomes a source of constant flow."""

    bond: Path
    value: float


@dataclass(frozen=True, slots=True)
class Cut:
    """What the bond leads to no longer acts on the system but is driven by it; `driven` names what it receives.

    At a bond between two junctions, the one that shares this variable drives.
    """

    bond: Path
    driven: Variable


@dataclass(frozen=True, slots=True)
class Prescribe:
    """What the bond leads to is driven by an input of the scenario, `<bond>.<driven>`, such as a recorded variable."""

    bond: Path
    driven: Variable


@dataclass(frozen=True, slots=True)
class Merge:
    """The linear element at the bond is merged into the one at another, with which it shares a variable; exact."""

    bond: Path
    into: Path


@dataclass(frozen=True, slots=True)
class Freeze:
    """The signal keeps a constant value."""

    signal: Path
    value: float


Removal = ZeroEffort | ZeroFlow | ConstantEffort | ConstantFlow | Cut | Prescribe | Merge | Freeze
BondRemoval = ZeroEffort | ZeroFlow | ConstantEffort | ConstantFlow | Cut | Prescribe | Merge


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A complete model: the root with its parameter values, the domains used, and the removals made."""

    name: str
    root: Part
    domains: tuple[DomainData, ...]
    removals: tuple[Removal, ...] = ()

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    def without(self, removals: Iterable[Removal]) -> Model:
        """The model with further removals."""
        return replace(self, removals=(*self.removals, *removals))

    def domain(self, name: str) -> DomainData:
        """The domain of this name."""
        return next(domain for domain in self.domains if domain.name == name)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """Excitation, initial values, parameter values and time window of a run, as plain data.

    `inputs` gives root inputs (and prescribed root ports, `road.flow`) by path: a number, or a table over
    time. `tables` exchanges the numbers of tables by path. `initial` sets the displacement, momentum or
    coordinate of a storage, or the start of a discrete state, by path. `parameters` sets parameters by path,
    in SI.
    """

    name: str = "scenario"
    start: float = 0.0
    stop: float = 1.0
    inputs: Mapping[Path, float | TableValues] = field(default_factory=dict[Path, float | TableValues])
    tables: Mapping[Path, TableValues] = field(default_factory=dict[Path, TableValues])
    initial: Mapping[Path, float] = field(default_factory=dict[Path, float])
    parameters: Mapping[Path, float] = field(default_factory=dict[Path, float])
    description: str = ""

    def __post_init__(self) -> None:
        # Paths may be written as text, `road.flow`.
        for name in ("inputs", "tables", "initial", "parameters"):
            given: Mapping[Path | str, object] = getattr(self, name)
            paths = {parse_path(key) if isinstance(key, str) else key: value for key, value in given.items()}
            object.__setattr__(self, name, paths)
