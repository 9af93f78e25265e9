"""People get through the doors that their ways lead through."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.crowd.bodies.adaptation import Adaptation
from hunav_drake.systems.crowd.walls import passages
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap
from hunav_drake.systems.world.shapes import Box, World

MODELS = [
    "social_force",
    "headed_social_force",
    "orca",
    "collision_free_speed",
    "anticipation_velocity",
]


# The weights of a person.
WEIGHTS = np.array([[2, 0.5, 10, 0.2, 5, 2, 0.35, 2, 3, 0, 3, 2, 1.0]])


def room_with_a_door(width, *, thickness=0.2):
    """A room of 8 x 8 m, with a door at x = 3, y = 0 in a wall across."""
    side = (8 - width) / 2
    return World(
        walls=[
            Box(center=[3, (width + side) / 2], size=[thickness, side]),
            Box(center=[3, -(width + side) / 2], size=[thickness, side]),
            Box(center=[3, 4.1], size=[8.4, 0.2]),
            Box(center=[3, -4.1], size=[8.4, 0.2]),
            Box(center=[-1.1, 0], size=[0.2, 8.4]),
            Box(center=[7.1, 0], size=[0.2, 8.4]),
        ]
    )


def walks(*humans, world, time=25.0, **config):
    """Returns where people are after each second, until all have arrived."""
    builder = DiagramBuilder()
    ports = AddHumans(
        builder,
        humans,
        obstacles=world,
        config=CrowdConfig(**config),
        num_robots=0,
    )
    builder.ExportOutput(ports.human_states, "human_states")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    goals = np.array([human.goals[-1] for human in humans])
    places = []
    for second in range(1, round(time) + 1):
        simulator.AdvanceTo(second)
        port = diagram.GetOutputPort("human_states")
        states = port.Eval(simulator.get_context()).reshape(-1, 7)
        places.append(states[:, :2].copy())
        away = np.hypot(*(places[-1] - goals).T)
        if (away < 0.5).all():
            return places
    return places


def arrive(*humans, **kwargs):
    places = walks(*humans, **kwargs)[-1]
    goals = np.array([human.goals[-1] for human in humans])
    return (np.hypot(*(places - goals).T) < 0.5).all()


@pytest.mark.parametrize("width", [0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 1.0, 1.2])
@pytest.mark.parametrize("model", MODELS)
def test_people_pass_every_door_that_is_a_way(model, width):
    """People straight before it, and people who come along the wall."""
    world = room_with_a_door(width)
    for start, goal in (([0, 0], [6, 0]), ([0, 2.5], [6, -2.5])):
        human = HumanConfig(pose=[*start, 0.0], goals=[goal])
        ways = RouteMap.from_obstacles(
            world.obstacles(), clearance=route_clearance([human.radius])
        )
        assert (ways.next_waypoint([2.6, 0.0], goal)[0] > 3).all()
        assert arrive(human, world=world, model=model)


@pytest.mark.parametrize("radius", [0.2, 0.3, 0.4, 0.5])
@pytest.mark.parametrize("model", MODELS)
def test_people_of_any_size_pass_a_door_of_80_cm(model, radius):
    human = HumanConfig(pose=[0, 2.5, 0], goals=[[6, -2.5]], radius=radius)
    assert arrive(human, world=room_with_a_door(0.8), model=model)


@pytest.mark.parametrize("speed", [0.4, 2.0])
@pytest.mark.parametrize("thickness", [0.02, 0.6])
def test_people_of_any_speed_pass_a_door(speed, thickness):
    world = room_with_a_door(0.7, thickness=thickness)
    human = HumanConfig(
        pose=[0, 2.5, 0], goals=[[6, -2.5]], desired_speed=speed
    )
    assert arrive(human, world=world, time=12 / speed + 5)


@pytest.mark.parametrize("model", ["social_force", "headed_social_force"])
def test_people_pass_a_door_into_a_narrow_corridor(model):
    """Straight behind the door is a wall; the waypoint is before it."""
    world = room_with_a_door(0.8)
    world.walls.append(Box(center=[1.75, 0], size=[0.1, 8]))
    human = HumanConfig(pose=[5, 0.5, 3], goals=[[2.3, -3]], desired_speed=0.6)
    assert arrive(human, world=world, model=model)
    # As in version 0.1.
    old = {"model": model, "walls_behind_doors": False}
    assert not arrive(human, world=world, **old)


def test_people_take_the_wide_gap_where_the_door_is_none():
    """0.5 m straight ahead are no way; 1.5 m, 3 m aside, are one."""

    def world(top):
        return World(
            walls=[
                Box(center=[3, -1.4], size=[0.2, 2]),
                Box(center=[3, top + 1.5], size=[0.2, 3]),
                Box(center=[3, -6.9], size=[0.2, 6]),
            ]
        )

    human = HumanConfig(pose=[0, 0, 0], goals=[[6, 0]])
    narrow = walks(human, world=world(0.1))
    assert np.hypot(*(narrow[-1][0] - [6, 0])) < 0.5
    assert min(place[0, 1] for place in narrow) < -2.4
    # A door of 0.8 m is one, too.
    straight = walks(human, world=world(0.4))
    assert np.hypot(*(straight[-1][0] - [6, 0])) < 0.5
    assert min(place[0, 1] for place in straight) > -0.2


def test_without_route_planning_the_original_stands_before_the_door():
    human = HumanConfig(pose=[0, 0, 0], goals=[[6, 0]])
    world = room_with_a_door(0.8)
    assert not arrive(human, world=world, route_planning=False)


def ease(world, *, p=(2.0, 0.0), goal=(6.0, 0.0), planned=True, **command):
    """Returns radius and obstacle factor of a default person at a place."""
    rows = np.zeros((1, COMMAND_SIZE))
    rows[0, :4] = *goal, 0.3, 1
    rows[0, Command.DESIRED_SPEED] = 1.2
    for name, value in command.items():
        rows[0, Command[name]] = value
    states = np.array([[*p, 0.0, 0.0, 0.0, 0.0]])
    dut = Adaptation(
        *(np.array([0.35]), np.array([0.3]), world.obstacles()),
        CrowdConfig(route_planning=planned),
    )
    _, at_walls = dut.adapt(
        states.ravel(), rows.ravel(), np.zeros(0), WEIGHTS.ravel()
    )
    return tuple(at_walls[0])


@pytest.mark.parametrize("width", [1.0, 1.2, 2.0])
def test_a_wide_door_changes_nothing(width):
    assert ease(room_with_a_door(width)) == (0.35, 10.0)


def test_the_narrower_the_door_the_less_walls_push():
    eased = [ease(room_with_a_door(w)) for w in (0.6, 0.7, 0.8, 0.9)]
    assert eased[0][0] == pytest.approx(0.27)
    factors = [factor for _, factor in eased]
    assert factors == sorted(factors)
    assert 2 < factors[0] < factors[-1] < 10


@pytest.mark.parametrize(
    "case",
    [
        # No way at all, so nobody forces it.
        {"world": room_with_a_door(0.4)},
        {"p": (0.5, 0.0)},
        {"p": (4.0, 0.0)},
        {"goal": (2.0, 3.0)},
        {"planned": False},
        {"HAS_GOAL": 0},
        {"DESIRED_SPEED": 0},
        {"GOAL_RADIUS": 9},
    ],
)
def test_who_passes_no_door_feels_walls_as_ever(case):
    assert ease(**{"world": room_with_a_door(0.7), **case}) == (0.35, 10.0)


def test_what_is_felt_of_walls_changes_without_jumps():
    """Through a narrow door and out of it, straight and at a slant."""
    world = room_with_a_door(0.6)
    for slope in (0.0, 0.1, -0.3):
        x = np.linspace(1.5, 4.5, 601)
        felt = np.array(
            [
                ease(world, p=(at, slope * (at - 3)), goal=(9, 6 * slope))
                for at in x
            ]
        )
        assert felt[:, 0].min() < 0.28
        assert abs(np.diff(felt[:, 0])).max() < 0.01
        assert abs(np.diff(felt[:, 1])).max() < 1


def test_the_goal_counts_as_a_place_at_any_distance():
    """Between two walls to a goal 1 cm before a third one, which scrapes."""
    walls = [Box(center=[1.5, y], size=[3, 0.2]) for y in (-0.45, 0.45)]
    walls.append(Box(center=[3.0, 0], size=[0.2, 2]))
    table = World(walls=walls).obstacles().table
    command = np.zeros((1, COMMAND_SIZE))
    command[0, :4] = 2.89, 0.0, 0.1, 1
    command[0, Command.DESIRED_SPEED] = 1.2
    for x in np.linspace(1.6, 1.7, 300):
        position = np.array([[x, 0.0, 0.0, 0.0, 0.0, 0.0]])
        own = np.array([[0.35, 10.0]])
        eased = passages.ease(
            *(position, command, own, WEIGHTS, 0.0, 0.6), *(table, 5.0, 0, True)
        )
        np.testing.assert_array_equal(eased, own)


@pytest.mark.parametrize("width", [0.6, 0.7, 0.9, 1.2])
@pytest.mark.parametrize("model", MODELS)
def test_nobody_is_stuck_or_thrown_at_a_door(model, width):
    """From many places; more than 1.25 g is a throw."""
    crowd_step = 0.05
    for y in (-2.0, 0.0, 1.25, 2.5):
        human = HumanConfig(pose=[0, y, 0], goals=[[6, -y / 2]])
        builder = DiagramBuilder()
        ports = AddHumans(
            builder,
            [human],
            obstacles=room_with_a_door(width),
            config=CrowdConfig(model=model),
            num_robots=0,
            time_step=crowd_step,
        )
        builder.ExportOutput(ports.human_states, "human_states")
        diagram = builder.Build()
        simulator = Simulator(diagram)
        states = []
        for k in range(300):
            simulator.AdvanceTo(k * crowd_step)
            port = diagram.GetOutputPort("human_states")
            states.append(port.Eval(simulator.get_context()))
        states = np.array(states)
        away = np.hypot(states[:, 0] - 6, states[:, 1] + y / 2)
        assert away.min() < 0.5
        change = np.diff(states[:, 3:5], axis=0) / crowd_step
        assert np.hypot(*change.T).max() < 1.25 * 9.81


@pytest.mark.parametrize("width", [0.6, 0.7, 0.8])
def test_people_who_meet_in_a_door_are_as_large_as_ever(width):
    there = HumanConfig(pose=[0, 0, 0], goals=[[6, 0]])
    back = HumanConfig(pose=[6, 0, 3.14], goals=[[0, 0]])
    places = walks(
        there, back, world=room_with_a_door(width), model="orca", time=15
    )
    # (They may touch as bodies do, which are smaller than discs of comfort.)
    apart = [np.hypot(*(pair[0] - pair[1])) for pair in places]
    assert min(apart) > 2 * there.contact_radius - 0.01


@pytest.mark.parametrize(("planned", "exact"), [(True, False), (False, True)])
def test_at_doors_derivatives_are_approximate_if_ways_are_planned(
    planned, exact
):
    dut = HumanCrowd(
        [HumanConfig(pose=[2, 0, 0])],
        obstacles=room_with_a_door(0.7).obstacles(),
        num_robots=0,
        config=CrowdConfig(route_planning=planned),
    )
    context = dut.CreateDefaultContext()
    command = np.zeros(COMMAND_SIZE)
    command[:4] = 6, 0, 0.3, 1
    command[Command.DESIRED_SPEED] = 1.2
    command[Command.MAX_SPEED] = 1.5
    command[Command.GROUP_ID] = -1
    dut.get_commands_input_port().FixValue(context, command)

    def speed(x):
        dut.SetStates(context, [[x, 0.03, 0, 0.8, 0.05, 0]])
        update = dut.EvalUniquePeriodicDiscreteUpdate(context)
        return update.get_vector(0).CopyToVector()[3]

    expected = (speed(2.5 + 1e-6) - speed(2.5 - 1e-6)) / 2e-6
    dut.SetStates(context, [[2.5, 0.03, 0, 0.8, 0.05, 0]])
    result = dut.CalcJacobian(context).states[3, 0]
    assert (abs(result - expected) < 1e-5) == exact
