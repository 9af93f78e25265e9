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

    The defaults are those that HuNavSim uses. Symbols in parentheses are of
    Moussaid et al. 2009 (people), 2010 (groups), and Helbing & Molnar 1995
    (goal, obstacles).
    """

    goal_factor: Factor = 2.0
    """How strongly the velocity is drawn to the desired one (k_d)."""

    relaxation_time: Annotated[StrictFloat, within(1e-3, 1e3, "s")] = 0.5
    """The time in which it is (tau), in seconds."""

    obstacle_factor: Factor = 10.0
    """The push of a wall at the body's surface (k_o), in m/s^2."""

    obstacle_sigma: Annotated[StrictFloat, within(1e-3, 1e3, "m")] = 0.2
    """The distance in which it falls to 1/e (sigma_o), in meters."""

    social_factor: Factor = 5.0
    """The strength of the interaction with other people (k_s), in m/s^2."""

    lambda_importance: Factor = 2.0
    """The weight of the relative velocity in the direction of the interaction
    (lambda), in s/m."""

    gamma: Positive = 0.35
    """The range of the interaction per length of that direction (gamma), m."""

    n: Factor = 2.0
    """The angular range of the force to the side (n)."""

    n_prime: Factor = 3.0
    """The angular range of the slowing-down (n')."""

    epsilon: Annotated[StrictFloat, within(-1, 1)] = 0.005
    """The turn that breaks the tie of an exact head-on encounter (epsilon): to
    the right; a negative one, to the left; 0 is HuNavSim's form."""

    group_gaze_factor: Factor = 3.0
    """Turning to keep the others of the group in view."""

    group_coherence_factor: Factor = 2.0
    """Staying near the center of the group."""

    group_repulsion_factor: Factor = 1.0
    """Keeping the bodies of the group apart."""


# The names of the columns.
PARAMETERS = tuple(f.name for f in fields(SocialForceParameters))
NUM_PARAMETERS = len(PARAMETERS)
