"""The same physics drawn in other ways gives the same results."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import numpy as np
import pytest

from propermodel.compiler import Backend, CompiledModel, compile_quietly
from propermodel.diagnostics import parse_path
from propermodel.modelling.model import Model
from tests.properties.answers import accepted, drawn
from tests.properties.graphs import Graph, model_of
from tests.properties.reference import Reference
from tests.properties.rewrite import (
    Redrawn,
    with_arrows_reversed,
    with_junctions_split,
    with_two_ports_inserted,
)
from tests.properties.runs import run

SEEDS = range(30)
STEP = 5e-3
TOLERANCE = 1e-6  # of the largest value, or of 1: other states and orders of summation leave rounding and step errors

WAYS: dict[str, Callable[[Graph, Random], Redrawn]] = {
    "arrows reversed": with_arrows_reversed,
    "two-ports inserted": with_two_ports_inserted,
    "junctions split": with_junctions_split,
}


@pytest.mark.parametrize("way", WAYS)
def test_results_do_not_depend_on_the_drawing(way: str):
    compared = 0
    for seed, plain in accepted(SEEDS):
        redrawn = WAYS[way](drawn(seed), Random(seed))
        other = compile_quietly(model_of(redrawn.graph), backend=Backend.INTERPRETED)
        compared += same_results(drawn(seed), plain, other, signs=redrawn.signs)
    assert compared > 100


def test_results_do_not_depend_on_names_and_order():
    compared = 0
    for seed, plain in accepted(SEEDS):
        random = Random(seed)
        order = random.sample(range(11), 11)
        model: Model = model_of(drawn(seed), prefix="z_", order=order)
        compared += same_results(drawn(seed), plain, compile_quietly(model, backend=Backend.INTERPRETED), prefix="z_")
    assert compared > 100


def same_results(
    graph: Graph, plain: CompiledModel, other: CompiledModel, signs: dict[str, float] | None = None, prefix: str = ""
) -> int:
    """Run both from one start and compare the variables of all elements; gives how many varied."""
    signs = signs or {}
    own = {str(s.path) for s in plain.system.states}
    common = own == {str(s.path).removeprefix(prefix) for s in other.system.states}
    # Where another choice of states was made, both start from rest.
    values = dict(zip(sorted(own), np.random.default_rng(len(own)).uniform(-0.3, 0.3, len(own)), strict=True))
    start = {path: float(value) if common else 0.0 for path, value in values.items()}
    other_start = {prefix + path: signs.get(_port_of(path), 1.0) * value for path, value in start.items()}
    one, two = run(plain, start, STEP), run(other, other_start if common else {}, STEP)
    varied = 0
    for path in Reference(graph).ports:
        for name in (f"{path}.effort", f"{path}.flow"):
            if parse_path(name) not in plain.lowered.observables:
                continue
            before, after = one[name], signs.get(path, 1.0) * two[prefix + name]
            scale = max(1.0, float(np.max(np.abs(before))))
            assert np.max(np.abs(after - before)) < TOLERANCE * scale, f"{name} differs"
            varied += bool(np.ptp(before) > 1e-6)
    return varied


def _port_of(state: str) -> str:
    """The port of a stored quantity."""
    element, _, coordinate = state.partition(".")
    return f"{element}.{coordinate.removesuffix('_stored') if element.startswith('m') else 'port'}"
