"""The columns of MPPI's parameters, as its kernels take them."""

# The critics in the order of their scores, after the total.
CRITICS = (
    "constraint",
    "cost",
    "goal",
    "goal_angle",
    "path_align",
    "path_follow",
    "path_angle",
    "prefer_forward",
    "social",
)

# Their weights have the numbers of their scores.
(
    CONSTRAINT,
    COST,
    GOAL,
    GOAL_ANGLE,
    PATH_ALIGN,
    PATH_FOLLOW,
    PATH_ANGLE,
    PREFER_FORWARD,
    SOCIAL,
) = range(1, 10)

# The score that no critic gives: how far controls are from the last ones.
CONTROL = 10
NUM_SCORES = 11

(
    DT,
    MIN_V,
    MAX_V,
    MAX_TURN,
    ACC_V,
    ACC_TURN,
    STD_V,
    STD_TURN,
    TEMPERATURE,
    GAMMA,
    COLLISION_COST,
    CRITICAL_COST,
    USE_FOOTPRINT,
    COST_NEAR_GOAL,
    GOAL_NEAR,
    GOAL_ANGLE_NEAR,
    PATH_NEAR,
    FOLLOW_NEAR,
    ALIGN_AHEAD,
    ALIGN_BLOCKED,
    FOLLOW_AHEAD,
    ANGLE_AHEAD,
    ANGLE_LEAST,
    COST_EVERY,
    ALIGN_EVERY,
    SOCIAL_EVERY,
    HOLD,
    NUM_PARAMETERS,
) = range(NUM_SCORES, NUM_SCORES + 28)
