"""The configuration of simulated people."""

from hunav_drake.systems.people.behavior_choice import BehaviorConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.people.weights import draw_weights

__all__ = [
    "BehaviorConfig",
    "HumanConfig",
    "Place",
    "SocialForceParameters",
    "draw_weights",
]
