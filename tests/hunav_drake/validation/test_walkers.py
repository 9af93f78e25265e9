"""People of any model, walked step by step."""

import numpy as np
import pytest

from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.validation.case import Setting
from hunav_drake.validation.diagrams import EndlessCorridor
from hunav_drake.validation.walkers import TIME_STEP, Walkers

MODELS = sorted(MOTION_MODELS)


@pytest.mark.parametrize("model", MODELS)
def test_who_has_left_is_met_by_nobody(model):
    setting = Setting(model)
    starts = [[0, 0], [1.5, 0.1]]
    goals = [[20, 0], [-20, 0]]
    both = Walkers(setting, starts, goals)
    both.send_away(np.array([False, True]))
    alone = Walkers(setting, starts[:1], goals[:1]).walk(3.0)
    walk = both.walk(3.0)
    assert abs(walk.states[:, 0] - alone.states[:, 0]).max() < 1e-9
    assert not walk.present[:, 1].any()


@pytest.mark.parametrize("model", MODELS)
def test_walks_repeat_bit_for_bit(model):
    starts, goals = [[0, 0], [4, 0.1]], [[20, 0], [-20, 0]]
    walks = [Walkers(Setting(model), starts, goals).walk(4.0) for _ in "ab"]
    assert np.array_equal(walks[0].states, walks[1].states)


def test_a_walk_ends_when_all_have_left_or_patience_is_over():
    walkers = Walkers(Setting("social_force"), [[0, 0]], [20, 0], speeds=1.0)
    walk = walkers.walk(60.0, leave=lambda rows: rows[:, 0] > 5)
    assert 5 < walk.times[-1] < 6.5
    walkers = Walkers(Setting("social_force"), [[0, 0]], [20, 0], speeds=1.0)
    walk = walkers.walk(60.0, leave=lambda rows: rows[:, 0] > 5, patience=2.0)
    assert walk.times[-1] == pytest.approx(2.0 + TIME_STEP)


@pytest.mark.parametrize("model", MODELS)
def test_an_endless_corridor_has_no_seam(model):
    """Whether people meet in the middle or at the end, they do the same.

    It is longer than twice the distance from which models see others.
    """
    starts = np.array([[4.0, 0.9], [4.7, 1.2], [5.5, 0.8], [6.2, 1.1]])
    speeds = [1.6, 1.0, 1.4, 0.7]
    moved = []
    for shift in (0.0, 17.0):
        p = starts + np.array([shift, 0])
        p[:, 0] %= 22
        corridor = EndlessCorridor(Setting(model), p, 22.0, 2.0, speeds)
        moved.append([corridor.step() for _ in range(40)])
    assert np.ptp(np.sum(moved[0], axis=0)[:, 0]) > 0.05
    assert abs(np.array(moved[0]) - moved[1]).max() < 1e-3


def test_one_person_has_an_endless_corridor_alone():
    corridor = EndlessCorridor(
        Setting("social_force"), np.array([[1.0, 2.0]]), 12.0, 4.0
    )
    # Twice around.
    assert corridor.mean_speed(3.0, 20.0) == pytest.approx(1.34, abs=0.01)
