"""What happens on the way, and when there is none: defined, and in words."""

import dataclasses
import math
import re

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.planning import (
    DwbPlanner,
    LocalPlanner,
    PlannerStatus,
    PlanningTask,
    SclPlanner,
    View,
)
from hunav_drake.systems.planning.navigation import Control, maps
from hunav_drake.systems.planning.navigation.memory import Sight
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.sensing import LidarConfig
from hunav_drake.systems.world.obstacles import Obstacles

NOBODY = np.zeros((0, 7))
ROOM = [(-1, -2), (8, -2), (8, 2), (-1, 2), (-1, -2)]


def walls(*solids):
    return Obstacles.from_shapes(
        [ROOM, *solids], solid=[False] + [True] * len(solids)
    )


def box(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def make_task(obstacles=None, num_humans=0, radius=0.35):
    return PlanningTask(
        limits=RobotLimits(),
        robot_radius=radius,
        goal_tolerance=0.25,
        goal_yaw_tolerance=0.25,
        obstacles=walls() if obstacles is None else obstacles,
        num_humans=num_humans,
    )


def person(x, y, vx=0.0, vy=0.0):
    return [x, y, math.atan2(vy, vx), vx, vy, 0.0, 0.4]


def drive(
    planner, task, *, start=(0, 0, 0), goal=(6, 0, 0), humans=NOBODY, time=40.0
):
    """Drives a robot that obeys at once; returns its poses and its plans.

    `humans` are rows, or a function of the time that gives them.
    """
    x, y, yaw = map(float, start)
    v = omega = 0.0
    memory = planner.initial_memory
    poses, plans = [], []
    for k in range(round(time / planner.period)):
        now = humans(k * planner.period) if callable(humans) else humans
        robot = [x, y, yaw, v * math.cos(yaw), v * math.sin(yaw), omega, 0.35]
        view = View(
            np.array(robot),
            np.array(now, dtype=float).reshape(-1, 7),
            np.array(goal, dtype=float),
        )
        plan = planner.plan(task, view, memory)
        memory = plan.memory
        poses.append((x, y, yaw))
        plans.append(plan)
        done = (PlannerStatus.ARRIVED, PlannerStatus.FAILED)
        if plan.status in done:
            break
        v, omega = plan.v, plan.omega
        x += v * math.cos(yaw) * planner.period
        y += v * math.sin(yaw) * planner.period
        yaw += omega * planner.period
    return np.array(poses), plans


@pytest.mark.parametrize(
    ("profile", "speed"), [("pmb2_foxy", 0.579), ("humble", 0.842)]
)
def test_cruises_as_fast_as_its_profile_does(profile, speed):
    """The speeds measured with DWB of that release: within 3 %."""
    _, plans = drive(DwbPlanner(profile=profile), make_task())
    assert plans[-1].status == PlannerStatus.ARRIVED
    cruise = [plan.v for plan in plans[30:-100]]
    assert np.median(cruise) == pytest.approx(speed, rel=0.03)


@pytest.mark.parametrize("quarter", range(4))
def test_is_as_fast_in_all_directions(quarter):
    """Points of plans lie on middles of cells, not between them."""
    yaw = 0.5 * math.pi * quarter
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    square = Obstacles.from_shapes([box(-8, -8, 8, 8)], solid=[False])
    start, goal = np.append(-6 * ahead, yaw), np.append(6 * ahead, yaw)
    _, plans = drive(
        DwbPlanner(), make_task(square), start=start, goal=goal, time=60.0
    )
    assert plans[-1].status == PlannerStatus.ARRIVED
    cruise = [plan.v for plan in plans[60:-60]]
    assert np.mean(cruise) == pytest.approx(11 / 19, rel=0.005)


@pytest.mark.parametrize("planner", [DwbPlanner(), SclPlanner()])
def test_drives_around_what_stands_in_the_way(planner):
    task = make_task(walls(box(2, -0.6, 3, 0.8)), 1)
    humans = [person(4.4, 0.3)]
    poses, plans = drive(planner, task, humans=humans)
    assert plans[-1].status == PlannerStatus.ARRIVED
    away = np.hypot(*(poses[:, :2] - (4.4, 0.3)).T)
    assert away.min() > 0.45
    x, y = poses[:, 0], poses[:, 1]
    beside = (x > 2) & (x < 3)
    assert (y[beside] < -0.6 - 0.27).all()
    # No spinning on the spot, no going back.
    assert all(plan.status != PlannerStatus.RECOVERING for plan in plans)
    assert np.abs(np.diff(np.unwrap(poses[:, 2]))).sum() < 7


def test_scl_leaves_more_room_than_dwb():
    room = []
    for planner in (DwbPlanner(), SclPlanner()):
        task = make_task(num_humans=1)
        humans = [person(3, 0.35)]
        poses, _ = drive(planner, task, humans=humans)
        room.append(np.hypot(*(poses[:, :2] - (3, 0.35)).T).min())
    assert room[1] > room[0] + 0.15
    assert room[1] > 0.8


# One begins as far from the goal as does not count as at it any more.
@pytest.mark.parametrize("x", [0.0, 2.75])
def test_turns_at_the_goal(x):
    poses, plans = drive(
        DwbPlanner(), make_task(), start=(x, 0, 0), goal=(3, 0, 2.0)
    )
    assert plans[-1].status == PlannerStatus.ARRIVED
    assert plans[-1].v == plans[-1].omega == 0.0
    assert poses[-1, 2] == pytest.approx(2.0, abs=0.25)


def test_a_new_goal_begins_anew():
    task, planner = make_task(), DwbPlanner()
    _, plans = drive(planner, task, goal=(7.9, 0, 0), time=2.0)
    memory = plans[-1].memory
    robot = np.array([0, 0, 0, 0, 0, 0, 0.35])
    plan = planner.plan(
        task, View(robot, NOBODY, np.array([3.0, 0, 0])), memory
    )
    assert plan.memory.cycle == 1
    assert plan.memory.goal == (3.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("obstacles", "start", "goal", "words"),
    [
        (
            walls(box(4, -1, 6, 1)),
            (0, 0, 0),
            (5, 0, 0),
            r"the goal \(5.00, 0.00\) is in an obstacle, and no place",
        ),
        (
            walls(box(3, -2, 3.5, 2)),
            (0, 0, 0),
            (6, 0, 0),
            r"there is no path from .* to the goal \(6.00, 0.00\)",
        ),
        (walls(), (0, 0, 0), (20, 0, 0), "no path from .* to the goal"),
    ],
)
def test_a_goal_out_of_reach_is_told_at_once(obstacles, start, goal, words):
    _, plans = drive(DwbPlanner(), make_task(obstacles), start=start, goal=goal)
    assert len(plans) == 1
    assert plans[0].status == PlannerStatus.FAILED
    assert plans[0].v == plans[0].omega == 0.0

    assert re.search(words, plans[0].reason)


@pytest.mark.parametrize("profile", ["pmb2_foxy", "humble"])
def test_a_start_in_a_wall_is_told_after_all_was_tried(profile):
    task = make_task(walls(box(-0.5, -0.5, 0.5, 0.5)))
    _, plans = drive(DwbPlanner(profile=profile), task, time=90)
    assert plans[0].status == PlannerStatus.RECOVERING
    assert plans[-1].status == PlannerStatus.FAILED
    assert "the start (0.00, 0.00) is in an obstacle" in plans[-1].reason
    assert "gave up after 6 recoveries" in plans[-1].reason
    assert all(plan.v == 0.0 for plan in plans)


def test_a_goal_beside_a_wall_is_approached_and_told():
    task = make_task(walls(box(5, -2, 6, 2)))
    poses, plans = drive(DwbPlanner(), task, goal=(5.1, 0, 0))
    assert plans[-1].status == PlannerStatus.FAILED
    assert "an obstacle is on, or near, the goal" in plans[-1].reason
    assert 4.3 < poses[-1, 0] < 4.75


def test_waits_beside_a_goal_that_people_cover_until_they_leave():
    def humans(time):
        return [person(6.0, 0.0 if time < 25 else 1.7)]

    poses, plans = drive(
        DwbPlanner(plan_tolerance=0.8),
        make_task(num_humans=1),
        humans=humans,
        time=50,
    )
    waiting = [p for p in plans if p.status == PlannerStatus.BLOCKED]
    assert len(waiting) > 100
    reason = waiting[-1].reason
    assert "people stand on the goal: the nearest reachable" in reason
    assert plans[-1].status == PlannerStatus.ARRIVED
    assert np.hypot(*(poses[:500, :2] - (6.0, 0.0)).T).min() > 0.45


def test_gives_up_if_people_keep_the_way_blocked():
    doorway = walls(box(3, -2, 3.5, -0.5), box(3, 0.5, 3.5, 2))
    humans = [person(3.25, 0.25), person(3.25, -0.25)]
    poses, plans = drive(
        DwbPlanner(), make_task(doorway, 2), humans=humans, time=120
    )
    assert plans[-1].status == PlannerStatus.FAILED
    assert "people or other moving obstacles block it" in plans[-1].reason
    assert "gave up after 6 recoveries" in plans[-1].reason
    assert poses[:, 0].max() < 3.25 - 0.45


def test_goes_on_when_the_way_is_free_again():
    doorway = walls(box(3, -2, 3.5, -0.5), box(3, 0.5, 3.5, 2))

    def humans(time):
        y = 0.25 if time < 10 else 5.0
        return [person(3.25, y), person(3.25, -y)]

    _, plans = drive(
        DwbPlanner(), make_task(doorway, 2), humans=humans, time=60
    )
    kinds = [plan.status for plan in plans]
    assert PlannerStatus.RECOVERING in kinds
    assert kinds[-1] == PlannerStatus.ARRIVED


class Standing(DwbPlanner):
    """Gives no command while people are near."""

    def control(self, task, view, local, costmap, memory):
        if len(view.humans):
            return Control(0.0, 0.0, memory, "somebody is there")
        return super().control(task, view, local, costmap, memory)


@pytest.mark.parametrize(
    ("profile", "cycles", "kinds"),
    [
        ("pmb2_foxy", 1, ["spin", "wait"]),
        ("humble", 7, ["spin", "wait", "back_up"]),
    ],
)
def test_recoveries_are_those_of_the_release(profile, cycles, kinds):
    planner = Standing(profile=profile)
    poses, plans = drive(
        planner,
        make_task(num_humans=1),
        humans=[person(0, 1.5)],
        time=100,
        start=(2, 0, 0),
    )
    first = next(
        k for k, p in enumerate(plans) if p.status == PlannerStatus.RECOVERING
    )
    # (One more try after the failure tolerance.)
    assert first in (cycles, 2 * cycles, 2 * cycles - 1)
    done = []
    for plan in plans:
        if plan.reason.startswith("recovers"):
            kind = plan.reason.split("(")[1].split(")")[0]
            if not done or done[-1] != kind:
                done.append(kind)
    assert done[: len(kinds)] == kinds
    assert plans[-1].reason.startswith("somebody is there; gave up after 6")
    turned = np.unwrap(poses[:, 2])[-1]
    spins = 6 if profile == "pmb2_foxy" else 2
    assert turned == pytest.approx(1.57 * spins, abs=0.06 * spins)
    if profile == "humble":
        back = np.hypot(*(poses[-1, :2] - poses[0, :2]))
        assert back == pytest.approx(0.3, abs=0.02)


def test_backing_up_and_spinning_stop_before_they_touch():
    task = make_task(
        walls(box(0.5, -0.6, 1.55, 0.6), box(2.45, -0.6, 3, 0.6)), 1
    )
    poses, _ = drive(
        Standing(profile="humble", inflation_radius=0.05),
        task,
        humans=[person(2, 1.5)],
        time=100,
        start=(2, 0, 0),
    )
    # 17 cm behind the robot's outline there is a wall.
    assert 1.55 + 0.27 < poses[:, 0].min() <= 2.0


def test_who_does_not_get_on_recovers():
    class Idling(DwbPlanner):
        def control(self, task, view, local, costmap, memory):
            return Control(0.0, 0.1, memory)

    _, plans = drive(Idling(), make_task(), time=12)
    slow = [p for p in plans if p.status == PlannerStatus.RECOVERING]
    assert "it has moved less than 0.5 m in 10 s" in slow[0].reason
    assert plans.index(slow[0]) == pytest.approx(200, abs=3)


@pytest.mark.parametrize(
    ("own", "planned"), [(0.35, 0.275), (0.275, 0.275), (0.2, 0.2), (0.5, 0.5)]
)
def test_radius_is_pmb2s_for_a_robot_like_it(own, planned):
    task = make_task(radius=own)
    assert DwbPlanner().setup(task).robot_radius == planned
    given = DwbPlanner(robot_radius=0.3)
    assert given.setup(task).robot_radius == 0.3


def test_a_world_that_is_too_large_is_told_when_the_system_is_made():
    long = Obstacles.from_shapes([[(0, 0), (900, 900)]], solid=[False])
    with pytest.raises(ValueError, match="take a coarser one"):
        DwbPlanner().MakeSystem(make_task(long))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"profile": "galactic"}, "pmb2_foxy"),
        ({"max_vel_x": -1.0}, "must be in"),
        ({"local_costmap": {"layers": ["paint"]}}, "static"),
        ({"scales": {"path_dist": -1.0}}, "must be in"),
    ],
)
def test_bad_parameters_are_told(given, words):
    with pytest.raises(ValueError, match=words):
        DwbPlanner(**given)


