"""Registers the planners of the package."""

from hunav_drake.systems.planning.dwb.dwb import DwbPlanner
from hunav_drake.systems.planning.dwb.scl import SclPlanner
from hunav_drake.systems.planning.mppi.mppi import MppiPlanner
from hunav_drake.systems.planning.pursuit import PursuitPlanner

__all__ = ["DwbPlanner", "MppiPlanner", "PursuitPlanner", "SclPlanner"]
