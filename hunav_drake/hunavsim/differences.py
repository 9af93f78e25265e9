"""What differs from HuNavSim's evaluator on purpose, and why."""

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
    "time_to_reach_goal": "HuNavSim gives the length of the run,"
    " reached or not; `duration` is that",
    "group_intimate_space_intrusions": _GROUPS,
    "group_personal_space_intrusions": _GROUPS,
    "group_social+_space_intrusions": _GROUPS,
    "robot_on_person_collisions": _COLLISIONS,
    "person_on_robot_collisions": _COLLISIONS,
    "time_not_moving": "here an interval in which the robot comes to rest, or"
    " sets off, is not one of rest; it is the convention that differs",
    "avg_robot_acceleration": "HuNavSim divides by the number of samples; here"
    " it is that of the intervals, one fewer, without those of repeated stamps",
    "avg_robot_jerk": "HuNavSim divides the acceleration by the time step; here"
    " it is the change of the acceleration",
    "social_force_on_agents": _FORCES,
    "social_force_on_robot": _FORCES,
    "social_work": "it sums up the social forces, which differ",
    "obstacle_force_on_agents": _POINTS,
    "obstacle_force_on_robot": _POINTS,
    "max_dist_to_people": "HuNavSim subtracts the robot's radius alone; here it"
    " is the gap between the surfaces",
}
