"""Power ports, and vector ports: several ports and signals that belong together and are wired as one.

With `components`, the only module with descriptors and class hooks.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeVar, overload

from propermodel.diagnostics import ModelError, Path, Source
from propermodel.expressions.core import Expr, SymbolKind
from propermodel.modelling.domains import Domain
from propermodel.modelling.references import call_site, reference, unknown_name

if TYPE_CHECKING:
    from propermodel.modelling.components import Component

D = TypeVar("D", bound=Domain)

_OBSERVABLES = ("effort", "flow", "power", "displacement", "momentum")


class Member:
    """What a vector port may consist of."""

    __slots__ = ()

    def twin(self, *, gives: bool, source: Source) -> Any:
        """One like it for one vector port; what is a signal is given there, or taken."""
        raise NotImplementedError


class Port(Member, Generic[D]):
    """A power port of a component; its `effort`, `flow` and `power` are observables, positive into it."""

    def __init__(self, domain: type[D], *, between: tuple[Port[D], Port[D]] | None = None) -> None:
        self.domain = domain
        self.between = between
        self.root: object = self
        self.path = Path()
        self.source = call_site(1)

    def twin(self, *, gives: bool, source: Source) -> Port[D]:
        """A port of the same domain."""
        port = Port(self.domain)
        port.source = source
        return port

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: Component | VectorPort, owner: type) -> Self: ...
    def __get__(self, instance: Component | VectorPort | None, owner: type) -> Self:
        if instance is None:
            return self
        if isinstance(instance, VectorPort):
            return instance.own(self)
        view = object.__new__(type(self))
        view.domain, view.between, view.source = self.domain, self.between, self.source
        view.root, view.path = instance.root, instance.path / instance.name_of(self)
        return view

    if not TYPE_CHECKING:  # a checker shall see what there is not

        def __getattr__(self, name: str) -> Any:
            raise unknown_name("a power port", name, _OBSERVABLES)

    @property
    def effort(self) -> Expr:
        """The effort at this port."""
        return reference(SymbolKind.EFFORT, self.root, self.path / "effort", self.domain.effort_unit)

    @property
    def flow(self) -> Expr:
        """The flow into this port."""
        return reference(SymbolKind.FLOW, self.root, self.path / "flow", self.domain.flow_unit)

    @property
    def power(self) -> Expr:
        """The power into this port."""
        return reference(SymbolKind.POWER, self.root, self.path / "power", "W" if self.domain.is_true else "")

    @property
    def displacement(self) -> Expr:
        """The displacement of the compliance at this port."""
        unit = self.domain.displacement_unit
        return reference(SymbolKind.DISPLACEMENT, self.root, self.path / "displacement", unit)

    @property
    def momentum(self) -> Expr:
        """The momentum of the inertia at this port."""
        return reference(SymbolKind.MOMENTUM, self.root, self.path / "momentum", self.domain.momentum_unit)


class VectorPort:
    """A port of a vector bond: scalar power ports, and signals beside them, that are wired as one.

    Subclass it and declare its members, a `Port` for each bond and an `Input` for each signal; then declare it in a
    component like any port:

        class Point(VectorPort):
            x = Port(Translation)
            y = Port(Translation)

        class PointMass(Component):
            point = Point()

    `point.x` is a member. In the model, in results and in documents, members are scalar ports of the component,
    `point_x` and `point_y`: a vector bond is another way to write scalar ones. `connect` joins vector ports of equal
    members, member by member. Signals are taken, unless the port is declared by `giving()`: exactly one of the ports
    that are joined gives them to the others.
    """

    templates: ClassVar[Mapping[str, Member]] = {}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        templates: dict[str, Member] = dict(cls.templates)
        for name, value in vars(cls).items():
            if isinstance(value, Member) and name in RESERVED_MEMBERS:
                raise ModelError.of(
                    "model/reserved-name",
                    f"{cls.__name__} calls a member '{name}', as every vector port calls what it needs itself",
                    source=call_site(1),
                    help=f"choose another name, for example '{name}_1'",
                )
            if isinstance(value, Member) and not (isinstance(value, Port) and value.between):
                templates[name] = value
            elif isinstance(value, Expr | Port):
                raise ModelError.of(
                    "model/vector-port",
                    f"{cls.__name__} declares '{name}', which no vector port can have",
                    source=call_site(1),
                    help="a vector port consists of a Port for each bond and an Input for each signal beside them",
                )
        cls.templates = templates

    def __init__(self) -> None:
        self._make(gives=False, source=call_site(1))

    @classmethod
    def giving(cls) -> Self:
        """A vector port that gives the signals that others take."""
        port = object.__new__(cls)
        port._make(gives=True, source=call_site(1))
        return port

    members: Mapping[str, Any]
    gives: bool
    root: object
    path: Path
    source: Source

    def _make(self, *, gives: bool, source: Source) -> None:
        self.root, self.path, self.source, self.gives = self, Path(), source, gives
        self.members = {name: item.twin(gives=gives, source=source) for name, item in self.templates.items()}

    def own(self, template: object) -> Any:
        """The member of this port that its class declares as `template`."""
        return next(self.members[name] for name, item in self.templates.items() if item is template)

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: Component, owner: type) -> Self: ...
    def __get__(self, instance: Component | None, owner: type) -> Self:
        if instance is None:
            return self
        view = object.__new__(type(self))
        view.members = {name: member.__get__(instance, owner) for name, member in self.members.items()}
        view.gives, view.source = self.gives, self.source
        view.root, view.path = instance.root, instance.path / instance.name_of(self)
        return view

    if not TYPE_CHECKING:  # a checker shall see what there is not

        def __getattr__(self, name: str) -> Any:
            raise unknown_name(f"the vector port {type(self).__name__}", name, self.templates)


# What no member of a vector port may be called; dir() also lists the names that instances have.
RESERVED_MEMBERS = frozenset({*dir(VectorPort), *VectorPort.__annotations__})


def member_name(vector: str, member: str) -> str:
    """What the member of a vector port is called as a port or signal of its component."""
    return f"{vector}_{member}"
