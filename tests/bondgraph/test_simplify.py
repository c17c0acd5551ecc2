"""The normal form: what is left of a graph when everything that only passes a bond through is gone."""

from __future__ import annotations

from itertools import chain, combinations, permutations

import pytest
from hypothesis import given, settings

from propermodel.bondgraph.flatten import flatten
from propermodel.bondgraph.graph import Bond, BondGraph, Structure
from propermodel.diagnostics import Path, StructureError
from propermodel.modelling import (
    Component,
    Hydraulic,
    Port,
    ZeroEffort,
    ZeroFlow,
    connect,
    elaborate,
    prescribed_effort,
)
from propermodel.modelling.model import ElementKind, JunctionKind
from tests.parts import Damper, Fixed, Force, Line, Mass, Pipe, Spring, SpringDamper, Tank, Velocity
from tests.rigs import rigs


def shape(structure: Structure) -> frozenset[object]:
    """The structure up to the names of junctions: colours refined by what is around, elements by name."""
    at = structure.at()
    colour: dict[Path, object] = {p: str(p) for p in structure.elements}
    colour |= {p: j.kind.value for p, j in structure.junctions.items()}
    for _ in range(len(structure.junctions) + 1):
        seen = {
            path: (
                colour[path],
                tuple(sorted(repr((colour[b.other(path).owner], b.other(path).port)) for b in at[path])),
            )
            for path in structure.junctions
        }
        names = {c: f"{c[0]}:{n}" for n, c in enumerate(sorted(set(seen.values()), key=repr))}
        colour |= {path: names[c] for path, c in seen.items()}
    return frozenset(
        (frozenset({(colour[b.tail.owner], b.tail.port), (colour[b.head.owner], b.head.port)}))
        for b in structure.bonds.values()
    )


def junctions_of(graph: BondGraph, kind: JunctionKind) -> int:
    return sum(j.kind is kind for j in graph.normal.junctions.values())


def neighbours(graph: BondGraph, element: str) -> set[str]:
    """The elements that share a junction with a one-port element; a mere change of sign is looked through."""
    at = graph.normal.at()

    def beyond(bond: Bond, place: Path) -> Path:
        """What a bond leads to from a place, past junctions of two bonds."""
        while (there := bond.other(place).owner) in graph.normal.junctions and len(at[there]) == 2:
            first, second = at[there]
            bond, place = (second if first is bond else first), there
        return there

    start = Path(element.split("."))
    junction = beyond(at[start][0], start)
    around = {beyond(bond, junction) for bond in at.get(junction, [])}
    return {str(path) for path in around - {start} if path in graph.normal.elements}


class Suspended(Component):
    """A mass on a spring and a damper in parallel above a moving base."""

    base = Velocity(velocity=1.0)
    strut = SpringDamper(stiffness=10.0, damping=2.0)
    body = Mass(mass=3.0)

    connections = (connect(base.flange, strut.a), connect(strut.b, body.flange))


class SuspendedReversed(Component):
    """The same; the damper is turned round."""

    base = Velocity(velocity=1.0)
    spring = Spring(stiffness=10.0)
    damper = Damper(damping=2.0)
    body = Mass(mass=3.0)

    connections = (connect(base.flange, spring.a, damper.b), connect(spring.b, damper.a, body.flange))


def test_spring_and_damper_in_parallel_share_one_junction():
    graph = flatten(elaborate(Suspended()))
    assert neighbours(graph, "strut.spring") == {"strut.damper"}
    assert junctions_of(graph, JunctionKind.ZERO) == 1


def test_orientation_does_not_matter_to_the_normal_form():
    graph = flatten(elaborate(SuspendedReversed()))
    assert neighbours(graph, "spring") == {"damper"}


class ParallelLines(Component):
    """The dual: an inertance and a loss in series, twice, between two tanks."""

    upper = Tank(capacity=1e-9)
    lower = Tank(capacity=2e-9)
    line = Line(inertance=1e6)
    pipe = Pipe(loss=1e8)

    connections = (connect(upper.port, line.a), connect(line.b, pipe.a), connect(pipe.b, lower.port))


class ParallelPipes(Component):
    upper = Tank(capacity=1e-9)
    lower = Tank(capacity=2e-9)
    first = Pipe(loss=1e8)
    second = Pipe(loss=3e8)

    connections = (connect(upper.port, first.a, second.a), connect(lower.port, first.b, second.b))


def test_line_and_pipe_in_series_share_one_flow():
    graph = flatten(elaborate(ParallelLines()))
    assert neighbours(graph, "line") == {"pipe", "upper", "lower"}


def test_pipes_in_parallel_share_one_pressure_drop():
    graph = flatten(elaborate(ParallelPipes()))
    assert neighbours(graph, "first") == {"second"}
    assert neighbours(graph, "upper") == {"lower"}
    assert junctions_of(graph, JunctionKind.ONE) == 1


