"""Strong components in order, and partners, against SciPy and a search through everything."""

from __future__ import annotations

from itertools import product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from propermodel.causality.graph_algorithms import match_each, strong_components


@given(st.integers(1, 9).flatmap(lambda n: st.tuples(st.just(n), st.lists(st.tuples(*[st.integers(0, n - 1)] * 2)))))
def test_strong_components_are_those_of_scipy_and_in_order(graph):
    count, edges = graph
    components = strong_components(count, edges)
    matrix = np.zeros((count, count))
    for i, j in edges:
        matrix[i, j] = 1.0
    number, labels = connected_components(csr_array(matrix), directed=True, connection="strong")
    assert sorted(components) == sorted(np.flatnonzero(labels == label).tolist() for label in range(number))
    position = {node: place for place, component in enumerate(components) for node in component}
    assert all(position[j] <= position[i] for i, j in edges)


def test_long_chain_of_components():
    edges = [(i, i + 1) for i in range(5000)]
    assert strong_components(5001, edges) == [[i] for i in range(5000, -1, -1)]


def test_large_component():
    edges = [(i, (i + 1) % 5000) for i in range(5000)]
    assert strong_components(5000, edges) == [list(range(5000))]


@given(st.lists(st.lists(st.integers(0, 4), unique=True), max_size=5))
def test_everyone_has_a_partner_of_its_own_where_that_is_possible(candidates):
    possible = any(len(set(choice)) == len(candidates) for choice in product(*candidates))
    chosen = match_each(candidates)
    assert (chosen is not None) is possible
    if chosen is not None:
        assert len(set(chosen)) == len(candidates)
        assert all(one in offered for one, offered in zip(chosen, candidates, strict=True))


def test_first_choice_is_given_up_for_others():
    assert match_each([[0, 1], [0, 2], [0]]) == [1, 2, 0]
