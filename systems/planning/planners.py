"""Registers the planners of the package."""

from hunav_drake.systems.planning.dwb.dwb import DwbPlanner
from hunav_drake.systems.planning.dwb.scl import SclPlanner
from hunav_drake.systems.planning.external import ExternalPlanner
from hunav_drake.systems.planning.mppi.mppi import MppiPlanner
from hunav_drake.systems.planning.pursuit import PursuitPlanner
from hunav_drake.systems.planning.ros2.bridge import BridgePlanner
from hunav_drake.systems.planning.social.orca import OrcaPlanner
from hunav_drake.systems.planning.social.sfm import SfmPlanner
from hunav_drake.systems.planning.social.sfw import SfwPlanner
from hunav_drake.systems.planning.stand import StandPlanner

__all__ = [
    "BridgePlanner",
    "DwbPlanner",
    "ExternalPlanner",
    "MppiPlanner",
    "OrcaPlanner",
    "PursuitPlanner",
    "SclPlanner",
    "SfmPlanner",
    "SfwPlanner",
    "StandPlanner",
]
