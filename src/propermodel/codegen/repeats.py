"""Repeated structure of a function: one operation on many values that lie in memory at equal distances.

Straight-line code of a large model does not fit the caches of the processor. Nodes that are built alike, down to the
kind of memory their leaves are in, cannot depend on each other; where the rows of their operands and targets grow by
equal steps from one to the next, they become one `Repeat`, which is printed as a loop. Operands that cannot change
while the function is in use may lie anywhere: they are laid out in the order of the loop once (`Packs`). Every value
is computed by the same operation from the same values as before, so no bit changes; what has no such order, and all
of a small function, stays as it is.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from propermodel.codegen.likeness import Likeness
from propermodel.codegen.llvm_scratch import Packs, Streams
from propermodel.codegen.llvm_text import WIDE, Frame
from propermodel.codegen.program import Array
from propermodel.codegen.progressions import Point, progressions
from propermodel.codegen.schedule import Call, is_leaf, leaf_slot
from propermodel.expressions.core import TIME, Expr, Op

LEAST = 2 * WIDE  # instances of a loop


@dataclass(frozen=True, slots=True)
class StoreRow:
    """Store the value of a node in a row."""

    row: int
    value: Expr


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows at equal distances."""

    first: int
    step: int


@dataclass(frozen=True, slots=True, eq=False)
class Repeat:
    """The operation of the first node for all of them, or copies of what all are.

    An operand lies in rows, or is a constant or the time.
    """

    nodes: tuple[Expr, ...]
    operands: tuple[Rows | Expr, ...]
    targets: tuple[Rows, ...]
    is_copy: bool = False

    @property
    def computed(self) -> tuple[Expr, ...]:
        """The nodes that get their value here."""
        return () if self.is_copy else self.nodes


Item = Expr | StoreRow | Call | Repeat


@dataclass
class RepeatFinder:
    """Finds what is repeated in one function; `rows` are the nodes kept in memory, and get those that loops read."""

    frame: Frame
    rows: dict[Expr, int]
    streams: Streams
    loops_from: int  # so many items
    packs: Packs | None = None  # where nothing is laid out, every operand is where it is
    _used: set[Expr] = field(default_factory=set)  # read by something else than a store beside it
    is_arranged: bool = False  # there are repetitions

    def arranged(self, items: list[Item], late: Sequence[StoreRow] = ()) -> list[Item]:
        """The items, with repetitions in place of what is repeated; nothing moves past a solve."""
        if len(items) < self.loops_from or self._writes_what_it_reads(items):
            return items
        segments = [_Segment(self, part) for part in _between_calls(items)]
        if 2 * sum(segment.alike for segment in segments) < len(items):
            return items
        self.is_arranged = True
        self.streams.begin_function()
        self._used.update(store.value for store in late)
        self._used.update(value for segment in segments for value in segment.read())
        return [item for segment in segments for item in segment.ordered()]

    def copied(self, late: Sequence[StoreRow]) -> tuple[list[StoreRow], list[Repeat]]:
        """What is stored when everything has been read: one by one, and by copies from rows that loops have filled."""
        if not self.is_arranged:
            return [*late], []
        ready = [store for store in late if store.value.args and store.value in self.rows]
        found = list(_Segment(self, [*ready]).ordered())
        copied = set(ready).difference(item for item in found if isinstance(item, StoreRow))
        return [store for store in late if store not in copied], [item for item in found if isinstance(item, Repeat)]

    def is_used(self, node: Expr) -> bool:
        """Whether something else than a store beside it reads a node."""
        return node in self._used

    def is_power(self, row: int) -> bool:
        """Whether a row is that of a power, which may be added up instead of being stored."""
        return self.frame.is_in(Array.POWER, row)

    def row(self, node: Expr) -> int | None:
        """The row in which a value is found."""
        if node in self.rows:
            return self.rows[node]
        if node.args or node.op is Op.CONSTANT or node is TIME:
            return None
        slot = leaf_slot(self.frame.layout, node)
        return self.frame.row(slot.array, slot.index)

    def kind(self, node: Expr) -> Hashable:
        """What operands in the same place of operations that are alike have in common."""
        return ("packed", node.is_condition) if self.is_packed(node) else self.kind_in_memory(node)

    def kind_in_memory(self, node: Expr) -> Hashable:
        """Where a value is, if nothing is laid out."""
        if node is TIME or node.op is Op.CONSTANT:
            return node
        return ("kept", node.is_condition) if node.args else leaf_slot(self.frame.layout, node).array

    def is_packed(self, node: Expr) -> bool:
        """Whether a value is laid out where a loop wants it."""
        return self.packs is not None and node is not TIME and (node.op is Op.CONSTANT or self.packs.has(node))

    def packed(self, nodes: tuple[Expr, ...]) -> Rows | Expr:
        """Where values are that may lie anywhere."""
        assert self.packs is not None
        if nodes[0].op is Op.CONSTANT and all(node is nodes[0] for node in nodes):
            return nodes[0]
        rows = [self.row(node) for node in nodes]
        first, second = rows[0], rows[1]
        if first is not None and second is not None:
            step = second - first
            is_near = step in (0, 1) or self.frame.shape.lanes > 1
            if is_near and rows == [first + k * step for k in range(len(rows))]:
                return Rows(first, step)
        return Rows(self.packs.first_row(nodes), 1)

    def _writes_what_it_reads(self, items: list[Item]) -> bool:
        written = {item.row for item in items if isinstance(item, StoreRow)}
        read: set[Expr] = set()
        for item in items:
            read.update(item.args if isinstance(item, Expr) else (item.value,) if isinstance(item, StoreRow) else ())
        return any(is_leaf(node) and self._is_in_memory(node) and self.row(node) in written for node in read)

    def _is_in_memory(self, node: Expr) -> bool:
        return node in self.frame.layout.slots


