# pyright: basic
"""Prints Newton's method for one implicit block, for all lanes at once.

A lane that has converged is frozen, so that every lane goes through the numbers it would go through alone. A step
that makes the residuals grow, each weighed by the row of its Jacobian, is halved up to five times. Lanes that have not
converged begin again at zero, once.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from propermodel.codegen.dense import solve_dense
from propermodel.codegen.llvm_text import ARGUMENTS, PASSED, Module, Text
from propermodel.codegen.program import Array
from propermodel.codegen.schedule import Call, leaf_slot

MOST_HALVINGS = 5
LARGEST_STRAIGHT = 12  # larger systems are eliminated in loops


def write_newton(module: Module, name: str, call: Call) -> None:
    """Write the function `name`, which calls `<name>.residual`."""
    newton = _Newton(module, name, call)
    newton.affine() if call.is_affine else newton.iteration()
    body = "\n".join(newton.text.lines)
    module.functions.append(f"define internal void @{name}({ARGUMENTS}) {{\nentry:\n{body}\n}}")


class _Newton:
    def __init__(self, module: Module, name: str, call: Call) -> None:
        self.text = text = Text(module)
        self.shape = text.shape
        self.name = name
        self.call = call
        self.size = size = len(call.solve.unknowns)
        frame = module.frame
        self.unknown_rows = []
        for unknown in call.solve.unknowns:
            slot = leaf_slot(frame.layout, unknown)
            if slot.array is not Array.UNKNOWN:
                raise ValueError(f"'{unknown!r}' is solved for, but its slot is in {slot.array}")
            self.unknown_rows.append(frame.row(slot.array, slot.index))
        self.trial = [frame.regions["trial"] + i for i in range(size)]
        self.residual = [frame.regions["residual"] + i for i in range(size)]
        self.jacobian = [[frame.regions["jacobian"] + size * i + j for j in range(size)] for i in range(size)]
        self.alive, self.failed, self.failed_time = (
            frame.regions[region] for region in ("alive", "failed", "failed_time")
        )
        # Pointers are made in the entry block, which comes before every use.
        entries = (entry for row in self.jacobian for entry in row)
        verdict = (self.alive, self.failed, self.failed_time)
        for row in (*self.unknown_rows, *self.trial, *self.residual, *entries, *verdict):
            text.address(row)
        if size > LARGEST_STRAIGHT:
            for row in range((size + 1) * size):
                text.address(frame.regions["elimination"] + row)

    def affine(self) -> None:
        """One exact correction."""
        text = self.text
        start = [text.load_row(row) for row in self.unknown_rows]
        active = self._alive()
        self._evaluate(start)
        corrections = self._corrections()
        solution = [text.emit(f"fsub {text.kind} {x}, {d}") for x, d in zip(start, corrections, strict=True)]
        is_good = self.shape.truth_constant(True)
        infinity = self.shape.constant(math.inf)
        for x in solution:
            is_good = text.both(is_good, text.compare("olt", text.size(x), infinity))
        self._finish(solution, text.both(active, text.opposite(is_good)))

    def iteration(self) -> None:
        """Newton's method with damping and one retry."""
        text, kind, truth = self.text, self.text.kind, self.shape.truth
        size = self.size
        x, step = ([text.variable(kind) for _ in range(size)] for _ in range(2))
        factor, norm = text.variable(kind), text.variable(kind)
        weights = [text.variable(kind) for _ in range(size)]
        active = text.variable(truth)
        attempt, count, halvings = (text.variable("i32") for _ in range(3))
        for i, row in enumerate(self.unknown_rows):
            text.put(kind, text.load_row(row), x[i])
        text.put(truth, self._alive(), active)
        text.put("i32", "0", attempt)
        text.do("br label %begin")

        text.label("begin")
        text.put("i32", "0", count)
        self._evaluate([text.get(kind, item) for item in x])
        text.do("br label %iterate")

        text.label("iterate")
        before = [text.get(kind, item) for item in x]
        corrections = self._corrections()
        rest = self._accept_small(before, corrections, x, active)
        for i, correction in enumerate(corrections):
            text.put(kind, correction, step[i])
        text.do(f"br i1 {text.any(rest)}, label %continue, label %done")

        text.label("continue")
        is_last = text.emit(f"icmp sge i32 {text.counted(count)}, {self.call.solve.most_iterations}")
        text.do(f"br i1 {is_last}, label %give.up, label %first.trial")

        text.label("first.trial")
        for i, weight in enumerate(self._weights()):
            text.put(kind, weight, weights[i])
        text.put(kind, self._norm(weights), norm)
        text.put(kind, self.shape.constant(1.0), factor)
        text.put("i32", "0", halvings)
        # Where the whole step leads to residuals that the same Jacobian calls small, no other Jacobian is needed.
        first = []
        moving = text.get(truth, active)
        for here, correction in zip(before, corrections, strict=True):
            first.append(text.choose(moving, text.emit(f"fsub {kind} {here}, {correction}"), here))
        self._evaluate(first, "check")
        rest = self._accept_small(first, self._corrections(), x, active)
        text.do(f"br i1 {text.any(rest)}, label %trial, label %done")

        text.label("trial")
        share, moving = text.get(kind, factor), text.get(truth, active)
        tried = []
        for i in range(size):
            here = text.get(kind, x[i])
            there = text.subtract_product(here, share, text.get(kind, step[i]))
            tried.append(text.choose(moving, there, here))
        self._evaluate(tried)
        is_smaller = text.compare("ole", self._norm(weights), text.get(kind, norm))
        grew = text.both(moving, text.opposite(is_smaller))
        may_halve = text.emit(f"icmp slt i32 {text.get('i32', halvings)}, {MOST_HALVINGS}")
        again = text.emit(f"and i1 {text.any(grew)}, {may_halve}")
        text.do(f"br i1 {again}, label %halve, label %accept")

        text.label("halve")
        text.put(kind, text.choose(grew, text.multiply(share, self.shape.constant(0.5)), share), factor)
        text.counted(halvings)
        text.do("br label %trial")

        text.label("accept")
        for i, item in enumerate(tried):
            text.put(kind, item, x[i])
        text.do("br label %iterate")

        text.label("give.up")
        is_second = text.emit(f"icmp eq i32 {text.get('i32', attempt)}, 1")
        left = text.get(truth, active)
        for item in x:
            text.put(kind, text.choose(left, self.shape.constant(0.0), text.get(kind, item)), item)
        text.counted(attempt)
        text.do(f"br i1 {is_second}, label %done, label %begin")

        text.label("done")
        self._finish([text.get(kind, item) for item in x], text.get(truth, active))

    def _alive(self) -> str:
        return self.text.compare("une", self.text.load_row(self.alive), self.shape.constant(0.0))

    def _evaluate(self, at: list[str], what: str = "residual") -> None:
        """Compute the residuals at a trial point: with the Jacobian (`residual`) or alone (`check`)."""
        for row, item in zip(self.trial, at, strict=True):
            self.text.store_row(row, item)
        self.text.do(f"call void @{self.name}.{what}({PASSED})")

    def _corrections(self) -> list[str]:
        text = self.text
        if self.size > LARGEST_STRAIGHT:
            module = text.module
            module.declare("solve.loop", elimination(module))
            work = module.frame.regions["elimination"]
            pointers = (self.jacobian[0][0], self.residual[0], work)
            passed = ", ".join(f"ptr {text.address(row)}" for row in pointers)
            text.do(f"call void @solve.loop({passed}, i64 {self.size})")
            return [text.load_row(work + (self.size + 1) * i + self.size) for i in range(self.size)]
        matrix = [[text.load_row(entry) for entry in row] for row in self.jacobian]
        return solve_dense(matrix, [text.load_row(row) for row in self.residual], text)

    def _accept_small(self, before: list[str], corrections: list[str], x: list[str], active: str) -> str:
        """Move and freeze the lanes whose corrections are all small; the lanes that are left. All others stay."""
        text, solve = self.text, self.call.solve
        is_small = self.shape.truth_constant(True)
        after = []
        tolerance, infinity = self.shape.constant(solve.tolerance), self.shape.constant(math.inf)
        for here, correction, scale in zip(before, corrections, solve.scales, strict=True):
            there = text.emit(f"fsub {text.kind} {here}, {correction}")
            allowed = text.multiply(tolerance, text.add(text.size(there), self.shape.constant(scale)))
            size = text.size(correction)
            is_small = text.both(is_small, text.compare("ole", size, allowed))
            # An infinite correction is not small beside an infinite unknown.
            is_small = text.both(is_small, text.compare("olt", size, infinity))
            after.append(there)
        moving = text.get(self.shape.truth, active)
        arrived = text.both(moving, is_small)
        for there, item in zip(after, x, strict=True):
            text.put(text.kind, text.choose(arrived, there, text.get(text.kind, item)), item)
        rest = text.both(moving, text.opposite(is_small))
        text.put(self.shape.truth, rest, active)
        return rest

    def _weights(self) -> list[str]:
        text = self.text
        if self.size == 1:
            return [self.shape.constant(1.0)]
        result = []
        for row in self.jacobian:
            total = self.shape.constant(0.0)
            for entry, scale in zip(row, self.call.solve.scales, strict=True):
                size = text.size(text.load_row(entry))
                total = text.add(total, text.multiply(size, self.shape.constant(scale or 1.0)))
            result.append(text.divide(self.shape.constant(1.0), total))
        return result

    def _norm(self, weights: list[str]) -> str:
        text = self.text
        total = self.shape.constant(0.0)
        for row, weight in zip(self.residual, weights, strict=True):
            weighed = text.multiply(text.get(text.kind, weight), text.load_row(row))
            total = text.add(total, text.multiply(weighed, weighed))
        return total

    def _finish(self, solution: list[str], failed: str) -> None:
        """Keep the solution of the lanes that have one, record the failure of the others."""
        text, constant = self.text, self.shape.constant
        for row, item in zip(self.unknown_rows, solution, strict=True):
            text.store_row(row, text.choose(failed, text.load_row(row), item))
        text.do(f"br i1 {text.any(failed)}, label %fail, label %end")
        text.label("fail")
        number = constant(float(self.call.number + 1))
        text.store_row(self.failed, text.choose(failed, number, text.load_row(self.failed)))
        time = text.spread("%t")
        text.store_row(self.failed_time, text.choose(failed, time, text.load_row(self.failed_time)))
        text.store_row(self.alive, text.choose(failed, constant(0.0), text.load_row(self.alive)))
        text.do("br label %end")
        text.label("end")
        text.do("ret void")


