"""People who walk by the social force model."""

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.crowd.human_crowd import HumanCrowd
from hunav_drake.systems.crowd.parameters import SocialForceParameters

__all__ = ["CrowdConfig", "HumanConfig", "HumanCrowd", "SocialForceParameters"]
