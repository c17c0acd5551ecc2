"""Vector bonds are scalar ones written together: equal models, equal answers, and faults at the author's line."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import numpy as np
import pytest

import propermodel as pm
from propermodel.diagnostics import ModelError, Path
from propermodel.library.mechanics.translation import ForceSource
from propermodel.modelling.documents import from_document, to_document
from propermodel.modelling.model import HalfArrow, Node, OpenPort, SignalLink
from tests.parts import Fixed, Flywheel, Mass, Spring


def line_of_next(lines: int = 1) -> str:
    """The place of a line after the caller's."""
    frame = inspect.currentframe()
    assert frame is not None
    assert frame.f_back is not None
    return f"tests/modelling/test_vector_ports.py:{frame.f_back.f_lineno + lines}"


class Point(pm.VectorPort):
    """A point that moves in x and y."""

    x = pm.Port(pm.Translation)
    y = pm.Port(pm.Translation)


class Pose(Point):
    """A point with an angle, and where it is."""

    angle = pm.Port(pm.Rotation)
    place = pm.Input("m")


class Disc(pm.Component):
    """A point with a mass in either direction."""

    point = Point()
    mass: pm.Parameter = pm.parameter("kg", default=2.0)

    along = Mass(mass=mass)
    across = Mass(mass=mass)

    connections = (pm.connect(point.x, along.flange), pm.connect(point.y, across.flange))


class Anchor(pm.Component):
    """A spring in either direction between a point and another."""

    a = Point()
    b = Point()

    along = Spring(stiffness=100.0)
    across = Spring(stiffness=400.0)

    connections = (
        pm.connect(a.x, along.a),
        pm.connect(a.y, across.a),
        pm.connect(b.x, along.b),
        pm.connect(b.y, across.b),
    )


class Wall(pm.Component):
    """A point that stands still."""

    point = Point()
    held = Fixed()

    connections = (pm.connect(held.flange, point.x, point.y),)


class Rig(pm.Component):
    """A disc between two anchors, wired by vectors."""

    left = Wall()
    first = Anchor()
    disc = Disc()
    second = Anchor()
    right = Wall()

    connections = (
        pm.connect(left.point, first.a),
        pm.connect(first.b, disc.point, second.a),
        pm.connect(second.b, right.point),
    )


class RigByMembers(pm.Component):
    """The same, wired member by member."""

    left = Wall()
    first = Anchor()
    disc = Disc()
    second = Anchor()
    right = Wall()

    connections = (
        pm.connect(left.point.x, first.a.x),
        pm.connect(left.point.y, first.a.y),
        pm.connect(first.b.x, disc.point.x, second.a.x),
        pm.connect(first.b.y, disc.point.y, second.a.y),
        pm.connect(second.b.x, right.point.x),
        pm.connect(second.b.y, right.point.y),
    )


def test_a_vector_connection_is_its_scalar_connections():
    by_vectors, by_members = pm.elaborate(Rig(), name="rig"), pm.elaborate(RigByMembers(), name="rig")
    assert by_vectors.root.definition.connections == by_members.root.definition.connections
    nodes = by_vectors.root.definition.connections
    assert all(isinstance(node, Node) for node in nodes)
    assert nodes[2] == Node(ports=(Path(("first", "b_x")), Path(("disc", "point_x")), Path(("second", "a_x"))))


def test_the_document_is_scalar_and_comes_back_equal():
    model = pm.elaborate(Rig())
    document = to_document(model)
    disc = next(d for d in document["definitions"] if d["type_name"] == "Disc")
    assert [port["name"] for port in disc["ports"]] == ["point_x", "point_y"]
    assert from_document(document) == model


def test_each_direction_vibrates_with_its_own_springs():
    scenario = pm.Scenario(stop=1.0, initial={"disc.along.momentum": 2.0, "disc.across.momentum": 2.0})
    answer = pm.simulate(pm.compile_model(pm.elaborate(Rig())), scenario, step=1e-3, method=pm.Method.RK4)
    time = answer.time
    # Two springs in parallel on 2 kg: 10 rad/s along, 20 rad/s across.
    assert answer["disc.point_x.flow"] == pytest.approx(np.cos(10.0 * time), abs=1e-7)
    assert answer["disc.point_y.flow"] == pytest.approx(np.cos(20.0 * time), abs=1e-7)


def test_members_are_observables_of_views():
    rig = Rig()
    assert rig.disc.point.x.flow.data.path == Path(("disc", "point_x", "flow"))
    assert rig.disc.point.path == Path(("disc", "point"))
    assert Disc.declarations["point_y"] is Disc.point.y
    assert [name for name in Disc.declarations if name.startswith("point")] == ["point", "point_x", "point_y"]


