"""The spine: a model becomes a compiled model.

    Component -> Model -> BondGraph -> CausalGraph -> EquationSystem -> Program -> CompiledModel

Each arrow is one function, each node one frozen type.
"""

from __future__ import annotations

import gc
import json
import sys
import time
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.graph import BondGraph
from propermodel.bondgraph.parameters import parameter_values
from propermodel.bondgraph.separate import separate_parts
from propermodel.causality.complete import complete_causality
from propermodel.causality.transformer_loops import TransformerLoop, locked_loops, transformer_loops
from propermodel.codegen.build import Backend, build_machine
from propermodel.codegen.lower import Lowered, lower
from propermodel.codegen.machine import Machine, Method
from propermodel.diagnostics import Diagnostic, ModelWarning
from propermodel.equations.events import SystemEvent
from propermodel.equations.formulate import formulate
from propermodel.equations.impulsive import impulsive_sources
from propermodel.equations.state_selection import select_states
from propermodel.equations.system import EquationSystem, StorageDatum
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.limits import Limits
from propermodel.modelling.model import Model
from propermodel.presentation import notebook_html

if TYPE_CHECKING:
    from propermodel.codegen.tangents import Direction, TangentProgram


@dataclass(frozen=True)
class CompiledTangents:
    """A program with tangents for one integration method; machines are made when first used."""

    tangents: TangentProgram
    method: Method
    backend: Backend
    _machines: dict[int, Machine] = field(default_factory=dict[int, Machine], repr=False)

    def machine(self, lanes: int = 1) -> Machine:
        """The native code."""
        if lanes not in self._machines:
            with _collection_later():
                self._machines[lanes] = build_machine(self.tangents.program, self.method, lanes, self.backend)
        return self._machines[lanes]


@dataclass(frozen=True)
class CompiledModel:
    """A model with its equations and program; machines for each integration method are made when first used."""

    model: Model
    system: EquationSystem
    lowered: Lowered
    backend: Backend
    compile_s: float
    _machines: dict[tuple[Method, int], Machine] = field(default_factory=dict[tuple[Method, int], Machine], repr=False)
    _variants: dict[SystemEvent, CompiledModel] = field(
        default_factory=dict["SystemEvent", "CompiledModel"], repr=False
    )

    _tangents: dict[tuple[Any, ...], CompiledTangents] = field(
        default_factory=dict[tuple[Any, ...], CompiledTangents], repr=False
    )

    def _repr_html_(self) -> str | None:
        return notebook_html(self)

    @property
    def graph(self) -> BondGraph:
        """The bond graph in normal form."""
        return self.system.causal.graph

    @cached_property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What its author may not have meant, although it can be simulated; what removals bring about is meant."""
        if self.model.removals:
            return ()
        with _collection_later():
            loops = self.transformer_loops
            locked = locked_loops(self.graph, loops, parameter_values(self.graph.parameters)) if loops else ()
            return (*separate_parts(self.graph), *locked, *impulsive_sources(self.system))

    @cached_property
    def transformer_loops(self) -> tuple[TransformerLoop, ...]:
        """Two-ports in a ring; whether they lock or repeat each other depends on parameters."""
        return transformer_loops(self.graph.normal)

    def machine(self, method: Method, lanes: int = 1) -> Machine:
        """The native code for one integration method."""
        key = (method, lanes)
        if key not in self._machines:
            with _collection_later():
                self._machines[key] = build_machine(self.lowered.program, method, lanes, self.backend)
        return self._machines[key]

    def with_event(self, event: SystemEvent) -> CompiledModel:
        """The same with one more event, the last; what it mentions must have slots, so that memories still fit."""
        if event not in self._variants:
            system = replace(self.system, events=(*self.system.events, event))
            self._variants[event] = CompiledModel(self.model, system, lower(system), self.backend, self.compile_s)
        return self._variants[event]

    def about(self, datum: StorageDatum) -> CompiledModel:
        """The same, where the activity of storage is measured about a datum, too."""
        system = replace(self.system, datum=datum)
        return CompiledModel(self.model, system, lower(system), self.backend, self.compile_s)

    def tangents(
        self, method: Method, directions: tuple[Direction, ...], signals: tuple[int, ...], powers: tuple[int, ...]
    ) -> CompiledTangents:
        """The program for a method with its tangents along directions, of chosen signals and powers.

        Raises:
            SimulationError: the derivatives pass an implicit block that is too large.
        """
        from propermodel.codegen.rosenbrock import with_step_of
        from propermodel.codegen.tangents import with_tangents

        key = (method, directions, signals, powers)
        if key not in self._tangents:
            with _collection_later():
                program = with_tangents(with_step_of(self.lowered.program, method), directions, signals, powers)
            self._tangents[key] = CompiledTangents(program, method, self.backend)
        return self._tangents[key]

    @cached_property
    def _document(self) -> str:
        return json.dumps(to_document(self.model))

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process gets the document of the model, and compiles it once however often it gets it."""
        return _compiled_there, (self._document, self.backend, len(self.system.events), self.system.datum)

    def __str__(self) -> str:
        return str(self.system)


def compile_model(model: Model, *, backend: Backend = Backend.NATIVE) -> CompiledModel:
    """Compile a model, removals included; what its author may not have meant is shown as a `ModelWarning`.

    Raises:
        ModelError: ports or signals are not connected.
        StructureError: the bond graph has no causality or its equations are singular.
    """
    compiled = compile_quietly(model, backend=backend)
    for diagnostic in compiled.warnings:
        warnings.warn(ModelWarning(diagnostic), stacklevel=2)
    return compiled


def compile_quietly(model: Model, *, backend: Backend = Backend.NATIVE) -> CompiledModel:
    """Compile a variant of a model whose warnings have been shown.

    Raises:
        ModelError: ports or signals are not connected.
        StructureError: the bond graph has no causality or its equations are singular.
    """
    begin = time.perf_counter()
    with _collection_later():
        graph = flatten(model)
        causal = select_states(complete_causality(graph))
        system = formulate(causal)
        lowered = lower(system)
    return CompiledModel(model, system, lowered, backend, time.perf_counter() - begin)


@lru_cache(maxsize=4)
def _compiled_there(document: str, backend: Backend, events: int, datum: StorageDatum | None) -> CompiledModel:
    """The compiled model of a document from another process of the same user.

    Raises:
        ValueError: it had more events than its model, those of `CompiledModel.with_event`.
    """
    own = Limits(**{limit.name: sys.maxsize for limit in fields(Limits)})
    compiled = compile_quietly(from_document(json.loads(document), limits=own), backend=backend)
    if len(compiled.system.events) != events:
        raise ValueError(f"{compiled.model.name} with an event that its model does not have stays in its process")
    return compiled if datum is None else compiled.about(datum)


@contextmanager
def _collection_later() -> Generator[None, None, None]:
    """Without the collector of cycles: it would search, again and again, what is kept anyway."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            if not gc.get_freeze_count():
                # What has been made counts as old at once, rather than after it has been searched three times.
                gc.freeze()
                gc.unfreeze()
            gc.enable()


__all__ = ["Backend", "CompiledModel", "Method", "compile_model", "compile_quietly"]
