"""Prints a program as C++ of the plainest kind, to compare what a compiler for C makes of the same arithmetic.

One function for each function of the program, one variable for each node of its expressions, the whole fixed-step loop
with the integrals of power; what depends on parameters or samples alone is computed when these change, as in the
package's own code. A number is a double, or a vector of GCC with one entry for each lane. Only this benchmark uses it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from propermodel.codegen.machine import SAME_INSTANT, Method
from propermodel.codegen.program import Array, Extrapolation, Function, Program
from propermodel.codegen.reciprocals import with_reciprocals
from propermodel.codegen.schedule import (
    Call,
    Level,
    Order,
    Store,
    frontier,
    leaf_slot,
    node_levels,
    number_solves,
    power_plan,
    sequence,
    whole_power,
)
from propermodel.expressions.core import Expr, Op

ARGUMENTS = "V *w, const long *tables, double t"
PASSED = "w, tables, t"

_BINARY = {
    Op.ADD: "+",
    Op.SUBTRACT: "-",
    Op.MULTIPLY: "*",
    Op.DIVIDE: "/",
    Op.LESS: "<",
    Op.LESS_EQUAL: "<=",
    Op.EQUAL: "==",
}
_LOGIC = {Op.AND: "&", Op.OR: "|"}
_CALLED = {
    Op.ABSOLUTE: "fabs",
    Op.SQUARE_ROOT: "sqrt",
    Op.EXPONENTIAL: "exp",
    Op.LOGARITHM: "log",
    Op.SINE: "sin",
    Op.COSINE: "cos",
    Op.TANH: "tanh",
    Op.FLOOR: "floor",
    Op.ARCTANGENT: "atan2",
}


class CPrinter:
    """The source of a program for a method and a number of lanes, and where its numbers are.

    With `observes` its `observe` is printed, too, and single functions can be called.
    """

    def __init__(self, program: Program, method: Method, lanes: int, *, observes: bool = False) -> None:
        if method not in (Method.EULER, Method.SEMI_IMPLICIT):
            raise ValueError(f"{method} is not printed as C")
        if program.guards is not None or program.corrections:
            raise ValueError("programs with events or corrections are not printed as C")
        self._program = with_reciprocals(program)
        self._method = method
        self._observes = observes
        self._lanes = lanes
        self._numbers = number_solves(self._program)
        self._lines: list[str] = []
        self._sites = 0
        layout = self._program.layout
        momenta = list(layout.momenta)
        others = [state for state in range(layout.lengths[Array.STATE]) if state not in set(momenta)]
        order = {state: row for row, state in enumerate([*momenta, *others])}
        self.states = [order[state] for state in range(len(order))]  # the row of each state; momenta come first
        self._momenta = len(momenta)
        self.rows = 0
        self.regions: dict[str, int] = {}
        for array in (Array.STATE, Array.RATE, Array.DISCRETE, Array.PARAMETER, Array.UNKNOWN, Array.POWER):
            self.regions[array] = self._new_rows(layout.lengths.get(array, 0))
        self.regions[Array.SIGNAL] = self._new_rows(layout.lengths.get(Array.SIGNAL, 0) if observes else 0)
        for name in ("integral", "activity"):
            self.regions[name] = self._new_rows(layout.lengths.get(Array.POWER, 0))
        self.text = self._source()

    def _new_rows(self, count: int) -> int:
        first = self.rows
        self.rows += count
        return first

    def _row(self, array: Array, index: int) -> int:
        place = self.states[index] if array in (Array.STATE, Array.RATE) else index
        return self.regions[array] + place

    # -- functions -------------------------------------------------------------------------------------

    def _source(self) -> str:
        program = self._program
        observed = (program.observe,) if self._observes else ()
        continuous = (program.rates, program.displacement_rates, *observed)
        levels = node_levels(continuous, program.layout)
        nodes = frontier(continuous, levels)
        kept: dict[Expr, int] = {}
        self._kept("prepare", [node for node in nodes if levels[node] is Level.RUN], kept)
        fixed = dict(kept)
        self._kept("refresh", [node for node in nodes if levels[node] is Level.SAMPLE], kept)
        self._function("rates", program.rates, kept)
        self._function("displacement_rates", program.displacement_rates, kept)
        for function in observed:
            self._function("observe", function, kept)
        for k, function in enumerate(program.samples):
            self._function(f"sample{k}", function, fixed)
        head = f"#define LANES {self._lanes}\n{_PRELUDE}\nstatic V sites[{max(1, self._sites)}][10];\n"
        calls = _calls(len(program.samples)) if self._observes else ""
        return "\n".join([head, *self._lines, self._loop(), calls])

    def _kept(self, name: str, nodes: Iterable[Expr], rows: dict[Expr, int]) -> None:
        body = _Body(self, rows)
        order = Order(dict(rows).__contains__)
        for node in nodes:
            for inner in order.new_below(node):
                body.compute(inner)
            row = self._new_rows(1)
            body.lines.append(f"w[{row}] = {body.number(node)};")
            rows[node] = row
        self._define(f"static void {name}({ARGUMENTS})", body.lines)

    def _function(self, name: str, function: Function, rows: Mapping[Expr, int]) -> None:
        body = _Body(self, rows)
        late: list[str] = []
        for item in sequence(function, self._numbers, rows.__contains__):
            if isinstance(item, Store):
                line = f"w[{self._row(item.slot.array, item.slot.index)}] = {body.number(item.value)};"
                (late if item.slot.array in (Array.DISCRETE, Array.STATE) else body.lines).append(line)
            elif isinstance(item, Call):
                self._solve(f"{name}_solve{item.number}", item, body, rows)
            else:
                body.compute(item)
        self._define(f"static void {name}({ARGUMENTS})", [*body.lines, *late])

    def _define(self, head: str, lines: Iterable[str]) -> None:
        self._lines.append("\n".join([f"{head} {{", *(f"  {line}" for line in lines), "}"]))

    def _solve(self, name: str, call: Call, body: _Body, rows: Mapping[Expr, int]) -> None:
        """An implicit block: a function of its residuals, and a call of Newton's method."""
        known = dict(rows)
        for node in call.captures:
            known[node] = row = self._new_rows(1)
            body.lines.append(f"w[{row}] = {body.number(node)};")
        solve, size = call.solve, len(call.solve.unknowns)
        inner = _Body(self, known)
        inner.names.update((unknown, f"x[{i}]") for i, unknown in enumerate(solve.unknowns))
        for node in call.inner:
            inner.compute(node)
        inner.lines += [f"r[{i}] = {inner.number(root)};" for i, root in enumerate(solve.residuals)]
        entries = [entry for row in solve.jacobian for entry in row]
        inner.lines += [f"j[{i}] = {inner.number(entry)};" for i, entry in enumerate(entries)]
        self._define(f"static void {name}({ARGUMENTS}, const V *x, V *r, V *j)", inner.lines)
        places = [self._row(Array.UNKNOWN, leaf_slot(self._program.layout, u).index) for u in solve.unknowns]
        scales = ", ".join(_literal(scale) for scale in solve.scales)
        body.lines += [
            f"V x_{name}[{size}] = {{{', '.join(f'w[{place}]' for place in places)}}};",
            f"{{ const double scales[{size}] = {{{scales}}};",
            f"  newton<{size}>({PASSED}, x_{name}, scales, {_literal(solve.tolerance)}, {solve.most_iterations},",
            f"    {'true' if call.is_affine else 'false'}, {name}); }}",
            *(f"w[{place}] = x_{name}[{i}];" for i, place in enumerate(places)),
        ]
        body.names.update((unknown, f"x_{name}[{i}]") for i, unknown in enumerate(solve.unknowns))

    # -- the loop --------------------------------------------------------------------------------------

    def _loop(self) -> str:
        regions, lengths = self.regions, self._program.layout.lengths
        states, powers, rates = lengths[Array.STATE], lengths.get(Array.POWER, 0), len(self._program.samples)
        state, rate = regions[Array.STATE], regions[Array.RATE]

        def advance(first: int, last: int) -> str:
            return f"for (int i = {first}; i < {last}; ++i) w[{state} + i] += w[{rate} + i] * h;"

        step = [
            f"rates({PASSED});",
            f"for (int i = 0; i < {powers}; ++i) {{",
            f"  const V d = w[{regions[Array.POWER]} + i] * h;",
            f"  w[{regions['integral']} + i] += d; w[{regions['activity']} + i] += v_fabs(d);",
            "}",
        ]
        if self._method is Method.EULER:
            step.append(advance(0, states))
        else:
            step += [
                advance(0, self._momenta),
                "displacement_rates(w, tables, t + h);",
                advance(self._momenta, states),
            ]
        self._lines.clear()
        samples = [
            f"if (instant(origin, taken[{k}], periods[{k}]) <= limit) {{ sample{k}({PASSED}); ++taken[{k}]; }}"
            for k in range(rates)
        ]
        soonest = [
            f"{{ const double at = instant(origin, taken[{k}], periods[{k}]); if (at < end) end = at; }}"
            for k in range(rates)
        ]
        return "\n".join(
            [
                f"static inline void step({ARGUMENTS}, double h) {{",
                *(f"  {line}" for line in step),
                "}",
                'extern "C" int run(V *w, const long *tables, double *clock, double until, double dt, double origin,',
                "               const double *periods, long *taken) {",
                "  double t = 0.0;",
                f"  prepare({PASSED}); refresh({PASSED});",
                "  t = *clock;",
                "  for (;;) {",
                f"    const double limit = t + dt * {_literal(SAME_INSTANT)};",
                *(f"    {line}" for line in samples),
                *([f"    refresh({PASSED});"] if rates else []),
                "    if (limit >= until) { *clock = t; return 0; }",
                "    double end = until;",
                *(f"    {line}" for line in soonest),
                f"    const double most = ceil((end - t) / dt - {_literal(SAME_INSTANT)});",
                "    const long n = most > 1.0 ? (long)most : 1;",
                "    const double h = (end - t) / (double)n;",
                "    for (long i = 0; i < n; ++i) step(w, tables, t + (double)i * h, h);",
                "    t = end;",
                "    bool well = true;",
                f"    for (int i = 0; i < {states}; ++i) well = well && is_finite(w[{state} + i]);",
                "    if (!well) { *clock = t; return 1; }",
                "  }",
                "}",
                "",
            ]
        )

    def site(self) -> str:
        """Room for the last cell of one more look-up."""
        self._sites += 1
        return f"sites[{self._sites - 1}]"

    def leaf(self, node: Expr) -> str:
        """Where a leaf is read from."""
        if node.op is Op.CONSTANT:
            return f"spread({_literal(node.data[0])})"
        slot = leaf_slot(self._program.layout, node)
        return "spread(t)" if slot.array is Array.TIME else f"w[{self._row(slot.array, slot.index)}]"

    def table(self, node: Expr) -> tuple[str, bool, bool]:
        """The descriptor of the table of a look-up, whether its grids are uniform, and whether it holds its ends."""
        index = self._program.layout.table_index[node.args[0]]
        slot = self._program.layout.tables[index]
        return f"tables + {16 * index}", slot.is_uniform, slot.extrapolation is Extrapolation.HOLD


