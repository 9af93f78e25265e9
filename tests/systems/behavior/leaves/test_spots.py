"""Spots with room to let a robot pass."""

import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.behavior.leaves.spots import (
    WALL_GAP,
    Wanted,
    drive_of,
    find_spot,
    free_way,
    way_off,
    way_past,
)
from hunav_drake.systems.behavior.nodes.tick import STATE, TICK
from hunav_drake.systems.world.obstacles import Obstacles

BODY, DISC = 0.25, 0.35
# What the addresses in ticks point to.
KEPT = []


def lines(segments, turn=0.0, mirror=False):
    """The table of thin walls, turned about the origin."""
    shapes = [[moved(p, turn, mirror) for p in it] for it in segments]
    return Obstacles.from_shapes(shapes, solid=[False] * len(shapes)).table


def moved(point, turn, mirror):
    x, y = point[0], -point[1] if mirror else point[1]
    c, s = math.cos(turn), math.sin(turn)
    return (c * x - s * y, s * x + c * y)


def row(x, y, yaw=0.0, speed=0.0, turn=0.0, mirror=False):
    yaw = (-yaw if mirror else yaw) + turn
    velocity = (speed * math.cos(yaw), speed * math.sin(yaw))
    numbers = (*moved((x, y), turn, mirror), yaw, *velocity, 0.0, DISC)
    return np.array([numbers], STATE)[0]


def corridor(width, end=None):
    sides = [[(-20.0, s * width / 2), (20.0, s * width / 2)] for s in (1, -1)]
    if end is not None:
        sides.append([(end, -5.0), (end, 5.0)])
    return sides


def tick_of(person, table, others=()):
    """The tick of a person among walls and others, who stand."""
    people = np.array([tuple(row(*it)) for it in others], STATE)
    tick = np.zeros(1, TICK)[0]
    for name in STATE.names:
        tick[name] = person[name]
    tick["index"] = -1
    tick["body_radius"] = BODY
    tick["num_humans"] = len(people)
    for name, array in (("humans", people), ("walls", table)):
        tick[name] = array.__array_interface__["data"][0]
        KEPT.append(array)
    tick["walls_size"] = len(table)
    return tick


def spot(person, robot, table, gap=0.3, least=0.1, away=0.0, others=()):
    drive = drive_of(robot, person)
    wanted = Wanted(gap, least, 1.2, away)
    found = find_spot(tick_of(person, table, others), drive, wanted)
    return found if found.gap > -math.inf else None


def free(table, *line):
    return free_way(tick_of(row(0.0, 0.0), table), *line)


def test_free_way_ends_a_body_before_a_wall():
    table = lines([[(2.0, -1.0), (2.0, 1.0)]])
    length = free(table, 0.0, 0.0, 1.0, 0.0, 9.0, 0.0)
    assert length == pytest.approx(2.0 - BODY - WALL_GAP)
    assert free(table, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0) == 0.5
    assert free(table, 0.0, 0.0, -1.0, 0.0, 9.0, 0.0) == 9.0
    assert free(lines([]), 0.0, 0.0, 1.0, 0.0, 9.0, 0.0) == 9.0
    # Its side meets the wall's end.
    assert free(table, 0.0, 1.2, 1.0, 0.0, 9.0, 0.0) == 9.0
    assert free(table, 0.0, 1.2, 1.0, 0.0, 9.0, DISC) < 2.0


@pytest.mark.parametrize("width", [2.2, 2.3, 2.6, 4.0])
def test_spot_in_a_corridor_is_at_the_wall_or_far_enough(width):
    found = spot(row(0, 0.1), row(-4, 0, 0, 0.6), lines(corridor(width)))
    wall = width / 2 - BODY - WALL_GAP
    assert found.y == pytest.approx(min(wall, 2 * DISC + 0.3))
    assert found.x == pytest.approx(0.0)
    assert found.gap == pytest.approx(found.y - 2 * DISC)


@pytest.mark.parametrize("width", [1.2, 1.5, 1.9, 2.1])
def test_there_is_none_where_the_corridor_is_too_narrow(width):
    table = lines(corridor(width))
    assert spot(row(0, 0.1), row(-4, 0, 0, 0.6), table) is None


