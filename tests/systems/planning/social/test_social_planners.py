"""The robots that a force, or reciprocal avoidance, drives."""

import math

import numpy as np
import pytest

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial
from hunav_drake.systems.people.parameters import (
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.planning.navigation.memory import LocalPlan
from hunav_drake.systems.planning.planner import PLANNERS, PlanningTask, View
from hunav_drake.systems.planning.social.differential import steer
from hunav_drake.systems.planning.social.following import carrot_at
from hunav_drake.systems.planning.social.forces import robot_force
from hunav_drake.systems.planning.social.reciprocal import avoiding_velocity
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.simulation import MakeTrialSimulator

NO_WALLS = Obstacles.from_points([]).table
K = np.array([getattr(SocialForceParameters(), name) for name in PARAMETERS])
P = np.array([0.6, 0.4, 0.4, 10.0, 3.0, 1.0, 1.0, 0.05])


QUICK = RobotLimits(max_turn_rate=2.0, max_turn_acceleration=50.0)


def test_steers_into_the_velocity():
    assert steer(0.5, 0.0, 0.0, 0.4, QUICK, 0.1) == (0.5, 0.0)
    v, omega = steer(0.0, 0.5, 0.0, 0.4, QUICK, 0.1)
    assert v == pytest.approx(0.0, abs=1e-12)
    assert omega == 2.0
    fast = RobotLimits(max_turn_rate=9.0, max_turn_acceleration=50.0)
    v, omega = steer(-0.5, 0.0, 0.0, 0.4, fast, 0.1)
    assert v == 0.0
    assert abs(omega) == pytest.approx(math.pi / 0.4)
    assert steer(0.0, 0.0, 1.0, 0.4, QUICK, 0.1) == (0.0, 0.0)


def test_a_turn_ends_where_it_is_to_though_turning_takes_time():
    """Without the bound, it would swing to and fro."""
    limits = RobotLimits()
    yaw = omega = 0.0
    yaws = []
    for _ in range(100):
        _, wanted = steer(0.0, 0.5, yaw, 0.1, limits, 0.1)
        most = 0.05 * limits.max_turn_acceleration
        omega += min(max(wanted - omega, -most), most)
        yaw += 0.05 * omega
        yaws.append(yaw)
    assert max(yaws) < 0.5 * math.pi + 0.05
    np.testing.assert_allclose(yaws[-20:], 0.5 * math.pi, atol=0.02)


@pytest.mark.parametrize("reaction", [0.1, 0.5, 2.0])
def test_a_turn_is_not_faster_than_the_next_command_can_end_it(reaction):
    _, omega = steer(0.3, 0.4, 0.0, 0.01, QUICK, reaction)
    assert omega == pytest.approx(min(math.atan2(4, 3) / reaction, 2.0))


def test_the_force_of_walls_is_none_in_the_middle_and_smooth_about_it():
    sides = [[(-9, y), (9, y)] for y in (-0.8, 0.8)]
    table = Obstacles.from_shapes(sides, solid=[False, False]).table

    def across(y):
        robot = np.array([0.0, y, 0.0, 0.0, 0.0, 0.0, 0.35])
        goal = np.array([9.0, y, 0.6])
        nobody = np.zeros((0, 7))
        return robot_force(robot, goal, nobody, table, 0.275, K)[1]

    assert across(0.0) == pytest.approx(0.0, abs=1e-12)
    assert across(0.01) == pytest.approx(-across(-0.01))
    assert -0.1 < across(0.01) < 0


def test_the_carrot_is_ahead_on_the_plan():
    x = np.arange(0, 5, 0.1)
    poses = np.column_stack([x, 0 * x, 0 * x])
    local = LocalPlan(poses, (4.9, 0.0, 0.0), False)

    def view(px, py):
        return View(np.array([px, py, 0, 0, 0, 0, 0.3]), None, None)

    assert carrot_at(view(1.0, 0.0), local, 1.0) == pytest.approx((2.1, 0.0))
    assert carrot_at(view(4.5, 0.0), local, 1.0) == pytest.approx((4.9, 0.0))
    # Off the plan, it goes on from the nearest pose.
    assert carrot_at(view(2.0, 3.0), local, 1.0)[0] >= 2.0


def test_the_force_is_that_of_a_person():
    robot = np.array([0.2, -0.3, 0.5, 0.3, 0.1, 0.0, 0.35])
    humans = np.array([[1.4, 0.2, 3.0, -0.6, 0.1, 0.0, 0.3]])
    force = robot_force(
        robot, np.array([4.0, 1.0, 0.6]), humans, NO_WALLS, 0.275, K
    )
    direction = np.array([3.8, 1.3]) / math.hypot(3.8, 1.3)
    pull = 2.0 * (0.6 * direction - robot[3:5]) / 0.5
    alone = robot_force(
        robot, np.array([4.0, 1.0, 0.6]), humans[:0], NO_WALLS, 0.275, K
    )
    np.testing.assert_allclose(alone, pull, rtol=1e-12)
    # Moussaid's interaction: away from approaching people, and to one side.
    push = force - pull
    assert push[0] < 0
    assert 0.05 < np.linalg.norm(push) < 10


def test_alone_the_wanted_velocity_is_taken():
    own = np.array([0.0, 0.0, 0.1, 0.0])
    nobody = np.zeros((0, 7))
    v = avoiding_velocity(own, 0.5, 0.1, nobody, NO_WALLS, P)
    np.testing.assert_array_equal(v, [0.5, 0.1])


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_reciprocal_avoidance_turns_with_the_world(angle):
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    position, velocity = np.array([2.0, 0.3]), np.array([-0.8, 0.0])

    def choose(matrix):
        human = np.zeros((1, 7))
        human[0, :2] = matrix @ position
        human[0, 3:5] = matrix @ velocity
        human[0, 6] = 0.3
        own = np.concatenate([[0.0, 0.0], matrix @ [0.5, 0.0]])
        tx, ty = matrix @ [0.6, 0.0]
        return avoiding_velocity(own, tx, ty, human, NO_WALLS, P)

    straight = choose(np.eye(2))
    # It gives way to the side where there is more room.
    assert straight[1] < -0.01
    np.testing.assert_allclose(choose(turn), turn @ straight, atol=1e-12)


def test_the_velocity_chosen_touches_nobody_within_the_horizon():
    generator = np.random.default_rng(0)
    for _ in range(200):
        human = np.zeros((1, 7))
        angle = generator.uniform(0, 2 * math.pi)
        away = generator.uniform(1.0, 4.0)
        human[0, :2] = away * np.array([math.cos(angle), math.sin(angle)])
        human[0, 3:5] = generator.uniform(-0.5, 0.5, 2)
        human[0, 6] = 0.3
        own = np.array([0.0, 0.0, *generator.uniform(-0.3, 0.3, 2)])
        tx, ty = generator.uniform(-0.4, 0.4, 2)
        vx, vy = avoiding_velocity(own, tx, ty, human, NO_WALLS, P)
        if math.hypot(*(human[0, 3:5])) > 0.3:
            continue
        times = np.linspace(0, 3.0, 301)[:, None]
        gaps = human[0, :2] + times * (human[0, 3:5] - [vx, vy])
        assert np.hypot(*gaps.T).min() > 0.7 - 1e-6


@pytest.mark.parametrize("planner", ["sfw", "sfm", "orca"])
@pytest.mark.parametrize(
    "name", ["passing", pytest.param("crossing", marks=pytest.mark.slow)]
)
def test_reaches_the_goal_among_people(planner, name):
    scenario = LoadScenario(
        filename=name, overrides=[f"planner.type={planner}"]
    )
    result = RunTrial(scenario, 1)
    assert result.end_reason == "goal"
    if planner != "sfm":
        assert result.metrics["robot_on_person_collisions"] == 0


@pytest.mark.parametrize("planner", ["sfw", "sfm", "orca"])
def test_a_clone_goes_on_alike(planner):
    scenario = LoadScenario(
        filename="crossing", overrides=[f"planner.type={planner}"]
    )
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(3.0)
    clone = simulator.get_context().Clone()
    fork = MakeTrialSimulator(diagram, clone)
    for it in (simulator, fork):
        it.AdvanceTo(5.0)
    a, b = (
        diagram.GetOutputPort("robot_state").Eval(it.get_context())
        for it in (simulator, fork)
    )
    np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("side", [-1, 1])
def test_pushed_back_it_faces_its_way(side):
    """It does not sway with a person who steps from side to side."""
    planner = PLANNERS["sfm"]()
    room = [(-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)]
    task = PlanningTask(
        limits=RobotLimits(),
        robot_radius=0.35,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=Obstacles.from_shapes([room], solid=[False]),
        num_humans=1,
    )
    robot, human = np.zeros(7), np.zeros((1, 7))
    robot[6] = 0.35
    human[0] = [0.8, 0.05 * side, 0, -2.0, 0, 0, 0.4]

    def command(goal, yaw=0.0):
        robot[2] = yaw
        view = View(robot.copy(), human, np.array([*goal, 0.0]))
        plan = planner.plan(task, view, planner.initial_memory)
        return plan.v, plan.omega

    v, omega = command((0.6, 0.0))
    assert v == 0
    # (The plan leads around the person; the push, to the side and back.)
    assert abs(omega) < 0.5
    v, omega = command((0.6, 0.0), yaw=-0.5)
    assert v == 0
    assert omega > 0.5
    human[0, 0] = 30.0
    assert command((0.6, 0.0))[0] > 0.1


def test_a_robot_by_forces_never_exceeds_a_low_desired_speed():
    options = ["planner={type: sfm, desired_speed: 0.04}"]
    options += ["simulation.duration=2.0"]
    recording = RunTrial(LoadScenario("passing", overrides=options)).recording
    speeds = np.hypot(*recording.robot[:, 3:5].T)
    assert 0.03 < speeds.max() <= 0.04 + 1e-12
