"""Readable equations have the values of the equation system they were made from, whatever the model."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath

import pytest

from propermodel.catalogue.finding import load_subject
from propermodel.compiler import CompiledModel, compile_model
from propermodel.equations.names import input_symbols, parameter_aliases, quantity_symbol
from propermodel.equations.readable import ReadableEquations, state_equations
from propermodel.expressions.core import TIME, Expr, Op, lookup, postorder
from propermodel.expressions.interpret import FUNCTIONS
from propermodel.modelling.model import Storage

EXAMPLES = sorted((FilePath(__file__).parents[2] / "examples").glob("*.py"))


def values_of(exprs: Iterable[Expr], point: Mapping[Expr, float]) -> dict[Expr, float]:
    """Values of expressions; a table is some smooth function, and its slope another one."""
    known = dict(point)
    for node in postorder(exprs):
        if node in known or (node.op is Op.SYMBOL and node.data.kind.value == "table"):
            continue
        args = [known[arg] for arg in node.args if arg in known]
        if node.op is Op.CONSTANT:
            known[node] = node.data[0]
        elif node.op in (Op.LOOKUP, Op.SLOPE):
            known[node] = 1.5 + math.sin(sum((k + 1.3) * arg for k, arg in enumerate(args)) + 0.7 * (node.data or 0))
        elif node.op in FUNCTIONS:
            try:
                known[node] = float(FUNCTIONS[node.op](*args))
            except (ArithmeticError, ValueError):
                known[node] = math.nan
        else:
            raise AssertionError(f"no value for {node}")
    return known


def points_of(model: CompiledModel, readable: ReadableEquations) -> tuple[dict[Expr, float], dict[Expr, float]]:
    """One point, in the symbols of the system and in those of the reader."""
    draw = random.Random(7)
    graph = model.graph
    aliases = parameter_aliases(graph)
    point: dict[Expr, float] = {TIME: 0.3}
    for parameter in graph.parameters.values():
        point[parameter.symbol] = draw.uniform(0.5, 1.5)
    point.update({leaf: point[top] for leaf, top in aliases.items()})
    read = dict(point)
    for table, leaf in input_symbols(graph).items():
        read[leaf] = point[lookup(table, TIME)] = draw.uniform(0.2, 1.0)
    for state in model.system.states:
        point[state.symbol] = read[state.symbol] = draw.uniform(0.1, 0.9)
    for held in model.lowered.held:
        point[held] = read[held] = draw.uniform(0.1, 0.9)
    for block in model.system.blocks:
        for unknown in block.unknowns:
            point[unknown] = read[quantity_symbol(graph, unknown)] = draw.uniform(0.1, 0.9)
    for state in readable.states:
        element = graph.normal.elements.get(state.path.parent)
        if state.symbol not in read:
            assert element is not None
            assert isinstance(element.behaviour, Storage)
            ((_, law),) = element.behaviour.outputs
            read[state.symbol] = values_of([law], point)[law]
    return point, read


def assert_same_values(model: CompiledModel) -> None:
    readable = state_equations(model)
    point, read = points_of(model, readable)
    for definition in readable.definitions:
        read[definition.symbol] = values_of([definition.value], read)[definition.value]
    shown = {state.path: state for state in readable.states}
    pairs: list[tuple[str, Expr, Expr]] = []
    for state in model.system.states:
        item = shown[state.path]
        # The rate of what is shown is that of the state in the same proportion.
        ratio = 1.0 if item.symbol is state.symbol else read[item.symbol] / point[state.symbol]
        pairs.append((str(state.path), state.derivative * ratio, item.derivative))
    for block, written in zip(model.system.blocks, readable.blocks, strict=True):
        pairs += [("residual", *pair) for pair in zip(model.system.laws_of(block), written.residuals, strict=True)]
    for (_, values), update in zip(model.system.updates, readable.updates, strict=True):
        pairs += [(str(held), value, shown) for (held, value), (_, shown) in zip(values, update.values, strict=True)]
    expected = values_of([pair[1] for pair in pairs], point)
    found = values_of([pair[2] for pair in pairs], read)
    for name, ours, theirs in pairs:
        assert found[theirs] == pytest.approx(expected[ours], rel=1e-8, abs=1e-9, nan_ok=True), name


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_the_examples(file: FilePath):
    assert_same_values(compile_model(load_subject(str(file)).model))


def test_the_truck():
    assert_same_values(compile_model(load_subject("truck").model))