def test_a_composite_exports_a_vector_port():
    class Carriage(pm.Component):
        point = Point()
        disc = Disc()
        connections = (pm.connect(point, disc.point),)

    class Held(pm.Component):
        carriage = Carriage()
        anchor = Anchor()
        wall = Wall()
        connections = (pm.connect(carriage.point, anchor.a), pm.connect(anchor.b, wall.point))

    inside = pm.elaborate(Held()).root.definition.parts[0].definition
    assert inside.connections == (
        Node(ports=(Path(("point_x",)), Path(("disc", "point_x")))),
        Node(ports=(Path(("point_y",)), Path(("disc", "point_y")))),
    )
    assert len(pm.compile_model(pm.elaborate(Held())).system.states) == 4


def test_a_chain_joins_vector_ports():
    class Row(pm.Component):
        left = Wall()
        anchors = pm.repeat(3, Anchor())
        right = Wall()
        connections = (
            pm.connect(left.point, anchors[0].a),
            pm.chain(anchors, "b", "a"),
            pm.connect(anchors[2].b, right.point),
        )

    nodes = pm.elaborate(Row()).root.definition.connections
    assert Node(ports=(Path(("anchors[1]", "b_y")), Path(("anchors[2]", "a_y")))) in nodes
    assert len(nodes) == 8


def test_a_vector_bond_has_a_half_arrow_for_each_member():
    class Pushed(pm.Component):
        disc = Disc()
        anchor = Anchor()
        wall = Wall()
        connections = (pm.bond(disc.point, anchor.a), pm.connect(anchor.b, wall.point))

    arrows = [c for c in pm.elaborate(Pushed()).root.definition.connections if isinstance(c, HalfArrow)]
    assert arrows == [
        HalfArrow(tail=Path(("disc", "point_x")), head=Path(("anchor", "a_x"))),
        HalfArrow(tail=Path(("disc", "point_y")), head=Path(("anchor", "a_y"))),
    ]


@pytest.mark.parametrize("opening", [pm.free, pm.prescribed_flow, pm.prescribed_effort])
def test_an_open_vector_port_is_open_at_each_member(opening: Callable[[Point], object]):
    class Open(pm.Component):
        point = Point()
        disc = Disc()
        connections = (pm.connect(point, disc.point), opening(point))

    found = [c for c in pm.elaborate(Open()).root.definition.connections if isinstance(c, OpenPort)]
    assert [item.port for item in found] == [Path(("point_x",)), Path(("point_y",))]
    assert len({item.opening for item in found}) == 1


def test_an_element_has_vector_ports_and_lies_between_members():
    class Between(pm.Compliance):
        """A spring along x between two points."""

        a = Point()
        b = Point()
        port = pm.Port(pm.Translation, between=(a.x, b.x))

        def effort(self, displacement: pm.Expr) -> pm.Expr:
            return pm.quantity(3.0, "N/m") * displacement

    assert [name for name in Between.declarations if name != "port"] == ["a", "a_x", "a_y", "b", "b_x", "b_y"]
    between = Between.declarations["port"].between
    assert between == (Between.a.x, Between.b.x)


def test_a_subclass_may_declare_another_vector_port_of_the_same_name():
    class Turning(Disc):
        point = Pose()

    assert "point_angle" in Turning.declarations
    assert Turning.declarations["point_x"] is Turning.point.x
    assert Disc.declarations["point_x"] is Disc.point.x


# -- signals beside the bonds -----------------------------------------------------------------------------


class Ground(pm.Component):
    """Stands still at 3 m and says so."""

    pose = Pose.giving()
    held = Fixed()
    shaft = Flywheel(inertia=1.0)

    connections = (
        pm.connect(held.flange, pose.x, pose.y),
        pm.connect(shaft.shaft, pose.angle),
        pm.connect(pm.quantity(3.0, "m"), pose.place),
    )


class Follower(pm.Component):
    """Is pushed with a force that grows with where it is."""

    pose = Pose()
    push = ForceSource()
    wheel = Flywheel(inertia=1.0)

    connections = (
        pm.connect(pose.x, push.flange),
        pm.connect(pose.y),
        pm.connect(pose.angle, wheel.shaft),
        pm.connect(pm.quantity(2.0, "N/m") * pose.place, push.force),
    )


def test_signals_go_from_the_port_that_gives_them_to_the_others():
    class Pushed(pm.Component):
        follower = Follower()
        ground = Ground()
        connections = (pm.connect(follower.pose, ground.pose),)

    (link,) = (c for c in pm.elaborate(Pushed()).root.definition.connections if isinstance(c, SignalLink))
    assert link.targets == (Path(("follower", "pose_place")),)
    assert link.value.data.path == Path(("ground", "pose_place"))


def test_an_exported_vector_port_hands_its_signals_on():
    class Inner(pm.Component):
        a = Pose()
        follower = Follower()
        connections = (pm.connect(a, follower.pose),)

    class Outer(pm.Component):
        b = Pose.giving()
        ground = Ground()
        connections = (pm.connect(ground.pose, b),)

    class Pushed(pm.Component):
        inner = Inner()
        outer = Outer()
        connections = (pm.connect(inner.a, outer.b),)

    compiled = pm.compile_model(pm.elaborate(Pushed()))
    run = pm.simulate(compiled, pm.Scenario(stop=0.1))
    assert run["inner.follower.push.force"][-1] == pytest.approx(6.0)


