"""Each critic of DWB against its closed form."""

import dataclasses
import math

import numpy as np
import pytest
from scipy import ndimage

from hunav_drake.systems.planning import PlanningTask, View
from hunav_drake.systems.planning.dwb import (
    DwbMemory,
    DwbPlanner,
    candidates,
    velocity_samples,
)
from hunav_drake.systems.planning.dwb.dwb import dynamics, robot_state
from hunav_drake.systems.planning.dwb.dwb_memory import Trend
from hunav_drake.systems.planning.dwb.map_grid import (
    distance_from,
    path_cells,
    plan_span,
)
from hunav_drake.systems.planning.dwb.scoring import Critic, roll_out
from hunav_drake.systems.planning.navigation import LocalPlan
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.maps.costs import Costmap
from hunav_drake.systems.world.obstacles import Obstacles

TASK = PlanningTask(
    limits=RobotLimits(),
    robot_radius=0.275,
    goal_tolerance=0.25,
    goal_yaw_tolerance=0.25,
    obstacles=Obstacles.from_shapes([], solid=[]),
    num_humans=0,
)
CELL = 0.025


def make_view(x=0.0, y=0.0, yaw=0.0, v=0.5, omega=0.0):
    c, s = math.cos(yaw), math.sin(yaw)
    robot = np.array([x, y, yaw, v * c, v * s, omega, 0.275])
    return View(robot, np.zeros((0, 7)), np.array([5.0, 0.0, 0.0]))


def make_map(costs=None):
    if costs is None:
        costs = np.zeros((160, 160), np.uint8)
    return Costmap(costs, (-2.0, -2.0), CELL)


def straight(end=1.0, *, goal=(5.0, 0.0, 0.0)):
    poses = np.zeros((81, 3))
    poses[:, 0] = np.linspace(0.0, end, 81)
    return LocalPlan(poses, goal, False)


def weigh(
    *, view=None, local=None, costs=None, memory=None, critics=None, **scales
):
    """Returns the candidates, scored by the given critics alone."""
    only = {critic.name.lower(): 0.0 for critic in Critic} | {
        name: float(scale) for name, scale in scales.items()
    }
    planner = DwbPlanner(scales=only, critics=critics or {})
    result = candidates(
        planner,
        TASK,
        view or make_view(),
        local or straight(),
        make_map(costs),
        memory,
    )
    for name in scales:
        only_column = result.scores[:, Critic[name.upper()]]
        legal = np.isfinite(result.scores[:, 0])
        if len(scales) == 1:
            np.testing.assert_array_equal(
                only_column[legal], result.scores[legal, 0]
            )
    return result


def cell(points):
    return np.floor((np.asarray(points) + 2.0) / CELL).astype(int)


def ends(result):
    return np.array([path[-1] for path in result.paths])


def is_sample(result):
    return (result.velocities != 0).any(axis=1)


# Samples.


@pytest.mark.parametrize("now", [0.0, 0.5, 1.2])
def test_samples_are_spread_over_all_speeds(now):
    samples = velocity_samples(now, 0.0, 1.0, 0.6, -2.5, 20, 1.7)
    np.testing.assert_allclose(samples, np.linspace(0, 1, 20))


def test_samples_stay_within_what_can_be_reached():
    samples = velocity_samples(0.3, 0.0, 1.0, 0.6, -2.5, 5, 0.05)
    np.testing.assert_allclose(samples, np.linspace(0.175, 0.33, 5))


def test_zero_is_between_both_signs():
    samples = velocity_samples(0.0, -1.05, 1.05, 3.14, -3.14, 20, 1.7)
    assert len(samples) == 21
    assert samples[10] == 0.0
    assert (np.diff(samples) > 0).all()


def test_a_velocity_that_cannot_change_is_one_sample():
    assert velocity_samples(0.2, 0.2, 0.2, 1.0, -1.0, 20, 1.0).tolist() == [0.2]


def test_there_are_419_candidates():
    result = weigh(twirling=1.0)
    assert len(result.velocities) == 420
    assert is_sample(result).sum() == 419
    assert np.isinf(result.scores[~is_sample(result)]).all()


# Roll-outs.


def test_a_steady_roll_out_is_a_circle():
    view = make_view(v=0.5, omega=0.6)
    planner = DwbPlanner()
    p = dynamics(planner, TASK).values
    path = roll_out(robot_state(view), 0.5, 0.6, p)
    # 1.7 * 0.6 / 0.025 steps, the start, and the last pose once more.
    assert len(path) == 41 + 2
    np.testing.assert_array_equal(path[-1], path[-2])
    assert path[-1, 2] == pytest.approx(1.02)
    radius = 0.5 / 0.6
    exact = radius * np.array([math.sin(1.02), 1 - math.cos(1.02)])
    np.testing.assert_allclose(path[-1, :2], exact, atol=0.02)


