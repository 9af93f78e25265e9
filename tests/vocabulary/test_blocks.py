"""The blocks of HuNavSim's wizard, in a tree that walks from goal to goal."""

import math
from pathlib import Path

import numpy as np
import pytest

from hunav_drake.systems import behavior
from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.people.places import Place
from tests.vocabulary.stage import STAND, WALK, Stage, robot_at, someone

BLOCKS = sorted(
    (Path(behavior.__file__).parent / "blocks").glob("*.xml"),
    key=lambda it: it.stem,
)
# Of each, its tree, values of its ports, and the node that it is for.
USES = {
    "attention": ("Attention", "", "SaySomething"),
    "blocking": ("Blocking", "", "BlockRobot"),
    "chat": ("Chat", 'probability="1"', "Converse"),
    "engage_robot": ("EngageRobot", 'duration="3"', "ApproachRobot"),
    "follow_agent": ("FollowNearest", "", "FollowAgent"),
    "greeting": ("Greeting", "", "SaySomething"),
    "group_formation": ("GroupFormation", "", "SetGroupWalk"),
    "guardian": ("Guardian", 'agent_id="2"', "BlockRobot"),
    "random_goals": (
        "RandomGoals",
        'period="1" kind="counter"',
        "SetRandomGoal",
    ),
    "robot_avoidance": ("RobotAvoidance", "", "StandStill"),
    "speech_detection": (
        "SpeechDetection",
        'duration="3"',
        "ConversationFormation",
    ),
    "stop_and_look": ("StopAndLook", "", "StandStill"),
    "talk_interact": ("TalkInteract", 'duration="3"', "ConversationFormation"),
}


def test_each_block_is_tried():
    assert [it.stem for it in BLOCKS] == [*USES]


@pytest.mark.slow
@pytest.mark.parametrize("name", USES)
def test_a_block_does_what_it_is_for_and_then_people_walk_on(name):
    tree, ports, node = USES[name]
    used = f'<SubTree ID="{tree}Tree" {ports}/>'
    speaks = '<SaySomething message="over here"/>'
    looks = '<LookAtAgent target_id="1" walk="true"/>'
    others = (
        f"<ForceFailure><Sequence>{looks}{speaks}</Sequence></ForceFailure>"
    )
    stage = Stage(
        [
            someone(0, 0, 0.3, used, goals=[(12, 3)]),
            someone(2.5, 2, math.pi, others, rest=WALK),
        ],
        robot=robot_at(4.5, 0, math.pi, 0.15),
        places=[Place(name="till", type="counter", pose=(12, 3, 0))],
    )
    found = []
    for _ in stage.run(30.0):
        assert np.isfinite(stage.states).all()
        found.append(stage.statuses(0)[node])
    assert {NodeStatus.RUNNING, NodeStatus.SUCCESS} & {*found}
    if name not in ("blocking", "follow_agent", "guardian", "robot_avoidance"):
        for _ in stage.run(20.0):
            pass
        assert math.dist(stage.states[0, :2], (12, 3)) < 0.6


def test_a_block_has_a_document_for_its_ports():
    with pytest.raises(ValueError, match="agent_id must be given"):
        Stage([someone(0, 0, 0, '<SubTree ID="GuardianTree"/>', STAND)])
