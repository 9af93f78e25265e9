"""Metrics of robots with each other, against paths with known answers."""

import dataclasses

import numpy as np
import pytest

from hunav_drake.systems.evaluation.compute import evaluate
from hunav_drake.systems.evaluation.recording import Recording


def robot(x, *, y=0.0, goal=None, name="", times=None):
    x = np.asarray(x, dtype=float)
    times = 0.1 * np.arange(len(x)) if times is None else times
    rows = np.zeros((len(x), 7))
    rows[:, 0], rows[:, 1], rows[:, 6] = x, y, 0.25
    rows[:, 3] = np.gradient(x, times)
    return Recording(
        times=times,
        robot=rows,
        humans=np.zeros((len(x), 0, 7)),
        goal=goal,
        robot_name=name,
    )


def of(*robots):
    first, *others = robots
    joined = dataclasses.replace(first, others=tuple(others))
    return evaluate(joined, ["fleet"]).values


def test_robots_that_meet_have_the_gap_and_the_contact_of_their_discs():
    x = np.linspace(0, 4, 81)
    values = of(robot(x, name="a"), robot(4 - x, y=0.6, name="b"))
    assert values["min_dist_between_robots"] == pytest.approx(0.1)
    assert values["contacts_between_robots"] == 0
    values = of(robot(x, name="a"), robot(4 - x, y=0.51, name="b"))
    assert values["min_dist_between_robots"] == pytest.approx(0.01)
    assert values["contacts_between_robots"] == 1


def test_a_contact_ends_after_a_pause():
    gap = np.array([1, 0, 0, 1, 0, 1, 1, 1, 1, 0, 1.0])
    values = of(robot(0 * gap, name="a"), robot(0.5 + gap, name="b"))
    # 0.2 s apart is one contact, 0.5 s are two.
    assert values["contacts_between_robots"] == 2


def test_a_contact_lasts_while_all_samples_are_in_it_however_rare_they_are():
    gap = np.array([0, 0, 0, 1, 0, 0.0])
    times = 0.5 * np.arange(6)
    first = robot(0 * gap, name="a", times=times)
    values = of(first, robot(0.5 + gap, name="b", times=times))
    assert values["contacts_between_robots"] == 2


def test_each_pair_counts():
    still = np.zeros(5)
    values = of(*(robot(still + 0.5 * i, name=f"r{i}") for i in range(4)))
    assert values["contacts_between_robots"] == 3
    assert values["min_dist_between_robots"] == pytest.approx(0.0)


def test_a_deadlock_is_a_long_stop_of_all_away_from_their_goals():
    def stop(seconds):
        steps = round(seconds / 0.1)
        x = [*np.linspace(0, 1, 11), *[1.0] * steps, *np.linspace(1, 2, 11)]
        goal = (2.0, 0.0, 0.0)
        return of(
            robot(x, name="a", goal=goal),
            robot(x, y=2.0, name="b", goal=(9.0, 9.0, 0.0)),
        )["deadlock_time"]

    assert stop(9.0) == 0
    assert stop(15.0) == pytest.approx(15.0, abs=0.3)
    # One robot at its goal is no deadlock; robots without goals do not count.
    x = np.zeros(300)
    at = robot(x, name="a", goal=(0.0, 0.0, 0.0))
    away = robot(x, y=3.0, name="b", goal=(5.0, 5.0, 0.0))
    assert of(at, away)["deadlock_time"] == 0
    assert np.isnan(of(away, robot(x, y=6.0, name="c"))["deadlock_time"])


def test_makespan_is_the_last_arrival_and_costs_are_their_sum():
    x = np.linspace(0, 4, 41)
    first = robot(2 * x, name="a", goal=(8.0, 0.0, 0.0))
    second = robot(x, y=3.0, name="b", goal=(2.0, 3.0, 0.0))
    values = of(first, second)
    # (The tolerance is 0.2 m.)
    assert values["makespan"] == pytest.approx(4.0, abs=0.11)
    assert values["sum_of_costs"] == pytest.approx(4.0 + 2.0, abs=0.3)
    never = robot(x, y=3.0, name="b", goal=(9.0, 3.0, 0.0))
    assert np.isnan(of(first, never)["makespan"])
    assert np.isnan(of(first, never)["sum_of_costs"])


def test_each_robot_has_the_reference_of_its_name(tmp_path):
    x = np.linspace(0, 4, 41)
    a, b = robot(x, name="a"), robot(x, y=3.0, name="b")
    both = dataclasses.replace(a, others=(b,))
    near = dataclasses.replace(
        robot(x, y=3.5, name="b"), others=(robot(x, y=1.0, name="a"),)
    )
    compared = both.compared_with(near)
    values = evaluate(compared, ["ade"]).values
    assert values == pytest.approx(
        {"a.avg_displacement_error": 1.0, "b.avg_displacement_error": 0.5}
    )
    compared.save(tmp_path / "compared.npz")
    assert Recording.load(tmp_path / "compared.npz") == compared
    # (Also where only some have one.)
    some = dataclasses.replace(compared, others=(b,))
    some.save(tmp_path / "some.npz")
    assert Recording.load(tmp_path / "some.npz") == some
    with pytest.raises(ValueError, match="robots of the recording, 'a', 'b'"):
        both.compared_with(a)
    with pytest.raises(ValueError, match="'robot'; it has 'a', 'b'"):
        robot(x).compared_with(both)
    # What a robot does after its end is no reference.
    ended = dataclasses.replace(
        both, others=(dataclasses.replace(b, end_time=1.0),)
    )
    path = both.compared_with(ended).others[0].reference_path
    assert path[-1, 0] == pytest.approx(1.0)
    alone = b.compared_with(ended.robots[1]).reference_path
    np.testing.assert_array_equal(alone, path)


def test_one_robot_has_none_of_them_unless_they_are_named():
    alone = robot(np.zeros(3))
    assert not evaluate(alone, ["fleet"]).values
    assert "makespan" not in evaluate(alone).values
    assert np.isnan(evaluate(alone, ["deadlock_time"]).values["deadlock_time"])


def test_arrivals_after_a_robots_end_do_not_count():
    """A robot that is stuck, and gets to its goal while others drive."""
    x = np.linspace(0, 4, 41)
    goal = (2.0, 3.0, 0.0)
    first = robot(x, name="a", goal=(4.0, 0.0, 0.0))
    second = robot(x, y=3.0, name="b", goal=goal)
    assert of(first, second)["makespan"] < 4.1
    stuck = dataclasses.replace(second, end_time=1.0)
    assert np.isnan(of(first, stuck)["makespan"])
    assert np.isnan(of(first, stuck)["sum_of_costs"])
