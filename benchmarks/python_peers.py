"""Ensembles of others: the printed model with fixed steps, by numba over threads and by JAX over a batch.

The step is semi-implicit Euler with the integrals of |power|, controllers sampled in between; all designs have one
period. Code that numba and JAX compile is executed from text, which only benchmarks do.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from benchmarks.python_printer import Dialect, print_functions
from propermodel.codegen.machine import FloatArray, IntArray, Memory, sample_periods
from propermodel.codegen.program import Array, Assign, Program
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.codegen.tables import prepare_tables

Answer = tuple[FloatArray, FloatArray]  # states and activities of all designs

_JAX_CELLS = """
def cell1(tables, k, u, holds):
    grid, refs, cells = tables[k]
    j = xp.searchsorted(grid, u, side="right")
    at = xp.clip(u, grid[0], grid[-1]) if holds else u
    return cells[j, 0], cells[j, 1], at - refs[j]

def cell2(tables, k, u, v, holds):
    grid, refs, grid2, refs2, cells = tables[k]
    i = xp.searchsorted(grid, u, side="right")
    j = xp.searchsorted(grid2, v, side="right")
    at = xp.clip(u, grid[0], grid[-1]) if holds else u
    at2 = xp.clip(v, grid2[0], grid2[-1]) if holds else v
    return cells[i, j, 0], cells[i, j, 1], cells[i, j, 2], cells[i, j, 3], at - refs[i], at2 - refs2[j]
"""

# All tables stand in one array: a loop over threads cannot be given a tuple of them.
_NUMBA_HELPERS = """
def choose(c, a, b):
    return a if c else b

def store(to, values):
    for k in range(len(values)):
        to[k] = values[k]

def add(to, values, h):
    for k in range(len(values)):
        to[k] += h * abs(values[k])

def find(data, begin, count, u):
    low, high = 0, count
    while low < high:
        middle = (low + high) >> 1
        if data[begin + middle] <= u:
            low = middle + 1
        else:
            high = middle
    return low

def away(data, begin, count, refs, j, u, holds):
    if holds:
        u = max(u, data[begin])
        u = min(u, data[begin + count - 1])
    return u - data[refs + j]

def cell1(data, k, u, holds):
    j = find(data, places[k, 0], places[k, 1], u)
    c = places[k, 6] + 2 * j
    return data[c], data[c + 1], away(data, places[k, 0], places[k, 1], places[k, 2], j, u, holds)

def cell2(data, k, u, v, holds):
    i = find(data, places[k, 0], places[k, 1], u)
    j = find(data, places[k, 3], places[k, 4], v)
    c = places[k, 6] + 4 * (i * (places[k, 4] + 1) + j)
    first = away(data, places[k, 0], places[k, 1], places[k, 2], i, u, holds)
    second = away(data, places[k, 3], places[k, 4], places[k, 5], j, v, holds)
    return data[c], data[c + 1], data[c + 2], data[c + 3], first, second
"""

_NUMBA = """
def mission(y, d, p, u, tables, activity, begin, ticks, steps, h):
    for i in prange(len(y)):
        for tick in range(ticks):
            t0 = begin + tick * (steps * h)
            {samples}
            for n in range(steps):
                t = t0 + n * h
                dy, power, un = rates(t, y[i], d[i], p[i], u[i], tables)
                store(u[i], un)
                add(activity[i], power, h)
                {momenta}
                dq, un = displacement_rates(t + h, y[i], d[i], p[i], u[i], tables)
                store(u[i], un)
                {others}
                {anew}
