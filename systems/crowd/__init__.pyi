from .advance import advance_people as advance_people
from .crowd_config import CrowdConfig as CrowdConfig
from .decisions_config import DecisionsConfig as DecisionsConfig
from .human_crowd import HumanCrowd as HumanCrowd, HumanCrowd_ as HumanCrowd_
from .human_decisions import HumanDecisions as HumanDecisions
from .models import (
    MOTION_MODELS as MOTION_MODELS,
    AnticipationVelocityModel as AnticipationVelocityModel,
    CollisionFreeSpeedModel as CollisionFreeSpeedModel,
    HeadedSocialForceModel as HeadedSocialForceModel,
    OrcaModel as OrcaModel,
    SocialForceModel as SocialForceModel,
)
from .motion_model import (
    MotionModel as MotionModel,
    Snapshot as Snapshot,
    register_motion_model as register_motion_model,
)
from .open_crowd import OpenCrowd as OpenCrowd, TrafficCounts as TrafficCounts
from .recorded_people import RecordedPeople as RecordedPeople
from .step import CrowdJacobian as CrowdJacobian
