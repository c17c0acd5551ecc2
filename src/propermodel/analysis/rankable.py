"""Which runs can be ranked: complete, of one model, and of one kind of bonds."""

from __future__ import annotations

from collections.abc import Sequence

from propermodel.bondgraph.graph import Bond, BondGraph
from propermodel.bondgraph.pseudo import is_pseudo
from propermodel.compiler import CompiledModel
from propermodel.diagnostics import Diagnostic, Path, ReductionError, one_of
from propermodel.simulation.trajectory import Trajectory

TRUE = "true"  # what true bonds are called in `rank_activity(run, among=...)`


def kind_of(graph: BondGraph, bond: Bond) -> str:
    """What a bond is ranked among: `true`, or the name of its pseudo domain."""
    return bond.domain if is_pseudo(graph, bond) else TRUE


def check_runs(runs: Sequence[Trajectory], refined: Sequence[Trajectory], among: str | None) -> None:
    """Refuse what cannot be ranked together.

    Raises:
        ReductionError: there are no runs or not one refined run for each, a run did not reach its end, runs are of
            different models, or true and pseudo bonds would be mixed.
    """
    if not runs or (refined and len(refined) != len(runs)):
        raise ReductionError.of(
            "activity/runs",
            f"{len(runs)} runs and {len(refined)} refined runs cannot be ranked",
            help="give at least one run, and no refined ones or one for each, in the same order",
        )
    for run in runs:
        _check_complete(run, "run" if len(runs) == 1 else f"run of scenario '{run.scenario.name}'")
    for run in refined:
        _check_complete(run, "refined run")
    first = runs[0].compiled.system.rows
    for run in (*runs[1:], *refined):
        if run.compiled.system.rows != first:
            raise ReductionError.of(
                "activity/runs",
                f"the runs are of models with different rows: {runs[0].compiled.model.name} and "
                f"{run.compiled.model.name}",
                help="rank runs of one model together, and others apart",
            )
        if run.compiled.system.datum != runs[0].compiled.system.datum:
            raise ReductionError.of(
                "activity/runs",
                f"the runs measure storage about different points: {_point(runs[0])} and {_point(run)}",
                help="measure all about one point: simulate what one measure_about(...) gives",
            )
    check_bonds(runs[0].compiled, among)


def _point(run: Trajectory) -> str:
    datum = run.compiled.system.datum
    return "none" if datum is None else datum.point


def _check_complete(trajectory: Trajectory, name: str) -> None:
    if not trajectory.ending.is_complete:
        raise ReductionError.of(
            "activity/incomplete",
            f"the {name} did not reach its end: {trajectory.ending.message}",
            where=str(trajectory.ending.path),
            help="rank a run that is complete: cure the failure (a smaller step?), or let the scenario stop earlier",
        )


def check_bonds(compiled: CompiledModel, among: str | None) -> None:
    """Refuse to rank true and pseudo bonds together.

    Raises:
        ReductionError: they would be, or there are no bonds of this name.
    """
    graph = compiled.graph
    pseudo = sorted({domain.name for domain in graph.domains.values() if not domain.is_true})
    if among is not None and among not in (TRUE, *pseudo):
        raise ReductionError.of(
            "activity/unknown-domain",
            f"there are no bonds called '{among}' to rank",
            help=one_of(among, (TRUE, *pseudo)),
        )
    bonds = [graph.normal.bonds[name] for row in compiled.system.rows for name in row.bonds]
    kinds = {kind_of(graph, bond): bond for bond in reversed(bonds)}
    if among is None and len(kinds) > 1:
        name, bond = next((name, bond) for name, bond in kinds.items() if name != TRUE)
        raise ReductionError(
            [
                Diagnostic(
                    "activity/pseudo-bonds",
                    "true and pseudo bonds cannot be ranked together: the product of a pseudo bond is not power",
                    where=f"{bond.name} is a pseudo bond ({name})",
                    help=f"rank them apart, rank_activity(run, among='{TRUE}') or among='{name}', "
                    "or write the pseudo domain as a true one, with entropy flow for heat",
                )
            ]
        )


def rows_among(compiled: CompiledModel, among: str | None) -> set[Path]:
    """The rows that are ranked."""
    graph = compiled.graph
    found: set[Path] = set()
    for row in compiled.system.rows:
        kinds = {kind_of(graph, graph.normal.bonds[name]) for name in row.bonds}
        if among is None or kinds == {among}:
            found.add(row.path)
    return found


def comparison_of(run: Trajectory, refined: Trajectory) -> str:
    """What the refined run has that the run has not, in words."""
    if run.step == refined.step:
        return f"at a tolerance of {refined.tolerance:g} instead of {run.tolerance:g}"
    return f"at a step of {refined.step:g} s instead of {run.step:g} s"
