"""Storage measured about a point, so that a preloaded spring and the weight it carries do not count."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from propermodel.analysis.linearise import operating_point
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Faults, Path, ReductionError, one_of
from propermodel.equations.system import StorageDatum, StorageReference
from propermodel.expressions.core import Expr
from propermodel.modelling.model import ElementKind, Scenario, Variable
from propermodel.simulation.equilibrium import Equilibrium
from propermodel.simulation.observables import observable_path
from propermodel.simulation.point import Point
from propermodel.simulation.trajectory import Trajectory


def measure_about(
    compiled: CompiledModel,
    at: Equilibrium | Scenario | Trajectory,
    *,
    time: float | None = None,
    of: Iterable[Expr | Path | str] | None = None,
) -> CompiledModel:
    """The same model, whose runs measure the activity of storage about a point.

    A spring that carries a weight gives and takes the work of its preload, which the weight takes and gives: neither
    says anything of the motion. Of a compliance counts (e - e0) f, of an inertia e (f - f0), with the effort e0 and the
    flow f0 that it has at the point. Resistances count as they are: what is lost is lost. `rank_activity` of a run of
    the model that is given back ranks by this, and says so among its datums.

    What rests at the point but works all the same, such as a vessel under pressure or a flywheel that turns, would seem
    small: name the parts that only carry their load in `of`.

    Args:
        compiled: The model.
        at: An equilibrium, the start of a scenario, or a run (its end, or the instant `time`).
        time: The instant of a run, s.
        of: The parts or elements whose storage is measured so; by default all.

    Raises:
        SimulationError: the point belongs to another compiled model, or the run does not reach the instant.
        ReductionError: there is no storage in a part.
    """
    memory, description = operating_point(compiled, at, time)
    parts = None if of is None else tuple(map(observable_path, of))
    point = Point(compiled.system, compiled.lowered, memory)
    graph = compiled.graph
    ports = [
        (bond, Variable.EFFORT if element.kind is ElementKind.COMPLIANCE else Variable.FLOW)
        for path, bonds in graph.normal.at().items()
        if (element := graph.normal.elements.get(path)) is not None and element.kind.is_storage
        if parts is None or any(_is_in(path, part) for part in parts)
        for bond in bonds
    ]
    _check(parts or (), [path for path, element in graph.normal.elements.items() if element.kind.is_storage])
    values = point.values([compiled.system.values[graph.variables.of(bond, variable)] for bond, variable in ports])
    references = tuple(
        StorageReference(bond.name, variable, float(value))
        for (bond, variable), value in zip(ports, values, strict=True)
    )
    return compiled.about(StorageDatum(_described(description, parts), references))


def _is_in(path: Path, part: Path) -> bool:
    return path[: len(part)] == part


def _described(point: str, parts: tuple[Path, ...] | None) -> str:
    return point if parts is None else f"{point} in {', '.join(map(str, parts))}"


def _check(parts: Iterable[Path], storage: Sequence[Path]) -> None:
    faults = Faults(ReductionError)
    for part in parts:
        if not any(_is_in(path, part) for path in storage):
            faults.add(
                Diagnostic(
                    "activity/no-storage",
                    f"there is no storage in '{part}' to be measured about a point",
                    help=one_of(str(part), map(str, storage)),
                )
            )
    faults.raise_if_any()
