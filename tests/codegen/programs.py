"""Programs built by hand, small enough to know their answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from propermodel.codegen.machine import Memory, TableData, start_memory
from propermodel.codegen.program import (
    Array,
    Assign,
    Extrapolation,
    Function,
    Layout,
    Program,
    Slot,
    Solve,
    TableSlot,
)
from propermodel.diagnostics import Path
from propermodel.expressions.core import TIME, ZERO, Expr, SymbolKind, lookup, sin, symbol, where
from propermodel.expressions.derivatives import partial_derivatives

KINDS = {
    Array.STATE: SymbolKind.STATE,
    Array.DISCRETE: SymbolKind.DISCRETE,
    Array.PARAMETER: SymbolKind.PARAMETER,
    Array.UNKNOWN: SymbolKind.UNKNOWN,
}


@dataclass
class Draft:
    """Collects the slots and assignments of a program."""

    slots: dict[Expr, Slot] = field(default_factory=dict)
    start: dict[Array, list[float]] = field(default_factory=dict)
    rates: list[Assign | Solve] = field(default_factory=list)
    displacement_rates: list[Assign | Solve] = field(default_factory=list)
    observe: list[Assign | Solve] = field(default_factory=list)
    samples: list[list[Assign | Solve]] = field(default_factory=list)
    periods: list[int] = field(default_factory=list)
    powers: int = 0
    signals: int = 0
    momenta: list[int] = field(default_factory=list)
    displacements: list[int] = field(default_factory=list)
    tables: list[TableSlot] = field(default_factory=list)
    table_data: list[TableData] = field(default_factory=list)
    table_index: dict[Expr, int] = field(default_factory=dict)

    def leaf(self, array: Array, name: str, value: float = 0.0) -> Expr:
        """A symbol with the next slot of an array, and its value at the start."""
        expr = symbol(KINDS[array], Path((name,)))
        values = self.start.setdefault(array, [])
        self.slots[expr] = Slot(array, len(values))
        values.append(value)
        return expr

    def state(self, name: str, value: float = 0.0) -> Expr:
        return self.leaf(Array.STATE, name, value)

    def parameter(self, name: str, value: float) -> Expr:
        return self.leaf(Array.PARAMETER, name, value)

    def unknown(self, name: str, value: float = 0.0) -> Expr:
        return self.leaf(Array.UNKNOWN, name, value)

    def discrete(self, name: str, value: float = 0.0) -> Expr:
        return self.leaf(Array.DISCRETE, name, value)

    def table(
        self,
        name: str,
        grids: Sequence[Sequence[float]],
        values: object,
        extrapolation: Extrapolation = Extrapolation.HOLD,
        is_uniform: bool = False,
    ) -> Expr:
        expr = symbol(SymbolKind.TABLE, Path((name,)))
        self.table_index[expr] = len(self.tables)
        self.tables.append(TableSlot(Path((name,)), len(grids), extrapolation, is_uniform))
        self.table_data.append(TableData(tuple(np.array(g, dtype=float) for g in grids), np.array(values, dtype=float)))
        return expr

    def rate(self, state: Expr, value: Expr) -> None:
        self.rates.append(Assign(Slot(Array.RATE, self.slots[state].index), value))

    def displacement_rate(self, state: Expr, value: Expr) -> None:
        self.rate(state, value)
        self.displacement_rates.append(Assign(Slot(Array.RATE, self.slots[state].index), value))

    def power(self, value: Expr) -> None:
        self.rates.append(Assign(Slot(Array.POWER, self.powers), value))
        self.powers += 1

    def signal(self, value: Expr) -> None:
        self.observe.append(Assign(Slot(Array.SIGNAL, self.signals), value))
        self.signals += 1

    def sample(self, period: Expr, updates: Mapping[Expr, Expr]) -> None:
        self.samples.append([Assign(self.slots[leaf], value) for leaf, value in updates.items()])
        self.periods.append(self.slots[period].index)

    def solve(self, unknowns: Sequence[Expr], residuals: Sequence[Expr]) -> Solve:
        tangents = partial_derivatives(residuals, unknowns)
        jacobian = tuple(tuple(tangent.get(unknown, ZERO) for unknown in unknowns) for tangent in tangents)
        paths = tuple(unknown.data.path for unknown in unknowns)
        return Solve(tuple(unknowns), tuple(residuals), jacobian, (1.0,) * len(unknowns), paths)

    def program(self) -> Program:
        """The program as it stands."""
        lengths = {array: len(self.start.get(array, ())) for array in KINDS}
        lengths |= {
            Array.TIME: 1,
            Array.RATE: lengths[Array.STATE],
            Array.POWER: self.powers,
            Array.SIGNAL: self.signals,
        }
        return Program(
            Function("rates", tuple(self.rates)),
            Function("displacement_rates", tuple(self.displacement_rates)),
            Function("observe", tuple(self.observe)),
            tuple(Function(f"sample_{k}", tuple(steps)) for k, steps in enumerate(self.samples)),
            tuple(self.periods),
            Layout(
                {**self.slots, TIME: Slot(Array.TIME, 0)},
                lengths,
                tuple(self.tables),
                self.table_index,
                tuple(self.momenta),
                tuple(self.displacements),
            ),
        )

    def memory(self, lanes: int = 1, origin: float = 0.0) -> Memory:
        """A memory with the values given at the start."""
        values = {array: np.array(items) for array, items in self.start.items()}
        return start_memory(self.program(), values, tables=self.table_data, origin=origin, lanes=lanes)


def oscillator(damping: float = 0.5, driven: bool = True) -> Draft:
    """A mass on a spring and damper, pushed by a controller that counts its samples and reads the position."""
    draft = Draft()
    mass = draft.parameter("mass", 2.0)
    stiffness = draft.parameter("stiffness", 50.0)
    loss = draft.parameter("damping", damping)
    period = draft.parameter("period", 0.05)
    q, p = draft.state("q", 0.3), draft.state("p", 1.0)
    draft.displacements, draft.momenta = [0], [1]
    force, count = draft.discrete("force"), draft.discrete("count")
    speed = p / mass
    spring, damper = stiffness * q, loss * speed
    push = force + sin(3.0 * TIME) if driven else 0.0 * q
    draft.displacement_rate(q, speed)
    draft.rate(p, push - spring - damper)
    draft.power(spring * speed)
    draft.power(damper * speed)
    draft.power(push * speed)
    for signal in (q, speed, force, count, TIME, 0.5 * stiffness * q * q + 0.5 * mass * speed * speed):
        draft.signal(signal)
    if driven:
        # Both read the values held before either is written.
        draft.sample(period, {count: count + 1.0, force: where(q > 0.0, -0.5 * count, 0.4 * force + 1.0)})
    return draft


def tables(extrapolation: Extrapolation = Extrapolation.HOLD, is_uniform: bool = False) -> Draft:
    """States that sweep over one- and two-dimensional tables, beyond their grids on both sides."""
    draft = Draft()
    grid = [-1.0, -0.5, 0.0, 0.5, 1.0] if is_uniform else [-1.0, -0.3, 0.1, 0.2, 1.0]
    other = [0.0, 1.0, 2.0] if is_uniform else [0.0, 0.2, 2.0]
    line = draft.table("line", [grid], [0.3, -0.2, 0.7, 0.1, -0.4], extrapolation, is_uniform)
    values = np.sin(np.arange(15.0)).reshape(5, 3)
    sheet = draft.table("sheet", [grid, other], values, extrapolation, is_uniform)
    time_line = draft.table("profile", [[0.0, 0.4, 1.1]], [1.0, -1.0, 0.5])
    x, y = draft.state("x", -1.7), draft.state("y", 2.6)
    first, second = lookup(line, x), lookup(sheet, x, y)
    slopes = partial_derivatives([first, second], [x, y])
    draft.rate(x, 3.0 + 0.2 * first + 0.1 * lookup(time_line, TIME))
    draft.rate(y, -3.0 + 0.3 * second)
    draft.power(first * x)
    for signal in (x, y, first, second, slopes[0][x], slopes[1][x], slopes[1][y], lookup(sheet, TIME, x)):
        draft.signal(signal)
    return draft


def implicit(size: int) -> Draft:
    """A state whose rate needs the solution of `size` coupled nonlinear equations; used again by the signals."""
    draft = Draft()
    x = draft.state("x", 0.2)
    gain = draft.parameter("gain", 0.4)
    unknowns = [draft.unknown(f"u{i}", 0.1) for i in range(size)]
    drive = sin(2.0 * TIME) * gain + x
    residuals = []
    for i, u in enumerate(unknowns):
        neighbour = unknowns[(i + 1) % size]
        residuals.append(u * u * u + 2.0 * u - drive * (1.0 + 0.1 * i) + 0.3 * sin(neighbour) * gain)
    solve = draft.solve(unknowns, residuals)
    draft.rates.append(solve)
    total = sum(unknowns[1:], unknowns[0])
    draft.rate(x, -x + 0.5 * total * abs(total))
    draft.power(total * x)
    draft.observe.append(solve)
    draft.signal(x)
    draft.signal(total)
    for residual in residuals:
        draft.signal(residual)
    return draft


def chain(sections: int) -> Draft:
    """Masses between springs and quadratic dampers in a row, the first pushed, with the power of every element."""
    draft = Draft()
    stiffness = draft.parameter("stiffness", 4000.0)
    loss = draft.parameter("loss", 3.0)
    masses = [draft.parameter(f"mass{i}", 1.0 + 0.01 * i) for i in range(sections)]
    q = [draft.state(f"q{i}") for i in range(sections)]
    p = [draft.state(f"p{i}", 0.1 * ((i % 5) - 2)) for i in range(sections)]
    draft.displacements = list(range(sections))
    draft.momenta = list(range(sections, 2 * sections))
    speeds = [a / b for a, b in zip(p, masses, strict=True)]
    push: Expr = 10.0 * sin(5.0 * TIME)
    for i in range(sections):
        following = speeds[i + 1] if i + 1 < sections else 0.0 * TIME
        stretching = speeds[i] - following
        spring = stiffness * q[i] + 100.0 * stiffness * q[i] * q[i] * q[i]
        damper = loss * stretching * (1.0 + abs(stretching))
        draft.displacement_rate(q[i], stretching)
        draft.rate(p[i], push - spring - damper)
        draft.power(spring * stretching)
        draft.power(damper * stretching)
        draft.power(push * speeds[i])
        draft.signal(p[i])
        push = spring + damper
    return draft


def blow_up() -> Draft:
    """Two states: a calm one, and one that squares itself to infinity at time 1 / start."""
    draft = Draft()
    calm, wild = draft.state("calm", 1.0), draft.state("wild", 2.0)
    speed = draft.parameter("speed", 1.0)
    draft.rate(calm, -calm)
    draft.rate(wild, speed * wild * wild)
    draft.signal(calm)
    return draft


def unsolvable() -> Draft:
    """Two implicit blocks; the second, u**2 = limit - t, has no solution after the limit."""
    draft = Draft()
    x = draft.state("x", 0.0)
    limit = draft.parameter("limit", 0.5)
    easy, u = draft.unknown("easy", 0.0), draft.unknown("u", 1.0)
    first = draft.solve([easy], [easy * easy * easy + easy - x])
    second = draft.solve([u], [u * u - (limit - TIME)])
    draft.rates += [first, second]
    draft.rate(x, u + easy)
    draft.signal(x)
    return draft
