"""What differs from HuNavSim's evaluator on purpose, and why."""

from hunav_drake.systems.evaluation.names import (
    AVG_ROBOT_ACCELERATION,
    AVG_ROBOT_JERK,
    GROUP_INTIMATE_SPACE_INTRUSIONS,
    GROUP_PERSONAL_SPACE_INTRUSIONS,
    GROUP_SOCIAL_SPACE_INTRUSIONS,
    MAX_DIST_TO_PEOPLE,
    OBSTACLE_FORCE_ON_AGENTS,
    OBSTACLE_FORCE_ON_ROBOT,
    PERSON_ON_ROBOT_COLLISIONS,
    ROBOT_ON_PERSON_COLLISIONS,
    SOCIAL_FORCE_ON_AGENTS,
    SOCIAL_FORCE_ON_ROBOT,
    SOCIAL_WORK,
    TIME_NOT_MOVING,
    TIME_TO_REACH_GOAL,
)

_GROUPS = (
    "HuNavSim fails with any group, and gives 0 without; here the centers of"
    " groups are found, and without groups there is no value"
)
_COLLISIONS = (
    "HuNavSim counts samples, not contacts, and mixes up the arguments of"
    " atan2, which charges the wrong party"
)
_FORCES = (
    "HuNavSim mixes up the arguments of atan2, so that its forces depend on"
    " the orientation of the world"
)
_POINTS = (
    "HuNavSim divides by the number of nearest points; here the forces of all"
    " walls add up"
)

# The reasons by the names of the metrics. Besides, what has no value is NaN
# here, and 10000 or 0 there.
DIFFERENCES = {
    TIME_TO_REACH_GOAL: "HuNavSim gives the length of the run, reached or not;"
    " `duration` is that",
    GROUP_INTIMATE_SPACE_INTRUSIONS: _GROUPS,
    GROUP_PERSONAL_SPACE_INTRUSIONS: _GROUPS,
    GROUP_SOCIAL_SPACE_INTRUSIONS: _GROUPS,
    ROBOT_ON_PERSON_COLLISIONS: _COLLISIONS,
    PERSON_ON_ROBOT_COLLISIONS: _COLLISIONS,
    TIME_NOT_MOVING: "here an interval in which the robot comes to rest, or"
    " sets off, is not one of rest; it is the convention that differs",
    AVG_ROBOT_ACCELERATION: "HuNavSim divides by the number of samples; here"
    " it is that of the intervals, one fewer, without those of repeated stamps",
    AVG_ROBOT_JERK: "HuNavSim divides the acceleration by the time step; here"
    " it is the change of the acceleration",
    SOCIAL_FORCE_ON_AGENTS: _FORCES,
    SOCIAL_FORCE_ON_ROBOT: _FORCES,
    SOCIAL_WORK: "it sums up the social forces, which differ",
    OBSTACLE_FORCE_ON_AGENTS: _POINTS,
    OBSTACLE_FORCE_ON_ROBOT: _POINTS,
    MAX_DIST_TO_PEOPLE: "HuNavSim subtracts the robot's radius alone; here it"
    " is the gap between the surfaces",
}
