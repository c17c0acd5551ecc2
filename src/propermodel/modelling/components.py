"""How a class body becomes a component: with `ports`, the only module with descriptors and class hooks.

The class body is the model. Names are taken from it; ports, parts and parameters are looked up by identity,
so that nothing is named twice.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self, dataclass_transform

from propermodel.diagnostics import Involved, ModelError, Path, Source, one_of
from propermodel.expressions.core import Expr, ExprLike, SymbolKind, as_expr, lookup
from propermodel.expressions.units import parse_unit
from propermodel.modelling.model import TableValues
from propermodel.modelling.ports import Port, VectorPort, member_name
from propermodel.modelling.references import Declared, call_site, unknown_name


class Parameter(Declared):
    """A physical parameter of a component; an expression, so it can be handed to parts and used in laws."""

    __slots__ = ("default", "doc", "high", "low", "origin", "status")

    def __init__(
        self,
        unit: str,
        default: Expr | None,
        low: float,
        high: float,
        origin: str,
        status: str,
        doc: str,
    ) -> None:
        super().__init__(SymbolKind.PARAMETER, unit)
        for name, value in {
            "default": default,
            "low": low,
            "high": high,
            "origin": origin,
            "status": status,
            "doc": doc,
        }.items():
            object.__setattr__(self, name, value)

    def __get__(self, instance: Component | None, owner: type | None = None) -> Parameter:
        if instance is None:
            return self
        return self.view(instance, instance.name_of(self))  # pyright: ignore[reportReturnType]

    def __set__(self, instance: Component, value: ExprLike) -> None:
        raise AttributeError("a component is immutable; make a variant with replace(component, ...)")


def parameter(
    unit: str,
    *,
    default: ExprLike | None = None,
    low: float = float("-inf"),
    high: float = float("inf"),
    source: str = "",
    status: str = "",
    doc: str = "",
) -> Any:
    """Declare a parameter in the body of a component, with its unit and where its value comes from.

    Numbers are in `unit`; a range `low` to `high` is checked when values are given. `status` says how sure
    the value is: published, derived, estimated.
    """
    site = call_site(1)
    try:
        value = None if default is None else in_unit(default, unit)
    except ModelError as error:
        raise ModelError([dataclasses.replace(d, source=site) for d in error.diagnostics]) from None
    return Parameter(unit, value, low, high, source, status, doc)


def in_unit(value: ExprLike, unit: str) -> Expr:
    """A number in `unit` as SI, an expression as it is."""
    if isinstance(value, Expr):
        return value
    return as_expr(float(value) if unit in _SI_ALREADY else float(value) * parse_unit(unit).factor)


_SI_UNITS = "1 m s kg N Pa W J K m/s rad rad/s N.m N/m N.s/m kg.m2 m2 m3 m3/s Hz V A Ohm F H"
_SI_ALREADY = frozenset(_SI_UNITS.split())


class Table(Declared):
    """A table of a component: `self.map(x)` or `self.map(x, y)` in a law is its linear interpolation."""

    __slots__ = ("coordinate_units", "extrapolation", "origin", "values")

    def __init__(
        self,
        unit: str,
        coordinate_units: tuple[str, ...],
        values: TableValues,
        extrapolation: str = "hold",
        origin: str = "",
    ) -> None:
        super().__init__(SymbolKind.TABLE, unit)
        for name, value in {
            "coordinate_units": coordinate_units,
            "values": values,
            "extrapolation": extrapolation,
            "origin": origin,
        }.items():
            object.__setattr__(self, name, value)

    def __get__(self, instance: Component | None, owner: type | None = None) -> TableView | Table:
        if instance is None:
            return self
        return TableView(self.view(instance, instance.name_of(self)))


class TableView:
    """A table seen from a law; call it to interpolate."""

    def __init__(self, leaf: Expr) -> None:
        self.leaf = leaf

    def __call__(self, *coordinates: ExprLike) -> Expr:
        return lookup(self.leaf, *coordinates)


class Repeated:
    """Several parts of one class: `axles = repeat(3, Axle(...))` makes `axles[0]`, `axles[1]`, `axles[2]`."""

    def __init__(self, parts: tuple[Component, ...]) -> None:
        self.parts = parts

    def __len__(self) -> int:
        return len(self.parts)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.parts)

    def __getitem__(self, index: int) -> Any:
        return self.parts[index]

    def __get__(self, instance: Component | None, owner: type | None = None) -> Repeated:
        if instance is None:
            return self
        return Repeated(tuple(part.__get__(instance, owner) for part in self.parts))


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(parameter,))
class Component:
    """What a user declares and wires: subclass it and describe the model in the class body."""

    connections: ClassVar[tuple[Any, ...]] = ()
    energy_group: ClassVar[bool] = False
    declarations: ClassVar[Mapping[str, Any]] = {}
    names: ClassVar[Mapping[int, str]] = {}
    declared_at: Source

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        declarations = _declarations(cls)
        cls.declarations = declarations
        frame = call_site(1)
        for name in declarations:
            if name in RESERVED:
                raise ModelError.of(
                    "model/reserved-name",
                    f"{cls.__name__} calls something '{name}', as every component calls what it needs itself",
                    source=frame,
                    help=f"choose another name, for example '{name}_1'",
                )
        cls.names = _names(cls, declarations, frame)
        cls.defined_at = Source(frame.file, cls.__dict__.get("__firstlineno__", frame.line))

    defined_at: ClassVar[Source] = Source("", 0)

    def __init__(self, **values: Any) -> None:
        known = {name for name, value in self.declarations.items() if isinstance(value, (Parameter, Table))}
        site = call_site(1)
        for name in values:
            if name not in known:
                raise ModelError.of(
                    "model/unknown-parameter",
                    f"{type(self).__name__} has no parameter '{name}'",
                    source=site,
                    involved=[Involved(n, "is a parameter of it", self.defined_at) for n in sorted(known)],
                    help=one_of(name, sorted(known), "it has no parameters"),
                )
        self._set(root=self, path=Path(), values=values, replaced={}, declared_at=site)

    def _set(self, **attributes: Any) -> None:
        for name, value in attributes.items():
            object.__setattr__(self, name, value)

    root: Any
    path: Path
    values: dict[str, Any]
    replaced: dict[str, Component]

    if not TYPE_CHECKING:  # a checker shall see what there is not

        def __getattr__(self, name: str) -> Any:
            raise unknown_name(type(self).__name__, name, type(self).declarations)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"components are immutable; make a variant with replace(component, {name}=...)")

    def __get__(self, instance: Component | None, owner: type | None = None) -> Self:
        if instance is None:
            return self
        name = instance.name_of(self)
        part = instance.replaced.get(name, self)
        view = object.__new__(type(part))
        view._set(
            root=instance.root,
            path=instance.path / name,
            values=part.values,
            replaced=part.replaced,
            declared_at=part.declared_at,
        )
        return view  # pyright: ignore[reportReturnType]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Component) and self.root is other.root and self.path == other.path

    def __hash__(self) -> int:
        return hash((id(self.root), self.path))

    def name_of(self, declared: object) -> str:
        """The name that the class body gives to one of its ports, parameters or parts."""
        return type(self).names[id(declared)]


# What nothing in a class body may be called; dir() also lists the names that instances have.
RESERVED = frozenset({*dir(Component), *Component.__annotations__})


def _declarations(cls: type) -> dict[str, Any]:
    """What a class declares or inherits, by name; the members of a vector port follow it."""
    found: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        if not found and base in (object, Component):
            continue  # which declare nothing, and have many names
        for name, value in vars(base).items():
            overridden = found.get(name)
            if isinstance(overridden, VectorPort):
                for member in overridden.members:
                    found.pop(member_name(name, member), None)
            if isinstance(value, (Parameter, Table, Port, VectorPort, Component, Repeated, Declared)):
                found[name] = value
            elif name in found:
                del found[name]
            if isinstance(value, VectorPort):
                _add_members(cls, found, name, value)
    return found


def _add_members(cls: type, found: dict[str, Any], name: str, vector: VectorPort) -> None:
    """Declare the members of a vector port, unless their names are taken."""
    for member, value in vector.members.items():
        key = member_name(name, member)
        if key in found or key in vars(cls):
            raise ModelError.of(
                "model/vector-port",
                f"{cls.__name__} declares '{key}', and its vector port '{name}' has a member of that name",
                source=vector.source,
                help="give one of them another name: members of a vector port are called after it",
            )
        found[key] = value


def _names(cls: type, declarations: Mapping[str, Any], site: Source) -> dict[int, str]:
    names: dict[int, str] = {}
    for name, value in declarations.items():
        members = value.parts if isinstance(value, Repeated) else (value,)
        for index, member in enumerate(members):
            if id(member) in names:
                raise ModelError.of(
                    "model/two-names",
                    f"{cls.__name__} gives one object the names '{names[id(member)]}' and '{name}'",
                    source=site,
                    help="make each part its own: left = Wheel(...), right = Wheel(...)",
                )
            names[id(member)] = f"{name}[{index}]" if isinstance(value, Repeated) else name
    # What a subclass declares anew is meant wherever the class it inherits from names the old.
    for base in cls.__mro__[1:]:
        for key, name in getattr(base, "names", {}).items():
            if name.partition("[")[0] in declarations:
                names.setdefault(key, name)
    return names


def replace(component: Component, **changes: Any) -> Any:
    """A variant of a component with other values or parts, `replace(truck, engine=OtherEngine())`."""
    values, replaced = dict(component.values), dict(component.replaced)
    for name, change in changes.items():
        declared = component.declarations.get(name)
        if declared is None:
            raise ModelError.of(
                "model/unknown-part",
                f"{type(component).__name__} has no part or parameter '{name}'",
                source=call_site(1),
                help=one_of(name, component.declarations),
            )
        if isinstance(declared, Component) is not isinstance(change, Component) or isinstance(
            declared, (Port, VectorPort, Repeated)
        ):
            raise ModelError.of(
                "model/replace",
                f"'{name}' of {type(component).__name__} is a {type(declared).__name__} "
                f"and cannot become a {type(change).__name__}",
                source=call_site(1),
                help="replace a part by a part, and a parameter or table by its new value",
            )
        (replaced if isinstance(declared, Component) else values)[name] = change
    variant = object.__new__(type(component))
    variant._set(root=variant, path=Path(), values=values, replaced=replaced, declared_at=call_site(1))  # pyright: ignore[reportPrivateUsage]
    return variant


def repeat(count: int, part: Component) -> Any:
    """`count` parts like the given one; refer to them as `name[0]`, `name[1]` and so on."""
    return Repeated(tuple(replace(part) for _ in range(count)))
