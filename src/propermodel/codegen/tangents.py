"""A program with its derivatives in several directions, the parameters: forward differentiation of the whole run.

Every quantity gets a tangent for each direction, the derivative of its value along the run: states, whose tangents are
states with the differentiated rates; what controllers hold; signals; powers. Unknowns of implicit blocks follow by the
implicit function theorem. Steps, samples, corrections, rows and integrals of the loop then act on tangents as they do
on what they belong to, so that a method gives the exact derivative of its own steps (Griewank and Walther, Evaluating
Derivatives, 2008, chapter 3); an implicit step is differentiated with the elimination in it. At kinks derivatives are
one-sided; tables are linear within their cells; conditions and steps of discrete logic stay where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from propermodel.codegen.program import Array, Assign, Function, ImplicitStep, Layout, Program, Slot, Solve
from propermodel.codegen.schedule import number_solves
from propermodel.codegen.tangent_rules import TangentRules, Tangents, needed_solves
from propermodel.diagnostics import Path
from propermodel.expressions.core import ONE, TIME, ZERO, Expr, SymbolKind, multiply, sign, symbol

# What is kept from one function to the next, with its tangents.
_KEPT = (Array.STATE, Array.DISCRETE, Array.FACTOR, Array.STAGE)


@dataclass(frozen=True, slots=True)
class Direction:
    """The parameters of a program that change along it, at the rate one or at rates that a run tells."""

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
    derivative, and this times the sign of the power, which is the derivative of its absolute value. JUMP has the
    tangents of jumps along the directions and with time alone, then those of guards along the directions and in time.
    """

    program: Program
    directions: tuple[Direction, ...]
    seeds: tuple[Seed, ...]
    states: int
    discretes: int
    parameters: int
    signals: int
    powers: int
    guards: int
    jumps: int

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

    def jump(self, direction: int) -> slice:
        """Where the tangents of JUMP along a direction are; those with time alone follow those of the directions."""
        return slice((direction + 1) * self.jumps, (direction + 2) * self.jumps)

    def guard(self, direction: int) -> slice:
        """Where, in JUMP, the tangents of GUARD along a direction are; their rates in time follow the directions."""
        first = (len(self.directions) + 2) * self.jumps
        return slice(first + direction * self.guards, first + (direction + 1) * self.guards)


def with_tangents(
    program: Program, directions: Sequence[Direction], signals: Sequence[int], powers: Sequence[int]
) -> TangentProgram:
    """A program, with the implicit step of its method, and its tangents; with the chosen entries of SIGNAL and POWER.

    Raises:
        SimulationError: the derivatives pass an implicit block that is too large.
    """
    if program.switching is not None:
        raise ValueError("programs with ideal switches have no tangents")
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
        counted = (*_KEPT, Array.PARAMETER, Array.GUARD, Array.JUMP)
        self._lengths = {array: lengths.get(array, 0) for array in counted}
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
            observe=self._function(program.observe, is_whole=False),
            samples=tuple(map(self._function, program.samples)),
            corrections=tuple(map(self._function, program.corrections)),
            layout=self._layout(program.layout, count),
            jumps=None if program.jumps is None else self._jumps(program.jumps),
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
            guards=self._lengths[Array.GUARD],
            jumps=self._lengths[Array.JUMP],
        )

    def _implicit(self, step: ImplicitStep) -> ImplicitStep:
        directions = range(len(self._directions))
        return ImplicitStep(
            first=self._function(step.first),
            first_again=None if step.first_again is None else self._function(step.first_again),
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
                Array.JUMP: (count + 2) * self._lengths[Array.JUMP] + (count + 1) * self._lengths[Array.GUARD],
            },
            momenta=all_of(layout.momenta),
            displacements=all_of(layout.displacements),
        )

    def _function(self, function: Function, *, is_whole: bool = True) -> Function:
        """A function with the tangents of what it assigns; with all its blocks, or with those that these need."""
        rules = TangentRules(self._leaves, len(self._directions))
        kept = [step for step in function.steps if isinstance(step, Assign) and self._is_chosen(step.slot)]
        solves = [step for step in function.steps if isinstance(step, Solve)]
        if not is_whole:
            solves = needed_solves(solves, [step.value for step in kept])
        for solve in solves:
            rules.add_solution(solve)
        assigns: list[Assign] = []
        for step in kept:
            assigns += self._with_tangents(step, rules.of(step.value))
        return Function(function.name, (*solves, *assigns))

    def _jumps(self, function: Function) -> Function:
        """What events make of the run, and how that and the guards change: along directions, with time, in time.

        Two directions are added: along the first time passes and nothing moves, along the second everything moves.
        """
        count, jumps, guards = len(self._directions), self._lengths[Array.JUMP], self._lengths[Array.GUARD]
        rates = {step.slot: step.value for step in self._program.rates.steps if isinstance(step, Assign)}
        moving = {leaf: (*tangents, ZERO, ZERO) for leaf, tangents in self._leaves.items()}
        for leaf, slot in self._program.layout.slots.items():
            if slot.array is Array.STATE:
                moving[leaf] = (*self._leaves[leaf], ZERO, rates.get(Slot(Array.RATE, slot.index), ZERO))
        moving[TIME] = (ZERO,) * count + (ONE, ONE)
        rules = TangentRules(moving, count + 2)
        assigned = [step for step in function.steps if isinstance(step, Assign)]
        assert self._program.guards is not None
        watched = [step for step in self._program.guards.steps if isinstance(step, Assign)]
        solves = needed_solves(
            number_solves(self._program), [*rates.values(), *(step.value for step in (*assigned, *watched))]
        )
        for solve in solves:
            rules.add_solution(solve)
        assigns = list(assigned)
        for step in assigned:
            for k, value in enumerate(rules.of(step.value)[: count + 1]):
                assigns.append(Assign(Slot(Array.JUMP, (k + 1) * jumps + step.slot.index), value))
        for step in watched:
            tangents = rules.of(step.value)
            for k, value in enumerate((*tangents[:count], tangents[-1])):
                index = (count + 2) * jumps + k * guards + step.slot.index
                assigns.append(Assign(Slot(Array.JUMP, index), value))
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
