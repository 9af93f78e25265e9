"""Profiles: the values of keys that are left out.

A profile stands for another program, or an earlier version of this one.
`crowd: {profile: hunavsim}` gives every parameter the value that does what
HuNavSim does, `crowd: {profile: hunav_drake_0.1}` that of version 0.1; keys
beside it take precedence.
"""

from collections.abc import Mapping, Sequence
import dataclasses
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_ids, people_names
from hunav_drake.systems.people.parameters import SocialForceParameters

ProfileName = Literal["default", "hunavsim", "hunav_drake_0.1"]


class Profile(NamedTuple):
    """The default values of keys.

    Attributes:
        crowd: By the fields of CrowdConfig; the others have the defaults that
            are written there.
        human: By the fields of HumanConfig that are None if left out.
        single: The fields of HumanConfig that are rounded to single precision;
            if there are any, so is the yaw of the pose.
    """

    crowd: Mapping[str, Any]
    human: Mapping[str, Any]
    single: tuple[str, ...] = ()


# The weights of people who are like recorded ones: docs/calibration.md.
RECORDED = SocialForceParameters(
    social_factor=90.0, lambda_importance=2.2, gamma=0.088, n=12.0, n_prime=18.0
)

# A row is a field and the value that does what the program does. The behaviors
# are in `hunav_drake.systems.behavior.profiles`.
PROFILES: Mapping[str, Profile] = MappingProxyType(
    {
        "default": Profile(
            crowd={}, human={"cyclic": False, "forces": RECORDED}
        ),
        "hunav_drake_0.1": Profile(
            crowd={
                "model": {
                    "type": "social_force",
                    "time_gap": 0.8,
                    "speed_matching": 0.35,
                    "passing_speed": 0.02,
                },
                "robots_behind": False,
                "walls_behind_doors": False,
            },
            human={"cyclic": False, "forces": SocialForceParameters()},
        ),
        "hunavsim": Profile(
            crowd={
                "model": {
                    "type": "social_force",
                    "kernel": "hunavsim",
                    "time_gap": 0.0,
                    "speed_matching": 0.0,
                    "passing_speed": 0.02,
                },
                "obstacle_range": 10.0,
                "max_obstacles": 1,
                "keep_out_of_walls": False,
                "route_planning": False,
                "keep_apart": False,
                "groups_part": False,
                "robot_gap": 0.0,
                "robots_behind": False,
                "walls_behind_doors": False,
                "standing": False,
                "max_acceleration": None,
                "max_turn_rate": None,
            },
            human={"cyclic": True, "forces": SocialForceParameters()},
            single=("desired_speed", "max_speed", "radius", "goal_radius"),
        ),
    }
)


def own_forces(
    human: HumanConfig, profile: ProfileName
) -> SocialForceParameters:
    """Returns the weights of a person: those given, or those of a profile.

    Factors as in HuNavSim, and drawn ones, stand among HuNavSim's weights.
    """
    if human.forces is not None:
        return human.forces
    if human.forces_mode != "custom":
        return SocialForceParameters()
    check_choice("profile", profile, PROFILES)
    forces: SocialForceParameters = PROFILES[profile].human["forces"]
    return forces


def complete_people(
    humans: Sequence[HumanConfig], profile: ProfileName
) -> list[HumanConfig]:
    """Returns people with the values of a profile, with names and numbers.

    Args:
        humans: The people, which are not changed.
        profile: The profile that gives the missing values.
    """
    _, defaults, single = PROFILES[profile]
    result = []
    for human, own_name, number in zip(
        humans, people_names(humans), people_ids(humans), strict=True
    ):
        values: dict[str, Any] = {"name": own_name, "id": number}
        for name, default in defaults.items():
            value = getattr(human, name)
            values[name] = default if value is None else value
        values["forces"] = own_forces(human, profile)
        for name in single:
            if (value := getattr(human, name)) is not None:
                values[name] = float(np.float32(value))
        if single:
            x, y, yaw = human.pose
            values["pose"] = (x, y, float(np.float32(yaw)))
        result.append(dataclasses.replace(human, **values))
    return result
