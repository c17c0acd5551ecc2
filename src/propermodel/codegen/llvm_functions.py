# pyright: basic
"""Prints the functions of a program, cut into pieces that LLVM compiles in linear time."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from propermodel.codegen.arrangement import Printing
from propermodel.codegen.llvm_block import Block
from propermodel.codegen.llvm_bundles import Bundle, bundled
from propermodel.codegen.llvm_loops import has_solve
from propermodel.codegen.llvm_newton import write_newton
from propermodel.codegen.llvm_repeats import repeat_lines
from propermodel.codegen.llvm_scratch import Life, Packs, Scratch, Streams
from propermodel.codegen.llvm_sums import ADDING, Sums
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Module, Text
from propermodel.codegen.program import Array, Function, Program
from propermodel.codegen.repeats import Item as Unbundled
from propermodel.codegen.repeats import Repeat, RepeatFinder, StoreRow
from propermodel.codegen.schedule import (
    Call,
    Level,
    Order,
    Store,
    frontier,
    node_levels,
    number_solves,
    sequence,
)
from propermodel.expressions.core import Expr, Op, postorder

_RARE = frozenset({"observe", "jumps", "switching"})
_WEIGHTS = {Op.LOOKUP: 20, Op.SLOPE: 3, Op.POWER: 3, Op.SIGN: 4, Op.MINIMUM: 2, Op.MAXIMUM: 2}


Item = Unbundled | Bundle


@dataclass(frozen=True)
class Plan:
    """What a function does: items, then what is stored when everything has been read, and where nodes are kept."""

    name: str
    items: list[Unbundled]
    late: list[StoreRow]
    copies: list[Repeat]
    rows: dict[Expr, int]
    has_loops: bool


@dataclass
class Piece:
    """What one LLVM function computes, and what it does at its end."""

    items: list[Item] = field(default_factory=list)
    late: list[StoreRow] = field(default_factory=list)
    weight: int = 0


class Writer:
    """Writes the functions of one program into a module."""

    def __init__(self, module: Module, program: Program, printing: Printing) -> None:
        self.module = module
        self.program = program
        self.printing = printing
        self.numbers = number_solves(program)
        self._scratch = Scratch(module.frame)
        self._streams = Streams(module.frame)
        self._sums: Sums | None = None  # while powers are added up
        self.adds_powers = False
        self.kept: dict[Level, dict[Expr, int]] = {Level.RUN: {}, Level.SAMPLE: {}}

    def write_program(self, *, may_add: bool) -> None:
        """Write `prepare`, `refresh`, and the functions of the program (`sample.<k>`, `correct.<k>`).

        If powers may be added up where they are computed, there is `rates.adding`, too, where it pays.
        """
        program = self.program
        levels = node_levels(program.continuous, program.layout)
        nodes = frontier(program.continuous, levels)
        for level, kept in self.kept.items():
            kept.update((node, self.module.frame.new_row()) for node in nodes if levels[node] is level)
        packs = Packs(self.module.frame, levels)
        rows = {**self.kept[Level.RUN], **self.kept[Level.SAMPLE]}
        # What loops want to have laid out is known before the functions are written that lay it out.
        continuous = [self._planned(*named, rows, packs) for named in self._continuous()]
        for name, level in (("prepare", Level.RUN), ("refresh", Level.SAMPLE)):
            self._write_kept(name, level, [StoreRow(*filled) for filled in packs.rows(level)])
        for plan in continuous:
            self._write_plan(plan)
            if plan.name == "rates" and plan.has_loops and may_add and not has_solve(program.rates):
                self.adds_powers = True
                self._sums = Sums(self.module.frame)
                self._write_plan(replace(plan, name=ADDING))
                self._sums = None
        for k, function in enumerate(program.samples):
            self._write_plan(self._planned(f"sample.{k}", function, self.kept[Level.RUN], None))

    def _continuous(self) -> Iterator[tuple[str, Function]]:
        """The functions that read what is kept, and their names."""
        program = self.program
        yield "rates", program.rates
        yield "displacement_rates", program.displacement_rates
        yield "observe", program.observe
        for name in ("guards", "jumps", "switching"):
            function = getattr(program, name)
            if function is not None:
                yield name, function
        if program.implicit_step is not None:
            yield from ((function.name, function) for function in program.implicit_step.functions)
        yield from ((f"correct.{k}", function) for k, function in enumerate(program.corrections))

    def _write_kept(self, name: str, level: Level, packs: Iterable[StoreRow]) -> None:
        """A function that computes what changes only with the parameters, or with the samples."""
        known = self.kept[Level.RUN] if level is Level.SAMPLE else {}
        order = Order(known.__contains__)
        items: list[Unbundled] = []
        for node, row in self.kept[level].items():
            items.extend(order.new_below(node))
            items.append(StoreRow(row, node))
        finder = self._finder(known)
        items = finder.arranged([*items, *packs])
        self.write(name, items, finder.rows)

    def _finder(self, rows: dict[Expr, int], packs: Packs | None = None) -> RepeatFinder:
        return RepeatFinder(self.module.frame, dict(rows), self._streams, self.printing.loops_from, packs)

    def _planned(self, name: str, function: Function, rows: dict[Expr, int], packs: Packs | None) -> Plan:
        """What a function does, in order."""
        items: list[Unbundled] = []
        late: list[StoreRow] = []
        for item in sequence(function, self.numbers, rows.__contains__):
            if isinstance(item, Store):
                store = StoreRow(self.module.frame.row(item.slot.array, item.slot.index), item.value)
                # What the function also reads is written when everything has been read.
                (late if item.slot.array in (Array.DISCRETE, Array.STATE) else items).append(store)
            else:
                items.append(item)
        finder = self._finder(rows, packs)
        items = finder.arranged(items, late)
        late, copies = finder.copied(late)
        return Plan(name, items, late, copies, finder.rows, finder.is_arranged)

    def _write_plan(self, plan: Plan) -> None:
        is_rare = plan.name in _RARE
        self.write(plan.name, plan.items, plan.rows, plan.late, plan.copies, is_rare=is_rare)

    def write(
        self,
        name: str,
        items: Sequence[Item],
        rows: dict[Expr, int],
        late: Iterable[StoreRow] = (),
        copies: Iterable[Repeat] = (),
        *,
        is_rare: bool = False,
    ) -> None:
        """Write one function as a sequence of pieces; values that cross a cut go through memory.

        What is rarely called is compiled fast rather than well: most of a large model's code observes.
        """
        if self.module.frame.shape.lanes == 1:
            items = list(bundled(items, (Call, Repeat)))
        pieces = self._cut(items)
        if any(isinstance(item, Repeat) for item in pieces[-1].items):
            pieces.append(Piece())
            pieces.append(Piece())
        pieces[-1].late.extend(late)
        pieces.extend(Piece([repeat]) for repeat in copies)
        with self._scratch.lent(self._crossing(pieces, rows)) as lent:
            rows = {**rows, **lent}
            for k, piece in enumerate(pieces):
                attributes = "noinline optnone" if is_rare else "noinline" if len(pieces) > 1 else ""
                self._write_piece(name if len(pieces) == 1 else f"{name}.piece{k}", piece, rows, attributes)
        if len(pieces) > 1:
            calls = [f"  call void @{name}.piece{k}({PASSED})" for k in range(len(pieces))]
            self._define(name, calls, "")

    def _define(self, name: str, lines: list[str], attributes: str) -> None:
        head = f"define internal void @{name}({ARGUMENTS}) {attributes} {{"
        self.module.functions.append("\n".join([head, *lines, "  ret void", "}"]))

    def _cut(self, items: Sequence[Item]) -> list[Piece]:
        pieces = [Piece()]
        for item in items:
            weight = sum(_WEIGHTS.get(node.op, 1) for node in _nodes_of(item)) or 1
            piece = pieces[-1]
            is_other = bool(piece.items) and isinstance(item, Repeat) is not isinstance(piece.items[-1], Repeat)
            if is_other or (piece.weight + weight > self.printing.most_instructions and piece.items):
                piece = Piece()
                pieces.append(piece)
            piece.items.append(item)
            piece.weight += weight
        return pieces

    def _crossing(self, pieces: list[Piece], rows: Container[Expr]) -> dict[Expr, Life]:
        """The pieces between which values live that cross a cut and have no row of their own."""
        home: dict[Expr, int] = {}
        last: dict[Expr, int] = {}

        def use(nodes: Iterable[Expr], piece: int, *, outside: bool = False) -> None:
            for node in nodes:
                if node in home and (outside or home[node] != piece):
                    last[node] = piece

        for k, piece in enumerate(pieces):
            for item in (*piece.items, *piece.late):
                for node in _nodes_of(item):
                    use(node.args, k)
                    if node not in rows:
                        home[node] = k
                if isinstance(item, StoreRow):
                    use((item.value,), k)
                elif isinstance(item, Call):
                    use(item.captures, k, outside=True)  # read by the residuals, which are functions of their own
        return {node: Life(home[node], end) for node, end in last.items()}

    def _write_piece(self, name: str, piece: Piece, rows: dict[Expr, int], attributes: str) -> None:
        if piece.items and isinstance(piece.items[0], Repeat):
            repeats = [item for item in piece.items if isinstance(item, Repeat)]
            self._define(name, repeat_lines(self.module, repeats, self._sums), attributes)
            return
        block = Block(self.module, rows)
        text = block.text
        for item in piece.items:
            if isinstance(item, Expr):
                block.compute(item)
            elif isinstance(item, Bundle):
                block.compute_together(item.nodes)
            elif isinstance(item, StoreRow):
                self._store(text, item.row, block.number(item.value))
            elif isinstance(item, Call):
                self._write_solve(f"{name}.solve{item.number}", item, rows)
                text.do(f"call void @{name}.solve{item.number}({PASSED})")
            for node in _nodes_of(item):
                if node in rows:
                    text.store_row(rows[node], block.number(node))
        values = [block.number(store.value) for store in piece.late]
        for store, value in zip(piece.late, values, strict=True):
            text.store_row(store.row, value)
        self._define(name, text.lines, attributes)

    def _store(self, text: Text, row: int, number: str) -> None:
        if self._sums is None or not self._sums.takes(row):
            text.store_row(row, number)
            return
        self._sums.add(
            text,
            text.multiply(number, self._sums.share(text)),
            lambda away: text.load_row(row + away),
            lambda away, total: text.store_row(row + away, total),
        )

    def _write_solve(self, name: str, call: Call, rows: dict[Expr, int]) -> None:
        """The functions of an implicit block: its residuals with their Jacobian, and the iteration."""
        frame = self.module.frame
        solve = call.solve
        size = len(solve.unknowns)
        trial, residual, jacobian = (frame.regions[region] for region in ("trial", "residual", "jacobian"))
        items: list[Item] = [*call.inner]
        items += [StoreRow(residual + i, root) for i, root in enumerate(solve.residuals)]
        items += [
            StoreRow(jacobian + size * i + j, entry)
            for i, row in enumerate(solve.jacobian)
            for j, entry in enumerate(row)
        ]
        at_trial = {unknown: trial + i for i, unknown in enumerate(solve.unknowns)}
        # What depends on the unknowns is computed here, whatever row it has in the function around.
        inner = set(call.inner)
        rows = {node: row for node, row in rows.items() if node not in inner}
        self.write(f"{name}.residual", items, {**rows, **at_trial})
        if not call.is_affine:
            needed = set(postorder(solve.residuals))
            alone: list[Item] = [node for node in call.inner if node in needed]
            alone += [StoreRow(residual + i, root) for i, root in enumerate(solve.residuals)]
            self.write(f"{name}.check", alone, {**rows, **at_trial})
        write_newton(self.module, name, call)


def _nodes_of(item: Item) -> tuple[Expr, ...]:
    """The nodes that an item computes one by one."""
    return (item,) if isinstance(item, Expr) else item.nodes if isinstance(item, Bundle) else ()