def test_a_roll_out_accelerates_towards_its_sample():
    state = robot_state(make_view(v=0.2))
    p = dynamics(DwbPlanner(), TASK).values
    path = roll_out(state, 0.5, 0.0, p)
    steps = np.diff(path[:-1, 0])
    dt = 1.7 / math.ceil(1.7 * 0.5 / 0.05)
    speeds = np.minimum(0.5, 0.2 + 0.6 * dt * np.arange(1, len(steps) + 1))
    np.testing.assert_allclose(steps, speeds * dt)
    at_once = dynamics(
        DwbPlanner(trajectory_generator="limited_accel"), TASK
    ).values
    assert roll_out(state, 0.5, 0.0, at_once)[-1, 0] == pytest.approx(0.85)


def test_scores_see_the_poses_of_the_roll_outs():
    """The kernel's own roll-outs end in the same cells."""
    view = make_view(yaw=0.4, v=0.37, omega=-0.3)
    result = weigh(view=view, goal_dist=2.0)
    end = cell(ends(result)[:, :2])
    away = np.abs(end - cell([1.0, 0.0])).sum(axis=1)
    legal = is_sample(result)
    np.testing.assert_allclose(
        result.scores[legal, 0], 2.0 * 0.5 * CELL * away[legal]
    )


# Critics on the grid.


def test_path_distances_are_taxicab_distances():
    rng = np.random.default_rng(2)
    for _ in range(5):
        plan = np.cumsum(rng.uniform(-0.1, 0.2, (30, 3)), axis=0) - 1.0
        costs = np.zeros((160, 120), np.uint8)
        cells = path_cells(costs, -1.5, -2.0, CELL, plan, *plan[-1, :2])
        is_off = np.ones(costs.shape, bool)
        is_off[*cells] = False
        assert (~is_off).sum() > 20
        reference = ndimage.distance_transform_cdt(is_off, metric="taxicab")
        result = [
            [distance_from(cells, i, j) for j in range(120)] for i in range(160)
        ]
        np.testing.assert_array_equal(result, reference)


def test_the_plan_counts_up_to_where_it_leaves_the_map():
    plan = np.zeros((50, 3))
    plan[:, 0] = np.linspace(-3.0, 3.0, 50)
    costs = np.zeros((160, 160), np.uint8)
    costs[:, 100] = 255
    rows, columns = path_cells(costs, -2.0, -2.0, CELL, plan, 3.0, 0.0)
    assert (rows == 80).all()
    assert np.unique(columns).tolist() == list(range(columns[0], 100))
    assert columns[0] <= 1
    assert columns[-1] == 99
    # Wherever its last pose is moved to.
    part = plan[:22]
    rows, columns = path_cells(costs, -2.0, -2.0, CELL, part, -0.29, 0.11)
    assert (rows[-1], columns[-1]) == (84, 68)
    far = plan + np.array([0.0, 9.0, 0.0])
    assert path_cells(costs, -2.0, -2.0, CELL, far, 3.0, 9.0).shape == (2, 0)


def test_the_best_is_the_same_whether_or_not_all_are_scored():
    rng = np.random.default_rng(3)
    planners = [
        DwbPlanner(),
        DwbPlanner(
            min_vel_x=-0.4,
            critics={"sum_scores": True},
            scales={"obstacle_footprint": 1.0},
        ),
    ]
    for k in range(60):
        costs = np.zeros((160, 160), np.uint8)
        for row, column in rng.integers(0, 150, (6, 2)):
            costs[row : row + 10, column : column + 10] = rng.choice([90, 254])
        costs[70:90, 70:90] = 0
        planner, view = planners[k % 2], make_view(yaw=rng.uniform(-1, 1))
        every = candidates(planner, TASK, view, straight(), make_map(costs))
        command = planner.control(
            TASK, view, straight(), make_map(costs), DwbMemory()
        )
        if every.best >= 0:
            total = every.scores[:, 0]
            assert every.best == np.argmin(total)
            chosen = every.velocities[every.best].tolist()
            assert [command.v, command.omega] == chosen
        else:
            assert command.fault


def test_path_dist():
    result = weigh(path_dist=32.0)
    end = cell(ends(result)[:, :2])
    off = np.abs(end[:, 1] - 80)
    off += np.maximum(end[:, 0] - 120, 0)
    legal = is_sample(result)
    np.testing.assert_allclose(
        result.scores[legal, 0], 32.0 * 0.5 * CELL * off[legal]
    )


