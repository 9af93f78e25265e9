from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.crowd.orca.neighbors import find_neighbors, make_cells


def neighbors_of_all(points, *, reach, most):
    points = np.asarray(points, dtype=float)
    x, y = points[:, 0].copy(), points[:, 1].copy()
    cells = make_cells(x, y)
    found = np.empty(len(points), np.int64)
    result = []
    for i in range(len(points)):
        count = find_neighbors(
            i, x[i], y[i], cells, reach, most, np.empty(most), found
        )
        result.append(sorted(found[:count].tolist()))
    return result


def expected(points, *, reach, most):
    result = []
    for i, point in enumerate(points):
        d = np.hypot(*(points - point).T)
        d[i] = np.inf
        last = np.sort(d)[min(most, len(d)) - 1]
        near = d <= min(reach, last * (1 + 1e-12))
        result.append(np.flatnonzero(near).tolist())
    return result


@pytest.mark.parametrize("n", [1, 2, 20, 300])
@pytest.mark.parametrize("shape", [(1, 1), (1, 0), (100, 0.01)])
def test_the_nearest_are_found(n, shape):
    rng = np.random.default_rng(n)
    points = rng.uniform(-10, 10, (n, 2)) * shape
    for reach in (0.5, 3.0, 100.0):
        assert neighbors_of_all(points, reach=reach, most=10) == expected(
            points, reach=reach, most=10
        )


def test_a_crowd_with_someone_far_away():
    points = np.random.default_rng(0).uniform(0, 20, (200, 2))
    points[17] = 1e5, -1e5
    result = neighbors_of_all(points, reach=10, most=5)
    assert result == expected(points, reach=10, most=5)
    assert result[17] == []


@pytest.mark.parametrize("shift", [0.0, 0.1, 1234.56])
def test_people_equally_far_all_count(shift):
    side = np.arange(11.0) + shift
    points = np.array(np.meshgrid(side, side)).reshape(2, -1).T
    center = 60
    result = neighbors_of_all(points, reach=10, most=2)[center]
    assert result == [49, 59, 61, 71]


def test_people_in_one_place_are_neighbors():
    assert neighbors_of_all([[3, 4]] * 3, reach=1, most=1) == [
        [1, 2],
        [0, 2],
        [0, 1],
    ]


@given(st.data())
def test_the_order_of_people_does_not_matter(data):
    coordinate = st.integers(-5, 5)
    points = data.draw(
        st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=30)
    )
    order = data.draw(st.permutations(range(len(points))))
    plain = neighbors_of_all(points, reach=4, most=3)
    permuted = neighbors_of_all([points[i] for i in order], reach=4, most=3)
    for row, i in zip(permuted, order, strict=True):
        assert sorted(order[j] for j in row) == plain[i]
