"""Points at equal distances, found among others."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from propermodel.codegen.progressions import progressions

points = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=60)


@given(points, st.integers(2, 5))
def test_every_sequence_has_equal_steps_and_no_point_is_in_two(given_points: list[tuple[int, int]], least: int):
    found = progressions(given_points, least)
    for members, step in found:
        assert len(members) >= least
        for before, after in pairwise(members):
            assert tuple(b - a for a, b in zip(given_points[before], given_points[after], strict=True)) == step
    every = [member for members, _ in found for member in members]
    assert len(every) == len(set(every))


def test_sequences_that_interleave_are_told_apart():
    # Each force with the speed before it and with the one after it.
    pairs = [(k, 100 + k + side) for k in range(20) for side in (0, 1)]
    found = progressions(pairs, 8)
    assert {step for _, step in found} == {(1, 1)}
    assert sorted(len(members) for members, _ in found) == [20, 20]


def test_one_sequence_is_found_in_any_order():
    shuffled = [(7 * k % 50, 3 * (7 * k % 50)) for k in range(50)]
    ((members, step),) = progressions(shuffled, 8)
    assert step == (1, 3)
    assert [shuffled[member] for member in members] == [(k, 3 * k) for k in range(50)]


def test_equal_points_follow_each_other():
    ((members, step),) = progressions([(4,)] * 9, 8)
    assert (members, step) == (list(range(9)), (0,))


def test_what_has_no_order_is_left():
    assert progressions([(k * k, 7 * k**3) for k in range(40)], 8) == []
