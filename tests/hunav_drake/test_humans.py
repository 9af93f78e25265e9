"""People in a diagram of one's own."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer
import pytest

from hunav_drake import AddHumans, AgentServices, HumanConfig, MakeHumans
from hunav_drake.systems.behavior import BEHAVIORS, BehaviorTree, LoadBehavior
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.people import draw_weights
from hunav_drake.systems.people.parameters import K_GOAL, K_OBSTACLE
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import Polyline, World
from tests.walkers import make_walkers

ROBOT = [3.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.3]


def run_humans(humans, *, time=4.0, robot=ROBOT, **kwargs):
    """Returns what the ports give at a time."""
    builder = DiagramBuilder()
    ports = AddHumans(builder, humans, **kwargs)
    if ports.robot_states is not None:
        source = builder.AddSystem(ConstantVectorSource(robot))
        builder.Connect(source.get_output_port(), ports.robot_states)
    for name in ("human_states", "behavior_status", "forces"):
        builder.ExportOutput(getattr(ports, name), name)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(time)
    context = simulator.get_context()
    return [
        diagram.GetOutputPort(name).Eval(context).reshape(len(humans), width)
        for name, width in (
            ("human_states", 7),
            ("behavior_status", 1),
            ("forces", 16),
        )
    ]


@pytest.mark.parametrize("n", [0, 1, 3])
def test_people_walk_around_a_robot_of_ones_own(n):
    states, status, forces = run_humans(make_walkers(n))
    assert states.shape == (n, 7)
    assert status.shape == (n, 1)
    assert forces.shape == (n, 16)
    if n:
        assert (states[:, 0] > 3).all()
        # The first person meets the robot and leaves the line.
        assert abs(states[0, 1]) > 0.05


def test_the_crowd_inside_can_be_reached():
    """Its people are put elsewhere in one Context, and not in another."""
    builder = DiagramBuilder()
    ports = AddHumans(builder, make_walkers(2), num_robots=0)
    diagram = builder.Build()
    one, other = (diagram.CreateDefaultContext() for _ in range(2))
    inside = ports.crowd.GetMyMutableContextFromRoot(one)
    states = ports.human_states.Eval(
        diagram.GetSubsystemByName("humans").GetMyContextFromRoot(one)
    ).reshape(-1, 7)
    moved = states.copy()
    moved[0, :2] = [4.0, 1.0]
    ports.crowd.SetStates(inside, moved)
    seen = [
        ports.crowd.GetOutputPort("human_states").Eval(
            ports.crowd.GetMyContextFromRoot(it)
        )[:2]
        for it in (one, other)
    ]
    np.testing.assert_array_equal(seen, [[4.0, 1.0], states[0, :2]])


@pytest.mark.parametrize("num_robots", [0, 1, 2])
def test_any_number_of_robots_will_do(num_robots):
    states, _, _ = run_humans(
        make_walkers(2), num_robots=num_robots, robot=ROBOT * num_robots
    )
    assert np.isfinite(states).all()
    assert (abs(states[0, 1]) > 0.05) == (num_robots > 0)


def test_people_feel_walls():
    wall = Obstacles.from_shapes([[[-9, -0.5], [9, -0.5]]], solid=[False])
    states, _, forces = run_humans(
        make_walkers(1), num_robots=0, obstacles=wall
    )
    assert states[0, 1] > 0.01
    assert forces[0, 3] > 0


def test_an_unknown_behavior_is_refused():
    human = HumanConfig(pose=[0, 0, 0], behavior="reglar")
    with pytest.raises(ValueError, match="reglar"):
        AddHumans(DiagramBuilder(), [human])


def test_goals_are_walked_to_in_turn():
    human = HumanConfig(pose=[0, 0, 0], goals=[[3, 0], [3, 3]])
    states, _, _ = run_humans([human], num_robots=0, time=3.3)
    assert states[0, 1] > 0.1
    states, _, _ = run_humans([human], num_robots=0, time=30.0)
    np.testing.assert_allclose(states[0, :2], [3, 3], atol=0.5)
    np.testing.assert_allclose(states[0, 3:5], 0, atol=1e-3)


def test_two_crowds_in_a_diagram_have_names():
    builder = DiagramBuilder()
    AddHumans(builder, make_walkers(1), num_robots=0)
    with pytest.raises(ValueError, match="a system named 'humans' already"):
        AddHumans(builder, make_walkers(1), num_robots=0)
    AddHumans(builder, make_walkers(1), num_robots=0, name="others")
    assert builder.Build().HasSubsystemNamed("others")


def test_two_robots_come_by_a_multiplexer():
    builder = DiagramBuilder()
    ports = AddHumans(builder, make_walkers(1), num_robots=2)
    robots = builder.AddSystem(Multiplexer([7, 7]))
    for i in range(2):
        source = builder.AddSystem(ConstantVectorSource(ROBOT))
        builder.Connect(source.get_output_port(), robots.get_input_port(i))
    builder.Connect(robots.get_output_port(), ports.robot_states)
    Simulator(builder.Build()).AdvanceTo(0.2)


def test_a_world_will_do_for_obstacles():
    world = World(walls=[Polyline(points=[[-9, -0.5], [9, -0.5]])])
    expected = run_humans(
        make_walkers(1), num_robots=0, obstacles=world.obstacles()
    )
    result = run_humans(make_walkers(1), num_robots=0, obstacles=world)
    for one, other in zip(result, expected, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"num_robots": 1.5}, "num_robots must be a whole number, got float"),
        ({"num_robots": True}, "num_robots must be a whole number, got bool"),
        ({"time_step": "0.05"}, "time_step must be a number, got str"),
        ({"config": {"model": "orca"}}, "config must be a CrowdConfig, got"),
        ({"obstacles": [[0, 0]]}, "must be Obstacles or a World, got list"),
        ({"humans": [{"pose": [0, 0, 0]}]}, r"humans\[0\] must be a HumanConf"),
        ({"humans": 3}, "humans must be a sequence, got int"),
        ({"may_leave": "no"}, "may_leave must be True or False, got 'no'"),
        ({"separate_trees": 1}, "separate_trees must be True or False, got 1"),
        ({"places": ["till"]}, r"places\[0\] must be a Place, got str 'till'"),
    ],
)
def test_arguments_of_another_kind_are_told(kwargs, message):
    with pytest.raises(TypeError, match=message):
        MakeHumans(**{"humans": make_walkers(1), **kwargs})


@pytest.mark.parametrize("seed", [-1, 1.5, 2**70])
def test_a_seed_out_of_range_is_told(seed):
    with pytest.raises(ValueError, match=r"seed must be a whole number in"):
        MakeHumans(make_walkers(1), seed=seed)


@pytest.mark.parametrize("separate_trees", [True, False])
@pytest.mark.parametrize("behavior", BEHAVIORS)
def test_people_without_robots_walk_to_their_goals(behavior, separate_trees):
    humans = [
        HumanConfig(pose=[0, y, 0], goals=[[9, y]], behavior=behavior)
        for y in (0, 2)
    ]
    states, status, _ = run_humans(
        humans, num_robots=0, separate_trees=separate_trees
    )
    assert (states.reshape(2, 7)[:, 0] > 2).all()
    assert not status.any()


@pytest.mark.parametrize(
    ("people", "message"),
    [
        ([{"id": 1}, {"id": 1}], "two people have the number 1"),
        ([{"name": "a"}, {"name": "a"}], "two people have the name 'a'"),
        ([{"max_speed": 0.5}], r"max_speed must be at least the .*1\.2 m/s"),
    ],
)
def test_people_who_are_mixed_up_are_refused(people, message):
    humans = [HumanConfig(pose=[0, i, 0], **p) for i, p in enumerate(people)]
    with pytest.raises(ValueError, match=message):
        AddHumans(DiagramBuilder(), humans)
    with pytest.raises(ValueError, match=message):
        AgentServices(humans)


def test_numbers_are_given_out_without_those_taken():
    """Two people never draw the same weights."""
    mode = {"pose": [0, 0, 0], "forces_mode": "random_normal"}
    first, second = draw_weights(
        [HumanConfig(id=2, **mode), HumanConfig(**mode)], 0
    )
    assert (first[[K_GOAL, K_OBSTACLE]] != second[[K_GOAL, K_OBSTACLE]]).all()
    (one,) = draw_weights([HumanConfig(id=1, **mode)], 0)
    np.testing.assert_array_equal(second, one)


# What a tree with this in it remembers at first: the index of the goal, which
# is 0, and the number of the person.
WITH_NUMBER = """
<root BTCPP_format="4"><BehaviorTree ID="Main">
  <SetBlackboard output_key="number" value="{id}"/>