class _Body:
    """The statements of one function."""

    def __init__(self, printer: CPrinter, rows: Mapping[Expr, int]) -> None:
        self._printer = printer
        self._rows = rows
        self._cells: dict[tuple[Expr, ...], str] = {}
        self.names: dict[Expr, str] = {}
        self.lines: list[str] = []

    def number(self, node: Expr) -> str:
        """A node as a number for each lane."""
        text = self._text(node)
        return f"choose({text}, spread(1.0), spread(0.0))" if node.is_condition and node not in self._rows else text

    def _truth(self, node: Expr) -> str:
        text = self._text(node)
        return text if node.is_condition and node not in self._rows else f"({text} != spread(0.0))"

    def _text(self, node: Expr) -> str:
        if node in self.names:
            return self.names[node]
        if node in self._rows:
            return f"w[{self._rows[node]}]"
        return self._printer.leaf(node)

    def compute(self, node: Expr) -> None:
        """Compute a node whose arguments are there."""
        text = self._look_up(node) if node.op in (Op.LOOKUP, Op.SLOPE) else self._operation(node)
        name = f"n{len(self.names)}"
        self.lines.append(f"const {'M' if node.is_condition else 'V'} {name} = {text};")
        self.names[node] = name

    def _operation(self, node: Expr) -> str:
        op, args = node.op, node.args
        if op in _BINARY:
            return f"{self.number(args[0])} {_BINARY[op]} {self.number(args[1])}"
        if op in _LOGIC:
            return f"{self._truth(args[0])} {_LOGIC[op]} {self._truth(args[1])}"
        if op in _CALLED:
            return f"v_{_CALLED[op]}({', '.join(map(self.number, args))})"
        first = self.number(args[0])
        match op:
            case Op.NEGATE:
                return f"-{first}"
            case Op.NOT:
                return f"v_not({self._truth(args[0])})"
            case Op.WHERE:
                return f"choose({self._truth(args[0])}, {self.number(args[1])}, {self.number(args[2])})"
            case Op.MINIMUM | Op.MAXIMUM:
                second = self.number(args[1])
                return f"choose({first} {'<=' if op is Op.MINIMUM else '>='} {second}, {first}, {second})"
            case Op.SIGN:
                return f"v_sign({first})"
            case Op.POWER:
                return self._power(first, args[1].data[0])
            case _:
                raise ValueError(f"no C for '{op}'")

    def _power(self, base: str, exponent: float) -> str:
        plan = power_plan(exponent)
        if plan is None:
            return f"v_pow({base}, {_literal(exponent)})"
        result = whole_power(base, plan.whole, lambda a, b: f"({a} * {b})") if plan.whole else ""
        if plan.has_root:
            result = f"{result} * v_sqrt({base})" if result else f"v_sqrt({base})"
        return f"spread(1.0) / ({result})" if plan.is_inverse else result

    def _look_up(self, node: Expr) -> str:
        table, is_uniform, holds = self._printer.table(node)
        coordinates = [self.number(arg) for arg in node.args[1:]]
        axes = len(coordinates)
        if node.args not in self._cells:
            site = self._printer.site()
            name = f"c{len(self._cells)}_{len(self.names)}"
            self._cells[node.args] = name
            flags = f"{str(is_uniform).lower()}, {str(holds).lower()}"
            self.lines.append(f"V {name}[{axes}]; const V *{name}_k = {site} + {3 * axes};")
            self.lines.append(f"cell{axes}<{flags}>({table}, {site}, {', '.join(coordinates)}, {name});")
        name = self._cells[node.args]
        k = [f"{name}_k[{item}]" for item in range(2 * axes)]
        if axes == 1:
            return f"{k[0]} + {k[1]} * {name}[0]" if node.op is Op.LOOKUP else k[1]
        if node.op is Op.LOOKUP:
            return f"({k[0]} + {k[1]} * {name}[0]) + ({k[2]} + {k[3]} * {name}[0]) * {name}[1]"
        return f"{k[1]} + {k[3]} * {name}[1]" if node.data == 0 else f"{k[2]} + {k[3]} * {name}[0]"