def elimination(module: Module) -> str:
    """The function that does what `solve_dense` does, in loops: the solution is the last column of the work matrix."""
    text = Text(module)
    kind = text.kind
    size = 8 * text.shape.lanes
    width = text.emit("add i64 %n, 1")
    k, i, j = (text.variable("i64") for _ in range(3))
    factor = text.variable(kind)

    def at(base: str, row: str, columns: str, column: str) -> str:
        place = text.emit(f"add i64 {text.emit(f'mul i64 {row}, {columns}')}, {column}")
        return text.emit(f"getelementptr inbounds i8, ptr {base}, i64 {text.emit(f'mul i64 {place}, {size}')}")

    def now(counter: str) -> str:
        return text.get("i64", counter)

    def work(row: str, column: str) -> str:
        return at("%work", row, width, column)

    def load(pointer: str) -> str:
        return text.emit(f"load {kind}, ptr {pointer}, align {text.shape.alignment}")

    def store(item: str, pointer: str) -> None:
        text.do(f"store {kind} {item}, ptr {pointer}, align {text.shape.alignment}")

    def loop(counter: str, start: str, stop: str, body: Callable[[], None]) -> None:
        label = text.name()[1:]
        text.put("i64", start, counter)
        text.do(f"br label %{label}.test")
        text.label(f"{label}.test")
        text.do(f"br i1 {text.emit(f'icmp slt i64 {now(counter)}, {stop}')}, label %{label}.body, label %{label}.end")
        text.label(f"{label}.body")
        body()
        text.put("i64", text.emit(f"add i64 {now(counter)}, 1"), counter)
        text.do(f"br label %{label}.test")
        text.label(f"{label}.end")

    def after(counter: str) -> str:
        return text.emit(f"add i64 {now(counter)}, 1")

    def copy_row() -> None:
        loop(j, "0", "%n", lambda: store(load(at("%matrix", now(i), "%n", now(j))), work(now(i), now(j))))
        store(load(at("%right", now(i), "1", "0")), work(now(i), "%n"))

    def exchange() -> None:
        is_larger = text.compare("ogt", text.size(load(work(now(i), now(k)))), text.size(load(work(now(k), now(k)))))

        def exchange_entry() -> None:
            upper, lower = work(now(k), now(j)), work(now(i), now(j))
            x, y = load(upper), load(lower)
            store(text.choose(is_larger, y, x), upper)
            store(text.choose(is_larger, x, y), lower)

        loop(j, now(k), width, exchange_entry)

    def eliminate_below() -> None:
        text.put(kind, text.divide(load(work(now(i), now(k))), load(work(now(k), now(k)))), factor)

        def eliminate_entry() -> None:
            target = work(now(i), now(j))
            share = text.get(kind, factor)
            store(text.subtract_product(load(target), share, load(work(now(k), now(j)))), target)

        loop(j, after(k), width, eliminate_entry)

    def eliminate() -> None:
        loop(i, after(k), "%n", exchange)
        loop(i, after(k), "%n", eliminate_below)

    def substitute() -> None:
        row = text.emit(f"sub i64 {text.emit(f'sub i64 %n, {now(k)}')}, 1")

        def substitute_entry() -> None:
            target = work(row, "%n")
            store(text.subtract_product(load(target), load(work(row, now(j))), load(work(now(j), "%n"))), target)

        loop(j, text.emit(f"add i64 {row}, 1"), "%n", substitute_entry)
        target = work(row, "%n")
        store(text.divide(load(target), load(work(row, row))), target)

    loop(i, "0", "%n", copy_row)
    loop(k, "0", "%n", eliminate)
    loop(k, "0", "%n", substitute)
    parameters = "ptr noalias %matrix, ptr noalias %right, ptr noalias %work, i64 %n"
    head = f"define internal void @solve.loop({parameters}) noinline {{"
    return "\n".join([head, *text.lines, "  ret void", "}"])
