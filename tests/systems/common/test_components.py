"""Connected components of graphs."""

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest
from scipy.sparse import coo_array, csgraph

from hunav_drake.systems.common.components import connected_components


@settings(deadline=None)
@given(st.data())
def test_they_are_those_of_scipy(data):
    count = data.draw(st.integers(1, 30))
    node = st.integers(0, count - 1)
    edges = data.draw(st.lists(st.tuples(node, node), max_size=40))
    ends = np.array(edges, dtype=np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(edges)), tuple(ends)), shape=(count, count))
    _, expected = csgraph.connected_components(graph, directed=False)
    np.testing.assert_array_equal(connected_components(count, ends), expected)


@pytest.mark.parametrize("shuffled", [False, True])
def test_a_long_chain_is_one(shuffled):
    nodes = np.arange(50_000)
    if shuffled:
        np.random.default_rng(0).shuffle(nodes)
    label = connected_components(len(nodes), (nodes[:-1], nodes[1:]))
    assert not label.any()


def test_without_edges_each_is_its_own():
    label = connected_components(3, ([], []))
    np.testing.assert_array_equal(label, [0, 1, 2])
