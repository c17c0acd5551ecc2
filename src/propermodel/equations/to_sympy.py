"""Readable equations as SymPy expressions; SymPy is imported when this is used."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from propermodel.diagnostics import ModelError
from propermodel.expressions.core import Expr, Op, SymbolKind, postorder

if TYPE_CHECKING:
    from propermodel.equations.readable import ReadableEquations


@dataclass(frozen=True)
class SymPyEquations:
    """State equations as SymPy expressions of symbols without units, real by assumption.

    `symbols` has every symbol by its name; tables are undefined functions. `rates` gives the rate of every state,
    `definitions` what the rates mention, in computing order, and `residuals` what is zero.
    """

    symbols: Mapping[str, Any]
    inputs: tuple[Any, ...]
    rates: Mapping[Any, Any]
    definitions: Mapping[Any, Any]
    outputs: Mapping[Any, Any]
    residuals: tuple[Any, ...]

    @property
    def states(self) -> tuple[Any, ...]:
        """The symbols of the states."""
        return tuple(self.rates)

    def substituted(self) -> Mapping[Any, Any]:
        """The rates with all definitions put in."""
        known: dict[Any, Any] = {}
        for symbol, value in self.definitions.items():
            known[symbol] = value.xreplace(known)
        return {state: rate.xreplace(known) for state, rate in self.rates.items()}


def sympy_equations(equations: ReadableEquations) -> SymPyEquations:
    """The equations for SymPy.

    Raises:
        ModelError: SymPy is not installed.
    """
    convert = _Converter(equations)
    leaves = {leaf: convert(leaf) for leaf in equations.names if leaf.data.kind is not SymbolKind.TABLE}
    return SymPyEquations(
        symbols={str(equations.names[leaf]): made for leaf, made in leaves.items()},
        inputs=tuple(leaves[leaf] for leaf in equations.inputs),
        rates={convert(state.symbol): convert(state.right) / convert(state.coefficient) for state in equations.states},
        definitions={convert(d.symbol): convert(d.value) for d in equations.definitions},
        outputs={convert(d.symbol): convert(d.value) for d in equations.outputs},
        residuals=tuple(convert(residual) for block in equations.blocks for residual in block.residuals),
    )


class _Converter:
    def __init__(self, equations: ReadableEquations) -> None:
        try:
            import sympy
        except ImportError:
            raise ModelError.of(
                "equations/no-sympy",
                "SymPy is not installed",
                help="pip install 'propermodel[symbolic]'",
            ) from None
        self._names = equations.names
        self._known: dict[Expr, Any] = {}
        self._sympy: Any = sympy
        self._functions = _functions(sympy)

    def __call__(self, expr: Expr) -> Any:
        for node in postorder([expr]):
            if node not in self._known:
                self._known[node] = self._node(node, [self._known[arg] for arg in node.args])
        return self._known[expr]

    def _node(self, node: Expr, args: list[Any]) -> Any:
        sympy = self._sympy
        match node.op:
            case Op.CONSTANT:
                value = node.data[0]
                return sympy.Integer(int(value)) if value == int(value) else sympy.Float(value)
            case Op.SYMBOL:
                name = str(self._names[node])
                return sympy.Function(name) if node.data.kind is SymbolKind.TABLE else sympy.Symbol(name, real=True)
            case Op.LOOKUP:
                return args[0](*args[1:])
            case Op.SLOPE:
                places = [sympy.Dummy() for _ in args[1:]]
                slope = sympy.Derivative(args[0](*places), places[node.data])
                return sympy.Subs(slope, tuple(places), tuple(args[1:]))
            case _:
                return self._functions[node.op](*args)


def _functions(sympy: Any) -> dict[Op, Any]:
    def piecewise(condition: Any, if_true: Any, if_false: Any) -> Any:
        return sympy.Piecewise((if_true, condition), (if_false, True))

    return {
        Op.ADD: sympy.Add,
        Op.SUBTRACT: operator.sub,
        Op.MULTIPLY: sympy.Mul,
        Op.DIVIDE: operator.truediv,
        Op.POWER: sympy.Pow,
        Op.NEGATE: operator.neg,
        Op.ABSOLUTE: sympy.Abs,
        Op.SIGN: sympy.sign,
        Op.SQUARE_ROOT: sympy.sqrt,
        Op.EXPONENTIAL: sympy.exp,
        Op.LOGARITHM: sympy.log,
        Op.SINE: sympy.sin,
        Op.COSINE: sympy.cos,
        Op.TANH: sympy.tanh,
        Op.ARCTANGENT: sympy.atan2,
        Op.FLOOR: sympy.floor,
        Op.MINIMUM: sympy.Min,
        Op.MAXIMUM: sympy.Max,
        Op.LESS: sympy.Lt,
        Op.LESS_EQUAL: sympy.Le,
        Op.EQUAL: sympy.Eq,
        Op.AND: sympy.And,
        Op.OR: sympy.Or,
        Op.NOT: sympy.Not,
        Op.WHERE: piecewise,
    }
