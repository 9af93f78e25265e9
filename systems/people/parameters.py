"""The parameters of the social force model."""

from dataclasses import fields
from typing import Annotated

from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, within

Factor = Annotated[StrictFloat, within(0, 1e3)]
Positive = Annotated[StrictFloat, within(1e-3, 1e3)]

# The columns of the parameters: the fields of SocialForceParameters in order.
(
    K_GOAL,
    TAU,
    K_OBSTACLE,
    SIGMA,
    K_SOCIAL,
    LAMBDA,
    GAMMA,
    N,
    N_PRIME,
    EPSILON,
    K_GAZE,
    K_COHERENCE,
    K_REPULSION,
) = range(13)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class SocialForceParameters:
    """The weights and constants of the forces on one person.

    The defaults are those of HuNavSim. Symbols in parentheses are those of
    Moussaid et al. 2009 (people), 2010 (groups), and Helbing & Molnar 1995
    (goal, obstacles).
    """

    goal_factor: Factor = 2.0
    """Gain of the pull towards the desired velocity (k_d)."""

    relaxation_time: Annotated[StrictFloat, within(1e-3, 1e3, "s")] = 0.5
    """Time constant of that pull (tau), in seconds."""

    obstacle_factor: Factor = 10.0
    """Push of a wall at the body's surface (k_o), in m/s^2."""

    obstacle_sigma: Annotated[StrictFloat, within(1e-3, 1e3, "m")] = 0.2
    """Distance over which it decays to 1/e (sigma_o), in meters."""

    social_factor: Factor = 5.0
    """Strength of the interaction with other people (k_s), in m/s^2."""

    lambda_importance: Factor = 2.0
    """Weight of the relative velocity in the direction of the interaction
    (lambda), in s/m."""

    gamma: Positive = 0.35
    """Range of the interaction per length of that direction (gamma), in m."""

    n: Factor = 2.0
    """Angular range of the sideways force (n)."""

    n_prime: Factor = 3.0
    """Angular range of the deceleration (n')."""

    epsilon: Annotated[StrictFloat, within(-1, 1)] = 0.005
    """Turn that breaks the tie of an exact head-on encounter (epsilon): to the
    right if positive, to the left if negative; 0 is HuNavSim's form."""

    group_gaze_factor: Factor = 3.0
    """Weight of slowing down to keep the others of the group in view."""

    group_coherence_factor: Factor = 2.0
    """Weight of the pull towards the center of the group."""

    group_repulsion_factor: Factor = 1.0
    """Weight of the repulsion between bodies of the group."""


# The names of the columns.
PARAMETERS = tuple(f.name for f in fields(SocialForceParameters))
NUM_PARAMETERS = len(PARAMETERS)
