"""The models of human motion that come with the package, by name."""

from hunav_drake.systems.crowd.anticipation_velocity import (
    AnticipationVelocityModel,
)
from hunav_drake.systems.crowd.collision_free_speed import (
    CollisionFreeSpeedModel,
)
from hunav_drake.systems.crowd.headed_social_force import HeadedSocialForceModel
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.crowd.orca.model import OrcaModel
from hunav_drake.systems.crowd.social_force.model import SocialForceModel

__all__ = [
    "MOTION_MODELS",
    "AnticipationVelocityModel",
    "CollisionFreeSpeedModel",
    "HeadedSocialForceModel",
    "OrcaModel",
    "SocialForceModel",
]
