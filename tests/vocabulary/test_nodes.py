"""Each node of HuNavSim 2: its ports, its model for Groot, and its memory."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from hunav_drake.systems.behavior import (
    NODE_TYPES,
    NodeStatus,
    ParseTree,
    WriteTree,
)
from hunav_drake.systems.behavior.nodes.port import Meaning
from tests.vocabulary.fuzz import PLACES
from tests.vocabulary.stage import Stage, robot_at, someone, tree

CONDITIONS = (
    *("IsRobotVisible", "IsGoalReached", "TimeExpiredCondition"),
    *("IsAgentVisible", "RandomChanceCondition", "IsRobotFacingAgent"),
    *("IsRobotClose", "IsAgentClose", "IsAtPosition"),
)
# They may run, which conditions of BehaviorTree.CPP do not.
WAITING = (
    *("IsAnyoneSpeaking", "IsSpeaking", "IsAnyoneLookingAtMe"),
    "IsLookingAtMe",
)
ACTIONS = (
    *("UpdateGoal", "RegularNav", "SurprisedNav", "CuriousNav", "ScaredNav"),
    *("ThreateningNav", "FindNearestAgent", "SaySomething", "SetGroupId"),
    *("SetGoal", "StopMovement", "ResumeMovement", "StopAndWaitTimerAction"),
    *("ConversationFormation", "GoTo", "ApproachAgent", "FollowAgent"),
    *("ApproachRobot", "BlockRobot", "BlockAgent", "AvoidRobot"),
    *("SetGroupWalk", "LookAtAgent", "LookAtRobot", "LookAtPoint"),
)
NODES = (*CONDITIONS, *WAITING, *ACTIONS, "TimeDelay")


def value_of(port):
    """Returns a value for a port, as a text."""
    of = {
        Meaning.RESULT: "{who}",
        Meaning.PERSON: "2",
        Meaning.PEOPLE: "2",
        Meaning.PLACE: "p0",
        Meaning.DOOR: "door",
        Meaning.NEED: "thirst",
    }
    if port.meaning in of:
        return of[port.meaning]
    if port.choices:
        return port.choices[-1]
    return {bool: "true", int: "3", str: "over here"}.get(port.base, "0.5")


def element(name, *, all_ports):
    kind = NODE_TYPES[name]
    ports = "".join(
        f' {port}="{value_of(it)}"'
        for port, it in kind.ports.items()
        if all_ports or it.default is ...
    )
    child = "<AlwaysSuccess/>" if kind.children[1] else ""
    return f'<{name} name="it"{ports}>{child}</{name}>'


def test_01_there_are_38_nodes_and_a_delay():
    assert len({*NODES}) == 39
    assert {*NODES} <= NODE_TYPES.keys()


@pytest.mark.parametrize("name", NODES)
@pytest.mark.parametrize("all_ports", [False, True])
def test_01_a_node_loads_and_its_model_has_its_ports(name, all_ports):
    text = tree(element(name, all_ports=all_ports))
    root = ET.fromstring(WriteTree(ParseTree(text)))
    kind = NODE_TYPES[name]
    (model,) = root.findall(f"TreeNodesModel/*[@ID='{name}']")
    told = {it.get("name"): it for it in model}
    assert told.keys() >= kind.ports.keys()
    for port, it in kind.ports.items():
        given = told[port].get("default")
        assert (given is None) == (it.default is ... or it.output), port
    is_condition = name in CONDITIONS
    assert (model.tag == "Condition") == is_condition


@pytest.mark.slow
@pytest.mark.parametrize("name", NODES)
@pytest.mark.parametrize("all_ports", [False, True])
def test_01_a_node_runs_a_minute_and_forgets_when_it_is_halted(name, all_ports):
    """It is halted for one tick every 3 s."""
    node = element(name, all_ports=all_ports)
    nodes = (
        "<ForceFailure><ReactiveSequence>"
        '<Inverter><TimeExpiredCondition seconds="3"/></Inverter>'
        f"{node}</ReactiveSequence></ForceFailure>"
    )
    stage = Stage(
        [
            someone(0, 0, 0.3, nodes, goals=[(6, 3), (-6, 3)], cyclic=True),
            someone(2.5, 2, 3.1, goals=[(-4, -2), (4, 2)], cyclic=True),
        ],
        robot=robot_at(4.5, 0, 3.14, 0.2),
        places=PLACES,
    )
    system = stage.diagram.GetSubsystemByName("behavior_0")
    (program,) = system.trees()
    (own,) = [it for it in program.nodes if it.name == "it"]
    forgotten = {
        own.first + k: initial
        for k, (slot, initial) in enumerate(own.type.slots.items())
        if slot not in own.type.kept
    }
    halts = 0
    status, before = NodeStatus.IDLE, NodeStatus.IDLE
    for _ in stage.run(60.0):
        assert np.isfinite(stage.states).all()
        if status == NodeStatus.IDLE:
            halts += 1
            if before == NodeStatus.RUNNING:
                context = system.GetMyContextFromRoot(stage.context)
                memory = system.GetMemory(context, 0)
                assert {k: memory[k] for k in forgotten} == forgotten
        before, status = status, stage.statuses(0)["it"]
    assert halts >= 19
