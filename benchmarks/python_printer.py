"""Prints the functions of a program as Python, for compilers of Python: numba and JAX.

A function takes time, states, held values, parameters, unknowns and tables; it gives what it computes as a tuple, or as
two for rates: rates and powers, and unknowns. Newton's method is the plain one, begun where it ended last.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

from propermodel.codegen.program import Array, Extrapolation, Function, Program
from propermodel.codegen.schedule import Call, Store, leaf_slot, number_solves, power_plan, sequence, whole_power
from propermodel.expressions.core import Expr, Op

ARGUMENTS = "t, y, d, p, u, tables"
_READ = {Array.STATE: "y", Array.DISCRETE: "d", Array.PARAMETER: "p", Array.UNKNOWN: "u"}
_BINARY = {
    Op.ADD: "+",
    Op.SUBTRACT: "-",
    Op.MULTIPLY: "*",
    Op.DIVIDE: "/",
    Op.LESS: "<",
    Op.LESS_EQUAL: "<=",
    Op.EQUAL: "==",
    Op.AND: "&",
    Op.OR: "|",
}
_CALLED = {
    Op.ABSOLUTE: "abs",
    Op.SQUARE_ROOT: "xp.sqrt",
    Op.EXPONENTIAL: "xp.exp",
    Op.LOGARITHM: "xp.log",
    Op.SINE: "xp.sin",
    Op.COSINE: "xp.cos",
    Op.TANH: "xp.tanh",
    Op.FLOOR: "xp.floor",
    Op.ARCTANGENT: "xp.arctan2",
    Op.SIGN: "xp.sign",
}


class Dialect(StrEnum):
    """Who compiles the functions."""

    NUMBA = "numba"
    JAX = "jax"


def print_functions(program: Program, dialect: Dialect) -> str:
    """The source of `rates`, `displacement_rates`, `sample0`, ...; it uses `xp`, `choose`, `cell1`, `cell2`, `lax`."""
    printer = _Printer(program, dialect)
    parts = [
        printer.function("rates", program.rates, (Array.RATE, Array.POWER)),
        printer.function("displacement_rates", program.displacement_rates, (Array.RATE,)),
    ]
    parts += [printer.function(f"sample{k}", f, (Array.DISCRETE,)) for k, f in enumerate(program.samples)]
    return "\n\n".join(parts)


class _Printer:
    def __init__(self, program: Program, dialect: Dialect) -> None:
        self._program = program
        self._dialect = dialect
        self._numbers = number_solves(program)

    def function(self, name: str, function: Function, arrays: Iterable[Array]) -> str:
        """The source of a function that answers with these arrays and the unknowns."""
        body = _Body(self._program, self._dialect)
        stores: dict[tuple[Array, int], str] = {}
        for item in sequence(function, self._numbers, lambda _: False):
            if isinstance(item, Store):
                stores[item.slot.array, item.slot.index] = body.number(item.value)
            elif isinstance(item, Call):
                body.solve(item)
            else:
                body.compute(item)
        answers: list[str] = []
        for array in arrays:
            count = self._program.layout.lengths.get(array, 0)
            kept = _READ.get(array)
            missing = "0.0" if kept is None else f"{kept}[{{}}]"
            answers.append(_tuple(stores.get((array, i), missing.format(i)) for i in range(count)))
        unknowns = self._program.layout.lengths.get(Array.UNKNOWN, 0)
        answers.append(_tuple(body.solved.get(i, f"u[{i}]") for i in range(unknowns)))
        return "\n".join([f"def {name}({ARGUMENTS}):", *body.lines, f"    return {', '.join(answers)}"])


def _tuple(items: Iterable[str]) -> str:
    inner = ", ".join(items)
    return f"({inner},)" if inner else "()"


class _Body:
    def __init__(self, program: Program, dialect: Dialect, indent: str = "    ") -> None:
        self._program = program
        self._dialect = dialect
        self._indent = indent
        self._cells: dict[tuple[Expr, ...], str] = {}
        self.names: dict[Expr, str] = {}
        self.solved: dict[int, str] = {}
        self.lines: list[str] = []

    def _write(self, line: str) -> None:
        self.lines.append(self._indent + line)

    def number(self, node: Expr) -> str:
        """A node as a number."""
        text = self._text(node)
        return f"choose({text}, 1.0, 0.0)" if node.is_condition else text

    def _truth(self, node: Expr) -> str:
        return self._text(node) if node.is_condition else f"({self._text(node)} != 0.0)"

    def _text(self, node: Expr) -> str:
        if node in self.names:
            return self.names[node]
        if node.op is Op.CONSTANT:
            value = node.data[0]
            return f"xp.inf * {1 if value > 0 else -1}" if abs(value) == float("inf") else f"({value!r})"
        slot = leaf_slot(self._program.layout, node)
        return "t" if slot.array is Array.TIME else f"{_READ[slot.array]}[{slot.index}]"

    def compute(self, node: Expr) -> None:
        """Compute a node whose arguments are there."""
        text = self._look_up(node) if node.op in (Op.LOOKUP, Op.SLOPE) else self._operation(node)
        name = f"n{len(self.names)}"
        self._write(f"{name} = {text}")
        self.names[node] = name

    def _operation(self, node: Expr) -> str:
        op, args = node.op, node.args
        if op in (Op.AND, Op.OR):
            return f"{self._truth(args[0])} {_BINARY[op]} {self._truth(args[1])}"
        if op in _BINARY:
            return f"{self.number(args[0])} {_BINARY[op]} {self.number(args[1])}"
        if op in _CALLED:
            return f"{_CALLED[op]}({', '.join(map(self.number, args))})"
        match op:
            case Op.NEGATE:
                return f"-{self.number(args[0])}"
            case Op.NOT:
                return f"({self._truth(args[0])} == False)"
            case Op.WHERE:
                return f"choose({self._truth(args[0])}, {self.number(args[1])}, {self.number(args[2])})"
            case Op.MINIMUM | Op.MAXIMUM:
                first, second = map(self.number, args)
                return f"choose({first} {'<=' if op is Op.MINIMUM else '>='} {second}, {first}, {second})"
            case Op.POWER:
                return _power(self.number(args[0]), args[1].data[0])
            case _:
                raise ValueError(f"no Python for '{op}'")

    def _look_up(self, node: Expr) -> str:
        index = self._program.layout.table_index[node.args[0]]
        holds = self._program.layout.tables[index].extrapolation is Extrapolation.HOLD
        coordinates = [self.number(arg) for arg in node.args[1:]]
        axes = len(coordinates)
        if node.args not in self._cells:
            name = self._cells[node.args] = f"c{len(self._cells)}"
            self._write(f"{name} = cell{axes}(tables, {index}, {', '.join(coordinates)}, {holds})")
        c = self._cells[node.args]
        if axes == 1:
            return f"{c}[0] + {c}[1] * {c}[2]" if node.op is Op.LOOKUP else f"{c}[1]"
        if node.op is Op.LOOKUP:
            return f"({c}[0] + {c}[1] * {c}[4]) + ({c}[2] + {c}[3] * {c}[4]) * {c}[5]"
        return f"{c}[1] + {c}[3] * {c}[5]" if node.data == 0 else f"{c}[2] + {c}[3] * {c}[4]"

    def solve(self, call: Call) -> None:
        """Newton's method for one unknown.

        Raises:
            ValueError: there are several.
        """
        solve = call.solve
        if len(solve.unknowns) > 1:
            raise ValueError("implicit blocks of several unknowns are not printed as Python")
        (unknown,), (residual,), ((slope,),) = solve.unknowns, solve.residuals, solve.jacobian
        slot = leaf_slot(self._program.layout, unknown)
        x = f"x{slot.index}"
        is_jax = self._dialect is Dialect.JAX
        inner = _Body(self._program, self._dialect, self._indent + "    ")
        inner.names, inner._cells = {**self.names, unknown: "x"}, dict(self._cells)
        for node in call.inner:
            inner.compute(node)
        most, near = solve.most_iterations, f"{solve.tolerance!r} * (abs(x) + {solve.scales[0]!r})"
        last = [f"s = {inner.number(residual)} / ({inner.number(slope)})", "x = x - s"]
        if is_jax:
            self._write(f"def newton{x}(carry):")
            inner_lines = ["x, _, count = carry", *[line.strip() for line in inner.lines], *last]
            inner_lines.append(f"return x, abs(s) > {near}, count + 1")
            self.lines += [f"{self._indent}    {line}" for line in inner_lines]
            start = f"({self._text(unknown)}, True, 0)"
            self._write(f"{x} = lax.while_loop(lambda c: c[1] & (c[2] < {most}), newton{x}, {start})[0]")
        else:
            self._write(f"x = {self._text(unknown)}")
            self._write(f"for _ in range({most}):")
            self.lines += inner.lines
            self.lines += [f"{self._indent}    {line}" for line in (*last, f"if abs(s) <= {near}:", "    break")]
            self._write(f"{x} = x")
        self.names[unknown] = x
        self.solved[slot.index] = x


def _power(base: str, exponent: float) -> str:
    plan = power_plan(exponent)
    if plan is None:
        return f"{base} ** {exponent!r}"
    result = whole_power(base, plan.whole, lambda a, b: f"({a} * {b})") if plan.whole else ""
    if plan.has_root:
        result = f"{result} * xp.sqrt({base})" if result else f"xp.sqrt({base})"
    return f"1.0 / ({result})" if plan.is_inverse else result