class Grounded(Component):
    mass = Mass(mass=1.0)
    spring = Spring(stiffness=10.0)
    damper = Damper(damping=2.0)
    wall = Fixed()

    connections = (connect(mass.flange, spring.a, damper.a), connect(spring.b, damper.b, wall.flange))


def test_ground_disappears():
    graph = flatten(elaborate(Grounded()))
    assert neighbours(graph, "mass") == {"spring", "damper"}
    assert len(graph.normal.junctions) == 1
    assert Path(("wall",)) in graph.idle


class TwoStruts(Component):
    """Struts of spring and damper above each other, with a third damper to the wall."""

    wall = Fixed()
    lower = SpringDamper(stiffness=10.0, damping=2.0)
    middle = Mass(mass=1.0)
    upper = SpringDamper(stiffness=20.0, damping=1.0)
    body = Mass(mass=3.0)
    push = Force(force=1.0)

    connections = (
        connect(wall.flange, lower.a),
        connect(lower.b, middle.flange, upper.a),
        connect(upper.b, body.flange, push.flange),
    )


LEAVES = [Path((strut, leaf, "port")) for strut in ("lower", "upper") for leaf in ("spring", "damper")]
SUBSETS = list(chain.from_iterable(combinations(LEAVES, n) for n in range(1, 5)))


@pytest.mark.parametrize("subset", SUBSETS, ids=lambda s: "+".join(f"{p[0][0]}{p[1][0]}" for p in s))
@pytest.mark.parametrize("removal", [ZeroEffort, ZeroFlow])
def test_order_of_removals_does_not_matter(subset, removal):
    model = elaborate(TwoStruts())
    shapes = set()
    for order in permutations(subset):
        at_once = model.without([removal(p) for p in order])
        one_by_one = model
        for path in order:
            one_by_one = one_by_one.without([removal(path)])
        assert one_by_one == at_once
        shapes.add(shape(flatten(at_once).normal))
    assert len(shapes) == 1


def test_removing_a_damper_leaves_the_spring_alone():
    graph = flatten(elaborate(Suspended()).without([ZeroEffort(Path(("strut", "damper", "port")))]))
    assert neighbours(graph, "strut.spring") == {"base", "body"}
    assert Path(("strut", "damper")) in graph.idle


def test_a_rigid_spring_joins_what_it_connects():
    graph = flatten(elaborate(TwoStruts()).without([ZeroFlow(LEAVES[2])]))
    assert neighbours(graph, "middle") == {"body", "push", "lower.spring", "lower.damper"}
    assert {Path(("upper", "spring")), Path(("upper", "damper"))} <= set(graph.idle)


def test_mass_without_forces_stays():
    removals = [ZeroEffort(Path(("strut", leaf, "port"))) for leaf in ("spring", "damper")]
    graph = flatten(elaborate(Suspended()).without(removals))
    assert [str(p) for p, e in graph.normal.elements.items() if e.kind is ElementKind.INERTIA] == ["body"]
    assert neighbours(graph, "body") == set()


class ClosedTank(Component):
    supply = Port(Hydraulic)
    valve = Pipe(loss=1e8)
    tank = Tank(capacity=1e-9)

    connections = (connect(supply, valve.a), connect(valve.b, tank.port), prescribed_effort(supply))


def test_volume_that_is_closed_off_keeps_its_pressure():
    graph = flatten(elaborate(ClosedTank()).without([ZeroFlow(Path(("valve", "port")))]))
    assert Path(("tank",)) in graph.normal.elements
    assert Path(("valve",)) in graph.idle


class Shorted(Component):
    wall = Fixed()
    motion = Velocity(velocity=1.0)

    connections = (connect(wall.flange, motion.flange),)


def test_a_source_against_a_ground_is_named():
    with pytest.raises(StructureError) as caught:
        flatten(elaborate(Shorted()))
    (fault,) = caught.value.diagnostics
    assert fault.code == "structure/source-shorted"
    assert fault.message == "motion prescribes the flow where wall holds it at zero"
    assert fault.help == "take one of the two away, or put a part between them that takes the difference of flow"
    assert [(i.path, i.role) for i in fault.involved] == [
        ("motion", "prescribes its flow"),
        ("wall", "holds it at zero (its Sf is 0)"),
    ]


@given(rigs())
@settings(max_examples=60)
def test_normal_form_has_nothing_left_to_simplify(rig):
    graph = flatten(elaborate(rig.component()))
    normal = graph.normal
    at = normal.at()
    for path, junction in normal.junctions.items():
        bonds = at[path]
        assert bonds
        for bond in bonds:
            other = bond.other(path)
            assert other.owner != path
            if not other.port:
                assert normal.junctions[other.owner].kind is not junction.kind
    assert {p for p, e in graph.original.elements.items() if e.kind.is_storage} <= set(normal.elements) | set(
        graph.idle
    )
    assert set(graph.idle) == set(graph.original.elements) - set(normal.elements)
