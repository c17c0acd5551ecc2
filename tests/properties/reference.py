"""The answer of dense linear algebra to a drawn graph: every bond, junction and law is one equation.

The unknowns are the effort and flow of every bond and the stored quantity of every storage port, Y; the equations
are B Y' + A Y = N(Y, t), where N holds the laws that are not linear and the values of sources. Nothing here knows of
causality, states or simplification. Along a solution Y is a power series in time; the equations of its coefficients
(the derivative array) are solved by Newton's method with least squares, and the rank of their matrix says what they
determine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise

import numpy as np

from propermodel.codegen.machine import FloatArray
from propermodel.modelling.domains import Shared
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.properties.graphs import Coupler, Field, Graph, OnePort

# Singular values below this share of the largest count as zero.
RANK_TOLERANCE = 1e-9


class Series:
    """Power series in time, truncated."""

    @staticmethod
    def product(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.convolve(a, b)[: len(a)]

    @staticmethod
    def exponential(a: FloatArray) -> FloatArray:
        found = np.zeros_like(a)
        found[0] = np.exp(a[0])
        for k in range(1, len(a)):
            found[k] = sum(j * a[j] * found[k - j] for j in range(1, k + 1)) / k
        return found

    @staticmethod
    def sine_and_cosine(a: FloatArray) -> tuple[FloatArray, FloatArray]:
        s, c = np.zeros_like(a), np.zeros_like(a)
        s[0], c[0] = np.sin(a[0]), np.cos(a[0])
        for k in range(1, len(a)):
            s[k] = sum(j * a[j] * c[k - j] for j in range(1, k + 1)) / k
            c[k] = -sum(j * a[j] * s[k - j] for j in range(1, k + 1)) / k
        return s, c


@dataclass(frozen=True)
class Law:
    """Row: minus size (u + u^3) or minus size sinh(u), where u is one unknown."""

    row: int
    column: int
    size: float
    kind: str

    def values(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The law and its slope."""
        if self.kind == "sinh":
            up, down = Series.exponential(u), Series.exponential(-u)
            return self.size * (up - down) / 2.0, self.size * (up + down) / 2.0
        square = Series.product(u, u)
        slope = 3.0 * square
        slope[0] += 1.0
        return self.size * (u + Series.product(square, u)), self.size * slope


@dataclass(frozen=True)
class Modulated:
    """Row: minus m v, with m = size (1 + depth sin(argument)); the argument is an unknown or time."""

    row: int
    column: int
    size: float
    depth: float
    argument: int | None


@dataclass(frozen=True)
class Driven:
    """Row: minus size + swing sin(2 time)."""

    row: int
    size: float
    swing: float


class Verdict(StrEnum):
    """What the equations of a graph determine."""

    REGULAR = "regular"
    WIRING = "undetermined only inside the junction structure"
    SINGULAR = "singular"