def _between_calls(items: Iterable[Item]) -> list[list[Item]]:
    parts: list[list[Item]] = [[]]
    for item in items:
        if isinstance(item, Call):
            parts.append([item])
            parts.append([])
        else:
            parts[-1].append(item)
    return parts


@dataclass(frozen=True, slots=True, eq=False)
class _Cell:
    """One thing to do: compute a node and store it in rows, or store a value that is there."""

    node: Expr
    targets: tuple[int, ...]
    is_copy: bool = False

    @property
    def args(self) -> tuple[Expr, ...]:
        return (self.node,) if self.is_copy else self.node.args


class _Segment:
    """A part of a function in which the order is free."""

    def __init__(self, finder: RepeatFinder, items: list[Item]) -> None:
        self._finder = finder
        self._items = items
        self._nodes = {item for item in items if isinstance(item, Expr)}
        self._likeness = Likeness(finder.kind)
        self._of_node: dict[Expr, Repeat] = {}
        self._of_store: dict[StoreRow, Repeat] = {}
        self._groups = self._alike()

    @property
    def alike(self) -> int:
        """How many items, about, may be in repetitions."""
        return sum(len(cells) * (1 + len(cells[0].targets)) for cells in self._groups)

    def read(self) -> Iterator[Expr]:
        """What is read here by something else than a store beside it."""
        for item in self._items:
            if isinstance(item, Expr):
                yield from item.args
            elif isinstance(item, Call):
                yield from item.captures
            elif isinstance(item, StoreRow) and item.value not in self._nodes:
                yield item.value

    def ordered(self) -> Iterator[Item]:
        """The items in an order in which everything is computed before it is needed."""
        self._find()
        done: set[Expr | Repeat] = set()
        # One after the other, so that they can be printed as one loop.
        for repeat in dict.fromkeys(self._of_node.values()):
            yield from self._with_operands(repeat, done)
        for item in self._items:
            if isinstance(item, Expr):
                yield from self._with_operands(self._of_node.get(item, item), done)
            elif isinstance(item, StoreRow) and item in self._of_store:
                repeat = self._of_store[item]
                if repeat.is_copy and repeat not in done:
                    done.add(repeat)
                    yield repeat
            else:
                yield item

    def _with_operands(self, root: Expr | Repeat, done: set[Expr | Repeat]) -> Iterator[Item]:
        """What is still to be computed for something, and this."""
        stack = [root]
        while stack:
            unit = stack[-1]
            if unit not in done:
                members = unit.nodes if isinstance(unit, Repeat) else (unit,)
                operands = (self._of_node.get(a, a) for node in members for a in node.args if a in self._nodes)
                missing = list(dict.fromkeys(operand for operand in operands if operand not in done))
                if missing:
                    stack.extend(reversed(missing))
                    continue
                done.add(unit)
                yield unit
            stack.pop()

    def _find(self) -> None:
        for cells in self._groups:
            node = cells[0].node
            if node.op in (Op.LOOKUP, Op.SLOPE) and not cells[0].is_copy:
                self._place(cells)
                continue
            varying = self._varying(cells[0])
            known: list[tuple[_Cell, Point]] = []
            for cell in cells:
                rows = [self._finder.row(cell.args[k]) for k in varying]
                if None not in rows:
                    known.append((cell, (*(row for row in rows if row is not None), *cell.targets)))
            for members, step in progressions([point for _, point in known], LEAST):
                self._repeat([known[k] for k in members], step, varying)

    def _alike(self) -> list[list[_Cell]]:
        """Cells that are built alike, if they are many; those they need come before them."""
        targets: dict[Expr, list[int]] = {}
        for item in self._items:
            if isinstance(item, StoreRow):
                targets.setdefault(item.value, []).append(item.row)
        groups: dict[Hashable, list[_Cell]] = {}
        for item in self._items:
            if isinstance(item, Expr):
                rows = tuple(targets.get(item, ()))
                groups.setdefault((self._likeness.number(item), len(rows)), []).append(_Cell(item, rows))
            elif isinstance(item, StoreRow) and item.value not in self._nodes:
                key = ("copy", self._finder.kind_in_memory(item.value))
                groups.setdefault(key, []).append(_Cell(item.value, (item.row,), is_copy=True))
        return [cells for cells in groups.values() if len(cells) >= LEAST]

    def _varying(self, cell: _Cell) -> list[int]:
        """The places of operands that lie in rows of their own."""
        return [
            k
            for k, arg in enumerate(cell.args)
            if arg is not TIME and arg.op is not Op.CONSTANT and (cell.is_copy or not self._finder.is_packed(arg))
        ]

    def _place(self, cells: list[_Cell]) -> None:
        """Give nodes that are computed one by one rows side by side, so that what reads them can be repeated."""
        used = [cell.node for cell in cells if self._finder.is_used(cell.node)]
        first = self._finder.streams.take(len(used)) if used else 0
        self._finder.rows.update((node, first + k) for k, node in enumerate(used))

    def _repeat(self, members: list[tuple[_Cell, Point]], step: Point, varying: list[int]) -> None:
        cells = [cell for cell, _ in members]
        (first, point) = members[0]
        rows = [Rows(row, by) for row, by in zip(point, step, strict=True)]
        of_place = dict(zip(varying, rows, strict=False))
        operands: list[Rows | Expr] = []
        for k, arg in enumerate(first.args):
            if k in of_place:
                operands.append(of_place[k])
            elif arg is TIME or (first.node.op is Op.POWER and k == 1) or not self._finder.is_packed(arg):
                operands.append(arg)
            else:
                operands.append(self._finder.packed(tuple(cell.args[k] for cell in cells)))
        targets = rows[len(varying) :]
        nodes = tuple(cell.node for cell in cells)
        if not first.is_copy and any(self._finder.is_used(node) for node in nodes):
            home = next(
                (target for target in targets if target.step == 1 and not self._finder.is_power(target.first)), None
            )
            if home is None:
                home = Rows(self._finder.streams.take(len(nodes)), 1)
                targets.append(home)
            self._finder.rows.update((node, home.first + k) for k, node in enumerate(nodes))
        repeat = Repeat(nodes, tuple(operands), tuple(targets), first.is_copy)
        self._of_node.update((node, repeat) for node in repeat.computed)
        self._of_store.update((StoreRow(row, cell.node), repeat) for cell in cells for row in cell.targets)
