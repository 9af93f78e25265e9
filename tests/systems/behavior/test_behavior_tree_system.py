import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer
import pytest

from hunav_drake.systems.behavior import BehaviorTree, LoadTree, ParseTree
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd.human_crowd import HumanCrowd
from hunav_drake.systems.people.human_config import HumanConfig
from tests.systems.behavior.ticks import all_discrete_state

# Sees the robot for half a second, then walks on. A tick lasts 0.1 s here.
SHY = ParseTree("""
<root BTCPP_format="4"><BehaviorTree ID="Shy"><Fallback>
  <Sequence>
    <IsRobotVisible distance="3"/>
    <Inverter><TimeExpiredCondition seconds="0.5" only_once="true"/></Inverter>
    <RegularNav robot="unseen"/>
  </Sequence>
  <Sequence>
    <ForceSuccess>
      <Sequence><IsGoalReached/><UpdateGoal/></Sequence>
    </ForceSuccess>
    <RegularNav/>
  </Sequence>
</Fallback></BehaviorTree></root>
""")
HUMAN = HumanConfig(
    pose=(0.0, 0.0, 0.0), goals=[(1.0, 0.0), (4.0, 0.0)], cyclic=True
)
FAR = [50.0, 0, 0, 0, 0, 0, 0.35]
NEAR = [2.0, 0, 0, 0, 0, 0, 0.35]


def row(x, y=0.0):
    return [x, y, 0, 0, 0, 0, 0.35]


@pytest.fixture
def dut():
    return BehaviorTree([SHY], [HUMAN] * 2, indices=[1], time_step=0.1)


def fix(dut, context, x, robot=FAR):
    dut.get_human_states_input_port().FixValue(context, row(9.0) + row(x))
    dut.get_robot_states_input_port().FixValue(context, robot)


def command(dut, context):
    return dut.get_commands_output_port().Eval(context)


def behavior_status(dut, context):
    return dut.get_behavior_status_output_port().Eval(context)


def memory(context):
    return context.get_discrete_state(0).value().copy()


def test_ports_have_the_shared_layout(dut):
    assert dut.get_human_states_input_port().size() == 14
    assert dut.get_human_states_input_port().get_name() == "human_states"
    assert dut.get_robot_states_input_port().size() == 7
    assert dut.get_robot_states_input_port().get_name() == "robot_states"
    assert dut.get_commands_output_port().size() == COMMAND_SIZE
    assert dut.get_commands_output_port().get_name() == "commands"
    assert dut.get_behavior_status_output_port().size() == 1
    assert dut.get_behavior_status_output_port().get_name() == "behavior_status"
    assert dut.trees() == [SHY]


def test_command_belongs_to_the_present_instant(dut):
    """Changing any input changes the command, with no update between."""
    context = dut.CreateDefaultContext()
    fix(dut, context, 0.0)
    assert command(dut, context)[Command.GOAL_X] == 1.0
    fix(dut, context, 1.0)
    assert command(dut, context)[Command.GOAL_X] == 4.0
    assert command(dut, context)[Command.ROBOT_ROLE] == RobotRole.PEDESTRIAN
    fix(dut, context, 1.0, NEAR)
    assert command(dut, context)[Command.ROBOT_ROLE] == RobotRole.UNSEEN
    fix(dut, context, 0.0)
    assert command(dut, context)[Command.GOAL_X] == 1.0
    state = memory(context)
    state[0] = 1
    context.SetDiscreteState(state)
    assert command(dut, context)[Command.GOAL_X] == 4.0
    assert behavior_status(dut, context) == [0]


def test_command_does_not_change_while_the_state_is_held(dut):
    context = dut.CreateDefaultContext()
    fix(dut, context, 1.0)
    before = command(dut, context)
    context.SetTime(3.0)
    np.testing.assert_array_equal(command(dut, context), before)


def test_each_output_depends_on_each_input(dut):
    for output in range(dut.num_output_ports()):
        for entry in range(dut.num_input_ports()):
            assert dut.HasDirectFeedthrough(entry, output)


def test_looking_does_not_tick(dut):
    context = dut.CreateDefaultContext()
    fix(dut, context, 0.0, NEAR)
    before = memory(context)
    for _ in range(3):
        command(dut, context)
        behavior_status(dut, context)
    np.testing.assert_array_equal(memory(context), before)


