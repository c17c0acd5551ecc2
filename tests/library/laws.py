"""Calls laws with plain numbers, inputs included."""

from typing import Any

import numpy as np

from propermodel.expressions.core import Expr, Op, as_expr, postorder
from propermodel.expressions.interpret import FUNCTIONS
from propermodel.modelling import Component, TableValues


def value_of(expr: Expr | float, component: Component | None = None, **given: float) -> float:
    """The value of an expression of a component's parameters, inputs and tables; `given` names what is no parameter."""
    if not isinstance(expr, Expr):
        return float(expr)
    known: dict[Expr, Any] = {}
    for node in postorder([expr]):
        if node.op is Op.CONSTANT:
            known[node] = node.data[0]
        elif node.op is Op.SYMBOL:
            known[node] = _leaf(node.data.path.name, component, given)
        elif node.op is Op.LOOKUP:
            known[node] = _interpolated(*(known[arg] for arg in node.args))
        else:
            known[node] = float(FUNCTIONS[node.op](*(known[arg] for arg in node.args)))
    return known[expr]


def law_value(law: Any, *arguments: float, **given: float) -> float:
    """The value of a law method: `law_value(loss.effort, 100.0, stroke=1.0)`."""
    return value_of(law(*map(as_expr, arguments)), law.__self__, **given)


def output_values(component: Component, results: Any, **given: float) -> dict[str, float]:
    """The values of a block's outputs or a controller's updates, by name."""
    return {key.data.path.name: value_of(expr, component, **given) for key, expr in results.items()}


def _leaf(name: str, component: Component | None, given: dict[str, float]) -> Any:
    if name in given:
        return given[name]
    assert component is not None, name
    declared: Any = component.declarations[name]
    if isinstance(getattr(declared, "values", None), TableValues):
        return declared.values
    value = component.values.get(name, declared.default)
    return value_of(value, component, **given) if isinstance(value, Expr) else float(value)


def _interpolated(values: TableValues, *at: float) -> float:
    if len(at) == 1:
        return float(np.interp(at[0], values.grids[0], values.values))
    rows = np.reshape(values.values, [len(g) for g in values.grids])
    along = [np.interp(at[1], values.grids[1], row) for row in rows]
    return float(np.interp(at[0], values.grids[0], along))
