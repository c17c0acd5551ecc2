"""Compiles printed programs with GCC and runs them on the memories of the package."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.c_printer import CPrinter
from propermodel.codegen.machine import FloatArray, IntArray, Memory, Method, sample_periods
from propermodel.codegen.native_memory import ready_tables
from propermodel.codegen.program import Array, Program

EXACT = ("-O2", "-march=native", "-fno-math-errno", "-fno-trapping-math")
FAST = ("-O3", "-march=native", "-ffast-math")


@dataclass(frozen=True, slots=True)
class Setting:
    """How GCC is called."""

    name: str
    flags: tuple[str, ...]


SETTINGS = (Setting("gcc -O2", EXACT), Setting("gcc -O3 -ffast-math", FAST))


def compiler() -> str | None:
    """The C++ compiler of GCC, where there is one."""
    return shutil.which("g++")


class CMachine:
    """A program as GCC compiled it."""

    def __init__(self, program: Program, method: Method, lanes: int, flags: tuple[str, ...]) -> None:
        self._program = program
        self._lanes = lanes
        self._printer = CPrinter(program, method, lanes)
        begin = time.perf_counter()
        self._library = compile_shared(self._printer.text, flags)
        self.compile_s = time.perf_counter() - begin

    def run(self, memory: Memory, until: float, step: float) -> float:
        """Run to an instant; gives the processor time it took."""
        printer, program = self._printer, self._program
        block = aligned(printer.rows, self._lanes)
        places = places_of(printer, memory)
        for first, values in places:
            block[first] = values.reshape(-1, self._lanes)
        tables = ready_tables(program, memory.tables)
        clock = np.array([memory.time])
        periods = np.array(sample_periods(program, memory))
        begin = time.process_time()
        code = self._library.run(
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (block, tables.descriptors, clock)),
            *(ctypes.c_double(number) for number in (until, step, memory.origin)),
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (periods, memory.samples_taken)),
        )
        taken = time.process_time() - begin
        if code:
            raise ArithmeticError(f"the compiled run has no finite state at {clock[0]} s")
        for first, values in places:
            values.reshape(-1, self._lanes)[...] = block[first]
        memory.time = float(clock[0])
        return taken


def aligned(rows: int, lanes: int) -> FloatArray:
    """Zeros that begin where vectors may."""
    storage = np.zeros(rows * lanes + 8)
    skip = (-storage.ctypes.data % 64) // 8
    return storage[skip : skip + rows * lanes].reshape(rows, lanes)


def places_of(printer: CPrinter, memory: Memory) -> list[tuple[IntArray, FloatArray]]:
    """The rows of a memory's arrays."""
    regions = printer.regions
    states = regions[Array.STATE] + np.array(printer.states, dtype=np.int64)
    found = [(states, memory.state)]
    for region, values in (
        (Array.DISCRETE, memory.discrete),
        (Array.PARAMETER, memory.parameter),
        (Array.UNKNOWN, memory.unknown),
        ("integral", memory.integral),
        ("activity", memory.activity),
    ):
        found.append((regions[region] + np.arange(len(values)), values))
    return found


def compile_shared(text: str, flags: Iterable[str], libraries: Iterable[Path] = ()) -> ctypes.CDLL:
    """A text as a library that is loaded here; those it needs are found again where they are."""
    program = compiler()
    if program is None:
        raise FileNotFoundError("g++ is not installed")
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "model.cpp"), Path(folder, "model.so")
        source.write_text(text)
        needed = [str(file) for file in libraries]
        paths = [f"-Wl,-rpath,{folder}" for folder in sorted({str(Path(file).parent) for file in needed})]
        subprocess.run([program, *flags, "-shared", "-fPIC", "-w", "-o", library, source, *needed, *paths], check=True)
        return ctypes.CDLL(str(library))
