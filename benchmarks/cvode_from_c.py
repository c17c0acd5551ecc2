"""CVODE driven from C: the printed model and the loop over samples in one library, linked with SUNDIALS.

SUNDIALS comes with scikit-sundae, whose wheels hold its libraries without its headers: what is called is declared here,
as in the manual of CVODE 7.
"""

from __future__ import annotations

import ctypes
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from benchmarks.c_machine import EXACT, aligned, compile_shared, places_of
from benchmarks.hybrid import Hybrid, Outcome
from propermodel.codegen.machine import FloatArray
from propermodel.codegen.program import Array

_NEEDED = (
    "sundials_core",
    "sundials_nvecserial",
    "sundials_sunmatrixdense",
    "sundials_sunlinsoldense",
    "sundials_cvode",
)

_DRIVER = r"""
extern "C" {
  int SUNContext_Create(int comm, void **context);
  int SUNContext_Free(void **context);
  void *N_VMake_Serial(int length, double *data, void *context);
  double *N_VGetArrayPointer(void *vector);
  void N_VDestroy(void *vector);
  void *SUNDenseMatrix(int rows, int columns, void *context);
  double *SUNDenseMatrix_Data(void *matrix);
  void SUNMatDestroy(void *matrix);
  void *SUNLinSol_Dense(void *vector, void *matrix, void *context);
  int SUNLinSolFree(void *solver);
  void *CVodeCreate(int method, void *context);
  void CVodeFree(void **memory);
  int CVodeInit(void *memory, int (*f)(double, void *, void *, void *), double t, void *y);
  int CVodeReInit(void *memory, double t, void *y);
  int CVodeSVtolerances(void *memory, double relative, void *absolute);
  int CVodeSetUserData(void *memory, void *data);
  int CVodeSetMaxNumSteps(void *memory, long most);
  int CVodeSetLinearSolver(void *memory, void *solver, void *matrix);
  int CVodeSetJacFn(void *memory, int (*jacobian)(double, void *, void *, void *, void *, void *, void *, void *));
  int CVodeSetStopTime(void *memory, double t);
  int CVode(void *memory, double end, void *y, double *t, int task);
}
struct Model { V *w; const long *tables; long evaluations; };
static int right(double t, void *y, void *dy, void *data) {
  Model *m = (Model *)data;
  ++m->evaluations;
  std::memcpy(m->w + STATE, N_VGetArrayPointer(y), 8 * STATES);
  rates(m->w, m->tables, t);
  std::memcpy(N_VGetArrayPointer(dy), m->w + RATE, 8 * STATES);
  return 0;
}
static const int rows_of[] = {ROWS}, columns_of[] = {COLUMNS};
static int slopes(double t, void *y, void *, void *matrix, void *data, void *, void *, void *) {
  Model *m = (Model *)data;
  std::memcpy(m->w + STATE, N_VGetArrayPointer(y), 8 * STATES);
  observe(m->w, m->tables, t);
  double *to = SUNDenseMatrix_Data(matrix);
  for (int k = 0; k < ENTRIES; ++k) to[columns_of[k] * STATES + rows_of[k]] = m->w[SIGNAL + k];
  return 0;
}
static void sample(V *w, const long *tables, double t, int k) {
  switch (k) { SAMPLES }
  refresh(w, tables, t);
}
extern "C" int drive(V *w, const long *tables, double t, double stop, int rates_count, const double *periods,
                     double relative, double *absolute, long *counts) {
  Model model = {w, tables, 0};
  double y_data[STATES], before[POWERS];
  long taken[16] = {0};
  void *context = 0;
  SUNContext_Create(0, &context);
  void *y = N_VMake_Serial(STATES, y_data, context), *a = N_VMake_Serial(STATES, absolute, context);
  void *matrix = SUNDenseMatrix(STATES, STATES, context), *solver = SUNLinSol_Dense(y, matrix, context);
  void *memory = CVodeCreate(2, context);
  const double origin = t;
  double near = 1.0;
  for (int k = 0; k < rates_count; ++k) near = periods[k] < near ? periods[k] : near;
  near *= 1e-9;
  prepare(w, tables, t); refresh(w, tables, t);
  std::memcpy(y_data, w + STATE, 8 * STATES);
  int flag = CVodeInit(memory, right, t, y);
  CVodeSVtolerances(memory, relative, a);
  CVodeSetUserData(memory, &model);
  CVodeSetMaxNumSteps(memory, 1000000);
  CVodeSetLinearSolver(memory, solver, matrix);
  CVodeSetJacFn(memory, slopes);
  while (flag >= 0) {
    std::memcpy(w + STATE, y_data, 8 * STATES);
    for (int k = 0; k < rates_count; ++k)
      if (instant(origin, taken[k], periods[k]) <= t + near) { sample(w, tables, t, k); ++taken[k]; }
    if (t + near >= stop) break;
    double end = stop;
    for (int k = 0; k < rates_count; ++k) {
      const double at = instant(origin, taken[k], periods[k]);
      if (at < end) end = at;
    }
    CVodeReInit(memory, t, y);
    CVodeSetStopTime(memory, end);
    rates(w, tables, t);
    std::memcpy(before, w + POWER, 8 * POWERS);
    while (t < end) {
      const double from = t;
      flag = CVode(memory, end, y, &t, 2);
      if (flag < 0) break;
      ++counts[0];
      std::memcpy(w + STATE, y_data, 8 * STATES);
      rates(w, tables, t);
      const double half = 0.5 * (t - from);
      for (int i = 0; i < POWERS; ++i) {
        const double p = w[POWER + i];
        w[INTEGRAL + i] += half * (before[i] + p);
        w[ACTIVITY + i] += half * (std::fabs(before[i]) + std::fabs(p));
        before[i] = p;
      }
    }
    t = end;
  }
  counts[1] = model.evaluations;
  CVodeFree(&memory); SUNLinSolFree(solver); SUNMatDestroy(matrix); N_VDestroy(a); N_VDestroy(y);
  SUNContext_Free(&context);
  return flag < 0 ? flag : 0;
}
"""