def test_each_step_is_one_tick(dut):
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix(dut, context, 0.0, NEAR)
    seconds = SHY.slots.index("TimeExpiredCondition: seconds")
    for step in range(4):
        simulator.AdvanceTo(0.1 * step + 0.05)
        assert memory(context)[seconds] == pytest.approx(0.1 * (step + 1))


@pytest.mark.usefixtures("node_types")
def test_behavior_status_is_that_of_the_same_tick():
    from hunav_drake.systems.behavior import register_action

    @register_action("React")
    def react(context):
        context.behavior_status = 1

    tree = ParseTree(
        "<root><BehaviorTree><Sequence>"
        '<IsRobotVisible distance="3"/><React/></Sequence>'
        "</BehaviorTree></root>"
    )
    dut = BehaviorTree([tree], [HUMAN] * 2, indices=[1])
    context = dut.CreateDefaultContext()
    fix(dut, context, 0.0, FAR)
    assert behavior_status(dut, context) == [0]
    fix(dut, context, 0.0, NEAR)
    assert behavior_status(dut, context) == [1]


def test_state_lives_in_the_context(dut):
    """Two contexts of one system do not disturb each other."""
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    fix(dut, context, 1.0)
    before = context.Clone()
    simulator.AdvanceTo(0.05)
    assert memory(context)[0] == 1
    assert memory(before)[0] == 0
    fix(dut, before, 0.0)
    assert command(dut, before)[Command.GOAL_X] == 1.0
    assert command(dut, context)[Command.GOAL_X] == 4.0


def test_people_can_share_a_tree():
    other = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(7.0, 7.0)])
    first, second = (
        BehaviorTree([SHY], [HUMAN, other], indices=[i]) for i in range(2)
    )
    for dut, goal in ((first, 1.0), (second, 7.0)):
        context = dut.CreateDefaultContext()
        dut.get_human_states_input_port().FixValue(context, row(0) + row(0))
        dut.get_robot_states_input_port().FixValue(context, FAR)
        assert command(dut, context)[Command.GOAL_X] == goal


def test_without_robots_there_is_no_robot_port():
    dut = BehaviorTree([SHY], [HUMAN], num_robots=0)
    assert dut.num_input_ports() == 1
    context = dut.CreateDefaultContext()
    dut.get_human_states_input_port().FixValue(context, row(0.0))
    assert command(dut, context)[Command.ROBOT_ROLE] == RobotRole.PEDESTRIAN
    with pytest.raises(ValueError, match="num_robots=0"):
        dut.get_robot_states_input_port()


@pytest.mark.parametrize(
    ("kwargs", "words"),
    [
        ({"indices": [0, 2]}, r"in \[0, 2\), the number of people, got 2"),
        ({"indices": [-1, 0]}, r"in \[0, 2\)"),
        ({"indices": [1, 1]}, "must all be different"),
        ({"indices": [1]}, "a tree for each of 1 people, got 2"),
        ({"num_robots": -1}, "num_robots"),
        ({"time_step": 0.0}, "time_step"),
        ({"time_step": float("nan")}, "time_step"),
    ],
)
def test_impossible_arguments_are_refused(kwargs, words):
    with pytest.raises(ValueError, match=words):
        BehaviorTree([SHY, SHY], [HUMAN, HUMAN], **kwargs)


def make_crowd_with_trees(humans, trees, robot=FAR, time_step=0.05):
    """A crowd whose trees command it, beside a standing robot."""
    builder = DiagramBuilder()
    crowd = builder.AddNamedSystem(
        "crowd", HumanCrowd(humans, time_step=time_step)
    )
    source = builder.AddNamedSystem("robot", ConstantVectorSource(robot))
    builder.Connect(
        source.get_output_port(), crowd.get_robot_states_input_port()
    )
    commands = builder.AddSystem(Multiplexer([COMMAND_SIZE] * len(humans)))
    builder.Connect(commands.get_output_port(), crowd.get_commands_input_port())
    for i, tree in enumerate(trees):
        dut = builder.AddNamedSystem(
            f"tree_{i}",
            BehaviorTree([tree], humans, indices=[i], time_step=time_step),
        )
        builder.Connect(
            crowd.get_human_states_output_port(),
            dut.get_human_states_input_port(),
        )
        builder.Connect(
            source.get_output_port(), dut.get_robot_states_input_port()
        )
        builder.Connect(
            dut.get_commands_output_port(), commands.get_input_port(i)
        )
    return builder.Build()


def crowd_states(diagram, context):
    crowd = diagram.GetSubsystemByName("crowd")
    port = crowd.get_human_states_output_port()
    states = port.Eval(crowd.GetMyContextFromRoot(context))
    return states.reshape(-1, 7)


