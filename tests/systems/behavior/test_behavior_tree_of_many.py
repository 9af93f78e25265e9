"""One system for many trees does what as many systems do, bit for bit."""

import dataclasses
import math

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.behavior import BEHAVIORS, BehaviorTree, LoadTree
from tests.walkers import make_walkers

ROBOT = [2.0, 0.5, 0.0, -0.3, 0.0, 0.0, 0.3]


def make_mixed_humans(n):
    """Every other one is impassive."""
    behaviors = ("regular", "impassive")
    return [
        dataclasses.replace(
            human, name=f"p{i}", id=i + 1, behavior=behaviors[i % 2]
        )
        for i, human in enumerate(make_walkers(n, xs=(3.0, 0.0), spacing=1.5))
    ]


def make_people_with_trees(n, *, separate_trees, num_robots=1):
    builder = DiagramBuilder()
    ports = AddHumans(
        builder,
        make_mixed_humans(n),
        num_robots=num_robots,
        separate_trees=separate_trees,
    )
    if num_robots:
        robot = builder.AddSystem(ConstantVectorSource(ROBOT * num_robots))
        builder.Connect(robot.get_output_port(), ports.robot_states)
    for name in ("human_states", "behavior_status"):
        builder.ExportOutput(getattr(ports, name), name)
    return builder.Build()


def run_people(diagram, time=8.0, context=None):
    simulator = Simulator(diagram, context or diagram.CreateDefaultContext())
    simulator.AdvanceTo(time)
    context = simulator.get_context()
    return np.concatenate(
        [
            diagram.GetOutputPort(name).Eval(context)
            for name in ("human_states", "behavior_status")
        ]
    )


@pytest.mark.parametrize("n", [0, 1, 5])
@pytest.mark.parametrize("num_robots", [0, 1, 2])
def test_people_walk_bit_for_bit_as_with_systems_of_their_own(n, num_robots):
    results = [
        run_people(
            make_people_with_trees(
                n, separate_trees=separate, num_robots=num_robots
            )
        )
        for separate in (True, False)
    ]
    np.testing.assert_array_equal(*results)


def test_the_trees_of_many_people_are_one_system_unless_told_otherwise():
    for n, separate, one in [(10, None, 0), (11, None, 1), (11, True, 0)]:
        humans = make_people_with_trees(
            n, separate_trees=separate
        ).GetSubsystemByName("humans")
        names = [system.get_name() for system in humans.GetSystems()]
        assert ("behaviors" in names) == bool(one)
        assert ("behavior_0" in names) != bool(one)


def test_two_contexts_do_not_disturb_each_other_and_a_clone_goes_on_alike():
    diagram = make_people_with_trees(4, separate_trees=False)
    alone = run_people(diagram)
    context = diagram.CreateDefaultContext()
    run_people(diagram, 3.0, context)
    clone = context.Clone()
    run_people(diagram, 5.0, diagram.CreateDefaultContext())
    run_people(diagram, 6.0, context)
    np.testing.assert_array_equal(run_people(diagram, 8.0, clone), alone)


def test_ports_have_getters():
    trees = [LoadTree("regular")] * 2
    dut = BehaviorTree(trees, make_mixed_humans(2), num_robots=3)
    assert dut.get_human_states_input_port().size() == 14
    assert dut.get_robot_states_input_port().size() == 21
    assert dut.get_commands_output_port().size() == 24
    assert dut.get_behavior_status_output_port().size() == 2
    nodes = len(trees[0].nodes)
    assert dut.get_node_status_output_port().size() == 2 * nodes
    assert dut.trees() == trees
    dut = BehaviorTree(trees, make_mixed_humans(2), num_robots=0)
    with pytest.raises(ValueError, match="made with num_robots=0"):
        dut.get_robot_states_input_port()


def test_bad_arguments_are_refused():
    tree = LoadTree("regular")
    with pytest.raises(ValueError, match="a tree for each of 2 people, got 1"):
        BehaviorTree([tree], make_mixed_humans(2))
    with pytest.raises(ValueError, match="time_step must be positive"):
        BehaviorTree([tree], make_mixed_humans(1), time_step=0.0)


