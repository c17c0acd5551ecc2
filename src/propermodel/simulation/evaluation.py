"""Values of expressions where those of their symbols are known: at one instant, or at many instants at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, MutableMapping, Sequence

import numpy as np

from propermodel.codegen.lower import Lowered
from propermodel.codegen.machine import FloatArray, Memory
from propermodel.codegen.numeric import Number, interpolate, operation_of
from propermodel.codegen.program import Array, Extrapolation
from propermodel.codegen.schedule import leaf_slot
from propermodel.codegen.tables import prepare_tables
from propermodel.expressions.core import Expr, Op


class Evaluation:
    """Evaluates expressions with the parameters, tables and values of a memory, unless others are given."""

    def __init__(self, lowered: Lowered, memory: Memory) -> None:
        program = lowered.program
        self._layout = program.layout
        self._tables = prepare_tables(program, memory.tables)
        self._arrays: Mapping[Array, FloatArray] = {
            Array.TIME: np.array([memory.time]),
            Array.STATE: memory.state,
            Array.DISCRETE: memory.discrete,
            Array.PARAMETER: memory.parameter,
            Array.UNKNOWN: memory.unknown,
        }

    def values(self, exprs: Sequence[Expr], given: Mapping[Expr, FloatArray]) -> FloatArray:
        """The values of expressions (rows) at instants (columns), given symbols or other nodes there.

        Raises:
            ValueError: an expression mentions a symbol that is neither given nor of the program.
        """
        known: dict[Expr, Number] = dict(given)
        with np.errstate(all="ignore"):
            self.complete(exprs, known)
        count = next((len(values) for values in given.values()), 1)
        found = np.empty((len(exprs), count))
        for row, expr in enumerate(exprs):
            found[row] = known[expr] * 1.0
        return found

    def complete(self, roots: Iterable[Expr], known: MutableMapping[Expr, Number]) -> None:
        """Add the values of roots, and of all that they consist of, to those that are known."""
        for node in missing(roots, known):
            known[node] = self._operate(node, known)

    def _operate(self, node: Expr, known: Mapping[Expr, Number]) -> Number:
        if node.op is Op.CONSTANT:
            return np.float64(node.data[0])
        if node.op in (Op.LOOKUP, Op.SLOPE):
            index = self._layout.table_index[node.args[0]]
            holds = self._layout.tables[index].extrapolation is Extrapolation.HOLD
            axis = None if node.op is Op.LOOKUP else int(node.data)
            coordinates = np.broadcast_arrays(*(known[arg] * 1.0 for arg in node.args[1:]))
            return interpolate(self._tables[index], coordinates, holds, axis)
        if not node.args:
            if node in self._layout.table_index:
                return np.float64(0.0)  # a table is read through its look-ups only
            slot = leaf_slot(self._layout, node)
            return self._arrays[slot.array][slot.index]
        function, truths = operation_of(node)
        operands: list[Number] = []
        for number, arg in enumerate(node.args):
            value = known[arg]
            if number < truths:
                operands.append(value if arg.is_condition else value != 0.0)
            else:
                operands.append(value * 1.0 if arg.is_condition else value)
        return function(*operands)


def missing(roots: Iterable[Expr], known: Mapping[Expr, object]) -> list[Expr]:
    """The nodes below the roots that are not known, arguments first."""
    order: list[Expr] = []
    seen: set[Expr] = set()
    for root in roots:
        stack: list[tuple[Expr, bool]] = [(root, False)]
        while stack:
            node, is_expanded = stack.pop()
            if node in seen or node in known:
                continue
            if is_expanded or not node.args:
                seen.add(node)
                order.append(node)
                continue
            stack.append((node, True))
            stack.extend((arg, False) for arg in reversed(node.args) if arg not in seen)
    return order
