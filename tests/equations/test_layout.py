"""Equations on pages of 100 columns: nothing is lost, nothing is wider, lines break where little is bound."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from propermodel.equations.layout import WIDTH, wrapped

NAMES = st.sampled_from(["front_axle.left_wheel.damping", "tyre.stiffness", "pipe[10].column.volume_flow", "v1", "2"])
FORMULAS = st.recursive(
    NAMES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from([" + ", " - ", "*", "/"]), inner).map("".join),
        inner.map("({})".format),
        inner.map("sqrt({})".format),
        st.tuples(NAMES, NAMES).map(lambda pair: f"|{pair[0]} - {pair[1]}|"),
        st.tuples(inner, inner, inner).map(lambda three: f"({three[0]} if {three[1]} < 0 else {three[2]})"),
        st.tuples(inner, inner).map(lambda two: f"min({two[0]}, {two[1]})"),
    ),
    max_leaves=40,
)


@given(left=FORMULAS, right=FORMULAS, width=st.integers(0, 60))
def test_a_wrapped_equation_is_the_equation_within_the_page(left, right, width):
    lines = wrapped(left, right, width)
    assert "".join("".join(lines).split()) == "".join(f"{left}={right}".split())
    assert max(map(len, lines)) <= WIDTH
    assert lines[0].startswith("  ")


@pytest.mark.parametrize("length", range(80, 100))
def test_what_fits_stays_on_one_line(length):
    right = "x" * (length - len("  a = "))
    assert wrapped("a", right, 1) == [f"  a = {right}"]


def test_terms_are_broken_before_factors_and_factors_before_brackets():
    long = "subsystem_with_a_long_name.part.velocity"
    assert wrapped("mass", f"{long}*{long} - {long}*({long} + {long})*{long}", 0) == [
        f"  mass = {long}*{long}",
        f"        - {long}",
        f"            *({long} + {long})",
        f"            *{long}",
    ]


def test_a_long_left_side_is_broken_too():
    inertia = "+ ".join(f"transmission.gear[{gear}].rotating_inertia*ratio^2 " for gear in range(4)).strip()
    lines = wrapped(f"({inertia})*speed'", "torque", 0)
    assert lines[0] == "  (transmission.gear[0].rotating_inertia*ratio^2"
    assert lines[-1].endswith("*speed' = torque")
    assert max(map(len, lines)) <= WIDTH
