"""People who walk, by one of several models of human motion."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.systems.crowd.advance import advance_people
    from hunav_drake.systems.crowd.crowd_config import (
        CrowdConfig,
    )
    from hunav_drake.systems.crowd.human_config import (
        HumanConfig,
    )
    from hunav_drake.systems.crowd.human_crowd import (
        HumanCrowd,
        HumanCrowd_,
    )
    from hunav_drake.systems.crowd.models import (
        MOTION_MODELS,
        HeadedSocialForceModel,
        OrcaModel,
        SocialForceModel,
        make_motion_model,
    )
    from hunav_drake.systems.crowd.motion_model import (
        MotionModel,
        Snapshot,
        register_motion_model,
    )
    from hunav_drake.systems.crowd.parameters import (
        SocialForceParameters,
    )
    from hunav_drake.systems.crowd.step import (
        CrowdJacobian,
    )
    from hunav_drake.systems.crowd.weights import (
        draw_weights,
    )

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
    "advance_people",
    "draw_weights",
    "make_motion_model",
    "register_motion_model",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "CrowdConfig": "hunav_drake.systems.crowd.crowd_config",
        "CrowdJacobian": "hunav_drake.systems.crowd.step",
        "HeadedSocialForceModel": "hunav_drake.systems.crowd.models",
        "HumanConfig": "hunav_drake.systems.crowd.human_config",
        "HumanCrowd": "hunav_drake.systems.crowd.human_crowd",
        "HumanCrowd_": "hunav_drake.systems.crowd.human_crowd",
        "MOTION_MODELS": "hunav_drake.systems.crowd.models",
        "MotionModel": "hunav_drake.systems.crowd.motion_model",
        "OrcaModel": "hunav_drake.systems.crowd.models",
        "Snapshot": "hunav_drake.systems.crowd.motion_model",
        "SocialForceModel": "hunav_drake.systems.crowd.models",
        "SocialForceParameters": "hunav_drake.systems.crowd.parameters",
        "advance_people": "hunav_drake.systems.crowd.advance",
        "draw_weights": "hunav_drake.systems.crowd.weights",
        "make_motion_model": "hunav_drake.systems.crowd.models",
        "register_motion_model": "hunav_drake.systems.crowd.motion_model",
    },
)
