"""SFW: its prediction by hand, and how it drives."""

import dataclasses
import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.people.parameters import (
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.planning import PlanningTask, View
from hunav_drake.systems.planning.costmap.footprint import circle_footprint
from hunav_drake.systems.planning.social import SfwPlanner
from hunav_drake.systems.planning.social.prediction import wall_points
from hunav_drake.systems.planning.social.sfw import Rules, set_up, weigh
from hunav_drake.systems.robot.robot_config import RobotLimits
from hunav_drake.systems.world.maps.costs import Costmap
from hunav_drake.systems.world.obstacles import Obstacles

NOBODY = np.zeros((0, 7))
FREE = Costmap(np.zeros((160, 160), dtype=np.uint8), (-4.0, -4.0), 0.05)
NO_POINTS = np.zeros((0, 2))


def task(humans=0, obstacles=None):
    return PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.35,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=obstacles or Obstacles.from_points([]),
        num_humans=humans,
    )


def cost_of(v, omega, *, carrot=(1.0, 0.0), humans=NOBODY, **options):
    planner = SfwPlanner(**options)
    robot = np.array([0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.35])
    view = View(robot, humans, np.array([5.0, 0.0, 0.0]))
    weighed = weigh(
        planner, task(len(humans)), view, carrot, FREE, np.array([[v, omega]])
    )
    return float(weighed.costs[0])


def person(x, y, vx=0.0, vy=0.0):
    return np.array([[x, y, 0.0, vx, vy, 0.0, 0.4]])


def test_the_candidates_are_44_and_the_fast_come_first():
    candidates = set_up(SfwPlanner(), task()).candidates
    assert candidates.shape == (44, 2)
    assert len({tuple(row) for row in candidates.tolist()}) == 44
    assert not (candidates == 0).all(axis=1).any()
    assert tuple(candidates[0]) == (0.8, 0.0)
    assert (np.diff(candidates[:, 0]) <= 0).all()


def test_the_cost_without_people_is_that_of_the_formula():
    # Six steps of 0.25 s, each 0.15 m/s^2 faster, along x.
    speeds = 0.4 + 0.15 * 0.25 * np.arange(1, 7)
    end = float(speeds.sum()) * 0.25
    expected = 0.8 * (0.8 - speeds[-1]) / 0.8 + (1.0 - end) ** 2
    assert cost_of(0.8, 0.0) == pytest.approx(expected, rel=1e-12)
    # A point to the side costs its bearing.
    sideways = cost_of(0.8, 0.0, carrot=(end, 1.0))
    expected = 0.8 * (0.8 - speeds[-1]) / 0.8 + 1.0 + 0.6 * 0.5
    assert sideways == pytest.approx(expected, rel=1e-12)


def test_left_and_right_cost_the_same():
    ahead = person(1.5, 0.4, -0.5, 0.1)
    mirrored = ahead * np.array([1, -1, -1, 1, -1, -1, 1])
    a = cost_of(0.6, 0.4, humans=ahead, carrot=(1.0, 0.2))
    b = cost_of(0.6, -0.4, humans=mirrored, carrot=(1.0, -0.2))
    assert a == pytest.approx(b, rel=1e-12)


def test_people_ahead_cost_work_and_far_ones_none():
    alone = cost_of(0.6, 0.0)
    assert cost_of(0.6, 0.0, humans=person(1.6, 0.1)) > alone + 0.1
    far = cost_of(0.6, 0.0, humans=person(40.0, 0.0))
    assert far == pytest.approx(alone, abs=1e-9)
    unweighed = cost_of(0.6, 0.0, humans=person(1.6, 0.1), social_weight=0.0)
    assert unweighed == pytest.approx(alone, rel=1e-12)


def test_who_is_run_into_is_no_candidate():
    assert cost_of(0.8, 0.0, humans=person(0.5, 0.0)) == math.inf
    assert math.isfinite(cost_of(0.0, 0.5, humans=person(0.9, 0.0)))


def test_the_work_of_one_step_by_hand():
    """The force of one person on the robot, and of it on the person."""
    planner = SfwPlanner(
        sim_time=0.25,
        velocity_weight=0.0,
        distance_weight=0.0,
        angle_weight=0.0,
        costmap_weight=0.0,
        social_weight=1.0,
        max_trans_acc=1e-9,
        max_rot_acc=1e-9,
        people_velocity=1e-6,
    )
    k = set_up(planner, task()).k
    names = dict(zip(PARAMETERS, k, strict=True))
    assert names["social_factor"] == 2.1
    assert names["epsilon"] == 0.0
    assert (
        names["lambda_importance"] == SocialForceParameters().lambda_importance
    )
    # Straight ahead of a robot at rest: theta is 0, so f = 2.1 exp(-r / B).
    robot = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35])
    view = View(robot, person(1.0, 0.0), np.array([5.0, 0.0, 0.0]))
    (cost,) = weigh(
        planner, task(1), view, (1.0, 0.0), FREE, np.array([[0.0, 0.0]])
    ).costs
    force = 2.1 * math.exp(-1.0 / 0.35)
    # (In the step, the person moves by less than a micrometer.)
    assert cost == pytest.approx(2 * force, rel=1e-5)


def test_candidates_cost_the_same_alone_and_together():
    rng = np.random.default_rng(1)
    for most in (0.15, 2.0):
        planner = SfwPlanner(max_trans_acc=most, max_rot_acc=3 * most)
        humans = np.vstack(
            [
                person(*rng.uniform(0.6, 2.5, 2), *rng.uniform(-1, 1, 2))
                for _ in range(6)
            ]
        )
        robot = np.array([0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.35])
        view = View(robot, humans, np.array([5.0, 0.0, 0.0]))
        known = task(len(humans)), view, (1.0, 0.4), FREE
        every = weigh(planner, *known)
        alone = [weigh(planner, *known, it[None]).costs[0] for it in every[0]]
        assert every.costs.tolist() == alone
        assert len(np.unique(every.costs)) > 10
        # Of those that are not the best, less may be known.
        best = weigh(planner, *known, None, Rules(every=False)).costs
        assert np.argmin(best) == np.argmin(every.costs)
        assert best.min() == every.costs.min()
        assert (best <= every.costs).all()
        assert (best < every.costs).any()


