# pyright: basic
"""Prints repetitions as loops: of wide operations where there is one lane, of one instance after the other elsewhere.

Repetitions of equal length share a loop where each instance needs nothing else of the others than what this instance
gives. The last pass of a loop ends with the last instance and may do some again that were done before, which gives
the same values: a loop writes no row that it reads. Only what is added up is left out when it is done again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from propermodel.codegen.llvm_block import Block, Value
from propermodel.codegen.llvm_sums import Sums
from propermodel.codegen.llvm_text import WIDE, Module, Shape, literal
from propermodel.codegen.repeats import Repeat, Rows
from propermodel.expressions.core import TIME, Expr

_TOGETHER = 4  # instances in one pass, where an instance has several lanes
_MOST_SHARING = 12  # repetitions in a loop: more values than registers


def repeat_lines(module: Module, repeats: Iterable[Repeat], sums: Sums | None) -> list[str]:
    """The instructions of repetitions that follow each other; powers are added up or stored."""
    block = Block(module, {}, Shape(WIDE) if module.frame.shape.lanes == 1 else None)
    for number, repeat in enumerate(sharing(repeats)):
        _Loop(block, repeat, f"loop{number}", sums).write()
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
    def __init__(self, block: Block, repeats: list[Repeat], name: str, sums: Sums | None) -> None:
        self._block = block
        self._text = block.text
        self._frame = block.text.frame
        self._repeats = repeats
        self._name = name
        self._sums = sums
        self._share = ""
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
        if self._sums is not None:
            self._share = self._sums.share(text)
        text.do(f"br label %{name}")
        text.label(name)
        first, following = f"%{name}.first", f"%{name}.next"
        text.do(f"{first} = phi i64 [ 0, %{name}.before ], [ {following}, %{name} ]")
        text.do(f"%{name}.done = phi i64 [ 0, %{name}.before ], [ %{name}.all, %{name} ]")
        text.do(f"%{name}.again = sub i64 %{name}.done, {first}")
        for place in range(1 if self._is_wide else at_once):
            instance = first if not place else text.emit(f"add nuw nsw i64 {first}, {place}")
            self._pass(instance, readers, self._fresh(place) if self._sums is not None and last % at_once else "")
        text.do(f"%{name}.all = add nuw nsw i64 {first}, {at_once}")
        text.do(f"%{name}.over = icmp ugt i64 %{name}.all, {last}")
        text.do(f"{following} = select i1 %{name}.over, i64 {last}, i64 %{name}.all")
        text.do(f"%{name}.more = icmp ult i64 {first}, {last}")
        text.do(f"br i1 %{name}.more, label %{name}, label %{name}.end")
        text.label(f"{name}.end")

    def _fresh(self, place: int) -> str:
        """Where an instance is not one that an earlier pass has done."""
        text, again = self._text, f"%{self._name}.again"
        if not self._is_wide:
            return text.emit(f"icmp sle i64 {again}, {place}")
        kind = f"<{WIDE} x i64>"
        first = text.emit(f"insertelement {kind} poison, i64 {again}, i32 0")
        every = text.emit(f"shufflevector {kind} {first}, {kind} poison, <{WIDE} x i32> zeroinitializer")
        places = ", ".join(f"i64 {k}" for k in range(WIDE))
        return text.emit(f"icmp sle {kind} {every}, <{places}>")

    def _pass(self, instance: str, readers: list[list[Callable[[str], Value]]], fresh: str) -> None:
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
                known[target] = result
                if self._sums is not None and self._sums.takes(target.first):
                    self._add(self._sums, number, target, instance, fresh)
                else:
                    self._store(number, target, instance)

    def _add(self, sums: Sums, power: str, rows: Rows, instance: str, fresh: str) -> None:
        """Add a power to its integrals, once."""
        text = self._text
        energy = text.multiply(power, self._share)
        if fresh:
            truth = text.shape.truth if self._is_wide else "i1"
            # Whatever it is added to stays the same to the last bit.
            nothing = text.constant(-0.0)
            energy = text.emit(f"select {truth} {fresh}, {text.kind} {energy}, {text.kind} {nothing}")
        sums.add(
            text,
            energy,
            lambda away: self._load(Rows(rows.first + away, rows.step), instance),
            lambda away, number: self._store(number, Rows(rows.first + away, rows.step), instance),
        )

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
