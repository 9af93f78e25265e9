from .advance import advance_people as advance_people
from .anticipation_velocity import (
    AnticipationVelocityModel as AnticipationVelocityModel,
)
from .collision_free_speed import (
    CollisionFreeSpeedModel as CollisionFreeSpeedModel,
)
from .crowd_config import CrowdConfig as CrowdConfig
from .decisions_config import DecisionsConfig as DecisionsConfig
from .headed_social_force import (
    HeadedSocialForceModel as HeadedSocialForceModel,
)
from .human_crowd import HumanCrowd as HumanCrowd, HumanCrowd_ as HumanCrowd_
from .human_decisions import HumanDecisions as HumanDecisions
from .motion_model import (
    MOTION_MODELS as MOTION_MODELS,
    MotionModel as MotionModel,
    Snapshot as Snapshot,
    register_motion_model as register_motion_model,
)
from .open_crowd import OpenCrowd as OpenCrowd, TrafficCounts as TrafficCounts
from .orca.model import OrcaModel as OrcaModel
from .recorded_people import RecordedPeople as RecordedPeople
from .social_force.model import SocialForceModel as SocialForceModel
from .step import CrowdJacobian as CrowdJacobian
