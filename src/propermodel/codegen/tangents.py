"""A program with its derivatives in several directions, the parameters: forward differentiation of the whole run.

Every quantity gets a tangent for each direction, the derivative of its value along the run: states, whose tangents are
states with the differentiated rates; what controllers hold; signals; powers. Unknowns of implicit blocks follow by the
implicit function theorem. Steps, samples, corrections, rows and integrals of the loop then act on tangents as they do
on what they belong to, so that a method gives the exact derivative of its own steps (Griewank and Walther, Evaluating
Derivatives, 2008, chapter 3); an implicit step is differentiated with the elimination in it. At kinks derivatives are
one-sided; tables are linear within their cells; conditions and steps of discrete logic stay where they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from propermodel.codegen.dense import solve_columns
from propermodel.codegen.program import Array, Assign, Function, ImplicitStep, Layout, Program, Slot, Solve
from propermodel.codegen.schedule import Order
from propermodel.codegen.state_jacobian import MOST_UNKNOWNS, SymbolicArithmetic
from propermodel.diagnostics import Path, SimulationError
from propermodel.expressions.core import ONE, ZERO, Expr, SymbolKind, is_zero, leaves, multiply, sign, symbol
from propermodel.expressions.derivatives import combine_tangents

Tangents = tuple[Expr, ...]  # of one quantity, one for each direction

# What is kept from one function to the next, with its tangents.
_KEPT = (Array.STATE, Array.DISCRETE, Array.FACTOR, Array.STAGE)


@dataclass(frozen=True, slots=True)
class Direction:
    """The parameters of a program that change along it, at the rate one or at rates that a run tells."""

    name: Path
    at_one: tuple[Expr, ...]
    at_given: tuple[Expr, ...] = ()


@dataclass(frozen=True, slots=True)
class Seed:
    """The rate at which a parameter changes along a direction, as an entry of PARAMETER."""

    direction: int
    parameter: Expr
    index: int


@dataclass(frozen=True)
class TangentProgram:
    """A program that also computes tangents. First stands what it computes itself, then its tangents, by direction.

    Of SIGNAL and POWER it has the chosen entries only. Each chosen power has two tangents that are integrated: its
    derivative, and this times the sign of the power, which is the derivative of its absolute value.
    """

    program: Program
    directions: tuple[Direction, ...]
    seeds: tuple[Seed, ...]
    states: int
    discretes: int
    parameters: int
    signals: int
    powers: int

    def state(self, direction: int) -> slice:
        """Where the tangents of STATE along a direction are."""
        return slice((direction + 1) * self.states, (direction + 2) * self.states)

    def discrete(self, direction: int) -> slice:
        """Where the tangents of DISCRETE along a direction are."""
        return slice((direction + 1) * self.discretes, (direction + 2) * self.discretes)

    def signal(self, direction: int) -> slice:
        """Where the tangents of the chosen entries of SIGNAL along a direction are."""
        return slice((direction + 1) * self.signals, (direction + 2) * self.signals)

    def power(self, direction: int) -> slice:
        """Where the tangents of the chosen entries of POWER along a direction are."""
        return slice((2 * direction + 1) * self.powers, (2 * direction + 2) * self.powers)

    def absolute_power(self, direction: int) -> slice:
        """Where the tangents of the absolute values of the chosen entries of POWER along a direction are."""
        return slice((2 * direction + 2) * self.powers, (2 * direction + 3) * self.powers)


def with_tangents(
    program: Program, directions: Sequence[Direction], signals: Sequence[int], powers: Sequence[int]
) -> TangentProgram:
    """A program, with the implicit step of its method, and its tangents; with the chosen entries of SIGNAL and POWER.

    Raises:
        SimulationError: the derivatives pass an implicit block that is too large.
    """
    if program.guards is not None:
        raise ValueError("only programs without events have tangents")
    return _Builder(program, directions, signals, powers).program()


class _Builder:
    def __init__(
        self, program: Program, directions: Sequence[Direction], signals: Sequence[int], powers: Sequence[int]
    ) -> None:
        self._program = program
        self._directions = tuple(directions)
        self._signals = {entry: place for place, entry in enumerate(signals)}
        self._powers = {entry: place for place, entry in enumerate(powers)}
        lengths = program.layout.lengths
        self._lengths = {array: lengths.get(array, 0) for array in (*_KEPT, Array.PARAMETER)}
        self._slots: dict[Expr, Slot] = {}
        self._seeds: list[Seed] = []
        self._leaves: dict[Expr, Tangents] = {}
        self._add_parameters()
        for leaf, slot in program.layout.slots.items():
            if slot.array in _KEPT:
                self._leaves[leaf] = self._new(leaf, slot)

    def _add_parameters(self) -> None:
        slots = self._program.layout.slots
        count = len(self._directions)
        for k, direction in enumerate(self._directions):
            for leaf in direction.at_one:
                self._leaves[leaf] = _with(self._leaves.get(leaf, (ZERO,) * count), k, ONE)
            for leaf in direction.at_given:
                index = self._lengths[Array.PARAMETER] + len(self._seeds)
                rate = symbol(SymbolKind.PARAMETER, _tangent_path(leaf, k))
                self._slots[rate] = Slot(Array.PARAMETER, index)
                self._seeds.append(Seed(k, leaf, index))
                self._leaves[leaf] = _with(self._leaves.get(leaf, (ZERO,) * count), k, rate)
        for leaf in self._leaves:
            if slots[leaf].array is not Array.PARAMETER:
                raise ValueError(f"'{leaf!r}' is no parameter of the program")

    def _new(self, leaf: Expr, slot: Slot) -> Tangents:
        """The symbols of a leaf's tangents, with their slots."""
        found: list[Expr] = []
        for k in range(len(self._directions)):
            tangent = symbol(leaf.data.kind, _tangent_path(leaf, k))
            self._slots[tangent] = self._beside(slot, k)
            found.append(tangent)
        return tuple(found)

    def _beside(self, slot: Slot, direction: int) -> Slot:
        """The slot of a tangent of what is kept, or of a RATE."""
        array = Array.STATE if slot.array is Array.RATE else slot.array
        return Slot(slot.array, (direction + 1) * self._lengths[array] + slot.index)

    def program(self) -> TangentProgram:
        """Everything."""
        program, count = self._program, len(self._directions)
        found = replace(
            program,
            implicit_step=None if program.implicit_step is None else self._implicit(program.implicit_step),
            rates=self._function(program.rates),
            displacement_rates=self._function(program.displacement_rates),
            observe=self._function(program.observe),
            samples=tuple(map(self._function, program.samples)),
            corrections=tuple(map(self._function, program.corrections)),
            layout=self._layout(program.layout, count),
        )
        return TangentProgram(
            program=found,
            directions=self._directions,
            seeds=tuple(self._seeds),
            states=self._lengths[Array.STATE],
            discretes=self._lengths[Array.DISCRETE],
            parameters=self._lengths[Array.PARAMETER],
            signals=len(self._signals),
            powers=len(self._powers),
        )

    def _implicit(self, step: ImplicitStep) -> ImplicitStep:
        directions = range(len(self._directions))
        return ImplicitStep(
            first=self._function(step.first),
            first_again=self._function(step.first_again),
            later=tuple(map(self._function, step.later)),
            shares=step.shares,
            start=(*step.start, *(self._beside(slot, k) for k in directions for slot in step.start)),
        )

    def _layout(self, layout: Layout, count: int) -> Layout:
        states = self._lengths[Array.STATE]

        def all_of(indices: tuple[int, ...]) -> tuple[int, ...]:
            return tuple(k * states + i for k in range(count + 1) for i in indices)

        return replace(
            layout,
            slots={**layout.slots, **self._slots},
            lengths={
                **layout.lengths,
                **{array: (count + 1) * self._lengths[array] for array in _KEPT},
                Array.RATE: (count + 1) * states,
                Array.PARAMETER: self._lengths[Array.PARAMETER] + len(self._seeds),
                Array.SIGNAL: (count + 1) * len(self._signals),
                Array.POWER: (2 * count + 1) * len(self._powers),
            },
            momenta=all_of(layout.momenta),
            displacements=all_of(layout.displacements),
        )

    def _function(self, function: Function) -> Function:
        """A function with the tangents of what it assigns, and the blocks that these need."""
        rules = _Rules(self._leaves, len(self._directions))
        kept = [step for step in function.steps if isinstance(step, Assign) and self._is_chosen(step.slot)]
        solves = needed_solves(function, [step.value for step in kept])
        for solve in solves:
            rules.add_solution(solve)
        assigns: list[Assign] = []
        for step in kept:
            assigns += self._with_tangents(step, rules.of(step.value))
        return Function(function.name, (*solves, *assigns))

    def _is_chosen(self, slot: Slot) -> bool:
        match slot.array:
            case Array.SIGNAL:
                return slot.index in self._signals
            case Array.POWER:
                return slot.index in self._powers
            case _:
                return True

    def _with_tangents(self, step: Assign, tangents: Tangents) -> list[Assign]:
        slot = step.slot
        match slot.array:
            case Array.SIGNAL:
                place, size = self._signals[slot.index], len(self._signals)
                values = (step.value, *tangents)
                return [Assign(Slot(slot.array, k * size + place), value) for k, value in enumerate(values)]
            case Array.POWER:
                place, size = self._powers[slot.index], len(self._powers)
                direction = sign(step.value)
                pairs = [pair for tangent in tangents for pair in (tangent, multiply(direction, tangent))]
                values = (step.value, *pairs)
                return [Assign(Slot(slot.array, k * size + place), value) for k, value in enumerate(values)]
            case Array.WEAK:
                return [step]
            case _:
                return [step, *(Assign(self._beside(slot, k), value) for k, value in enumerate(tangents))]


