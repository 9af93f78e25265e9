"""What differs from HuNavSim's evaluator."""

from hunav_drake.hunavsim.row import Difference


def _row(
    *metrics: str,
    original: str,
    here: str,
    why: str,
    name: str = "",
    series: bool = False,
) -> Difference:
    return Difference(
        area="metrics",
        name=name or ", ".join(metrics),
        original=original,
        here=here,
        why=why,
        metrics=metrics,
        series=series,
    )


METRIC_ROWS: tuple[Difference, ...] = (
    _row(
        name="no value",
        original="10000 or 0",
        here="NaN",
        why="a mean over runs must not count what was not measured",
    ),
    _row(
        "time_to_reach_goal",
        original="the length of the run, reached or not",
        here="the time until the goal is reached; `duration` is the other",
        why="the name says so",
    ),
    _row(
        "group_intimate_space_intrusions",
        "group_personal_space_intrusions",
        "group_social+_space_intrusions",
        original="fails with any group, and gives 0 without",
        here="the centers of groups are found; no value without groups",
        why="the paper defines them so",
    ),
    _row(
        "robot_on_person_collisions",
        "person_on_robot_collisions",
        original="counts samples, not contacts, and mixes up the arguments of"
        " atan2, which charges the wrong party",
        here="counts contacts, charged to who closes in",
        why="the number must not hang on the sampling",
    ),
    _row(
        "time_not_moving",
        original="tests `abs(w < 0.02)`, the absolute value of a truth, so any"
        " turn to the right counts as standing; and counts samples, times the"
        " mean step",
        here="|w| < 0.02 rad/s, and intervals that are of rest at both ends",
        why="a slip; and a time is made of intervals",
    ),
    _row(
        "avg_robot_angular_speed",
        name="the series of avg_robot_angular_speed",
        original="the value is the mean of |w|, the series is w with its sign",
        here="both are of |w|",
        why="the value is the mean of its series",
        series=True,
    ),
    _row(
        "avg_robot_acceleration",
        original="divides by the number of samples",
        here="divides by that of the intervals, one fewer, without those of"
        " repeated stamps",
        why="an acceleration is one of an interval",
    ),
    _row(
        "avg_robot_jerk",
        original="divides the acceleration by the time step",
        here="the change of the acceleration, by the time step",
        why="that is a jerk",
    ),
    _row(
        "social_force_on_agents",
        "social_force_on_robot",
        original="mixes up the arguments of atan2, so that forces depend on"
        " the orientation of the world",
        here="those of the social force model",
        why="a turned world must give the same",
    ),
    _row(
        "social_work",
        original="the sum of its social forces",
        here="the sum of those here",
        why="it follows from them",
    ),
    _row(
        "obstacle_force_on_agents",
        "obstacle_force_on_robot",
        original="divides by the number of nearest points",
        here="the forces of all walls add up",
        why="as they do in the crowd",
    ),
    _row(
        "max_dist_to_people",
        original="subtracts the robot's radius alone",
        here="the gap between the surfaces",
        why="as the other distances do",
    ),
)
