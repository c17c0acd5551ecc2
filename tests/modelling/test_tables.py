"""Tables and quantities: numbers become SI, and what is no table is refused at the author's line."""

from __future__ import annotations

import math

import pytest

from propermodel.diagnostics import ModelError
from propermodel.expressions import Expr
from propermodel.modelling import Component, EffortSource, Port, Translation, elaborate, quantity, table, table_values
from propermodel.modelling.model import PowerSource, TableValues


class Engine(EffortSource):
    flange = Port(Translation)
    pull = table("kN", ("km/h",), [[0.0, 36.0]], [2.0, 1.0], extrapolation="linear", source="measured")

    def effort(self) -> Expr:
        return self.pull(self.flange.flow)


def test_table_is_in_si():
    (spec,) = elaborate(Engine()).root.definition.tables
    assert spec.values == TableValues(((0.0, pytest.approx(10.0)),), (2000.0, 1000.0))
    assert (spec.extrapolation, spec.source) == ("linear", "measured")


def test_law_looks_the_table_up():
    behaviour = elaborate(Engine()).root.definition.behaviour
    assert isinstance(behaviour, PowerSource)
    assert repr(behaviour.value) == "pull(flange.flow)"


def test_numbers_of_a_table_are_exchanged_with_its_values():
    other = table_values([[0.0, 1.0]], [5.0, 6.0])

    class Rig(Component):
        engine = Engine(pull=other)
        connections = ()

    (part,) = elaborate(Rig()).root.definition.parts
    assert part.tables == (("pull", other),)


@pytest.mark.parametrize(
    ("grids", "values", "message"),
    [
        ([[0.0]], [1.0], "the grid of a table must have two or more strictly growing, finite points"),
        ([[0.0, 0.0]], [1.0, 2.0], "the grid of a table must have two or more strictly growing, finite points"),
        ([[0.0, math.nan]], [1.0, 2.0], "the grid of a table must have two or more strictly growing, finite points"),
        ([[0.0, math.inf]], [1.0, 2.0], "the grid of a table must have two or more strictly growing, finite points"),
        ([[0.0, 1.0]], [1.0], "a table on this grid needs 2 finite values, 1 were given"),
        ([[0.0, 1.0]], [1.0, math.nan], "a table on this grid needs 2 finite values, 2 were given"),
        ([[0.0, 1.0], [0.0, 1.0, 2.0]], [0.0] * 5, "a table on this grid needs 6 finite values, 5 were given"),
    ],
)
def test_what_is_no_table_is_refused_where_it_stands(grids, values, message):
    with pytest.raises(ModelError) as caught:
        table("N", ("m",) * len(grids), grids, values)
    (fault,) = caught.value.diagnostics
    assert fault.message == message
    assert fault.source.file == "tests/modelling/test_tables.py"


def test_quantity_is_in_si_with_its_dimension():
    assert quantity(20, "kN/m").data == (20000.0, "kg/s2")
    assert quantity(90, "deg").data == (pytest.approx(math.pi / 2), "")
    with pytest.raises(ModelError, match="is not a unit"):
        quantity(1.0, "parrots")