def test_spot_may_be_farther_back():
    """At the end of the corridor, 3 m off."""
    sides = [[(-20.0, s * 0.8), (3.0, s * 0.8)] for s in (1, -1)]
    found = spot(row(0, 0.1), row(-4, 0, 0, 0.6), lines(sides))
    assert 3.0 + DISC < found.x < 3.0 + DISC + 0.3
    assert found.back_x == pytest.approx(found.x)
    assert found.gap == pytest.approx(0.3)


def test_nobody_crosses_close_before_a_robot():
    """There is more room on the other side."""
    table = lines([[(-20.0, 0.9), (20.0, 0.9)]])
    far = spot(row(0, 0.1), row(-4, 0, 0, 0.6), table)
    assert far.y == pytest.approx(-1.0)
    near = spot(row(0, 0.1), row(-1.2, 0, 0, 0.6), table)
    assert near.back_x > 1.0
    # One that stands can be passed.
    stands = spot(row(0, 0.1), row(-1.2, 0), table)
    assert stands.y == pytest.approx(-1.0)


def test_spot_is_not_where_somebody_stands():
    robot = row(-4, 0, 0, 0.6)
    assert spot(row(0, 0.2), robot, lines([])).y > 0
    other = spot(row(0, 0.2), robot, lines([]), others=[(0.0, 1.0)])
    assert math.dist(other[2:4], (0.0, 1.0)) > 2 * BODY


@given(
    turn=st.floats(-3, 3),
    mirror=st.booleans(),
    y=st.sampled_from([-0.43, -0.21, -0.05, 0.0, 0.03, 0.27, 0.5]),
    width=st.sampled_from([1.3, 1.55, 1.95, 2.25, 2.7, 4.0]),
    speed=st.sampled_from([0.0, 0.3, 0.9]),
)
def test_spots_turn_with_the_world(turn, mirror, y, width, speed):
    """Also mirrored, unless the person is right on the robot's way."""
    sides = corridor(width, end=4.0)
    if mirror and abs(y) <= 0.1:
        return
    for search in (spot, way_off_of, way_past_of):
        plain = search(row(0, y), row(-2, 0, 0, speed), lines(sides))
        other = search(
            row(0, y, turn=turn, mirror=mirror),
            row(-2, 0, 0, speed, turn, mirror),
            lines(sides, turn, mirror),
        )
        assert (plain is None) == (other is None)
        if plain is not None:
            back = moved(other[-3:-1], -turn, False)
            back = (back[0], -back[1] if mirror else back[1])
            assert back == pytest.approx(plain[-3:-1], abs=1e-6)


def way_off_of(person, robot, table):
    return way_off(tick_of(person, table), drive_of(robot, person))


def way_past_of(person, robot, table):
    found = way_past(tick_of(person, table), drive_of(robot, person))
    return found if found.gap > -math.inf else None


def test_way_off_leads_straight_on_and_around_corners():
    robot = row(-2, 0, 0, 0.6)
    table = lines(corridor(1.6))
    assert way_off_of(row(0, 0), robot, table)[:2] == (1.0, 0.0)
    # The corridor turns to the left.
    bend = [
        [(-20.0, -0.8), (1.0, -0.8)],
        [(1.0, -0.8), (1.0, 9.0)],
        [(-20.0, 0.8), (-0.6, 0.8)],
        [(-0.6, 0.8), (-0.6, 9.0)],
    ]
    _, dy, free = way_off_of(row(0.2, 0), robot, lines(bend))
    assert dy > 0.5
    assert free >= 1.0
    # Nowhere to go.
    assert way_off_of(row(3.7, 0), robot, lines(corridor(1.6, 4.0)))[2] < 0.1


@pytest.mark.parametrize(
    ("width", "fits"), [(1.7, False), (1.85, False), (1.9, True), (2.6, True)]
)
def test_way_past_leads_along_the_wall_where_bodies_fit(width, fits):
    found = way_past_of(row(1.0, 0.1), row(0, 0), lines(corridor(width)))
    assert (found is not None) == fits
    if fits:
        assert found.y == found.back_y > 2 * BODY + 0.1
        assert found.x < -2 * DISC < 0 < found.back_x
        beside = np.abs(found.y) - BODY - DISC
        assert found.gap == pytest.approx(beside)
