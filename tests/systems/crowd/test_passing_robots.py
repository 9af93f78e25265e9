"""People pass robots at a distance, where there is room."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    VX,
    VY,
    Command,
    RobotRole,
    X,
    Y,
)
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.crowd.bodies.passing_robots import pass_robots
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.people.parameters import EPSILON
from hunav_drake.systems.world.shapes import World
from hunav_drake.trial.humans import MakeHumans
from tests.systems.crowd.crowds import NO_WALLS, box_between
from tests.systems.crowd.test_bodies import commands_to
from tests.systems.crowd.walls.test_passages import MODELS

BODY, ROBOT, SPEED, STEP = 0.25, 0.35, 1.2, 0.05

# So far apart meet those who are no concern of each other, in meters.
APART = 100.0


class Meeting(NamedTuple):
    """A person who walks 14 m along the x-axis, and a robot.

    Attributes:
        beside: The distance of the robot to the left of the person's way when
            it is abreast, if the person walks on, in meters.
        course: The robot's direction, in radians.
        speed: The robot's, in m/s.
        turned: The rotation of all of it, in radians.
        mirrored: Whether left is right in it.
    """

    beside: float
    course: float
    speed: float
    turned: float = 0.0
    mirrored: bool = False

    def points(self, number, *rows):
        """Returns points in the world, those of meetings far apart."""
        c, s = math.cos(self.turned), math.sin(self.turned)
        side = -1.0 if self.mirrored else 1.0
        x, y = np.reshape(rows, (-1, 2)).T
        place = [c * x - s * side * y, s * x + c * side * y]
        return np.stack(place, axis=1) + np.array([APART * number, 0.0])

    def person(self, number, **kwargs):
        start, goal = self.points(number, (-7, 0), (7, 0))
        epsilon = -0.005 if self.mirrored else 0.005
        return HumanConfig(
            pose=(*start, self.turned),
            goals=[tuple(goal)],
            desired_speed=SPEED,
            forces=SocialForceParameters(epsilon=epsilon),
            **kwargs,
        )

    def robot(self, number, time):
        """Returns the robot's state at a time."""
        vx = self.speed * math.cos(self.course)
        vy = self.speed * math.sin(self.course)
        # When the person walks through the middle.
        since = time - 7.0 / SPEED
        here, there = self.points(
            number,
            (vx * since, self.beside + vy * since),
            (vx * (since + 1), self.beside + vy * (since + 1)),
        )
        v = there - here
        yaw = math.atan2(v[1], v[0])
        return [*here, yaw, *v, 0.0, ROBOT]


def gaps(meetings, model="social_force", **crowd):
    """Returns of each the least gap on the way, and when the person is there.

    They are all in one world, but far apart.
    """
    people = [m.person(i) for i, m in enumerate(meetings)]
    states, robots = walk(
        people,
        lambda t: [m.robot(i, t) for i, m in enumerate(meetings)],
        CrowdConfig(model=model, **crowd),
    )
    goals = np.array([human.goals[-1] for human in people])
    left = np.hypot(*np.moveaxis(states[:, :, :2] - goals, -1, 0))
    away = np.hypot(*np.moveaxis((states - robots)[:, :, :2], -1, 0))
    away[np.logical_or.accumulate(left < 0.45)] = np.inf
    there = np.argmax(left < 0.45, axis=0) * STEP
    return away.min(axis=0) - BODY - ROBOT, there


def walk(people, robots_at, config, time=16.0):
    """Returns the states of people and robots, shapes (k, n, 7), (k, m, 7)."""
    diagram = MakeHumans(
        people,
        num_robots=len(robots_at(0.0)),
        config=config,
        time_step=STEP,
        separate_trees=False,
    )
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    states, robots = [], []
    for k in range(round(time / STEP)):
        robots.append(robots_at(k * STEP))
        diagram.GetInputPort("robot_states").FixValue(
            context, np.ravel(robots[-1])
        )
        port = diagram.GetOutputPort("human_states")
        states.append(port.Eval(context).reshape(-1, 7).copy())
        simulator.AdvanceTo((k + 1) * STEP)
    return np.array(states), np.array(robots)


