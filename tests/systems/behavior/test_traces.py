"""The behaviors against recorded runs of HuNavSim, step by step.

Each step starts from the recorded state of the step before, but the trees keep
their own memory: goals, timers. Where this package decides otherwise than
HuNavSim, the comparison leaves out or undoes exactly that decision:

=====================  ====================  ================================
decision               in the traces         here
=====================  ====================  ================================
a reached goal costs   the step in which     positions of that person in that
no step of standing    the goal changes      step are not compared
people react as they   as they do            ports have HuNavSim's values, and
should                                       the threatening its action
the curious keep to    1.8 d/10 m/s, above   positions are not compared while
their maximum          their maximum         1.8 d/10 is above the maximum
the threatening get    beside it: sine and   the robot is given the heading
in front of the robot  cosine are swapped    pi/2 - yaw, which swaps them
standing people have   the last one          velocities of standing people are
no velocity                                  not compared
people turn at a       at once; 0.0314 rad   yaws are compared of people who
limited rate           a step if surprised   do not turn to the robot
the threatening turn   within 1.2 m after    yaws of theirs are not compared
within 1.2 m of it     the step
as the step begins
everybody moves from   one after the other   people who react see those before
one snapshot                                 them, in the order of the trace,
                                             where these are after the step
=====================  ====================  ================================
"""

import itertools
import json
import math

import numpy as np
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Multiplexer
import pytest

from hunav_drake.systems.behavior import BehaviorTree, LoadBehavior, LoadTree
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.recorded import read_recorded, recorded_names, single
from tests.systems.behavior.ticks import WALK, as_original
from tests.systems.crowd.crowds import FREE

TRACES = recorded_names("crowd")
NAMES = [
    "",
    "regular",
    "impassive",
    "surprised",
    "scared",
    "curious",
    "threatening",
]
CURIOUS, THREATENING = 5, 6

# Columns of the recorded agents.
STATUS, GOAL = 7, 8


def load_tree(number, **changed):
    """Returns our tree of a behavior, with the numbers of HuNavSim."""
    return LoadBehavior(as_original(NAMES[number], **changed))


def make_traced_human(agent):
    return HumanConfig(
        pose=[agent["x"], agent["y"], agent["yaw"]],
        desired_speed=single(agent["desired_velocity"]),
        radius=single(agent["radius"]),
        goals=agent["goals"],
        goal_radius=single(agent["goal_radius"]),
        cyclic=agent["cyclic_goals"],
        group_id=agent["group_id"],
        forces=SocialForceParameters(epsilon=0.0),
    )


class Replay:
    """A crowd with its trees, put into recorded states."""

    def __init__(self, scenario, trees):
        agents = scenario["agents"]
        humans = [make_traced_human(agent) for agent in agents]
        walls = scenario.get("obstacles") or {}
        time_step = scenario["dt"]
        builder = DiagramBuilder()
        self.crowd = builder.AddSystem(
            HumanCrowd(
                humans,
                obstacles=Obstacles.from_points(walls.get("points", [])),
                config=CrowdConfig(
                    **FREE,
                    obstacle_range=walls.get("max_dist", 1.0),
                    max_obstacles=walls.get("count", 0),
                    route_planning=False,
                ),
                time_step=time_step,
            )
        )
        builder.ExportInput(
            self.crowd.get_robot_states_input_port(), "robot_states"
        )
        self.trees = []
        commands = builder.AddSystem(Multiplexer([COMMAND_SIZE] * len(humans)))
        builder.Connect(
            commands.get_output_port(), self.crowd.get_commands_input_port()
        )
        for i, tree in enumerate(trees):
            system = builder.AddNamedSystem(
                f"tree_{i}",
                BehaviorTree([tree], humans, indices=[i], time_step=time_step),
            )
            builder.Connect(
                self.crowd.get_human_states_output_port(),
                system.get_human_states_input_port(),
            )
            builder.ConnectInput(
                "robot_states", system.get_robot_states_input_port()
            )
            builder.Connect(
                system.get_commands_output_port(), commands.get_input_port(i)
            )
            self.trees.append(system)
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()

    def put(self, robot, agents):
        """Puts the robot and the people where they were."""
        self.diagram.GetInputPort("robot_states").FixValue(self.context, robot)
        state = np.zeros((len(agents), 6))
        state[:, :5] = np.array(agents)[:, :5]
        self.crowd.GetMyMutableContextFromRoot(self.context).SetDiscreteState(
            0, state.ravel()
        )

    def commands(self):
        return np.array(
            [
                tree.get_commands_output_port().Eval(
                    tree.GetMyContextFromRoot(self.context)
                )
                for tree in self.trees
            ]
        )

    def statuses(self):
        return [
            int(
                tree.get_behavior_status_output_port().Eval(
                    tree.GetMyContextFromRoot(self.context)
                )[0]
            )
            for tree in self.trees
        ]

    def step(self):
        """Returns where the people are one step later, and what trees know."""
        values = self.diagram.EvalUniquePeriodicDiscreteUpdate(self.context)
        moved = values.get_vector(0).value().reshape(-1, 6).copy()
        return moved, [
            values.get_vector(2 + i).value().copy()
            for i in range(len(self.trees))
        ]

    def remember(self, memories):
        for tree, memory in zip(self.trees, memories, strict=True):
            tree.GetMyMutableContextFromRoot(self.context).SetDiscreteState(
                memory
            )


