"""Random trees of all nodes do no harm: see `fuzz.py`."""

import pytest

from tests.vocabulary.fuzz import leaves, run


def test_39_all_leaves_are_tried():
    names = {it.name for it in leaves()}
    assert len(names) > 45
    assert {"ConversationFormation", "SaySomething", "BlockRobot"} <= names


@pytest.mark.parametrize("seed", range(4))
def test_39_random_trees_do_no_harm(seed):
    run(seed)


@pytest.mark.slow
def test_39_six_hundred_random_trees_do_no_harm():
    refused = sum(bool(run(seed)) for seed in range(100, 200))
    assert refused < 30
