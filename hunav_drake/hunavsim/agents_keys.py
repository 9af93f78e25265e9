"""The keys of HuNavSim's agents.yaml and metrics.yaml."""

from collections.abc import Iterator, Mapping
import math
from types import MappingProxyType
from typing import Any

from hunav_drake.hunavsim.reactions import REACTION_KEYS
from hunav_drake.systems.common.checks import is_multiple

# The behaviors by their numbers in HuNavSim.
BEHAVIOR_NAMES = {
    1: "regular",
    2: "impassive",
    3: "surprised",
    4: "scared",
    5: "curious",
    6: "threatening",
}

# The fields of HumanConfig by an agent's settings.
HUMAN_FIELDS = {
    "id": "id",
    "group_id": "group_id",
    "max_vel": "desired_speed",
    "radius": "radius",
    "goal_radius": "goal_radius",
    "cyclic_goals": "cyclic",
}
AGENT_KEYS = (*HUMAN_FIELDS, "behavior", "init_pose", "goals", "skin")

# HuNavSim's values of missing settings. (Its goal radius is 0, which is invalid
# here: with its margin, a goal is reached at 0.1 m.)
DEFAULTS: Mapping[str, Any] = MappingProxyType(
    {
        "group_id": -1,
        "max_vel": 1.0,
        "radius": 0.35,
        "goal_radius": 0.001,
        "cyclic_goals": True,
    }
)

# The fields of forces by the factors of a behavior, since HuNavSim 2.0.
FORCE_FIELDS = {
    "goal_force_factor": "goal_factor",
    "obstacle_force_factor": "obstacle_factor",
    "social_force_factor": "social_factor",
}

# The modes of these factors by their numbers in HuNavSim 2.0.
FORCES_MODES = {
    0: "default",
    1: "custom",
    2: "random_normal",
    3: "random_uniform",
}

# The reasons why settings of the evaluator are not imported.
METRICS_LEFT_OUT: Mapping[str, str] = MappingProxyType(
    {
        "result_file": "`hunav run --out DIR --format hunav` writes the files",
        "use_navgoal_to_start": "the robot of a scenario has its goal from the"
        " start; evaluator.start says when the recording begins",
    }
)
METRICS_KEYS = ("frequency", "experiment_tag", "metrics", *METRICS_LEFT_OUT)


def left_out_of_agent(
    agent: Mapping[str, Any],
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yields the path of each ignored setting of an agent, and the reason."""
    goals = agent.get("goals")
    if not isinstance(goals, list):
        goals = []
    names = [it for it in goals if isinstance(it, str)]
    for key, value in agent.items():
        if key == "skin":
            yield (key,), "the appearance of people depends on their order"
        elif key == "init_pose" and isinstance(value, dict):
            for part in sorted(value.keys() - {"x", "y", "h"}, key=str):
                yield (key, part), "people stand on the floor"
        elif key == "behavior" and isinstance(value, dict):
            known = {"type", "configuration", *FORCE_FIELDS, *REACTION_KEYS}
            for part in value:
                if part not in known:
                    yield (key, part), "set ports of the behavior instead"
        elif key in names and isinstance(value, dict):
            for part in sorted(value.keys() - {"x", "y"}, key=str):
                yield (key, part), "a goal is a point, without a heading"
        elif key not in AGENT_KEYS and key not in names:
            yield (key,), "is unknown, or a goal that is not used"


def steps_for(period: float, usual: float) -> float:
    """Returns a time step (s), at most `usual`, that divides a period."""
    if is_multiple(period, usual):
        return usual
    return period / math.ceil(period / usual)