def test_the_memory_of_one_can_be_put_into_another_context():
    trees = [LoadTree("regular"), LoadTree("surprised"), LoadTree("regular")]
    dut = BehaviorTree(trees, make_mixed_humans(3), num_robots=0)
    context = dut.CreateDefaultContext()
    first = [dut.GetMemory(context, i) for i in range(3)]
    thoughts = np.arange(len(first[1])) + 1.0
    dut.SetMemory(context, 1, thoughts)
    np.testing.assert_array_equal(dut.GetMemory(context, 1), thoughts)
    for i in (0, 2):
        np.testing.assert_array_equal(dut.GetMemory(context, i), first[i])
    # It is all that the state holds, and a copy.
    state = context.get_discrete_state(0).value()
    np.testing.assert_array_equal(
        state, np.concatenate([first[0], thoughts, first[2]])
    )
    dut.GetMemory(context, 1)[:] = 0
    np.testing.assert_array_equal(dut.GetMemory(context, 1), thoughts)


@pytest.mark.parametrize("behavior", BEHAVIORS)
def test_a_memory_can_be_put_where_there_are_no_robots(behavior):
    """A robot that one keeps in mind is forgotten there."""
    human = HumanConfig(pose=[0, 0, 0], goals=[[9, 0]])
    state = [0.0, 0, 0, 0.5, 0, 0, 0.3]
    robot = [2.0, 0, math.pi, -0.5, 0, 0, 0.3]
    tree = LoadTree(behavior)
    before = BehaviorTree([tree], [human], num_robots=2)
    after = BehaviorTree([tree], [human], num_robots=0)
    contexts = [dut.CreateDefaultContext() for dut in (before, after)]
    for dut, context in zip((before, after), contexts, strict=True):
        dut.get_human_states_input_port().FixValue(context, state)
    far = [80.0, *robot[1:]]
    before.get_robot_states_input_port().FixValue(contexts[0], far + robot)
    for _ in range(3):
        updated = before.EvalUniquePeriodicDiscreteUpdate(contexts[0])
        contexts[0].SetDiscreteState(updated)
    after.SetMemory(contexts[1], 0, before.GetMemory(contexts[0], 0))
    status = after.get_behavior_status_output_port()
    for _ in range(3):
        assert status.Eval(contexts[1]) == 0
        updated = after.EvalUniquePeriodicDiscreteUpdate(contexts[1])
        contexts[1].SetDiscreteState(updated)


def test_the_memory_of_another_tree_is_refused():
    dut = BehaviorTree([LoadTree("regular")], make_mixed_humans(1))
    context = dut.CreateDefaultContext()
    memory = dut.GetMemory(context, 0)
    for index in (-1, 0.5, 99):
        memory[0] = index
        with pytest.raises(ValueError, match="must be a whole number in"):
            dut.SetMemory(context, 0, memory)
    with pytest.raises(ValueError, match=r"memory of humans\[0\] has shape"):
        dut.SetMemory(context, 0, np.zeros(99))
    for index in (1, -1):
        with pytest.raises(IndexError, match=rf"not tick humans\[{index}\]"):
            dut.GetMemory(context, index)


def test_some_of_the_people_are_ticked_as_among_all():
    humans = make_mixed_humans(4)
    trees = [LoadTree("regular"), LoadTree("surprised")]
    rows = np.arange(28.0)
    results = []
    for indices in ([0, 1, 2, 3], [3, 1]):
        dut = BehaviorTree(
            [trees[i % 2] for i in indices], humans, indices=indices
        )
        context = dut.CreateDefaultContext()
        dut.get_human_states_input_port().FixValue(context, rows)
        dut.get_robot_states_input_port().FixValue(context, ROBOT)
        commands = dut.get_commands_output_port().Eval(context)
        results.append(
            [
                (
                    commands.reshape(-1, 12)[indices.index(i)].tolist(),
                    dut.EvalNodeStatus(context, i).tolist(),
                    dut.GetMemory(context, i).tolist(),
                )
                for i in (3, 1)
            ]
        )
    assert results[0] == results[1]
    assert len(results[0][0][1]) == len(trees[1].nodes)
    with pytest.raises(IndexError, match=r"not tick humans\[0\], only \[1, 3"):
        dut.EvalNodeStatus(context, 0)