def goal_index(diagram, context, i=0):
    tree = diagram.GetSubsystemByName(f"tree_{i}")
    return tree.GetMyContextFromRoot(context).get_discrete_state(0).value()[0]


@pytest.mark.parametrize("name", ["regular", "impassive"])
def test_crowd_and_trees_walk_through_the_goals(name):
    human = HumanConfig(
        pose=(0.0, 0.0, 0.0), goals=[(1.0, 0.0), (1.0, 2.0)], max_speed=1.5
    )
    diagram = make_crowd_with_trees([human], [LoadTree(name)])
    simulator = Simulator(diagram)
    context = simulator.get_context()
    x_turn = None
    while context.get_time() < 10:
        simulator.AdvanceTo(context.get_time() + 0.05)
        if x_turn is None and goal_index(diagram, context) == 1:
            x_turn = crowd_states(diagram, context)[0, 0]
    # A step at 1.2 m/s is 6 cm; a goal is reached 40 cm before it.
    assert 0.6 <= x_turn < 0.6 + 2 * 0.061
    x, y, _, vx, vy, _, _ = crowd_states(diagram, context)[0]
    assert goal_index(diagram, context) == 2
    assert np.hypot(vx, vy) < 1e-6
    assert np.hypot(x - 1.0, y - 2.0) < 0.5


def test_only_goal_of_a_cycle_ends_in_standing():
    human = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(1.0, 0.0)], cyclic=True)
    diagram = make_crowd_with_trees([human], [LoadTree("regular")])
    simulator = Simulator(diagram)
    simulator.AdvanceTo(15.0)
    x, y, _, vx, vy, _, _ = crowd_states(diagram, simulator.get_context())[0]
    assert np.hypot(vx, vy) < 1e-6
    assert np.hypot(x - 1.0, y) <= human.goal_radius


def test_walker_does_not_stop_at_a_goal_on_the_way():
    human = HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(3.0, 0.0), (9.0, 0.0)])
    diagram = make_crowd_with_trees([human], [LoadTree("regular")])
    simulator = Simulator(diagram)
    simulator.AdvanceTo(2.0)
    speeds = []
    for step in range(40):
        simulator.AdvanceTo(2.0 + 0.05 * step)
        speeds.append(crowd_states(diagram, simulator.get_context())[0, 3])
    assert goal_index(diagram, simulator.get_context()) == 1
    assert np.all(np.diff(speeds) >= -1e-12)


def make_crossing(time_step=0.05):
    humans = [
        HumanConfig(
            pose=(0.0, 0.3 * i, 0.0),
            goals=[(2.0, 0.0), (0.0, 1.0)],
            cyclic=True,
        )
        for i in range(3)
    ]
    trees = [SHY, LoadTree("regular"), LoadTree("impassive")]
    return make_crowd_with_trees(humans, trees, NEAR, time_step)


@pytest.mark.parametrize("fork", [0.3, 1.0, 2.5])
def test_cloned_context_has_the_same_future(fork):
    diagram = make_crossing()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(fork)
    other = Simulator(diagram, simulator.get_context().Clone())
    simulator.AdvanceTo(4.0)
    other.AdvanceTo(4.0)
    np.testing.assert_array_equal(
        all_discrete_state(simulator.get_context()),
        all_discrete_state(other.get_context()),
    )


def test_saved_state_has_the_same_future():
    diagram = make_crossing()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.0)
    saved = simulator.get_context().Clone()
    simulator.AdvanceTo(3.0)
    expected = all_discrete_state(simulator.get_context())
    context = simulator.get_mutable_context()
    context.SetTimeStateAndParametersFrom(saved)
    simulator.Initialize()
    simulator.AdvanceTo(3.0)
    np.testing.assert_array_equal(
        all_discrete_state(simulator.get_context()), expected
    )


def test_two_simulations_of_one_diagram_do_not_disturb_each_other():
    diagram = make_crossing()
    alone = Simulator(diagram)
    alone.AdvanceTo(2.02)
    first, second = Simulator(diagram), Simulator(diagram)
    second.AdvanceTo(0.7)
    for step in range(21):
        first.AdvanceTo(0.1 * step + 0.02)
        second.AdvanceTo(0.1 * step + 0.72)
    np.testing.assert_array_equal(
        all_discrete_state(first.get_context()),
        all_discrete_state(alone.get_context()),
    )