def test_who_was_at_their_goal_is_not_drawn_back_to_it():
    """Pushed along a line, somebody only brakes: lightsfm drops the goal."""
    steps, dt = 40, 0.25
    planner = SfwPlanner(
        sim_time=steps * dt,
        velocity_weight=0.0,
        distance_weight=0.0,
        angle_weight=0.0,
        costmap_weight=0.0,
        social_weight=1.0,
    )

    def push(r, v):
        # At the robot, at rest, from r away from it at the speed v.
        length = abs(1 - 2 * v)
        return 2.1 * math.exp(-r / (0.35 * length))

    place, speed, work = 0.5, 0.0, 0.0
    for _ in range(steps):
        force = push(place, speed)
        speed += (force - speed / 0.5) * dt
        place += speed * dt
        work += force + push(place, speed)
    # It is beyond the radius of the goal, 0.35 m.
    assert place - 0.5 > 0.4
    robot = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35])
    view = View(robot, person(0.5, 0.0), np.array([5.0, 0.0, 0.0]))
    (cost,) = weigh(
        planner, task(1), view, (1.0, 0.0), FREE, np.array([[0.0, 0.0]])
    ).costs
    assert cost == pytest.approx(work, rel=1e-9)


def test_the_frame_of_the_original_depends_on_the_heading():
    humans = person(1.5, 0.3, -0.3, 0.0)
    turned = humans.copy()
    turned[0, :2] = -humans[0, 1], humans[0, 0]
    turned[0, 3:5] = 0.0, -0.3

    def cost(yaw, humans, carrot, legacy):
        planner = SfwPlanner(legacy_body_frame_velocity=legacy)
        c, s = math.cos(yaw), math.sin(yaw)
        robot = np.array([0.0, 0.0, yaw, 0.4 * c, 0.4 * s, 0.0, 0.35])
        view = View(robot, humans, np.array([5.0, 0.0, 0.0]))
        pair = np.array([[0.6, 0.2]])
        odometry_yaw = 0.0 if legacy else math.nan
        return weigh(
            *(planner, task(1), view, carrot, FREE, pair),
            rules=Rules(odometry_yaw=odometry_yaw),
        ).costs[0]

    for legacy in (False, True):
        a = cost(0.0, humans, (1.0, 0.0), legacy)
        b = cost(math.pi / 2, turned, (0.0, 1.0), legacy)
        assert (a == pytest.approx(b, rel=1e-9)) == (not legacy)


def test_walls_around_are_points_where_rays_end():
    square = [[-2, -1], [3, -1], [3, 1], [-2, 1]]
    walls = Obstacles.from_shapes([square], solid=[True])
    points = wall_points(0.0, 0.0, 2.5, 8, walls.table)
    # The ray along +x ends before the wall at 3 m.
    expected = [[1, 1], [0, 1], [-1, 1], [-2, 0], [-1, -1], [0, -1], [1, -1]]
    np.testing.assert_allclose(points, expected, atol=1e-12)


def test_a_costmap_that_is_touched_makes_a_candidate_impossible():
    costs = FREE.costs.copy()
    costs[:, 100:104] = 254
    blocked = Costmap(costs, FREE.origin, FREE.resolution)
    planner = SfwPlanner()
    robot = np.array([0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.35])
    view = View(robot, NOBODY, np.array([5.0, 0.0, 0.0]))
    pairs = np.array([[0.8, 0.0], [0.0, 0.4]])
    far, near = weigh(planner, task(), view, (1, 0), blocked, pairs).costs
    assert far == math.inf
    assert near == math.inf
    slow = view._replace(robot=np.array([0.0, 0, 0, 0.1, 0, 0, 0.35]))
    far, near = weigh(planner, task(), slow, (1, 0), blocked, pairs).costs
    assert math.isfinite(far)
    assert math.isfinite(near)


def test_the_footprint_is_that_of_the_navigation():
    assert SfwPlanner().setup(task()).footprint is circle_footprint(0.275)


def test_it_cruises_at_the_speed_of_the_paper():
    scenario = LoadScenario(filename="passing", overrides=["planner.type=sfw"])
    free = dataclasses.replace(scenario, humans=[])
    result = RunTrial(free)
    assert result.end_reason == "goal"
    v = np.hypot(*result.recording.robot[:, 3:5].T)
    assert np.median(v) == pytest.approx(0.60, rel=0.03)
    assert result.end_time == pytest.approx(26.3, rel=0.03)


def test_near_its_goal_it_keeps_maxima_below_the_minima_there():
    planner = "{type: sfw, max_trans_vel: 0.05, max_rot_vel: 0.3}"
    options = [f"planner={planner}", "humans=[]", "simulation.duration=3.0"]
    options += ["robot.start=[0, 0, 1.5]", "robot.goal=[0.4, 0, 0]"]
    turning = [*options[:3], "robot.start=[0, 0, 1.5]", "robot.goal=[0, 0, 0]"]
    for overrides in (options, turning):
        scenario = LoadScenario("passing", overrides=overrides)
        robot = RunTrial(scenario).recording.robot
        assert np.hypot(*robot[:, 3:5].T).max() <= 0.05 + 1e-12
        assert 0.29 < abs(robot[:, 5]).max() <= 0.3 + 1e-12