def placements():
    """Returns 20 meetings in the open: head-on, across, overtaken, standing."""
    rng = np.random.default_rng(2026)
    kinds = {"head-on": math.pi, "left": -math.pi / 2, "right": math.pi / 2}
    courses = [*kinds.values(), 0.0, None] * 4
    return [
        Meeting(
            beside=float(rng.uniform(-0.6, 0.6)),
            course=0.0 if course is None else course,
            speed=0.0 if course is None else float(rng.uniform(0.3, 0.8)),
            turned=float(rng.uniform(-math.pi, math.pi)),
        )
        for course in courses
    ]


@pytest.mark.parametrize("model", MODELS)
def test_people_pass_robots_at_a_distance_in_the_open(model):
    least, there = gaps(placements(), model)
    assert np.count_nonzero((least > 0.4) & (least < 0.8)) >= 18
    assert least.min() > 0.3
    # Nobody waits: 14 m take 11.3 s.
    assert there.max() < 13.5


@pytest.mark.parametrize("offset", [0.0, 0.05, 0.15, 0.3, 0.6])
def test_forces_alone_let_people_graze_a_robot(offset):
    """Without it the fault is there: the forces do not make the distance."""
    meetings = [Meeting(offset, math.pi, speed) for speed in (0.3, 0.5, 0.8)]
    least, _ = gaps(meetings, robot_gap=0.0)
    assert least.max() < 0.3
    least, _ = gaps(meetings)
    assert least.min() > 0.4


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("beside", [-0.3, 0.1, 0.4])
def test_a_robot_that_stands_near_the_goal_is_passed_as_there_is_room(
    model, beside
):
    """People at the goal are 0.4 to 0.5 m off it, so no more is left before."""
    person = HumanConfig(pose=(-4, 0, 0), goals=[(0, 0)], desired_speed=0.5)
    robot = [-1.0, beside, 0.3, 0.0, 0.0, 0.0, ROBOT]
    states, _ = walk([person], lambda _: [robot], CrowdConfig(model=model))
    away = np.hypot(states[:, 0, X] - robot[X], states[:, 0, Y] - robot[Y])
    assert away.min() - BODY - ROBOT > 0.3
    assert np.hypot(states[:, 0, X], states[:, 0, Y]).min() < 0.45


def test_who_has_room_does_not_care():
    meetings = [Meeting(1.4, math.pi, 0.5), Meeting(-1.4, 0.0, 0.0)]
    with_gap, without = gaps(meetings), gaps(meetings, robot_gap=0.0)
    np.testing.assert_array_equal(with_gap, without)


def test_ways_past_robots_turn_and_mirror_with_the_world():
    first = [
        Meeting(0.5, math.pi, 0.5),
        Meeting(-0.1, math.pi, 0.3),
        Meeting(0.2, math.pi / 2, 0.6),
        Meeting(-0.4, 0.0, 0.4),
    ]
    turned = [m._replace(turned=2.3) for m in first]
    mirrored = [m._replace(mirrored=True, turned=-1.1) for m in first]
    least, there = gaps([*first, *turned, *mirrored])
    for results in (least, there):
        same = results.reshape(3, -1)
        np.testing.assert_allclose(same - same[0], 0, atol=1e-6)


