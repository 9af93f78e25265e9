"""A goal of many counts as reached where others stand on it."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake.systems.behavior import NodeStatus, ParseTree
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people import HumanConfig
from hunav_drake.trial.humans import MakeHumans
from tests.systems.behavior.ticks import NO_ROBOT, at, person

REACHED = "<root><BehaviorTree><IsGoalReached {}/></BehaviorTree></root>"


@pytest.mark.parametrize("seed", [0, 1])
def test_ten_people_with_one_goal_all_stand_around_it(seed):
    turns = np.random.default_rng(seed).uniform(0, 0.4, 10)
    angles = 2 * math.pi * np.arange(10) / 10 + turns
    people = [
        HumanConfig(
            pose=(5 * math.cos(a), 5 * math.sin(a), a + math.pi),
            goals=[(0.0, 0.0)],
        )
        for a in angles
    ]
    diagram = MakeHumans(people, num_robots=0)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(30.0)
    port = diagram.GetOutputPort("human_states")
    context = simulator.get_context()
    states = port.Eval(context).reshape(-1, 7)
    # The last one has nine others nearer: the radius, and 0.4 m times 3.
    assert np.hypot(states[:, 0], states[:, 1]).max() < 1.5
    # Nobody wants to get nearer. (They stand so close that some still shift.)
    crowd = diagram.GetSubsystemByName("crowd")
    commands = crowd.get_commands_input_port().Eval(
        crowd.GetMyContextFromRoot(context)
    )
    assert not commands.reshape(10, -1)[:, Command.HAS_GOAL].any()
    assert np.hypot(states[:, 3], states[:, 4]).max() < 0.3


CASES = {
    "stands on it": (at(0.0, 0.0), True),
    "walks over it": (at(0.0, 0.0, 0.0, 0.3), False),
    "stands behind": (at(1.6, 0.0), False),
    "stands too far off": (at(-0.4, 0.0), False),
}


@pytest.mark.parametrize("name", CASES)
def test_goal_counts_where_somebody_in_the_way_stands(name):
    other, expected = CASES[name]
    who = person(goals=[(0.0, 0.0)], goal_radius=0.3)
    states = np.concatenate([at(0.69, 0.0, math.pi, -0.1), other])
    for ports, holds in (("", expected), ('shared="false"', False)):
        tree = ParseTree(REACHED.format(ports))
        outcome = tree.tick(who, tree.initial_memory(who), states, NO_ROBOT)
        assert (outcome.node_status is NodeStatus.SUCCESS) == holds