def test_reads_a_lidar_by_option():
    """Marks, and a way around what only the lidar knows of."""
    planner = DwbPlanner(obstacle_layer={"source": "lidar"})
    lidar = LidarConfig(num_rays=181, field_of_view=math.pi)
    task = dataclasses.replace(make_task(), lidar=lidar)
    assert planner.scan_size is None
    assert DwbPlanner().scan_size == 0
    post = np.array([2.0, 0.1])
    x = y = yaw = v = omega = 0.0
    memory, nearest = planner.initial_memory, math.inf
    for _ in range(500):
        angles = yaw + np.linspace(-math.pi / 2, math.pi / 2, 181)
        dx, dy = post - (x, y)
        along = dx * np.cos(angles) + dy * np.sin(angles)
        off = dx * np.sin(angles) - dy * np.cos(angles)
        hit = (along > 0) & (np.abs(off) < 0.15)
        depth = along - np.sqrt(np.maximum(0.15**2 - off**2, 0))
        robot = [x, y, yaw, v * math.cos(yaw), v * math.sin(yaw), omega, 0.35]
        plan = planner.plan(
            task,
            View(
                np.array(robot),
                NOBODY,
                np.array([4.0, 0, 0]),
                np.where(hit, depth, np.inf),
            ),
            memory,
        )
        if plan.status == PlannerStatus.ARRIVED:
            break
        memory, v, omega = plan.memory, plan.v, plan.omega
        x += v * math.cos(yaw) * 0.05
        y += v * math.sin(yaw) * 0.05
        yaw += omega * 0.05
        nearest = min(nearest, math.dist(post, (x, y)))
    assert plan.status == PlannerStatus.ARRIVED
    assert 0.4 < nearest < 0.8
    assert (memory.marks.costs == 254).any()