def replay(case, trees):
    """Compares a trace; returns what was active, recorded and here.

    Returns:
        Both of shape (steps, n), and the number of compared positions.
    """
    scenario, trace = case["scenario"], case["trace"]
    agents = scenario["agents"]
    dut = Replay(scenario, trees)
    ids = trace["ids"]
    rank = [trace["tick_order"].index(i) for i in ids]
    recorded, active = [], []
    compared = 0
    for before, after in itertools.pairwise(trace["steps"]):
        start, end = np.array(before["agents"]), np.array(after["agents"])
        x, y, yaw, *velocity = after["robot"]
        robot = [x, y, math.pi / 2 - yaw, *velocity]
        robot.append(single(scenario["robot"]["radius"]))
        dut.put(robot, start)
        command = dut.commands()
        active.append(dut.statuses())
        recorded.append(end[:, STATUS].astype(int).tolist())
        moved, memories = dut.step()
        for i, agent in enumerate(agents):
            if start[i, GOAL] != end[i, GOAL]:
                continue
            if active[-1][i] != recorded[-1][i]:
                continue
            if active[-1][i] and agent["behavior"] == CURIOUS:
                distance = math.hypot(x - start[i, 0], y - start[i, 1])
                if 1.8 * distance / 10 > single(agent["desired_velocity"]):
                    continue
            row = moved[i]
            if active[-1][i] and len(agents) > 1:
                seen = [
                    end[j] if rank[j] < rank[i] else start[j]
                    for j in range(len(agents))
                ]
                dut.put(robot, seen)
                row = dut.step()[0][i]
            np.testing.assert_allclose(row[:2], end[i, :2], atol=1e-6, rtol=0)
            compared += 1
            if not command[i, Command.HOLD]:
                np.testing.assert_allclose(
                    row[3:5], end[i, 3:5], atol=1e-5, rtol=0
                )
            turns = active[-1][i] and agent["behavior"] == THREATENING
            if not command[i, Command.TURN_RATE] and not turns:
                np.testing.assert_allclose(
                    np.exp(1j * row[2]), np.exp(1j * end[i, 2]), atol=1e-5
                )
        dut.remember(memories)
    return np.array(recorded), np.array(active), compared