def test_path_align_is_of_a_point_ahead_and_off_at_the_goal():
    result = weigh(path_align=32.0)
    end = ends(result)
    point = cell(
        end[:, :2]
        + 0.1 * np.column_stack([np.cos(end[:, 2]), np.sin(end[:, 2])])
    )
    off = np.abs(point[:, 1] - 80) + np.maximum(point[:, 0] - 120, 0)
    legal = is_sample(result)
    np.testing.assert_allclose(
        result.scores[legal, 0], 32.0 * 0.5 * CELL * off[legal]
    )
    near = straight(0.09, goal=(0.09, 0.0, 0.0))
    assert weigh(path_align=32.0, local=near).scores[5, 0] == 0.0


def test_goal_align_moves_the_end_of_the_plan_away_from_the_robot():
    result = weigh(goal_align=24.0)
    end = ends(result)
    point = cell(
        end[:, :2]
        + 0.1 * np.column_stack([np.cos(end[:, 2]), np.sin(end[:, 2])])
    )
    away = np.abs(point - cell([1.1, 0.0])).sum(axis=1)
    legal = is_sample(result)
    np.testing.assert_allclose(
        result.scores[legal, 0], 24.0 * 0.5 * CELL * away[legal]
    )


def test_leaving_the_map_is_forbidden():
    result = weigh(goal_dist=1.0, view=make_view(x=1.5), local=straight())
    end = ends(result)
    inside = (np.abs(end[:, :2]) < 2.0).all(axis=1)
    legal = np.isfinite(result.scores[:, 0])
    assert not legal[~inside].any()
    assert legal[inside & is_sample(result)].all()


# Critics of obstacles.


def test_base_obstacle_is_the_cost_at_the_end():
    costs = np.zeros((160, 160), np.uint8)
    costs[:] = np.arange(160)
    result = weigh(base_obstacle=0.02, costs=costs)
    end = cell(ends(result)[:, :2])
    legal = is_sample(result)
    np.testing.assert_allclose(result.scores[legal, 0], 0.02 * end[legal, 0])


def test_base_obstacle_adds_up_by_option():
    costs = np.full((160, 160), 3, np.uint8)
    result = weigh(base_obstacle=1.0, costs=costs, critics={"sum_scores": True})
    for k in np.flatnonzero(is_sample(result)):
        assert result.scores[k, 0] == 3.0 * len(result.paths[k])


@pytest.mark.parametrize("cost", [253, 254, 255])
def test_base_obstacle_forbids_to_pass_what_touches(cost):
    costs = np.zeros((160, 160), np.uint8)
    costs[:, 100:102] = cost
    result = weigh(base_obstacle=0.02, costs=costs)
    reaches = np.array(
        [(cell(p[:, :2])[:, 0] >= 100).any() for p in result.paths]
    )
    legal = np.isfinite(result.scores[:, 0])
    assert reaches.any()
    np.testing.assert_array_equal(legal, ~reaches & is_sample(result))


def test_obstacle_footprint_is_of_the_outline():
    costs = np.zeros((160, 160), np.uint8)
    # What the outline, but not the middle of the robot, comes to.
    costs[60:100, 100:110] = 254
    result = weigh(obstacle_footprint=1.0, costs=costs)
    legal = np.isfinite(result.scores[:, 0])
    straight_on = result.velocities[:, 1] == 0
    front = np.array([path[-1, 0] for path in result.paths]) + 0.285
    assert legal[straight_on & (front < 0.5) & is_sample(result)].all()
    assert not legal[straight_on & (front > 0.525)].any()
    costs[60:100, 100:110] = 90
    graded = weigh(obstacle_footprint=1.0, costs=costs)
    assert set(np.unique(graded.scores[is_sample(graded), 0])) == {0.0, 90.0}


# Critics of velocities.


def test_rotate_to_goal_is_silent_on_the_way():
    result = weigh(rotate_to_goal=32.0)
    assert (result.scores[is_sample(result), 0] == 0).all()


def test_rotate_to_goal_slows_down_at_the_goal():
    near = straight(0.2, goal=(0.2, 0.0, 1.0))
    result = weigh(rotate_to_goal=32.0, local=near)
    v, _ = result.velocities.T
    legal = np.isfinite(result.scores[:, 0])
    np.testing.assert_array_equal(legal, (v < 0.5) & is_sample(result))
    error = np.abs(ends(result)[:, 2] - 1.0)
    expected = 32.0 * (5.0 * v**2 + error)
    np.testing.assert_allclose(result.scores[legal, 0], expected[legal])