def _with(tangents: Tangents, place: int, value: Expr) -> Tangents:
    return (*tangents[:place], value, *tangents[place + 1 :])


def _tangent_path(leaf: Expr, direction: int) -> Path:
    return Path(("tangent", str(direction), *leaf.data.path))


def needed_solves(function: Function, values: Iterable[Expr]) -> list[Solve]:
    """The blocks of a function that some values need, in order."""
    found: list[Solve] = []
    wanted = set(leaves(*values))
    for solve in reversed([step for step in function.steps if isinstance(step, Solve)]):
        if wanted.intersection(solve.unknowns):
            found.append(solve)
            wanted.update(leaves(*solve.residuals, *(entry for row in solve.jacobian for entry in row)))
    return found[::-1]


class _Rules:
    """Tangents of expressions, from those of their leaves; each node is differentiated once."""

    def __init__(self, known: Mapping[Expr, Tangents], count: int) -> None:
        self._known = dict(known)
        self._nothing: Tangents = (ZERO,) * count
        self._order = Order(lambda node: node in self._known)

    def of(self, root: Expr) -> Tangents:
        """The tangents of an expression whose unknowns have been solved for."""
        for node in self._order.new_below(root):
            self._known[node] = self._combined(node, [self._known.get(arg, self._nothing) for arg in node.args])
        return self._known.get(root, self._nothing)

    def _combined(self, node: Expr, tangents: list[Tangents]) -> Tangents:
        if all(tangent is self._nothing for tangent in tangents):
            return self._nothing
        found = combine_tangents(node, tangents)
        return self._nothing if all(map(is_zero, found)) else found

    def add_solution(self, solve: Solve) -> None:
        """Make the tangents of the unknowns z of r(z, x) = 0 known: dr/dz z' = - dr/dx x'."""
        if len(solve.unknowns) > MOST_UNKNOWNS:
            names = ", ".join(str(path) for path in dict.fromkeys(solve.paths[:3]))
            raise SimulationError.of(
                "simulation/large-block",
                f"sensitivities need the derivatives of {len(solve.unknowns)} unknowns that must be solved for "
                f"together ({names}, ...); they can be had for {MOST_UNKNOWNS}",
                help="break the loop or the rigid coupling by a compliance",
            )
        right = self._explicit(solve)
        moved = [k for k, column in enumerate(zip(*right, strict=True)) if not all(map(is_zero, column))]
        if not moved:
            return
        matrix = [list(row) for row in solve.jacobian]
        found = solve_columns(matrix, [[-row[k] for k in moved] for row in right], SymbolicArithmetic())
        for unknown, row in zip(solve.unknowns, found, strict=True):
            by_direction = dict(zip(moved, row, strict=True))
            self._known[unknown] = tuple(by_direction.get(k, ZERO) for k in range(len(self._nothing)))

    def _explicit(self, solve: Solve) -> list[Tangents]:
        """The tangents of the residuals while the unknowns stay."""
        unknowns = set(solve.unknowns)
        inside: dict[Expr, Tangents] = dict.fromkeys(unknowns, self._nothing)
        order = Order(lambda _: False)
        for root in solve.residuals:
            for node in order.new_below(root):
                if any(arg in inside for arg in node.args):
                    inside[node] = self._combined(
                        node, [inside[arg] if arg in inside else self.of(arg) for arg in node.args]
                    )
        return [inside[root] if root in inside else self.of(root) for root in solve.residuals]
