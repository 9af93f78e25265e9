"""The shipped scenarios in which walls bend the robot's way."""

import functools
import itertools
import math

import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.runs import LoadSuite

# The corners that the shortest way bends around, and on which side: -1 on the
# left of it, 1 on the right.
CORNERS = {
    "corner": [((6.8, 1.2), -1)],
    "next_room": [((-0.1, 1.0), 1), ((0.1, 1.0), 1)],
}


@functools.cache
def result(name, planner):
    overrides = [f"planner={planner}"]
    return RunTrial(LoadScenario(filename=name, overrides=overrides))


def shortest(name):
    """Returns the length of tangents and arcs around corners on one side."""
    robot = LoadScenario(filename=name).robot
    r = robot.radius
    points = [robot.start[:2], *(p for p, _ in CORNERS[name]), robot.goal[:2]]
    (side,) = {s for _, s in CORNERS[name]}
    length, headings = 0.0, []
    for i, (p, q) in enumerate(itertools.pairwise(points)):
        distance = math.dist(p, q)
        heading = math.atan2(q[1] - p[1], q[0] - p[0])
        # From and to a point the tangent is askew; between circles it is not.
        ends = (i == 0) - (i == len(points) - 2)
        if ends:
            heading += ends * side * math.asin(r / distance)
            distance = math.sqrt(distance**2 - r**2)
        length += distance
        headings.append(heading)
    return length + r * abs(headings[-1] - headings[0])


@pytest.mark.slow
@pytest.mark.parametrize("name", list(CORNERS))
def test_the_shortest_way_bends_around_the_corners(name):
    assert name in LoadSuite(filename="standard").scenarios
    recording = result(name, "dwb").recording
    (way,) = recording.path_features.shortest_to_goal
    assert way.length == pytest.approx(shortest(name), abs=1e-9)
    straight = math.dist(recording.robot[0, :2], recording.goal[:2])
    assert way.length > 1.2 * straight
    assert way.turning > 1.2


@pytest.mark.parametrize(
    "planner",
    [
        *("dwb", "sfw"),
        *(pytest.param(it, marks=pytest.mark.slow) for it in ("scl", "sfm")),
        pytest.param("orca", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("name", list(CORNERS))
def test_planners_with_maps_go_the_bent_way(name, planner):
    metrics = result(name, planner).metrics
    assert metrics["completed"] == 1
    assert 0.85 < metrics["path_efficiency"] < 1


@pytest.mark.parametrize("name", list(CORNERS))
def test_who_drives_straight_is_stuck(name):
    assert result(name, "pursuit").end_reason == "stuck"
