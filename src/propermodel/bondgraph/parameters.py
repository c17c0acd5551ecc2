"""The values of parameters, which follow from each other, and the ranges they are declared to stay in."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping

from propermodel.bondgraph.graph import FlatParameter
from propermodel.diagnostics import Diagnostic, Path
from propermodel.expressions.core import Expr, Op, leaves
from propermodel.expressions.derivatives import partial_derivatives
from propermodel.expressions.interpret import interpret
from propermodel.expressions.units import parse_unit

Values = dict[Expr, float]


def parameter_values(parameters: Mapping[Path, FlatParameter], given: Mapping[Path, float] | None = None) -> Values:
    """The value of every parameter, in SI; what is given replaces what the model says."""
    known: Values = {parameters[path].symbol: float(value) for path, value in (given or {}).items()}
    by_symbol = {parameter.symbol: parameter for parameter in parameters.values()}
    for start in parameters.values():
        pending = [start]
        while pending:
            top = pending[-1]
            if top.symbol in known:
                pending.pop()
            elif top.value.op is Op.CONSTANT:
                known[top.symbol] = top.value.data[0]
            elif missing := [by_symbol[leaf] for leaf in leaves(top.value) if leaf not in known]:
                pending.extend(missing)
            else:
                known[top.symbol] = interpret(top.value, known)
    return known


def parameter_rates(
    parameters: Mapping[Path, FlatParameter], values: Mapping[Expr, float], path: Path, given: Container[Path] = ()
) -> Values:
    """The derivative of every parameter that changes with one of them, itself included.

    Args:
        parameters: All parameters.
        values: Their values.
        path: The parameter that changes.
        given: Parameters that keep what they are given, whatever the model says.
    """
    rates: Values = {parameters[path].symbol: 1.0}
    for follower in followers(parameters, path):
        rate = 0.0
        if follower.path not in given:
            moving = [leaf for leaf in leaves(follower.value) if leaf in rates]
            (slopes,) = partial_derivatives([follower.value], moving)
            rate = sum(interpret(slope, values) * rates[leaf] for leaf, slope in slopes.items())
        rates[follower.symbol] = rate
    return rates


def followers(parameters: Mapping[Path, FlatParameter], path: Path) -> tuple[FlatParameter, ...]:
    """The parameters whose values the model computes from one of them, each after those it is computed from."""
    reached = {parameters[path].symbol}
    users: dict[Expr, list[FlatParameter]] = {}
    for parameter in parameters.values():
        for leaf in leaves(parameter.value):
            users.setdefault(leaf, []).append(parameter)
    pending = [parameters[path].symbol]
    while pending:
        for user in users.get(pending.pop(), ()):
            if user.symbol not in reached:
                reached.add(user.symbol)
                pending.append(user.symbol)
    reached.remove(parameters[path].symbol)
    found: dict[Expr, FlatParameter] = {}
    waiting = [p for p in parameters.values() if p.symbol in reached]
    while waiting:
        ready = [p for p in waiting if all(leaf in found for leaf in leaves(p.value) if leaf in reached)]
        found.update((p.symbol, p) for p in ready)
        waiting = [p for p in waiting if p.symbol not in found]
    return tuple(found.values())


def faults_of_range(
    code: str, parameters: Iterable[FlatParameter], values: Mapping[Expr, float], help: str
) -> Iterator[Diagnostic]:
    """A fault for each parameter whose value leaves its range, however it came by it."""
    for parameter in parameters:
        value = values[parameter.symbol]
        if math.isfinite(value) and not parameter.low <= value <= parameter.high:
            factor = parse_unit(parameter.unit).factor
            yield Diagnostic(
                code,
                f"'{parameter.path}' = {in_unit(value, parameter.unit)} lies outside its range "
                f"{parameter.low / factor:g} to {parameter.high / factor:g}",
                source=parameter.source,
                help=help,
            )


def in_unit(value: float, unit: str) -> str:
    """A value in SI as it is written in a unit."""
    written = f"{value / parse_unit(unit).factor:g}"
    return written if unit in ("", "1") else f"{written} {unit}"
