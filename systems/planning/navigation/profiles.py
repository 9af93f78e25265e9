"""Profiles: the parameters that differ between releases of Nav2's robots.

`pmb2_foxy` is that of PAL's PMB2 under ROS 2 Foxy, as in the paper of
HuNavSim; `humble` that of the same robot under Humble. (The public files of
pmb2_navigation, branches foxy-devel and humble-devel, over the defaults of
navigation2's branches of that name.)
"""

from dataclasses import dataclass
import math
from typing import Literal

ProfileName = Literal["pmb2_foxy", "humble"]


@dataclass(frozen=True, kw_only=True)
class NavigationProfile:
    """What depends on the release, of the parts that planners share.

    Attributes:
        robot_radius: PMB2's radius for navigation, in meters.
        cost_scaling_factor: Of the inflation, in 1/m.
        local_size: The side of the local map, in meters.
        local_resolution: The side of its cells, in meters.
        local_update_period: The time between its updates, in seconds.
        failure_tolerance: How long there may be no command, in seconds.
        recoveries: What is done when navigation fails.
        one_at_a_time: Whether one recovery is done per failure, in turns.
    """

    robot_radius: float
    cost_scaling_factor: float
    local_size: float
    local_resolution: float
    local_update_period: float
    failure_tolerance: float
    recoveries: tuple[str, ...]
    one_at_a_time: bool


@dataclass(frozen=True, kw_only=True)
class DwbProfile:
    """What depends on the release, of DWB.

    Attributes:
        max_vel_theta: In rad/s.
        acc_lim_x: In m/s^2.
        decel_lim_x: In m/s^2, negative.
        acc_lim_theta: In rad/s^2.
        decel_lim_theta: In rad/s^2, negative.
        prune_distance: How far from the robot the local plan begins, m.
        forward_prune_distance: How far it goes, in meters.
        search_all: Whether its begin is sought on the whole plan, not on the
            next `prune_distance` only.
    """

    max_vel_theta: float
    acc_lim_x: float
    decel_lim_x: float
    acc_lim_theta: float
    decel_lim_theta: float
    prune_distance: float
    forward_prune_distance: float
    search_all: bool


NAVIGATION_PROFILES = {
    "pmb2_foxy": NavigationProfile(
        robot_radius=0.275,
        cost_scaling_factor=10.0,
        local_size=4.0,
        local_resolution=0.025,
        local_update_period=0.1,
        failure_tolerance=0.0,
        recoveries=("clear", "spin", "wait"),
        one_at_a_time=False,
    ),
    "humble": NavigationProfile(
        robot_radius=0.275,
        cost_scaling_factor=3.0,
        local_size=3.0,
        local_resolution=0.05,
        local_update_period=0.2,
        failure_tolerance=0.3,
        recoveries=("clear", "spin", "wait", "back_up"),
        one_at_a_time=True,
    ),
}

DWB_PROFILES = {
    "pmb2_foxy": DwbProfile(
        max_vel_theta=1.05,
        acc_lim_x=0.6,
        decel_lim_x=-2.5,
        acc_lim_theta=3.14,
        decel_lim_theta=-3.14,
        prune_distance=1.0,
        forward_prune_distance=1.0,
        search_all=True,
    ),
    "humble": DwbProfile(
        max_vel_theta=1.0,
        acc_lim_x=2.5,
        decel_lim_x=-2.5,
        acc_lim_theta=3.2,
        decel_lim_theta=-3.2,
        prune_distance=2.0,
        forward_prune_distance=2.0,
        search_all=False,
    ),
}

# The radius of the circle that the paper's metrics take for PMB2, in meters.
_METRICS_RADIUS = 0.35


def navigation_radius(own: float, profile: NavigationProfile) -> float:
    """Returns the radius that a robot is planned with, in meters.

    A robot as large as PMB2, or as the larger circle that the paper's metrics
    take for it, is PMB2; any other is planned with its own radius.

    Args:
        own: That of the robot.
        profile: Of PMB2.
    """
    if profile.robot_radius <= own <= _METRICS_RADIUS + 1e-9:
        return profile.robot_radius
    return own


def either[Value](value: Value | None, other: Value) -> Value:
    """Returns a parameter, or that of the profile if it is None."""
    return other if value is None else value


def cycles(seconds: float, period: float) -> int:
    """Returns how many cycles come next to a time, at least 1."""
    return max(1, math.floor(seconds / period + 0.5))
