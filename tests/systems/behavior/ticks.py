"""People, robots and small trees for tests that tick."""

import re

import numpy as np

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    BehaviorConfig,
    ParseTree,
    Person,
)
from hunav_drake.systems.common.layout import Command
from hunav_drake.systems.people.human_config import HumanConfig

# The tree of the regular behavior in the form of HuNavSim's files.
WALK = """
<root main_tree_to_execute = "WalkTree">
    <BehaviorTree ID="WalkTree">
        <Fallback>
            <Sequence>
                <Inverter><IsGoalReached agent_id="{id}" /></Inverter>
                <RegularNav agent_id="{id}" time_step="{dt}" />
            </Sequence>
            <UpdateGoal agent_id="{id}" />
        </Fallback>
    </BehaviorTree>
</root>
"""

# The values of ports in HuNavSim.
ORIGINAL = {
    "memory": 0.0,
    "track": False,
    "hysteresis": 0.0,
    "ignore_robot_when_idle": True,
    "deceleration": 0.0,
    "own_maximum": False,
    "push": 20.0,
    "make_way": False,
    "near": 0.0,
    "wait_time": 1e9,
}


def as_original(name, **changed):
    """Returns one of our behaviors with the numbers of HuNavSim.

    For the threatening that is another action, too.
    """
    source = BEHAVIORS[name].read_text()
    if name == "threatening":
        source = re.sub(r"<BlockRobot[^>]*/>", "<ThreateningNav/>", source)
    ports = {
        port: value
        for port, value in (ORIGINAL | changed).items()
        if f'<input_port name="{port}"' in source
    }
    return BehaviorConfig(type=source, ports=ports)


def at(x, y, yaw=0.0, vx=0.0, vy=0.0):
    """Returns the state of a person or a robot."""
    return np.array([x, y, yaw, vx, vy, 0.0, 0.35])


def person(*, index=0, time_step=0.05, obstacles=None, **kwargs):
    """Returns a person at the origin, with attributes of a HumanConfig."""
    human = HumanConfig(
        **({"pose": (0.0, 0.0, 0.0), "goals": [(9.0, 0.0)]} | kwargs)
    )
    return Person.from_config(
        human, index, time_step=time_step, obstacles=obstacles
    )


def tree_of(xml):
    """Returns the tree of one node, with what is in it."""
    return ParseTree(f"<root><BehaviorTree>{xml}</BehaviorTree></root>")


def as_xml(tree, leaf):
    """Returns nested (tag, children) in XML.

    Args:
        tree: One of these, or the results of a leaf.
        leaf: The tag of all leaves.
    """
    if isinstance(tree, str):
        return f'<{leaf} results="{tree}"/>'
    tag, children = tree
    return f"<{tag}>{''.join(as_xml(c, leaf) for c in children)}</{tag}>"


PERSON = person(
    goals=[(5.0, 0.0), (9.0, 0.0)], id=7, time_step=0.1, needs={"rest": {}}
)
ME = at(0.0, 0.0)
ROBOT = at(2.0, 0.0)
NO_ROBOT = np.zeros(0)


def tick(tree, who=None, human=None, robot=NO_ROBOT, memory=None):
    """Returns the outcome of a tick, by default of a person all alone."""
    who = who or person()
    human = ME if human is None else human
    memory = tree.initial_memory(who) if memory is None else memory
    return tree.tick(who, memory, human, robot)


def tick_near(tree, memory=None, robot=ROBOT):
    """Returns the outcome of a tick of `PERSON`, by default near a robot."""
    return tick(tree, PERSON, ME, robot, memory)


def wish(outcome):
    """Returns the command of an outcome, by its elements."""
    return dict(zip(Command, outcome.command, strict=True))


def traces(tree, count, memory=None):
    """Yields the outcome of each tick, and what each node said in it."""
    memory = tree.initial_memory(PERSON) if memory is None else memory
    for _ in range(count):
        outcome, statuses = tree.trace(PERSON, memory, ME, ME)
        assert tree.tick(PERSON, memory, ME, ME) == outcome
        memory = outcome.memory
        yield outcome, statuses


def all_discrete_state(context):
    """Returns the values of all discrete states of a Context in one array."""
    groups = context.num_discrete_state_groups()
    return np.concatenate(
        [context.get_discrete_state(i).value() for i in range(groups)]
    )
