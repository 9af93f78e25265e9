"""MPPI's critics and parameters for its kernels."""

from enum import IntEnum
from typing import NamedTuple


class Critic(IntEnum):
    """The columns of scores after the total, in the order of `CriticWeights`.

    The last one is not a critic: the deviation from the last controls.
    """

    CONSTRAINT = 1
    COST = 2
    GOAL = 3
    GOAL_ANGLE = 4
    PATH_ALIGN = 5
    PATH_FOLLOW = 6
    PATH_ANGLE = 7
    PREFER_FORWARD = 8
    SOCIAL = 9
    CONTROL = 10


NUM_SCORES = 1 + len(Critic)


class Parameters(NamedTuple):
    """The bounds of rollouts and the parameters of scores; all are floats.

    `dt` is the time step of rollouts, `v` are speeds, `turn` turn rates, `acc`
    their maximum rates of change, and `std` the standard deviations of their
    noise; in SI units. A command holds for `hold` steps: see `Setting`. The
    others are those of `MppiPlanner` and its `CriticSettings`.
    """

    dt: float
    min_v: float
    max_v: float
    max_turn: float
    acc_v: float
    acc_turn: float
    std_v: float
    std_turn: float
    hold: float
    temperature: float
    gamma: float
    collision_cost: float
    critical_cost: float
    consider_footprint: float
    near_goal_distance: float
    goal_threshold: float
    goal_angle_threshold: float
    path_threshold: float
    path_follow_threshold: float
    path_align_offset: float
    max_path_occupancy_ratio: float
    path_follow_offset: float
    path_angle_offset: float
    max_angle_to_furthest: float
    cost_step: float
    path_align_step: float
    social_step: float