@dataclass
class Reference:
    """The equations of a drawn graph."""

    graph: Graph
    ports: dict[str, int] = field(default_factory=dict)  # effort of a port, by path; its flow is the next column
    stored: dict[str, int] = field(default_factory=dict)  # stored quantity, by path of the coordinate
    laws: list[Law] = field(default_factory=list)
    products: list[Modulated] = field(default_factory=list)
    driven: list[Driven] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.bonds = 0
        self.at: list[list[tuple[int, float]]] = []  # per junction: bond and sign of power into the junction
        self.kinds: list[JunctionKind] = []
        self.entries: list[tuple[int, int, float]] = []
        self.rates: list[tuple[int, int]] = []
        self.pending: list[tuple[str, OnePort | Coupler | Field, tuple[int, ...]]] = []
        self.rows = 0
        self._draw()
        names = [name for path, element, _ in self.pending for name in _coordinates(path, element)]
        self.stored.update((name, 2 * self.bonds + n) for n, name in enumerate(names))
        self.count = 2 * self.bonds + len(self.stored)
        self._write()
        assert self.rows == self.count
        self.A = np.zeros((self.count, self.count))
        self.B = np.zeros((self.count, self.count))
        for row, column, value in self.entries:
            self.A[row, column] += value
        for row, column in self.rates:
            self.B[row, column] = 1.0
        self.port_columns = sorted({c + k for c in self.ports.values() for k in (0, 1)} | set(self.stored.values()))

    # -- bonds -------------------------------------------------------------------------------------

    def _draw(self) -> None:
        for knot in self.graph.knots:
            self.kinds.append(knot.kind)
            self.at.append([])
        for wire in self.graph.wires:
            bond = self._bond()
            self.at[wire.tail].append((bond, -1.0))
            self.at[wire.head].append((bond, 1.0))
        for n, one in enumerate(self.graph.one_ports):
            is_source = one.kind in (ElementKind.EFFORT_SOURCE, ElementKind.FLOW_SOURCE)
            bond = self._port(f"e{n}.port", one.knot, True, one.turned, is_source)
            self.pending.append((f"e{n}", one, (bond,)))
        for n, two in enumerate(self.graph.couplers):
            a = self._port(f"t{n}.a", two.knots[0], True, two.turned[0], False)
            b = self._port(f"t{n}.b", two.knots[1], False, two.turned[1], False)
            self.pending.append((f"t{n}", two, (a, b)))
        for n, many in enumerate(self.graph.fields):
            bonds = tuple(
                self._port(f"m{n}.{p}", k, True, False, False) for p, k in zip(many.ports, many.knots, strict=True)
            )
            self.pending.append((f"m{n}", many, bonds))

    def _bond(self) -> int:
        self.bonds += 1
        return self.bonds - 1

    def _port(self, path: str, knot: int, inward: bool, turned: bool, is_source: bool) -> int:
        """The bond at a port; a half arrow against the sense of the law meets it at a node of the domain's kind."""
        bond = self._bond()
        self.ports[path] = 2 * bond
        sense = 1.0 if inward else -1.0  # of power into the element
        if turned and is_source:
            self.at[knot].append((bond, sense))
        elif turned:
            shares_flow = self.graph.domain(knot).shared is Shared.FLOW
            self.kinds.append(JunctionKind.ONE if shares_flow else JunctionKind.ZERO)
            arrow = self._bond()
            self.at.append([(bond, -sense), (arrow, -sense)])
            self.at[knot].append((arrow, sense))
        else:
            self.at[knot].append((bond, -sense))
        return bond

    # -- equations ---------------------------------------------------------------------------------

    def _row(self, *terms: tuple[int, float]) -> int:
        self.entries.extend((self.rows, column, value) for column, value in terms)
        self.rows += 1
        return self.rows - 1

    def _write(self) -> None:
        for kind, bonds in zip(self.kinds, self.at, strict=False):
            common = 0 if kind is JunctionKind.ZERO else 1
            for (one, _), (other, _) in pairwise(bonds):
                self._row((2 * one + common, 1.0), (2 * other + common, -1.0))
            if bonds:
                self._row(*((2 * bond + 1 - common, sign) for bond, sign in bonds))
        for path, element, bonds in self.pending:
            match element:
                case OnePort():
                    self._one_port(path, element, bonds[0])
                case Coupler():
                    self._coupler(element, *bonds)
                case Field():
                    self._field(path, element, bonds)

    def _coordinate(self, path: str, bond: int, kind: ElementKind) -> int:
        column = self.stored[path]
        driver = 2 * bond + (1 if kind is ElementKind.COMPLIANCE else 0)
        self.rates.append((self._row((driver, -1.0)), column))
        return column

    def _one_port(self, path: str, one: OnePort, bond: int) -> None:
        effort, flow = 2 * bond, 2 * bond + 1
        match one.kind:
            case ElementKind.EFFORT_SOURCE:
                self.driven.append(Driven(self._row((effort, 1.0)), one.size, one.swing))
            case ElementKind.FLOW_SOURCE:
                self.driven.append(Driven(self._row((flow, 1.0)), one.size, one.swing))
            case ElementKind.RESISTANCE:
                self._law(one, effort, flow)
            case ElementKind.COMPLIANCE:
                self._law(one, effort, self._coordinate(f"{path}.displacement", bond, one.kind))
            case _:
                self._law(one, flow, self._coordinate(f"{path}.momentum", bond, one.kind))

    def _law(self, one: OnePort, result: int, argument: int) -> None:
        if one.law == "linear":
            self._row((result, 1.0), (argument, -one.size))
        else:
            self.laws.append(Law(self._row((result, 1.0)), argument, one.size, one.law))

    def _coupler(self, two: Coupler, a: int, b: int) -> None:
        e_a, f_a, e_b, f_b = 2 * a, 2 * a + 1, 2 * b, 2 * b + 1
        pairs = ((e_a, e_b), (f_b, f_a)) if two.kind is ElementKind.TRANSFORMER else ((e_a, f_b), (e_b, f_a))
        m = two.modulus
        for result, argument in pairs:
            if not m.depth:
                self._row((result, 1.0), (argument, -m.size))
                continue
            storage = None
            if m.storage is not None:
                (name,) = _coordinates(f"e{m.storage}", self.graph.one_ports[m.storage])
                storage = self.stored[name]
            self.products.append(Modulated(self._row((result, 1.0)), argument, m.size, m.depth, storage))

    def _field(self, path: str, many: Field, bonds: tuple[int, ...]) -> None:
        if many.kind is ElementKind.RESISTANCE:
            arguments = [2 * bond + 1 for bond in bonds]
        else:
            arguments = [
                self._coordinate(f"{path}.{port}_stored", bond, many.kind)
                for port, bond in zip(many.ports, bonds, strict=True)
            ]
        for row, bond in zip(many.matrix, bonds, strict=True):
            result = 2 * bond + (1 if many.kind is ElementKind.INERTIA else 0)
            self._row((result, 1.0), *((column, -value) for column, value in zip(arguments, row, strict=True)))

    # -- power series along a solution -------------------------------------------------------------

    def residuals(self, series: FloatArray, time: float) -> FloatArray:
        """The coefficients of all equations, shape (orders, rows), for coefficients of shape (orders + 1, columns)."""
        orders = len(series) - 1
        growth = np.arange(1, orders + 1)[:, np.newaxis]
        found = (growth * series[1:]) @ self.B.T + series[:-1] @ self.A.T
        for law in self.laws:
            found[:, law.row] -= law.values(series[:-1, law.column])[0]
        for item in self.products:
            modulus, _ = self._modulus(item, series[:-1], time)
            found[:, item.row] -= Series.product(modulus, series[:-1, item.column])
        for source in self.driven:
            wave, _ = Series.sine_and_cosine(2.0 * _instant(time, orders))
            found[:, source.row] -= source.swing * wave
            found[0, source.row] -= source.size
        return found

    def slopes(self, series: FloatArray, time: float) -> FloatArray:
        """How the coefficients of all equations change with those of Y: (orders, rows, orders + 1, columns)."""
        orders = len(series) - 1
        along = np.zeros((orders, self.count, self.count))  # the matrix of Y, as a series
        along[0] = self.A
        for law in self.laws:
            along[:, law.row, law.column] -= law.values(series[:-1, law.column])[1]
        for item in self.products:
            modulus, slope = self._modulus(item, series[:-1], time)
            along[:, item.row, item.column] -= modulus
            if item.argument is not None:
                along[:, item.row, item.argument] -= Series.product(slope, series[:-1, item.column])
        found = np.zeros((orders, self.count, orders + 1, self.count))
        for k in range(orders):
            for j in range(k + 1):
                found[k, :, j, :] += along[k - j]
            found[k, :, k + 1, :] += (k + 1) * self.B
        return found

    @staticmethod
    def _modulus(item: Modulated, series: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
        argument = _instant(time, len(series)) if item.argument is None else series[:, item.argument]
        s, c = Series.sine_and_cosine(argument)
        value = item.size * item.depth * s
        value[0] += item.size
        return value, item.size * item.depth * c

    # -- what the equations determine --------------------------------------------------------------

    def verdict(self, random: np.random.Generator) -> Verdict:
        """Whether s B + A is regular for a general s, at a general point."""
        point = random.uniform(-1.0, 1.0, (2, self.count))
        slopes = self.slopes(point, 0.3)[0, :, 0, :]
        pencil = complex(0.7, 0.4) * self.B + slopes
        _, values, rows = np.linalg.svd(pencil)
        null = np.abs(rows[values < RANK_TOLERANCE * values[0]])
        if not len(null):
            return Verdict.REGULAR
        return Verdict.SINGULAR if np.max(null[:, self.port_columns]) > 1e-6 else Verdict.WIRING

    def index(self, random: np.random.Generator, most: int = 5) -> int:
        """How often the equations must be differentiated until they give the rate of every stored quantity and port.

        0 stands for a model without storage or laws that need it; `most` + 1 for more than `most`.
        """
        point = random.uniform(-1.0, 1.0, (1, self.count))
        wanted = np.zeros(self.count, dtype=bool)
        wanted[self.port_columns] = True
        for orders in range(1, most + 2):
            series = np.concatenate([point, np.zeros((orders, self.count))])
            slopes = self.slopes(series, 0.3)[:, :, 1:, :].reshape(orders * self.count, orders * self.count)
            if _determined(slopes, np.flatnonzero(wanted)):
                return orders - 1
        return most + 1

    def solve(
        self,
        held: Mapping[str, float],
        time: float,
        orders: int,
        wanted: Sequence[int],
        guess: FloatArray | None = None,
    ) -> Solution:
        """The coefficients of Y when some stored quantities have given values.

        The solution says whether the `wanted` unknowns and the rates of what is held are unique.
        """
        fixed = np.zeros((orders + 1, self.count), dtype=bool)
        series = np.zeros((orders + 1, self.count)) if guess is None else guess.copy()
        for path, value in held.items():
            fixed[0, self.stored[path]] = True
            series[0, self.stored[path]] = value
        free = ~fixed.reshape(-1)
        error = np.inf
        slopes = np.zeros((0, 0))
        for _ in range(60):
            residual = self.residuals(series, time).reshape(-1)
            error = float(np.max(np.abs(residual)))
            slopes = self.slopes(series, time).reshape(len(residual), -1)[:, free]
            if error < 1e-11 * max(1.0, float(np.max(np.abs(series)))):
                break
            step = np.linalg.lstsq(slopes, residual, rcond=1e-12)[0]
            series = self._advance(series, free, step, time, error)
        asked = np.zeros((orders + 1, self.count), dtype=bool)
        asked[0, list(wanted)] = True
        asked[1, [self.stored[path] for path in held]] = True
        columns = np.flatnonzero(asked.reshape(-1)[free])
        return Solution(self, series, error, _determined(slopes, columns))

    def _advance(self, series: FloatArray, free: FloatArray, step: FloatArray, time: float, error: float) -> FloatArray:
        """A Newton step, shortened while it makes things worse."""
        length = 1.0
        while True:
            attempt = series.reshape(-1).copy()
            attempt[free] -= length * step
            attempt = attempt.reshape(series.shape)
            with np.errstate(over="ignore", invalid="ignore"):
                after = float(np.max(np.abs(self.residuals(attempt, time))))
            if after < error or length < 1e-3:
                return attempt
            length *= 0.5


@dataclass(frozen=True)
class Solution:
    """The coefficients of a solution, the worst residual, and whether what was asked for is unique."""

    reference: Reference
    series: FloatArray
    error: float
    is_unique: bool

    @property
    def is_found(self) -> bool:
        """Whether the equations hold."""
        return self.error < 1e-10 * max(1.0, float(np.max(np.abs(self.series))))

    def rate(self, path: str) -> float:
        """The rate of a stored quantity."""
        return float(self.series[1, self.reference.stored[path]])


def _instant(time: float, orders: int) -> FloatArray:
    found = np.zeros(orders)
    found[:2] = (time, 1.0)[:orders]
    return found


def _coordinates(path: str, element: OnePort | Coupler | Field) -> list[str]:
    if isinstance(element, Coupler) or not element.kind.is_storage:
        return []
    if isinstance(element, Field):
        return [f"{path}.{port}_stored" for port in element.ports]
    return [f"{path}.{'displacement' if element.kind is ElementKind.COMPLIANCE else 'momentum'}"]


def _determined(matrix: FloatArray, columns: FloatArray) -> bool:
    """Whether a linear system with this matrix gives these unknowns."""
    if not len(columns):
        return True
    scaled = matrix / np.maximum(np.max(np.abs(matrix), axis=1, keepdims=True), 1e-300)
    _, values, rows = np.linalg.svd(scaled)
    rank = int(np.sum(values > RANK_TOLERANCE * values[0]))
    null = rows[rank:]
    return not len(null) or float(np.max(np.abs(null[:, columns]))) < 1e-6