def test_two_ports_that_give_are_refused():
    class Twice(pm.Component):
        one = Ground()
        other = Ground()
        here = line_of_next()
        connections = (pm.connect(one.pose, other.pose),)

    with pytest.raises(ModelError) as caught:
        pm.elaborate(Twice())
    (fault,) = caught.value.diagnostics
    assert fault.message == "2 vector ports of a connection give place"
    assert str(fault.source) == Twice.here
    assert [(i.path, i.role) for i in fault.involved] == [("one.pose", "gives them"), ("other.pose", "gives them")]


def test_ports_that_all_take_are_refused():
    class Never(pm.Component):
        one = Follower()
        other = Follower()
        connections = (pm.connect(one.pose, other.pose),)

    with pytest.raises(ModelError, match="no vector port of a connection gives place"):
        pm.elaborate(Never())


# -- faults -----------------------------------------------------------------------------------------------


def test_vector_ports_of_different_members_are_refused():
    class Wrong(pm.Component):
        disc = Disc()
        follower = Follower()
        here = line_of_next()
        connections = (pm.connect(disc.point, follower.pose),)

    with pytest.raises(ModelError) as caught:
        pm.elaborate(Wrong())
    (fault,) = caught.value.diagnostics
    assert fault.code == "model/vector-port"
    assert fault.message == "a connection joins vector ports of different members"
    assert str(fault.source) == Wrong.here
    assert [(i.path, i.role) for i in fault.involved] == [
        ("disc.point", "has x (translation), y (translation)"),
        ("follower.pose", "has x (translation), y (translation), angle (rotation), place (m)"),
    ]


def test_members_of_other_domains_are_refused():
    class Shafts(pm.VectorPort):
        x = pm.Port(pm.Rotation)
        y = pm.Port(pm.Translation)

    class Turning(pm.Component):
        shafts = Shafts()
        wheel = Flywheel(inertia=1.0)
        mass = Mass(mass=1.0)
        connections = (pm.connect(shafts.x, wheel.shaft), pm.connect(shafts.y, mass.flange))

    class Wrong(pm.Component):
        disc = Disc()
        turning = Turning()
        connections = (pm.connect(disc.point, turning.shafts),)  # pyright: ignore[reportArgumentType]

    with pytest.raises(ModelError, match=r"has x \(rotation\), y \(translation\)"):
        pm.elaborate(Wrong())


def test_a_vector_port_with_a_scalar_one_is_refused():
    here = line_of_next(2)
    with pytest.raises(ModelError) as caught:
        pm.connect(Disc.point, Mass.flange)  # pyright: ignore[reportCallIssue, reportArgumentType]
    (fault,) = caught.value.diagnostics
    assert fault.message == "connect joins a vector port with vector ports only; it was given Point, Port"
    assert str(fault.source) == here
    with pytest.raises(ModelError, match="a bond joins a vector port with a vector port only"):
        pm.bond(Disc.point, Mass.flange)  # pyright: ignore[reportCallIssue, reportArgumentType]


def test_an_unconnected_vector_port_is_one_fault():
    class Loose(pm.Component):
        disc = Disc()
        anchor = Anchor()
        connections = (pm.connect(disc.point, anchor.a),)

    with pytest.raises(ModelError) as caught:
        pm.elaborate(Loose())
    (fault,) = caught.value.diagnostics
    assert fault.code == "model/unconnected-port"
    assert fault.message == "the vector port 'anchor.b' (x, y) is not connected"


def test_a_partly_connected_vector_port_names_what_is_missing():
    class Half(pm.Component):
        disc = Disc()
        wall = Fixed()
        connections = (pm.connect(disc.point.x, wall.flange),)

    with pytest.raises(ModelError) as caught:
        pm.elaborate(Half())
    (fault,) = caught.value.diagnostics
    assert fault.code == "model/vector-port"
    assert fault.message == "of the vector port 'disc.point' only x is connected, not y"
    assert fault.source.file == "tests/modelling/test_vector_ports.py"


def test_a_name_that_a_member_takes_is_refused():
    with pytest.raises(ModelError, match="declares 'point_x', and its vector port 'point' has a member of that name"):

        class Taken(pm.Component):  # pyright: ignore[reportUnusedClass]
            point = Point()
            point_x = pm.Port(pm.Translation)


def test_a_vector_port_has_ports_and_inputs_only():
    with pytest.raises(ModelError, match="Heavy declares 'mass', which no vector port can have"):

        class Heavy(pm.VectorPort):  # pyright: ignore[reportUnusedClass]
            x = pm.Port(pm.Translation)
            mass: pm.Parameter = pm.parameter("kg")


@pytest.mark.parametrize("name", ["path", "members", "gives", "giving"])
def test_a_member_may_not_be_called_as_what_a_vector_port_needs(name: str):
    with pytest.raises(ModelError, match=f"Odd calls a member '{name}'"):
        type("Odd", (pm.VectorPort,), {name: pm.Port(pm.Translation)})