def test_the_order_of_people_does_not_matter():
    people = [
        HumanConfig(pose=(6.0 + i, 0.4 * i - 0.8, math.pi), goals=[(-6.0, 0.3)])
        for i in range(5)
    ]

    def robots(time):
        return [
            [-4.0 + 0.5 * time, 0.0, 0.0, 0.5, 0.0, 0.0, ROBOT],
            [-1.0, 1.5, 0.0, 0.0, 0.0, 0.0, ROBOT],
        ]

    states, _ = walk(people, robots, CrowdConfig())
    others, _ = walk(people[::-1], robots, CrowdConfig())
    np.testing.assert_allclose(states, others[:, ::-1], atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_several_people_pass_a_robot_and_each_other(model):
    """Six who come towards it, and two across."""
    people = [
        *(
            HumanConfig(pose=(x, y, math.pi), goals=[(x - 13.0, y)])
            for x, y in itertools.product((2.5, 5.0), (-1.2, 0.0, 1.2))
        ),
        HumanConfig(pose=(0.0, -6.0, math.pi / 2), goals=[(0.0, 6.0)]),
        HumanConfig(pose=(1.5, 6.0, -math.pi / 2), goals=[(1.5, -6.0)]),
    ]

    def robots(time):
        return [[-4.5 + 0.5 * time, 0.1, 0.0, 0.5, 0.0, 0.0, ROBOT]]

    states, robot = walk(people, robots, CrowdConfig(model=model))
    away = np.hypot(*np.moveaxis((states - robot)[:, :, :2], -1, 0))
    assert away.min() - BODY - ROBOT > 0.25
    goals = np.array([human.goals[-1] for human in people])
    assert np.hypot(*(states[-1, :, :2] - goals).T).max() < 0.6


@pytest.mark.parametrize("model", MODELS)
def test_no_group_holds_who_passes_a_robot(model):
    """Two who walk abreast, one on either side of it."""
    people = [
        HumanConfig(pose=(6.0, y, math.pi), goals=[(-6.0, y)], group_id=1)
        for y in (-0.4, 0.4)
    ]
    states, robots = walk(
        people,
        lambda _: [[0.0, 0.05, 0.0, 0.0, 0.0, 0.0, ROBOT]],
        CrowdConfig(model=model),
        12.0,
    )
    away = np.hypot(*np.moveaxis((states - robots)[:, :, :2], -1, 0))
    assert away.min() - BODY - ROBOT > 0.4
    assert states[-1, :, X].max() < -5.0


def test_scalars_with_derivatives_take_the_same_way():
    """Past a robot, in a group of whom one goes elsewhere."""
    people = [
        HumanConfig(pose=(0.1 * i, 0.8 * i, 0.0), group_id=1) for i in range(3)
    ]
    commands = commands_to([(9.0, 0.0), (9.0, 0.8), (-9.0, 1.6)])
    commands[:, Command.GROUP_ID] = 1
    robots = np.array([2.0, 0.1, math.pi, -0.5, 0.0, 0.0, ROBOT])
    dut = HumanCrowd(people)
    converted = dut.ToAutoDiffXd()
    after = []
    for system in (dut, converted):
        context = system.CreateDefaultContext()
        system.get_commands_input_port().FixValue(context, commands.ravel())
        port = system.get_robot_states_input_port()
        port.FixValue(
            context,
            robots if system is dut else InitializeAutoDiff(robots).ravel(),
        )
        updated = system.EvalUniquePeriodicDiscreteUpdate(context)
        vector = updated.get_vector(0).CopyToVector()
        after.append(vector if system is dut else ExtractValue(vector).ravel())
    np.testing.assert_allclose(*after, rtol=0, atol=1e-9)
    # They walk aside, and the last one back.
    vx, vy = after[0].reshape(3, 6)[:, [VX, VY]].T
    assert vy[0] < -0.01
    assert vx[0] > 0 > vx[2]


def wanted(
    robot,
    *,
    goal=(6.0, 0.0),
    role=RobotRole.PEDESTRIAN,
    walls=NO_WALLS,
    more=(),
    behind=True,
    **command,
):
    """Returns which way, in radians, a person at the origin wants to walk."""
    row = np.zeros((1, COMMAND_SIZE))
    row[0, : Command.GOAL_RADIUS] = goal
    row[0, Command.GOAL_RADIUS] = 0.3
    row[0, Command.HAS_GOAL] = 1
    row[0, [Command.DESIRED_SPEED, Command.MAX_SPEED]] = SPEED
    row[0, Command.ROBOT_ROLE] = role
    row[0, Command.GROUP_ID] = 4
    for name, value in command.items():
        row[0, Command[name]] = value
    weights = np.zeros((1, 13))
    weights[0, EPSILON] = 0.005
    after, felt = pass_robots(
        np.zeros((1, 6)),
        np.array([BODY]),
        row,
        row,
        weights,
        np.array([robot, *more], dtype=float),
        np.array([[0.35, 10.0]]),
        walls.table,
        0.6,
        float(behind),
    )
    # Walls are felt as by who turns the shoulders, and no group pulls.
    passes = bool((after != row).any())
    assert (felt[0] < [0.35, 10.0]).all() == passes
    row[0, Command.GROUP_ID] = -1 if passes else 4
    np.testing.assert_array_equal(after[:, 2:], row[:, 2:])
    np.testing.assert_allclose(np.hypot(*after[0, :2]), np.hypot(*goal))
    return math.atan2(after[0, 1], after[0, 0]) - math.atan2(goal[1], goal[0])


def at(x, y, vx=0.0, vy=0.0):
    return [x, y, 0.0, vx, vy, 0.0, ROBOT]


def test_the_lane_is_taken_on_half_of_the_way():
    # 1.2 m off the robot's center, 1 m on.
    assert math.isclose(wanted(at(2, 0.6)), -math.asin(0.6))
    assert math.isclose(wanted(at(2, -0.6)), math.asin(0.6))
    # A robot that comes as fast is met halfway.
    assert math.isclose(
        wanted(at(2.8, 0.9, -SPEED)), -math.asin((1.2 - 0.9) / 0.7)
    )


def test_people_make_way_for_robots_from_behind():
    # Abreast in a second: 1.2 m off the robot's center.
    robot = at(-1, 0.9, SPEED + 1)
    assert math.isclose(wanted(robot), -math.asin((1.2 - 0.9) / (SPEED / 2)))
    assert wanted(robot, behind=False) == 0.0
    # And while they are beside each other.
    assert wanted(at(0.5, 0.9, SPEED + 1)) < 0


@pytest.mark.parametrize("beside", [-0.5, -0.2, 0.3, 0.6])
def test_a_robot_that_overtakes_is_given_room(beside):
    meeting = [Meeting(beside=beside, course=0.0, speed=1.8)]
    (gap,), (there,) = gaps(meeting)
    (grazed,), _ = gaps(meeting, robots_behind=False)
    assert gap > max(grazed, 0.3)
    assert there < 13.5


LET_BE = {
    "far away": {"robot": at(3.1, 0)},
    "beside the way": {"robot": at(2, 1.21)},
    "behind": {"robot": at(-0.5, 0)},
    "far behind in time": {"robot": at(-2.5, 0, SPEED + 0.5)},
    "ahead after overtaking": {"robot": at(0.7, 0.2, SPEED + 0.5)},
    "as fast": {"robot": at(1, 0, SPEED)},
    "beyond the goal": {"robot": at(2.5, 0.4), "goal": (1.0, 0.0)},
    "at the goal": {"robot": at(2.5, 0), "goal": (3.0, 0.0)},
    "gone by then": {"robot": at(2.5, 0, 0, 1.0)},
    "an obstacle": {"robot": at(2, 0), "role": RobotRole.OBSTACLE},
    "unseen": {"robot": at(2, 0), "role": RobotRole.UNSEEN},
    "of no matter to who stands": {"robot": at(2, 0), "HOLD": 1},
    "of no matter without a goal": {"robot": at(2, 0), "HAS_GOAL": 0},
    "of no matter without speed": {"robot": at(2, 0), "DESIRED_SPEED": 0},
}


@pytest.mark.parametrize("case", LET_BE)
def test_robots_are_let_be_that_are(case):
    assert wanted(**LET_BE[case]) == 0.0


def walls_of(*boxes):
    """Returns walls from pairs of corners, x0, y0, x1, y1."""
    return World(walls=[box_between(*box) for box in boxes]).obstacles()


def test_a_robot_behind_a_wall_is_not_seen():
    wall = walls_of((0.9, -1, 1.0, 1))
    assert wanted(at(2, 0)) != 0
    assert wanted(at(2, 0), walls=wall) == 0


def test_the_side_is_the_one_with_room():
    assert wanted(at(2, 0.1)) < 0
    # The wall leaves 0.9 m on the right, and the body needs half.
    right = walls_of((-1, -1.0, 5, -0.9))
    assert wanted(at(2, 0.1), walls=right) > 0
    # If neither has enough, people go where there is more.
    left = walls_of((-1, -1.0, 5, -0.9), (-1, 0.5, 5, 0.6))
    assert wanted(at(2, 0.1), walls=left) < 0


def test_what_is_beside_the_way_while_they_pass_takes_room():
    before, abreast, after = (
        walls_of((x - 0.1, -0.9, x + 0.1, -0.6)) for x in (0.8, 2.0, 2.6)
    )
    assert wanted(at(2, 0.1), walls=before) < 0
    assert wanted(at(2, 0.1), walls=abreast) > 0
    assert wanted(at(2, 0.1), walls=after) > 0
    # A person who is overtaken is beside for longer.
    far = walls_of((3.8, -0.9, 4.0, -0.6))
    assert wanted(at(2, 0.1), walls=far) < 0
    assert wanted(at(1, 0.1, SPEED / 2), walls=far) < 0
    assert wanted(at(1.6, 0.1, SPEED / 2), walls=far) > 0


def test_the_order_of_robots_does_not_matter():
    robots = [at(1.4, -0.1), at(0.8, -0.4, -0.5), at(1.3, 0.2)]
    wall = walls_of((1.2, 0.5, 3.2, 0.6))
    ways = [
        wanted(first, more=more, walls=wall)
        for first, *more in itertools.permutations(robots)
    ]
    np.testing.assert_allclose(ways, ways[0])


def test_who_crosses_is_passed_behind():
    assert wanted(at(2, -0.8, 0, 0.5)) < 0
    assert wanted(at(2, 0.8, 0, -0.5)) > 0
    # But for one who would be a long way off.
    assert wanted(at(2, 0.2, 0, 0.5)) < 0
    assert wanted(at(2, -1.6, 0, 0.5)) > 0


def test_two_robots_abreast_are_passed_on_one_side():
    assert wanted(at(2, 0.2)) < 0
    # The gap between them has no room, nor is there on the right.
    assert wanted(at(2, 0.4), more=[at(2, -0.5)]) < -1.0
    assert wanted(at(2, 0.1), more=[at(2, -0.9)]) > 1.0
    # But here is one.
    assert abs(wanted(at(2, 1.1), more=[at(2, -1.3)])) < 0.2


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("offset", [0.0, 0.2])
def test_people_and_robots_pass_in_a_corridor(model, offset):
    """It is 2 m wide, and the robot drives straight on."""
    assert passes(2.0, "pursuit", offset, model=model) > 0.0


@pytest.mark.parametrize("offset", [0.0, 0.2])
def test_a_person_passes_a_small_robot_in_a_corridor_of_a_door(offset):
    """It is 1.5 m wide, and the robot drives straight on."""
    assert passes(1.5, "pursuit", offset, radius=0.22) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("planner", ["dwb", "scl", "sfw"])
@pytest.mark.parametrize("offset", [-0.2, 0.0, 0.2])
def test_planners_and_people_pass_in_a_corridor_of_a_door(planner, offset):
    assert passes(1.5, planner, offset) > -0.01


CORRIDOR = """
world:
  walls:
  - {{type: box, name: north, center: [0, {side}], size: [24, 0.2]}}
  - {{type: box, name: south, center: [0, -{side}], size: [24, 0.2]}}
humans:
- {{pose: [4, {y}, 3.14159265], goals: [[-6, {y}]]}}
crowd: {{model: {model}}}
robot: {{radius: {radius}, start: [-4, 0, 0], goal: [5, 0, 0]}}
planner: {planner}
simulation: {{duration: 40.0}}
"""


def passes(width, planner, y, *, model="social_force", radius=0.35):
    """Returns the least gap of a person and a robot who both arrive."""
    scenario = LoadScenario(
        data=CORRIDOR.format(
            side=width / 2 + 0.1,
            planner=planner,
            y=y,
            model=model,
            radius=radius,
        )
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    human, robot = result.recording.humans[:, 0], result.recording.robot
    assert math.hypot(human[-1, X] + 6, human[-1, Y] - y) < 0.6
    walking = human[10:-10]
    stands = np.hypot(walking[:, VX], walking[:, VY]) < 0.1
    there = np.hypot(walking[:, X] + 6, walking[:, Y] - y) < 0.6
    assert np.count_nonzero(stands & ~there) * 0.1 < 3.0
    away = np.hypot(human[:, X] - robot[:, X], human[:, Y] - robot[:, Y])
    return away.min() - BODY - radius
