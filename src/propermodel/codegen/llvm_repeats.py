# pyright: basic
"""Prints repetitions as loops: of wide operations where there is one lane, of one instance after the other elsewhere.

Repetitions of equal length share a loop where each instance needs nothing else of the others than what this instance
gives. The last pass of a loop ends with the last instance and may do some again that were done before, which gives
the same values: a loop writes no row that it reads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from propermodel.codegen.llvm_block import Block, Value
from propermodel.codegen.llvm_text import WIDE, Module, Shape, literal
from propermodel.codegen.repeats import Repeat, Rows
from propermodel.expressions.core import TIME, Expr

_TOGETHER = 4  # instances in one pass, where an instance has several lanes
_MOST_SHARING = 12  # repetitions in a loop: more values than registers


def repeat_lines(module: Module, repeats: Iterable[Repeat]) -> list[str]:
    """The instructions of repetitions that follow each other."""
    block = Block(module, {}, Shape(WIDE) if module.frame.shape.lanes == 1 else None)
    for number, repeat in enumerate(sharing(repeats)):
        _Loop(block, repeat, f"loop{number}").write()
    return block.text.lines


def sharing(repeats: Iterable[Repeat]) -> list[list[Repeat]]:
    """Repetitions by the loop in which they are done; those they need are in the same loop or in one before."""
    loops: list[list[Repeat]] = []
    for repeat in repeats:
        chosen: list[Repeat] | None = None
        for loop in reversed(loops):
            needed = [(target, other) for other in loop for target in other.targets if _reads(repeat, target, other)]
            is_fitting = len(loop) < _MOST_SHARING and len(loop[0].nodes) == len(repeat.nodes)
            if is_fitting and all(target in repeat.operands for target, _ in needed):
                chosen = loop
            if needed:
                break
        if chosen is None:
            loops.append([repeat])
        else:
            chosen.append(repeat)
    return loops


def _reads(repeat: Repeat, target: Rows, other: Repeat) -> bool:
    """Whether an operand may lie in rows that another repetition fills."""
    first, last = target.first, target.first + target.step * (len(other.nodes) - 1)
    length = len(repeat.nodes) - 1
    return any(
        isinstance(operand, Rows)
        and min(operand.first, operand.first + operand.step * length) <= max(first, last)
        and max(operand.first, operand.first + operand.step * length) >= min(first, last)
        for operand in repeat.operands
    )


class _Loop:
    def __init__(self, block: Block, repeats: list[Repeat], name: str) -> None:
        self._block = block
        self._text = block.text
        self._frame = block.text.frame
        self._repeats = repeats
        self._name = name
        self._is_wide = self._frame.shape.lanes == 1
        self._row_bytes = self._frame.offset(1)

    def write(self) -> None:
        """Write the loop into the text."""
        text, name = self._text, self._name
        at_once = WIDE if self._is_wide else _TOGETHER
        last = len(self._repeats[0].nodes) - at_once
        text.do(f"br label %{name}.before")
        text.label(f"{name}.before")
        readers = [[self._reader(repeat, place) for place in range(len(repeat.operands))] for repeat in self._repeats]
        text.do(f"br label %{name}")
        text.label(name)
        first, following = f"%{name}.first", f"%{name}.next"
        text.do(f"{first} = phi i64 [ 0, %{name}.before ], [ {following}, %{name} ]")
        for place in range(1 if self._is_wide else at_once):
            self._pass(first if not place else text.emit(f"add nuw nsw i64 {first}, {place}"), readers)
        text.do(f"%{name}.all = add nuw nsw i64 {first}, {at_once}")
        text.do(f"%{name}.over = icmp ugt i64 %{name}.all, {last}")
        text.do(f"{following} = select i1 %{name}.over, i64 {last}, i64 %{name}.all")
        text.do(f"%{name}.more = icmp ult i64 {first}, {last}")
        text.do(f"br i1 %{name}.more, label %{name}, label %{name}.end")
        text.label(f"{name}.end")

    def _pass(self, instance: str, readers: list[list[Callable[[str], Value]]]) -> None:
        known: dict[Rows, Value] = {}
        for repeat, reads in zip(self._repeats, readers, strict=True):
            operands: list[Value] = []
            for operand, read in zip(repeat.operands, reads, strict=True):
                value = known.get(operand) if isinstance(operand, Rows) else None
                if value is None:
                    value = read(instance)
                    if isinstance(operand, Rows):
                        known[operand] = value
                operands.append(value)
            result = operands[0] if repeat.is_copy else self._block.result(repeat.nodes[0], operands)
            number = self._block.fitted(result)
            for target in repeat.targets:
                self._store(number, target, instance)
                known[target] = result

    def _reader(self, repeat: Repeat, place: int) -> Callable[[str], Value]:
        """What gives the value of an operand for an instance; what is the same for all is read before the loop."""
        operand, node = repeat.operands[place], repeat.nodes[0]
        if isinstance(operand, Expr):
            text = "%t" if operand is TIME else literal(operand.data[0])
            return lambda _: Value(text, is_uniform=True)
        is_truth = not repeat.is_copy and node.args[place].is_condition
        if not operand.step:
            same = self._value(self._load(operand, "0"), is_truth=is_truth)
            return lambda _: same
        return lambda instance: self._value(self._load(operand, instance), is_truth=is_truth)

    def _value(self, number: str, *, is_truth: bool) -> Value:
        text = self._text
        return Value(text.compare("une", number, text.constant(0.0)) if is_truth else number, is_truth)

    def _load(self, rows: Rows, instance: str) -> str:
        """The numbers of one pass."""
        text, align = self._text, self._frame.shape.alignment
        if not self._is_wide or rows.step == 1:
            return text.emit(f"load {text.kind}, ptr {self._pointer(rows, instance)}, align {align}")
        if not rows.step:
            return text.spread(text.emit(f"load double, ptr {self._pointer(rows, instance)}, align {align}"))
        numbers = "poison"
        for lane in range(WIDE):
            number = text.emit(f"load double, ptr {self._pointer(rows, instance, lane)}, align {align}")
            numbers = text.with_part(numbers, number, lane)
        return numbers

    def _store(self, number: str, rows: Rows, instance: str) -> None:
        text, align = self._text, self._frame.shape.alignment
        if not self._is_wide or rows.step == 1:
            text.do(f"store {text.kind} {number}, ptr {self._pointer(rows, instance)}, align {align}")
            return
        for lane in range(WIDE):
            pointer = self._pointer(rows, instance, lane)
            text.do(f"store double {text.part(number, lane)}, ptr {pointer}, align {align}")

    def _pointer(self, rows: Rows, instance: str, lane: int = 0) -> str:
        """The row of an instance, or of one that stands so many after it."""
        text = self._text
        away = text.emit(f"mul nsw i64 {instance}, {rows.step * self._row_bytes}")
        offset = self._frame.offset(rows.first + lane * rows.step)
        base = text.emit(f"getelementptr inbounds i8, ptr %w, i64 {offset}")
        return text.emit(f"getelementptr inbounds i8, ptr {base}, i64 {away}")
