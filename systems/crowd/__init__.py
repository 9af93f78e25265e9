"""People who walk, by one of several models of human motion."""

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.crowd.human_crowd import HumanCrowd
from hunav_drake.systems.crowd.motion_model import (
    MOTION_MODELS,
    MotionModel,
    Snapshot,
    make_motion_model,
    register_motion_model,
)
from hunav_drake.systems.crowd.parameters import SocialForceParameters
from hunav_drake.systems.crowd.social_force_model import SocialForceModel

__all__ = [
    "MOTION_MODELS",
    "CrowdConfig",
    "HumanConfig",
    "HumanCrowd",
    "MotionModel",
    "Snapshot",
    "SocialForceModel",
    "SocialForceParameters",
    "make_motion_model",
    "register_motion_model",
]