def test_the_system_tells_why():
    task = make_task(walls(box(4, -1, 6, 1)))
    dut = DwbPlanner().MakeSystem(task)
    assert isinstance(dut, LocalPlanner)
    context = dut.CreateDefaultContext()
    robot = [0, 0, 0, 0, 0, 0, 0.35]
    dut.get_robot_state_input_port().FixValue(context, robot)
    dut.get_human_states_input_port().FixValue(context, np.zeros(0))
    dut.get_goal_input_port().FixValue(context, [5, 0, 0])
    simulator = Simulator(dut, context)
    assert dut.GetReason(context) == ""
    simulator.AdvanceTo(0.1)
    assert "is in an obstacle" in dut.GetReason(context)
    status = dut.get_status_output_port().Eval(context)
    assert status == [PlannerStatus.FAILED]


@pytest.mark.slow
def test_a_world_in_blocks_has_the_same_local_maps(monkeypatch):
    random = np.random.default_rng(5)
    corners = random.uniform(-15, 15, (60, 2))
    solids = [box(x, y, x + 0.4, y + 0.7) for x, y in corners]
    obstacles = Obstacles.from_shapes(solids, solid=[True] * len(solids))
    whole = DwbPlanner().setup(make_task(obstacles)).maps
    monkeypatch.setattr(maps, "MOST_CELLS", 0)
    parted = DwbPlanner().setup(make_task(obstacles)).maps
    seen = 0
    for x, y in random.uniform(-16, 16, (20, 2)):
        robot = np.array([x, y, 0, 0, 0, 0, 0.35])
        sight = Sight(0, robot, NOBODY)
        one, other = (it.local_map(robot, sight) for it in (whole, parted))
        assert one.origin == other.origin
        np.testing.assert_array_equal(one.costs, other.costs)
        seen += one.costs.any()
    assert seen > 10