def sundials_libraries() -> list[Path] | None:
    """The libraries of SUNDIALS that scikit-sundae brings, where it is installed and does so."""
    package = find_spec("sksundae")
    if package is None or package.origin is None:
        return None
    folder = Path(package.origin).parent.parent / "scikit_sundae.libs"
    found = [next(iter(sorted(folder.glob(f"lib{name}*.so*"))), None) for name in _NEEDED]
    return [file for file in found if file is not None] if None not in found else None


class CvodeFromC:
    """A model with CVODE in one library."""

    def __init__(self, hybrid: Hybrid) -> None:
        libraries = sundials_libraries()
        if libraries is None:
            raise ModuleNotFoundError("scikit-sundae with its libraries is not installed")
        self._hybrid = hybrid
        printer = hybrid.printer
        regions = printer.regions
        samples = " ".join(f"case {k}: sample{k}(w, tables, t); break;" for k in range(len(hybrid.periods)))
        numbers = {
            "STATES": hybrid.size,
            "POWERS": len(hybrid.memory.activity),
            "ENTRIES": len(hybrid.rows),
            "STATE": regions[Array.STATE],
            "RATE": regions[Array.RATE],
            "POWER": regions[Array.POWER],
            "SIGNAL": regions[Array.SIGNAL],
            "INTEGRAL": regions["integral"],
            "ACTIVITY": regions["activity"],
        }
        text = _DRIVER.replace("{ROWS}", "{" + ", ".join(map(str, hybrid.rows)) + "}")
        text = text.replace("{COLUMNS}", "{" + ", ".join(map(str, hybrid.columns)) + "}").replace("SAMPLES", samples)
        constants = "".join(f"static const int {name} = {value};\n" for name, value in numbers.items())
        self._library = compile_shared(printer.text + constants + text, EXACT, libraries)

    def run(self, tolerance: float, scale: FloatArray) -> Outcome:
        """From the start to the end."""
        hybrid = self._hybrid
        hybrid.reset()
        block = aligned(len(hybrid.block), 1)[:, 0]
        block[:] = hybrid.block
        periods, counts = np.array(hybrid.periods), np.zeros(2, dtype=np.int64)
        absolute = tolerance * scale

        def at(array: FloatArray) -> ctypes.c_void_p:
            return ctypes.c_void_p(array.ctypes.data)

        flag = self._library.drive(
            at(block),
            at(hybrid.tables.descriptors),
            ctypes.c_double(hybrid.memory.time),
            ctypes.c_double(hybrid.stop),
            len(periods),
            at(periods),
            ctypes.c_double(tolerance),
            at(absolute),
            at(counts),
        )
        if flag:
            raise ArithmeticError(f"CVODE gave up with flag {flag}")
        for rows, values in places_of(hybrid.printer, hybrid.memory):
            values[...] = block[rows]
        hybrid.memory.time = hybrid.stop
        return Outcome(hybrid.memory, int(counts[0]), int(counts[1]))
