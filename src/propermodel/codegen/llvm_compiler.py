"""From text to machine code and into this process, by LLVM.

Code is compiled quickly at first, and thoroughly once a run is long enough to win back the time. Both give the same
numbers to the last bit, as no instruction may be replaced by one of another value.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import Any

from propermodel.codegen.program import Program

LARGE_MODULE = 1_000_000  # characters
_compile_lock = threading.Lock()


class Effort(StrEnum):
    """How much time compiling may take."""

    QUICK = "quick"
    THOROUGH = "thorough"


@dataclass(frozen=True)
class Levels:
    """How hard LLVM tries: the level of its passes over instructions, and of the choice of machine code."""

    passes: int
    code: int


def levels_of(effort: Effort, text: str) -> Levels:
    """The levels for an effort.

    Higher levels of code schedule instructions anew, which takes half of the time and makes no step shorter; what
    further passes add finds nothing in straight-line code that is printed without repetition. In a large module the
    first passes take as long as all the rest, and steps no longer become shorter.
    """
    if effort is Effort.QUICK:
        return Levels(passes=0, code=0)
    return Levels(passes=1 if len(text) < LARGE_MODULE else 0, code=1)


@lru_cache(maxsize=1)
def _binding() -> Any:
    # llvmlite is slow to import and not needed by those who only interpret.
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


@lru_cache(maxsize=1)
def host() -> tuple[str, ...]:
    """What machine code depends on beside its text: processor and its features, system, and the compiler."""
    import llvmlite

    binding = _binding()
    version = ".".join(str(part) for part in binding.llvm_version_info)
    features = binding.get_host_cpu_features().flatten()
    return (binding.get_host_cpu_name(), features, binding.get_default_triple(), llvmlite.__version__, version)


def vector_lanes() -> int:
    """How many numbers a vector register of this machine holds."""
    features = _binding().get_host_cpu_features()
    return 8 if features.get("avx512f") else 4 if features.get("avx") else 2


def _target(levels: Levels) -> Any:
    binding = _binding()
    cpu, features, *_ = host()
    target = binding.Target.from_default_triple()
    return target.create_target_machine(cpu=cpu, features=features, opt=levels.code)


def _module(text: str, target: Any) -> Any:
    binding = _binding()
    module = binding.parse_assembly(text)
    module.triple = binding.get_default_triple()
    module.data_layout = str(target.target_data)
    return module


def compile_text(text: str, effort: Effort) -> bytes:
    """The object code of LLVM assembly for the processor at hand."""
    binding = _binding()
    levels = levels_of(effort, text)
    with _compile_lock:
        target = _target(levels)
        module = _module(text, target)
        module.verify()
        options = binding.create_pipeline_tuning_options(speed_level=levels.passes)
        builder = binding.create_pass_builder(target, options)
        builder.getModulePassManager().run(module, builder)
        return target.emit_object(module)


class Library:
    """Machine code loaded into this process, and its entry points; it stays as long as this object."""

    def __init__(self, code: bytes, program: Program) -> None:
        binding = _binding()
        with _compile_lock:
            target = _target(Levels(0, 0))
            self._engine = binding.create_mcjit_compiler(_module("", target), target)
            self._engine.add_object_file(binding.ObjectFileRef.from_data(code))
            self._engine.finalize_object()
        self.run = self._function("run", ctypes.c_void_p)
        self.rates = self._function("evaluate.rates", ctypes.c_double)
        self.observe = self._function("evaluate.observe", ctypes.c_double)
        self.sample = self._function("evaluate.sample", ctypes.c_double)
        if program.guards is not None:
            self.guards = self._function("evaluate.guards", ctypes.c_double)
            self.jumps = self._function("evaluate.jumps", ctypes.c_double)
            self.advance = self._function("advance", ctypes.c_double, ctypes.c_double)
        if program.switching is not None:
            self.switching = self._function("evaluate.switching", ctypes.c_double)

    def _function(self, name: str, *last: Any) -> Callable[..., int]:
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *last)
        return prototype(self._engine.get_function_address(name))