"""


def tables_of(program: Program, memory: Memory) -> tuple[tuple[FloatArray, ...], ...]:
    """Grids, reference points and coefficients of all tables."""
    found: list[tuple[FloatArray, ...]] = []
    for table in prepare_tables(program, memory.tables):
        axes: list[FloatArray] = []
        for axis in table.axes:
            axes += [axis.grid.copy(), np.ascontiguousarray(axis.pairs[:-1, 1])]
        found.append((*axes, table.cells))
    return tuple(found)


def _flattened(tables: tuple[tuple[FloatArray, ...], ...]) -> tuple[IntArray, FloatArray]:
    """Where in one array each table has grids, their lengths, reference points and coefficients; and that array."""
    places = np.zeros((max(1, len(tables)), 7), dtype=np.int64)
    parts: list[FloatArray] = []
    size = 0
    for k, (*axes, cells) in enumerate(tables):
        for axis, (grid, refs) in enumerate(zip(axes[::2], axes[1::2], strict=True)):
            places[k, 3 * axis : 3 * axis + 3] = size, len(grid), size + len(grid)
            parts += [grid, refs]
            size += len(grid) + len(refs)
        places[k, 6] = size
        parts.append(cells.ravel())
        size += cells.size
    return places, np.concatenate([*parts, np.zeros(1)])


def split(program: Program) -> tuple[list[int], list[int], list[int]]:
    """The states that are advanced first, those with their rates of then, and those with rates made anew."""
    momenta = list(program.layout.momenta)
    anew = [s.slot.index for s in program.displacement_rates.steps if isinstance(s, Assign)]
    others = set(range(program.layout.lengths[Array.STATE])) - {*momenta, *anew}
    return momenta, sorted(others), anew


def numba_space(program: Program, memory: Memory) -> tuple[dict[str, Any], FloatArray]:
    """The printed functions with their helpers, not yet compiled, and the tables that they are given."""
    places, tables = _flattened(tables_of(program, memory))
    space: dict[str, Any] = {"xp": np, "places": places}
    exec(compile(_NUMBA_HELPERS + print_functions(program, Dialect.NUMBA), "model", "exec"), space)  # noqa: S102
    return space, tables


def numba_loop(program: Program) -> str:
    """The source of the loop over designs, samples and steps."""
    momenta, others, anew = split(program)
    samples = [f"store(d[i], sample{k}(t0, y[i], d[i], p[i], u[i], tables)[0])" for k in range(len(program.samples))]
    moves = (("momenta", "dy", momenta), ("others", "dy", others), ("anew", "dq", anew))
    return _NUMBA.format(
        samples="\n            ".join(samples),
        **{
            name: "\n                ".join(f"y[i, {s}] += h * {rate}[{s}]" for s in states)
            for name, rate, states in moves
        },
    )


def with_numba(program: Program, memory: Memory, step: float, stop: float) -> Callable[[], Answer]:
    """All designs of a memory of several lanes, over threads."""
    import numba

    program = with_reciprocals(program)
    space, tables = numba_space(program, memory)
    space["prange"] = numba.prange
    for name, function in list(space.items()):
        if isinstance(function, FunctionType):
            space[name] = numba.njit(error_model="numpy")(function)
    exec(compile(numba_loop(program), "mission", "exec"), space)  # noqa: S102
    mission = numba.njit(parallel=True, error_model="numpy")(space["mission"])
    ticks, steps = _ticks(program, memory, step, stop)
    start = [np.ascontiguousarray(a.T) for a in (memory.state, memory.discrete, memory.parameter, memory.unknown)]
    powers = len(memory.activity)

    def run() -> Answer:
        y, d, p, u = (array.copy() for array in start)
        activity = np.zeros((len(y), powers))
        mission(y, d, p, u, tables, activity, memory.time, ticks, steps, step)
        return y, activity

    return run


def with_jax(program: Program, memory: Memory, step: float, stop: float) -> Callable[[], Answer]:
    """All designs of a memory of several lanes, by a scan of a batch."""
    import jax
    import jax.numpy as jnp
    from jax import lax

    jax.config.update("jax_enable_x64", True)
    program = with_reciprocals(program)
    momenta, others, anew = (jnp.array(states, dtype=int) for states in split(program))
    space: dict[str, Any] = {"xp": jnp, "lax": lax, "choose": jnp.where}
    exec(compile(_JAX_CELLS + print_functions(program, Dialect.JAX), "model", "exec"), space)  # noqa: S102
    rates, displacement_rates = space["rates"], space["displacement_rates"]
    samples = [space[f"sample{k}"] for k in range(len(program.samples))]
    ticks, steps = _ticks(program, memory, step, stop)
    tables = jax.tree.map(jnp.asarray, tables_of(program, memory))

    def one(y: Any, d: Any, p: Any, u: Any) -> Any:
        def advance(n: Any, carry: Any) -> Any:
            y, u, activity, d, t0 = carry
            t = t0 + n * step
            dy, power, un = rates(t, y, d, p, u, tables)
            activity = activity + step * jnp.abs(_stacked(jnp, power))
            y = y.at[momenta].add(step * _stacked(jnp, dy)[momenta])
            dq, un = displacement_rates(t + step, y, d, p, _stacked(jnp, un), tables)
            y = y.at[others].add(step * _stacked(jnp, dy)[others]).at[anew].add(step * _stacked(jnp, dq)[anew])
            return y, _stacked(jnp, un), activity, d, t0

        def tick(carry: Any, number: Any) -> Any:
            y, d, u, activity = carry
            t0 = memory.time + number * (steps * step)
            for sample in samples:
                d = _stacked(jnp, sample(t0, y, d, p, u, tables)[0])
            y, u, activity, d, _ = lax.fori_loop(0, steps, advance, (y, u, activity, d, t0))
            return (y, d, u, activity), None

        start = (y, d, u, jnp.zeros(len(memory.activity)))
        (y, _, _, activity), _ = lax.scan(tick, start, jnp.arange(ticks))
        return y, activity

    batch = jax.jit(jax.vmap(one))
    start = [jnp.asarray(array.T) for array in (memory.state, memory.discrete, memory.parameter, memory.unknown)]

    def run() -> Answer:
        y, activity = batch(*start)
        return np.asarray(y), np.asarray(activity)

    return run


def _stacked(jnp: ModuleType, values: Any) -> Any:
    return jnp.stack([jnp.asarray(value, dtype=float) for value in values])


def _ticks(program: Program, memory: Memory, step: float, stop: float) -> tuple[int, int]:
    """How many samples there are, and how many steps between them; all controllers have one period here."""
    (period,) = set(sample_periods(program, memory))
    return round((stop - memory.time) / period), round(period / step)
