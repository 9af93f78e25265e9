"""What is measured on people, on walks whose answers are known."""

import numpy as np
import pytest

from hunav_drake.validation.measures import (
    flow_rate,
    lane_order,
    nearest_centers,
    peak_acceleration,
    peak_density,
    touches,
    weidmann,
)
from hunav_drake.validation.places import (
    Area,
    room,
    samples_in_walls,
    spread,
    wall,
)
from hunav_drake.validation.walkers import TIME_STEP, Walk


def make_walk(positions, velocities=None):
    """A walk of positions (k, n, 2), and maybe velocities, at each step."""
    positions = np.asarray(positions, dtype=float)
    states = np.zeros((*positions.shape[:2], 7))
    states[..., :2] = positions
    if velocities is not None:
        states[..., 3:5] = velocities
    times = np.arange(len(positions)) * TIME_STEP
    return Walk(times, states, np.ones(positions.shape[:2], dtype=bool))


@pytest.mark.parametrize(
    ("density", "speed"),
    [(0.5, 1.30), (1, 1.06), (1.75, 0.70), (2, 0.61), (3, 0.33), (5, 0.04)],
)
def test_weidmann_is_as_published(density, speed):
    assert weidmann(density) == pytest.approx(speed, abs=0.005)


def test_nobody_walks_in_a_jam():
    assert weidmann([5.4, 6.0]).tolist() == [0.0, 0.0]


def test_the_flow_is_that_of_the_middle_of_a_queue():
    # Two in a second, but for a late first one and a last one.
    times = np.concatenate([[0.0], np.arange(20, 38) / 2, [99.0]])
    assert flow_rate(times) == pytest.approx(2.0)
    assert flow_rate(np.flip(times)) == pytest.approx(2.0)


def test_who_never_passes_is_no_flow():
    assert flow_rate(np.full(10, np.inf)) == 0.0
    # Of ten, four pass in 3 s: the third and the fourth count.
    times = np.array([0.0, 1, 2, 3] + [np.inf] * 6)
    assert flow_rate(times) == pytest.approx(1.0)


def test_lanes_are_in_order_and_mixed_people_are_not():
    to_right = np.arange(20) < 10
    y = np.where(to_right, 0.5, 1.5)
    places = np.stack([np.arange(20.0), y], axis=1)
    assert lane_order(places, to_right) == 1.0
    assert lane_order(places, ~to_right) == 1.0
    places[:, 1] = 0.5
    assert lane_order(places, to_right) == 0.0
    # Three against one: ((3 - 1) / 4)^2.
    assert lane_order(places[:4], np.array([1, 1, 1, 0]) > 0) == 0.25


def test_a_contact_counts_when_it_begins():
    apart = [1.0, 0.4, 0.3, 0.4, 1.0, 0.44, 0.46]
    positions = [[[0, 0], [d, 0], [9, 9]] for d in apart]
    assert touches(np.array(positions)) == 2
    # Who starts in contact has not come into it.
    assert touches(np.array(positions[1:])) == 1
    assert nearest_centers(make_walk(positions)) == pytest.approx(0.3)


def test_acceleration_is_a_mean_of_a_fifth_of_a_second():
    speeds = np.zeros((21, 1, 2))
    speeds[10:, 0, 0] = 0.6
    walk = make_walk(np.zeros((21, 1, 2)), speeds)
    assert peak_acceleration(walk) == pytest.approx(3.0)


def test_density_is_counted_where_people_are():
    positions = np.full((40, 3, 2), 0.5)
    positions[:20, 2] += 5
    walk = make_walk(positions)
    area = Area(0, 0, 2, 1)
    assert peak_density(walk, area, seconds=0.5) == pytest.approx(1.5)
    walk.present[:, 0] = False
    assert peak_density(walk, area, seconds=0.5) == pytest.approx(1.0)


def test_what_does_not_happen_takes_for_ever():
    walk = make_walk(np.zeros((5, 3, 2)))
    begun, done = np.zeros((2, 5, 3), dtype=bool)
    begun[1:, :2] = True
    done[4:, 0] = True
    times = walk.time_between(begun, done)
    assert times.tolist() == [pytest.approx(3 * TIME_STEP), np.inf, np.inf]


def test_the_first_time_is_that_of_people_who_are_there():
    walk = make_walk(np.zeros((5, 2, 2)))
    reached = np.zeros((5, 2), dtype=bool)
    reached[2:, 0] = True
    assert walk.first_time(reached).tolist() == [2 * TIME_STEP, np.inf]
    walk.present[:3, 0] = False
    assert walk.first_time(reached)[0] == pytest.approx(3 * TIME_STEP)


@pytest.mark.parametrize("n", [0, 1, 7, 30, 100])
def test_people_start_within_their_area_and_apart(n):
    area = Area(-1, 2, 5, 7)
    places = spread(n, area, np.random.default_rng(0))
    assert places.shape == (n, 2)
    assert area.holds(places).all()
    apart = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    assert (apart[~np.eye(n, dtype=bool)] >= 0.4).all()


def test_too_many_people_do_not_fit():
    with pytest.raises(ValueError, match="do not fit into 2 x 1 m"):
        spread(40, Area(0, 0, 2, 1), np.random.default_rng(0))


def test_a_room_has_a_door_of_its_width():
    walls = room(8, 5, 1.0)
    y = np.linspace(0.01, 4.99, 499)
    line = np.stack([np.full_like(y, 8.1), y], axis=1)
    free = [samples_in_walls(walls, p) == 0 for p in line]
    assert y[free].min() == pytest.approx(2.0, abs=0.02)
    assert y[free].max() == pytest.approx(3.0, abs=0.02)


def test_a_millimeter_in_a_wall_does_not_count():
    walls = [wall(0, 0, 1, 1)]
    points = np.array([[0.5e-3, 0.5], [2e-3, 0.5], [0.5, 0.5], [2, 2]])
    assert samples_in_walls(walls, points) == 2