</BehaviorTree></root>
"""
# Who has no number has the first that is free, 2, and not that of the place.
SOME_NUMBERS = [
    HumanConfig(pose=[0, 0, 0], behavior=WITH_NUMBER),
    HumanConfig(pose=[0, 2, 0], behavior=WITH_NUMBER, id=1),
]


def test_all_trees_know_the_same_numbers():
    diagram = MakeHumans(SOME_NUMBERS, separate_trees=True)
    root = diagram.CreateDefaultContext()
    for name, number in [("behavior_0", 2), ("behavior_1", 1)]:
        tree = diagram.GetSubsystemByName(name)
        own = tree.GetMyContextFromRoot(root)
        assert max(own.get_discrete_state(0).value()) == number
    diagram = MakeHumans(SOME_NUMBERS, separate_trees=False)
    system = diagram.GetSubsystemByName("behaviors")
    own = system.GetMyContextFromRoot(diagram.CreateDefaultContext())
    assert [max(system.GetMemory(own, i)) for i in range(2)] == [2, 1]


def test_a_system_alone_gives_numbers_as_everybody_does():
    trees = [LoadBehavior(WITH_NUMBER)] * 2
    dut = BehaviorTree(trees, SOME_NUMBERS)
    context = dut.CreateDefaultContext()
    assert [max(dut.GetMemory(context, i)) for i in range(2)] == [2, 1]


def test_services_and_evaluator_know_the_numbers_of_the_trees():
    services = AgentServices(SOME_NUMBERS)
    services.reset_agents(robot=ROBOT)
    for number, y in [(2, 0.0), (1, 2.0)]:
        agent = services.compute_agent(number)
        assert agent.states[1] == pytest.approx(y, abs=0.1)
    dut = Evaluator(SOME_NUMBERS)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("robot_state").FixValue(context, ROBOT)
    dut.GetInputPort("human_states").FixValue(context, np.ones(14))
    recording = dut.GetRecording(context)
    assert recording.human_ids == (2, 1)
    assert recording.human_names == ("human_1", "human_2")


@pytest.mark.parametrize(
    ("count", "option", "systems"),
    [(10, None, 10), (11, None, 1), (11, True, 11), (2, False, 1)],
)
def test_crowd_chooses_how_many_systems_tick_the_trees(count, option, systems):
    config = CrowdConfig(separate_trees=option)
    diagram = MakeHumans(make_walkers(count), config=config)
    names = {system.get_name() for system in diagram.GetSystems()}
    separate = {f"behavior_{i}" for i in range(count)}
    assert len(names & {"behaviors", *separate}) == systems
    assert ("behaviors" in names) == (systems == 1)
