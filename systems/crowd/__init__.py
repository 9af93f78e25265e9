"""People who walk, by one of several models of human motion."""

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.headed_social_force import (
    HeadedSocialForceModel,
)
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.crowd.human_crowd import (
    CrowdJacobian,
    HumanCrowd,
    HumanCrowd_,
)
from hunav_drake.systems.crowd.motion_model import (
    MOTION_MODELS,
    MotionModel,
    Snapshot,
    make_motion_model,
    register_motion_model,
)
from hunav_drake.systems.crowd.orca import OrcaModel
from hunav_drake.systems.crowd.parameters import SocialForceParameters
from hunav_drake.systems.crowd.social_force_model import SocialForceModel
from hunav_drake.systems.crowd.weights import draw_weights

__all__ = [
    "MOTION_MODELS",
    "CrowdConfig",
    "CrowdJacobian",
    "HeadedSocialForceModel",
    "HumanConfig",
    "HumanCrowd",
    "HumanCrowd_",
    "MotionModel",
    "OrcaModel",
    "Snapshot",
    "SocialForceModel",
    "SocialForceParameters",
    "draw_weights",
    "make_motion_model",
    "register_motion_model",
]