def test_rotate_to_goal_turns_once_slow_enough():
    near = straight(0.2, goal=(0.2, 0.0, 1.0))
    result = weigh(rotate_to_goal=32.0, local=near, view=make_view(v=0.2))
    v, omega = result.velocities.T
    legal = np.isfinite(result.scores[:, 0])
    np.testing.assert_array_equal(legal, (v == 0) & (omega != 0))
    assert result.velocities[result.best, 1] > 0
    # It stays so when the robot rolls on, until there is a new plan.
    memory = DwbMemory(in_window=True, rotating=True)
    for is_new in (False, True):
        far = straight()._replace(is_new=is_new)
        again = weigh(rotate_to_goal=32.0, local=far, memory=memory)
        free = np.isfinite(again.scores[:, 0]).sum()
        assert free == (419 if is_new else 20)


def test_oscillation_allows_one_sign_only():
    memory = DwbMemory(theta=Trend(1, 1))
    result = weigh(oscillation=1.0, memory=memory)
    omega = result.velocities[:, 1]
    legal = np.isfinite(result.scores[:, 0])
    np.testing.assert_array_equal(legal, (omega >= 0) & is_sample(result))
    assert (result.scores[legal, 0] == 0).all()


def test_a_trend_forbids_to_turn_back():
    trend = Trend()
    for value, expected in [
        (0.5, Trend(1, 0)),
        (0.2, Trend(1, 0)),
        (-0.1, Trend(-1, -1)),
        (0.0, Trend(-1, -1)),
        (0.3, Trend(1, 1)),
    ]:
        trend = trend.after(value)
        assert trend == expected


def test_prefer_forward():
    result = weigh(prefer_forward=1.0)
    v, omega = result.velocities.T
    slow = (v < 0.1) & (np.abs(omega) < 0.2)
    expected = np.where(slow, 1.0, 10.0 * np.abs(omega))
    legal = is_sample(result)
    np.testing.assert_allclose(result.scores[legal, 0], expected[legal])


def test_twirling():
    result = weigh(twirling=2.0)
    legal = is_sample(result)
    omega = result.velocities[legal, 1]
    np.testing.assert_allclose(result.scores[legal, 0], 2 * np.abs(omega))


def test_critics_add_up_and_the_first_of_equals_is_taken():
    scales = {"path_dist": 32.0, "goal_dist": 24.0, "path_align": 32.0}
    view = make_view(y=0.2, yaw=-0.3)
    together = weigh(view=view, **scales)
    alone = sum(
        weigh(view=view, **{name: scale}).scores[:, 0]
        for name, scale in scales.items()
    )
    np.testing.assert_allclose(together.scores[:, 0], alone)
    assert together.best == np.argmin(together.scores[:, 0])
    # It comes back to the plan.
    assert ends(together)[together.best, 1] < 0.1


# The local plan.


def test_the_local_plan_is_what_is_near():
    plan = np.zeros((101, 3))
    plan[:, 0] = np.linspace(0.0, 5.0, 101)
    assert plan_span(plan, 0, 2.02, 0.0, 1.0, 1.0, math.inf) == (21, 61)
    assert plan_span(plan, 30, 2.02, 0.0, 1.0, 1.0, math.inf) == (30, 61)
    assert plan_span(plan, 0, 2.02, 0.0, 1.5, 1.5, 2.0) == (11, 71)
    assert plan_span(plan, 0, 9.0, 0.0, 1.0, 1.0, math.inf) == (-1, -1)
    # Humble looks for its begin on the next two meters only.
    assert plan_span(plan, 0, 4.5, 0.0, 2.0, 1.5, 2.0) == (-1, -1)


def test_a_plan_off_the_map_is_told():
    far = straight()._replace(poses=np.full((2, 3), 9.0))
    with pytest.raises(
        ValueError, match="no part of the plan is on the local map"
    ):
        weigh(path_dist=1.0, local=far)


@pytest.mark.parametrize("tolerance", [0.02, 0.05, 0.25])
def test_some_speed_ends_at_a_goal_however_small(tolerance):
    task = dataclasses.replace(TASK, goal_tolerance=tolerance)
    found = candidates(
        DwbPlanner(), task, make_view(v=0.0), straight(), make_map()
    )
    speeds = np.unique(found.velocities[:, 0])
    apart = np.diff(speeds).max() * DwbPlanner().sim_time
    assert apart <= tolerance + 1e-9
    if tolerance == 0.25:
        assert len(speeds) == DwbPlanner().vx_samples