@pytest.mark.slow
@pytest.mark.parametrize("name", TRACES)
def test_every_step_is_that_of_the_original(name):
    case = json.loads(read_recorded(name))
    agents = case["scenario"]["agents"]
    recorded, active, compared = replay(
        case, [load_tree(agent["behavior"]) for agent in agents]
    )
    # Each flag is one that the trace has at most two ticks away, ...
    padded = np.pad(recorded, ((2, 2), (0, 0)), mode="edge")
    near = np.stack([padded[k : k + len(active)] for k in range(5)])
    assert (near == active).any(axis=0).all()
    # ... and nearly all are those of the same tick.
    assert (recorded != active).sum() <= 1
    assert compared >= 0.97 * active.size
    for i, agent in enumerate(agents):
        expected = ACTIVE_TICKS.get((name, agent["behavior"]))
        assert expected is None or active[:, i].sum() == expected


# The duration of a timer of 30 s or 40 s in steps of 0.05 s.
ACTIVE_TICKS = {
    ("crowd/12_curious_pass", 5): 599,
    ("crowd/19_curious_timer30", 5): 599,
    ("crowd/32_mix6", 3): 599,
    ("crowd/32_mix6", 5): 599,
    ("crowd/32_mix6", 6): 800,
}

# The tree of a reaction in the form of HuNavSim's files.
CLASSIC = """
<root main_tree_to_execute = "Reaction">
  <TreeNodesModel>
    <Action ID="{node}">
      <input_port name="agent_id" type="int">who it is</input_port>
      <Action ID="SaySomething">

      </Action>
    </Action>
    <Condition ID="IsRobotVisible">
      <input_port name="agent_id" type="int">who it is</input_port>
    </Condition>
  </TreeNodesModel>
  <include path="walk.xml"/>
  <BehaviorTree ID="Reaction">
    <Fallback name="Either">
      <Sequence name="React"> <!-- it begins anew each time -->
        <IsRobotVisible agent_id="{{id}}" distance="{distance}" />
        {open}
        <Inverter>
          <TimeExpiredCondition seconds="{seconds}" ts="{{dt}}"
            only_once="{once}" />
        </Inverter>
        <{node} agent_id="{{id}}" time_step="{{dt}}" />
        {close}
      </Sequence>
      <Sequence name="Walk">
        <SetBlackboard output_key="number" value="{{id}}" />
        <SetBlackboard output_key="step" value="{{dt}}" />
        <SubTree ID="WalkTree" id="number" dt="step" />
      </Sequence>
    </Fallback>
  </BehaviorTree>
</root>
"""
NUMBERS = {
    "surprised": (4.0, 30.0, "True"),
    "scared": (3.0, 40.0, "False"),
    "curious": (10.0, 30.0, "True"),
    "threatening": (4.0, 40.0, "True"),
}


def classic_tree(number, folder):
    name = NAMES[number]
    (folder / "walk.xml").write_text(WALK)
    if name == "regular":
        return LoadTree(folder / "walk.xml")
    if name == "impassive":
        return load_tree(number)
    distance, seconds, once = NUMBERS[name]
    nested = number == THREATENING
    path = folder / f"{name}.xml"
    path.write_text(
        CLASSIC.format(
            node=f"{name.capitalize()}Nav",
            distance=distance,
            seconds=seconds,
            once=once,
            open='<Sequence name="Timed">' if nested else "",
            close="</Sequence>" if nested else "",
        )
    )
    return LoadTree(path)


@pytest.mark.slow
@pytest.mark.parametrize("name", TRACES)
def test_trees_in_the_form_of_the_original_tick_as_ours_do(tmp_path, name):
    case = json.loads(read_recorded(name))
    scenario = case["scenario"]
    numbers = [agent["behavior"] for agent in scenario["agents"]]
    # (Its own trees ignore the robot elsewhere; the leaves need not.)
    ours = Replay(
        scenario, [load_tree(n, ignore_robot_when_idle=False) for n in numbers]
    )
    theirs = Replay(scenario, [classic_tree(n, tmp_path) for n in numbers])
    radius = single(scenario["robot"]["radius"])
    for before, after in itertools.pairwise(case["trace"]["steps"]):
        for dut in (ours, theirs):
            dut.put([*after["robot"], radius], before["agents"])
        np.testing.assert_array_equal(ours.commands(), theirs.commands())
        assert ours.statuses() == theirs.statuses()
        for dut in (ours, theirs):
            dut.remember(dut.step()[1])
