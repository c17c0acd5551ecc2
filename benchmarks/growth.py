"""How the time from a model's source to its first native step grows with its size, beside other tools."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from itertools import pairwise

from benchmarks.chain import chain_model
from benchmarks.equation_peers import measure_peers
from propermodel.codegen.machine import Method
from propermodel.compiler import compile_model
from propermodel.modelling.elaborate import elaborate
from propermodel.modelling.model import Scenario
from propermodel.simulation.simulate import simulate


@dataclass(frozen=True)
class Stages:
    """Seconds of processor time for one chain, from its classes to its first step."""

    size: int
    equations: float
    native: float
    first_step: float

    @property
    def total(self) -> float:
        """From source to step."""
        return self.equations + self.native + self.first_step


def print_growth(sizes: tuple[int, ...] = (10, 57, 200, 500, 1000, 2000, 5000)) -> None:
    """Print a table over chain sizes, its slope, and what other tools need."""
    print("chain of N mass-spring-damper sections, from components to the first native step, processor time:")
    _measure(10)
    rows = [_middle(size, repeats=5 if size <= 200 else 1) for size in sizes]
    for row in rows:
        print(
            f"  N = {row.size:>4}: {row.total:>6.2f} s (equations {row.equations:.2f} s, "
            f"native code {row.native:.2f} s, first step {row.first_step:.3f} s)"
        )
    print(f"  total grows as N to the {_slope([row for row in rows if row.size >= 57]):.2f} from N = 57")
    print("other tools, equations of the same chain:")
    for peer in measure_peers():
        print(peer)


def _middle(size: int, repeats: int) -> Stages:
    found = sorted((_measure(size) for _ in range(repeats)), key=lambda stages: stages.total)
    return found[len(found) // 2]


def _measure(size: int) -> Stages:
    marks = [time.process_time()]
    compiled = compile_model(elaborate(chain_model(size)))
    marks.append(time.process_time())
    compiled.machine(Method.SEMI_IMPLICIT)
    marks.append(time.process_time())
    simulate(compiled, Scenario(name="one step", stop=1e-6), step=1e-6)
    marks.append(time.process_time())
    return Stages(size, *(later - sooner for sooner, later in pairwise(marks)))


def _slope(rows: list[Stages]) -> float:
    """The exponent of a power law through the totals, by least squares of the logarithms."""
    x = [math.log(row.size) for row in rows]
    y = [math.log(row.total) for row in rows]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / sum((a - mean_x) ** 2 for a in x)
