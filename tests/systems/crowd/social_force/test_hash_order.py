"""The order in which HuNavSim goes through people."""

import numpy as np
import pytest

from hunav_drake.systems.crowd.social_force.hash_order import hash_order
from hunav_drake.systems.crowd.social_force.model import SocialForceModel

# The results of GCC's std::unordered_map<int, int>.
RECORDED = [
    ([], []),
    ([5], [0]),
    ([1, 2, 3, 4, 5], [4, 3, 2, 1, 0]),
    ([5, 4, 3, 2, 1], [4, 3, 2, 1, 0]),
    ([3, 16, 29, 1], [3, 2, 1, 0]),
    ([*range(1, 15)], [13, *range(13)]),
    ([10, 45, 2, 4, 34, 50, 13, 9, 42], [8, 7, 6, 5, 4, 3, 2, 1, 0]),
    (
        [
            *(130, 173, 150, 9, 285, 257, 122, 209, 51, 32, 225, 219, 126, 195),
            *(235, 113),
        ],
        [15, 13, 0, 1, 2, 3, 12, 4, 10, 8, 5, 6, 7, 14, 9, 11],
    ),
]


@pytest.mark.parametrize(("ids", "rows"), RECORDED)
def test_it_is_that_of_a_hash_table(ids, rows):
    assert hash_order(ids).tolist() == rows


@pytest.mark.parametrize("n", [13, 14, 29, 30, 500, 3000])
def test_everybody_is_in_it_once(n):
    ids = np.random.default_rng(n).permutation(4 * n)[:n]
    assert sorted(hash_order(ids.tolist())) == list(range(n))


def test_forces_go_to_whom_they_belong_whoever_is_first(make_snapshot):
    rng = np.random.default_rng(1)
    states = rng.uniform(-2, 2, (6, 6))
    snapshot = make_snapshot(states, rng.uniform(-9, 9, (6, 2)))
    model = SocialForceModel(kernel="hunavsim")
    usual = model.forces(snapshot)
    other = snapshot._replace(turns=rng.permutation(6))
    np.testing.assert_allclose(model.forces(other), usual, atol=1e-12)
    np.testing.assert_allclose(
        model.advance(other, model.forces(other)),
        model.advance(snapshot, usual),
        atol=1e-7,
    )
