import dataclasses
import math

import pytest

from hunav_drake.systems.behavior import BehaviorTree
from hunav_drake.systems.common.checks import (
    check_count,
    check_number,
    check_time_step,
    count_steps,
)
from hunav_drake.systems.crowd import HumanCrowd
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
from hunav_drake.systems.planning import (
    LocalPlanner,
    PlanningTask,
    PursuitPlanner,
)
from hunav_drake.systems.robot import (
    DifferentialDrive,
    DifferentialDriveConfig,
    RobotLimits,
)
from hunav_drake.systems.world.obstacles import Obstacles

TASK = PlanningTask(
    limits=RobotLimits(),
    robot_radius=0.35,
    goal_tolerance=0.25,
    goal_yaw_tolerance=0.3,
    obstacles=Obstacles.from_points([]),
    num_humans=0,
)
SYSTEMS = {
    "HumanCrowd": lambda **k: HumanCrowd([], **k),
    "BehaviorTree": lambda **k: BehaviorTree([], [], **k),
    "DifferentialDrive": lambda **k: DifferentialDrive(
        DifferentialDriveConfig(), **k
    ),
    "LocalPlanner": lambda **k: LocalPlanner(
        PursuitPlanner(), dataclasses.replace(TASK, **k)
    ),
    "Evaluator": lambda **k: Evaluator([], **k),
    "TrialMonitor": lambda **k: TrialMonitor(
        goal_tolerance=0.25, goal_yaw_tolerance=0.3, **k
    ),
}


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("value", [0.0, -0.05, math.inf, math.nan])
def test_every_system_refuses_such_a_time_step(name, value):
    words = f"time_step must be positive, got {value} s"
    with pytest.raises(ValueError, match=words):
        SYSTEMS[name](time_step=value)


@pytest.mark.parametrize("name", ["HumanCrowd", "BehaviorTree"])
def test_a_negative_number_of_robots_is_refused(name):
    with pytest.raises(ValueError, match="num_robots must be at least 0"):
        SYSTEMS[name](num_robots=-1)


@pytest.mark.parametrize(
    ("period", "step", "count"),
    [(0.1, 0.05, 2), (0.05, 0.05, 1), (0.3, 0.1, 3), (60.0, 0.01, 6000)],
)
def test_a_period_is_counted_in_steps(period, step, count):
    assert count_steps(period, step) == count


@pytest.mark.parametrize(
    ("period", "words"),
    [
        (0.12, "multiple of time_step .0.05 s., got 0.12 s; nearest: 0.1 or"),
        (0.02, "nearest: 0.05$"),
        (0.10000004, "nearest: 0.1 or 0.15"),
        (0.0, "period must be positive"),
        (math.nan, "period must be positive"),
        (math.inf, "period must be positive"),
        (1e-300, "nearest: 0.05$"),
    ],
)
def test_a_period_between_steps_is_refused(period, words):
    with pytest.raises(ValueError, match=words):
        count_steps(period, 0.05)


def test_numbers_and_their_bounds():
    assert check_number("gain", 0.0) == 0.0
    assert check_number("gain", -1.0, low=-1.0) == -1.0
    assert check_time_step(0.1) == 0.1
    assert check_count("num_humans", 0) == 0
    with pytest.raises(ValueError, match=r"gain must be at least 0, got -1$"):
        check_number("gain", -1)
    with pytest.raises(ValueError, match=r"gain must be positive, got 0 m"):
        check_number("gain", 0, "m", low_open=True)
    with pytest.raises(ValueError, match="gain must be above 2, got 2"):
        check_number("gain", 2, low=2.0, low_open=True)


def test_other_kinds_are_named():
    for value in ("a", None, [1.0]):
        with pytest.raises(TypeError, match="gain must be a number, got"):
            check_number("gain", value)
    for value in (1.5, "1", None, math.nan):
        with pytest.raises(TypeError, match="num_robots must be a whole"):
            check_count("num_robots", value)


def test_a_step_too_small_for_its_period_is_refused():
    with pytest.raises(ValueError, match="must be a multiple of time_step"):
        count_steps(1e308, 1e-10)