def _calls(samples: int) -> str:
    """Functions that can be called one by one."""
    bodies = {"begin": f"prepare({PASSED}); refresh({PASSED});", "f": f"rates({PASSED});", "g": f"observe({PASSED});"}
    bodies |= {f"s{k}": f"sample{k}({PASSED}); refresh({PASSED});" for k in range(samples)}
    return "\n".join(f'extern "C" void call_{name}({ARGUMENTS}) {{ {body} }}' for name, body in bodies.items())


def _literal(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "(-INFINITY)"
    return f"({value!r})" if value < 0.0 else repr(float(value))


_PRELUDE = r"""
#include <cmath>
#include <cstring>
#if LANES == 1
typedef double V;
typedef bool M;
static inline V spread(double a) { return a; }
static inline double &part(V &a, int) { return a; }
static inline double part(const V &a, int) { return a; }
static inline bool all(M m) { return m; }
static inline M v_not(M m) { return !m; }
#define EACH(F) static inline V v_##F(V a) { return std::F(a); }
static inline V v_atan2(V a, V b) { return std::atan2(a, b); }
static inline V v_pow(V a, double b) { return std::pow(a, b); }
#else
typedef double V __attribute__((vector_size(8 * LANES)));
typedef long M __attribute__((vector_size(8 * LANES)));
static inline V spread(double a) { return a - (V){}; }
static inline double part(const V &a, int i) { return a[i]; }
static inline bool all(M m) { long r = -1; for (int i = 0; i < LANES; ++i) r &= m[i]; return r != 0; }
static inline M v_not(M m) { return ~m; }
#define EACH(F) static inline V v_##F(V a) { V r; for (int i = 0; i < LANES; ++i) r[i] = std::F(a[i]); return r; }
static inline V v_atan2(V a, V b) { V r; for (int i = 0; i < LANES; ++i) r[i] = std::atan2(a[i], b[i]); return r; }
static inline V v_pow(V a, double b) { V r; for (int i = 0; i < LANES; ++i) r[i] = std::pow(a[i], b); return r; }
#endif
EACH(fabs) EACH(sqrt) EACH(exp) EACH(log) EACH(sin) EACH(cos) EACH(tanh) EACH(floor)
static inline V choose(M m, V a, V b) { return m ? a : b; }
static inline V v_sign(V a) {
  const V zero = spread(0.0);
  return choose(a > zero, spread(1.0), choose(a < zero, spread(-1.0), zero));
}
static inline bool is_finite(V a) { return all(v_fabs(a) < spread(INFINITY)); }
static inline double instant(double origin, long k, double period) { return k ? origin + (double)k * period : origin; }

/* Tables: an axis is pairs, points, start, density, low, high; a table two axes, then its cells. */
static inline double number(const long *words, int i) { double a; std::memcpy(&a, words + i, 8); return a; }
template <bool UNIFORM> static long find(const long *axis, double u) {
  const double *pairs = (const double *)axis[0];
  const long points = axis[1];
  if (UNIFORM) {
    double at = (u - number(axis, 2)) * number(axis, 3) + 1.0;
    at = at > 0.0 ? at : 0.0;
    at = at > (double)points ? (double)points : at;
    const long guess = (long)at;
    return guess - (u < pairs[2 * guess]) + (u >= pairs[2 * guess + 2] && guess < points);
  }
  long low = 0, high = points;
  while (low < high) {
    const long middle = (low + high) >> 1;
    if (pairs[2 * middle + 2] <= u) low = middle + 1; else high = middle;
  }
  return low;
}
static inline void put(V *to, int lane, double value) { ((double *)to)[lane] = value; }
static inline void limits(const long *axis, long k, V *site, int lane) {
  const double *pairs = (const double *)axis[0];
  put(site, lane, pairs[2 * k]); put(site + 1, lane, pairs[2 * k + 2]); put(site + 2, lane, pairs[2 * k + 1]);
}
template <bool HOLDS> static inline V held(const long *axis, V u) {
  if (!HOLDS) return u;
  const V low = spread(number(axis, 4)), high = spread(number(axis, 5));
  u = choose(u < low, low, u);
  return choose(u > high, high, u);
}
template <bool UNIFORM> static __attribute__((noinline, cold)) void miss1(const long *table, V *site, V u) {
  for (int i = 0; i < LANES; ++i) {
    const long k = find<UNIFORM>(table, part(u, i));
    limits(table, k, site, i);
    const double *cell = (const double *)table[12] + 2 * k;
    for (int item = 0; item < 2; ++item) put(site + 3 + item, i, cell[item]);
  }
}
template <bool UNIFORM, bool HOLDS> static inline void cell1(const long *table, V *site, V u, V *away) {
  if (__builtin_expect(!all((u >= site[0]) & (u < site[1])), 0)) miss1<UNIFORM>(table, site, u);
  away[0] = held<HOLDS>(table, u) - site[2];
}
template <bool UNIFORM> static __attribute__((noinline, cold)) void miss2(const long *table, V *site, V u, V v) {
  for (int i = 0; i < LANES; ++i) {
    const long j = find<UNIFORM>(table, part(u, i)), k = find<UNIFORM>(table + 6, part(v, i));
    limits(table, j, site, i);
    limits(table + 6, k, site + 3, i);
    const double *cell = (const double *)table[12] + 4 * (j * (table[7] + 1) + k);
    for (int item = 0; item < 4; ++item) put(site + 6 + item, i, cell[item]);
  }
}
template <bool UNIFORM, bool HOLDS> static inline void cell2(const long *table, V *site, V u, V v, V *away) {
  const M inside = (u >= site[0]) & (u < site[1]) & (v >= site[3]) & (v < site[4]);
  if (__builtin_expect(!all(inside), 0)) miss2<UNIFORM>(table, site, u, v);
  away[0] = held<HOLDS>(table, u) - site[2];
  away[1] = held<HOLDS>(table + 6, v) - site[5];
}

/* Newton's method as in the package: frozen where it has converged, damped where residuals grow. */
template <int N> static inline void eliminate(const V *j, const V *r, V *d) {
  V a[N * N], b[N];
  for (int i = 0; i < N * N; ++i) a[i] = j[i];
  for (int i = 0; i < N; ++i) b[i] = r[i];
  for (int k = 0; k < N; ++k) {
    for (int i = k + 1; i < N; ++i) {
      const M larger = v_fabs(a[i * N + k]) > v_fabs(a[k * N + k]);
      for (int c = k; c < N; ++c) {
        const V x = a[k * N + c], y = a[i * N + c];
        a[k * N + c] = choose(larger, y, x); a[i * N + c] = choose(larger, x, y);
      }
      const V x = b[k], y = b[i];
      b[k] = choose(larger, y, x); b[i] = choose(larger, x, y);
    }
    for (int i = k + 1; i < N; ++i) {
      const V f = a[i * N + k] / a[k * N + k];
      for (int c = k + 1; c < N; ++c) a[i * N + c] = a[i * N + c] - f * a[k * N + c];
      b[i] = b[i] - f * b[k];
    }
  }
  for (int i = N - 1; i >= 0; --i) {
    V sum = b[i];
    for (int c = i + 1; c < N; ++c) sum = sum - a[i * N + c] * d[c];
    d[i] = sum / a[i * N + i];
  }
}
template <int N> static inline M small(const V *x, const V *d, const double *scales, double tolerance, V *moved) {
  M result = spread(0.0) == spread(0.0);
  for (int i = 0; i < N; ++i) {
    moved[i] = x[i] - d[i];
    const V size = v_fabs(d[i]);
    result = result & (size <= tolerance * (v_fabs(moved[i]) + spread(scales[i]))) & (size < spread(INFINITY));
  }
  return result;
}
template <int N> static inline V norm(const V *weights, const V *r) {
  V total = spread(0.0);
  for (int i = 0; i < N; ++i) { const V a = weights[i] * r[i]; total = total + a * a; }
  return total;
}
template <int N, class F>
static inline void newton(V *w, const long *tables, double t, V *x, const double *scales, double tolerance, int most,
                          bool affine, F evaluate) {
  V r[N], j[N * N], d[N], moved[N], first[N], weights[N];
  evaluate(w, tables, t, x, r, j);
  if (affine) {
    eliminate<N>(j, r, d);
    for (int i = 0; i < N; ++i) x[i] = x[i] - d[i];
    return;
  }
  M active = spread(0.0) == spread(0.0);
  for (int count = 1; count <= most; ++count) {
    eliminate<N>(j, r, d);
    M done = active & small<N>(x, d, scales, tolerance, moved);
    for (int i = 0; i < N; ++i) x[i] = choose(done, moved[i], x[i]);
    active = active & v_not(done);
    if (all(v_not(active)) || count == most) return;
    for (int i = 0; i < N; ++i) {
      V sum = spread(0.0);
      for (int c = 0; c < N; ++c) sum = sum + v_fabs(j[i * N + c]) * spread(scales[c] != 0.0 ? scales[c] : 1.0);
      weights[i] = N == 1 ? spread(1.0) : spread(1.0) / sum;
    }
    const V before = norm<N>(weights, r);
    V jacobian[N * N];
    for (int i = 0; i < N; ++i) first[i] = choose(active, x[i] - d[i], x[i]);
    evaluate(w, tables, t, first, r, jacobian);
    V again[N];
    eliminate<N>(j, r, again);
    done = active & small<N>(first, again, scales, tolerance, moved);
    for (int i = 0; i < N; ++i) x[i] = choose(done, moved[i], x[i]);
    active = active & v_not(done);
    if (all(v_not(active))) return;
    V factor = spread(1.0), tried[N];
    for (int halvings = 0;; ++halvings) {
      for (int i = 0; i < N; ++i) tried[i] = choose(active, x[i] - factor * d[i], x[i]);
      evaluate(w, tables, t, tried, r, j);
      const M grew = active & v_not(norm<N>(weights, r) <= before);
      if (all(v_not(grew)) || halvings == 5) break;
      factor = choose(grew, factor * 0.5, factor);
    }
    for (int i = 0; i < N; ++i) x[i] = tried[i];
  }
}
"""
