import math

import numpy as np
import pytest

from hunav_drake.systems.planning import (
    PlannerStatus,
    PlanningTask,
    PursuitPlanner,
    View,
)
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles

NO_WALLS = Obstacles.from_shapes([], solid=[])
NOBODY = np.zeros((0, 7))


def plan_once(
    *, robot=(0, 0, 0), humans=NOBODY, goal=(10, 0, 0), walls=NO_WALLS, **kwargs
):
    task = PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.3,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=walls,
        num_humans=len(humans),
    )
    state = np.array([*robot, 0, 0, 0, 0.3], dtype=float)
    view = View(state, humans, np.array(goal, dtype=float))
    return PursuitPlanner(**kwargs).plan(task, view, None)


def person_at(x, y):
    return np.array([[x, y, 0, 0, 0, 0, 0.4]])


def test_drives_straight_at_a_goal_ahead():
    result = plan_once()
    assert result.v == pytest.approx(0.6)
    assert result.omega == 0
    assert result.status == PlannerStatus.DRIVING


@pytest.mark.parametrize("side", [1, -1])
def test_turns_on_the_spot_to_a_goal_at_the_side(side):
    result = plan_once(goal=(0, 5 * side, 0))
    assert result.v == 0
    assert np.sign(result.omega) == side


def test_steers_while_driving_to_a_goal_a_little_off():
    result = plan_once(goal=(10, 1, 0))
    assert 0 < result.v < 0.6
    assert result.omega == pytest.approx(2 * math.atan2(1, 10))


def test_brakes_for_the_goal():
    assert plan_once(goal=(0.2, 0, 0)).v == pytest.approx(
        math.sqrt(2 * 0.5 * 0.2)
    )


def test_turns_to_the_heading_of_the_goal_and_rests():
    turning = plan_once(goal=(0.05, 0, -1))
    assert turning.v == 0
    assert turning.omega < 0
    arrived = plan_once(goal=(0.05, 0, 0.1))
    assert (arrived.v, arrived.omega) == (0, 0)
    assert arrived.status == PlannerStatus.ARRIVED


def test_slows_for_a_person_in_its_way():
    result = plan_once(humans=person_at(1.2, 0.5))
    # It drives on for one period before the next command.
    free = 1.2 - 0.7 - 0.3 - 0.6 * 0.05
    assert result.v == pytest.approx(math.sqrt(2 * 0.5 * free))
    assert result.status == PlannerStatus.SLOWED


def test_stops_for_a_person_close_before_it():
    result = plan_once(humans=person_at(0.9, 0))
    assert result.v == 0
    assert result.status == PlannerStatus.BLOCKED


@pytest.mark.parametrize("place", [(-1, 0), (1, 0.9), (1, -0.9)])
def test_does_not_mind_people_behind_or_beside(place):
    assert plan_once(humans=person_at(*place)).status == PlannerStatus.DRIVING


@pytest.mark.parametrize("distance", [0.4, 0.7, 1.0, 5.0])
def test_stops_short_of_a_wall(distance):
    wall = [[distance, -3.0], [distance, 3.0]]
    walls = Obstacles.from_shapes([wall], solid=[False])
    free = distance - 0.3 - 0.3
    expected = math.sqrt(max(free - 0.03, 0)) if free < 0.36 else 0.6
    assert plan_once(walls=walls).v == pytest.approx(expected, abs=0.01)


def test_passes_between_walls_that_leave_room():
    walls = [[[0, y], [9, y]] for y in (-0.31, 0.31)]
    walls = Obstacles.from_shapes(walls, solid=[False, False])
    assert plan_once(walls=walls).v == pytest.approx(0.6)


def test_refuses_parameters_outside_their_range():
    with pytest.raises(ValueError, match=r"must be in \(0, 10\] m/s, got 11"):
        plan_once(cruise_speed=11.0)
