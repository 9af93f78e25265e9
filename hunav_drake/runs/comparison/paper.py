"""The values that HuNavSim's paper prints.

Pérez-Higueras et al., "HuNavSim: A ROS 2 Human Navigation Simulator for
Benchmarking Human-Aware Robot Navigation", RA-L 2023, Tables II to IV.
"""

PLANNERS = ("dwb", "scl", "sfw")

# The metrics of Tables II and III, in their order, with units as printed and
# what ours are to be multiplied by.
METRICS: tuple[tuple[str, str, float], ...] = (
    ("time_to_reach_goal", "s", 1.0),
    ("path_length", "m", 1.0),
    ("cumulative_heading_changes", "rad", 1.0),
    ("avg_dist_to_closest_person", "m", 1.0),
    ("min_dist_to_people", "m", 1.0),
    ("intimate_space_intrusions", "%", 1.0),
    ("personal_space_intrusions", "%", 1.0),
    ("social+_space_intrusions", "%", 1.0),
    ("completed", "%", 100.0),
    ("min_dist_to_target", "m", 1.0),
    ("final_dist_to_target", "m", 1.0),
    ("robot_on_person_collisions", "-", 1.0),
    ("person_on_robot_collisions", "-", 1.0),
    ("time_not_moving", "s", 1.0),
    ("avg_robot_linear_speed", "m/s", 1.0),
    ("avg_robot_angular_speed", "rad/s", 1.0),
    ("avg_robot_acceleration", "m/s²", 1.0),
    ("avg_robot_jerk", "m/s³", 1.0),
    ("avg_pedestrian_velocity", "m/s", 1.0),
    ("avg_closest_pedestrian_velocity", "m/s", 1.0),
    ("social_force_on_agents", "m/s²", 1.0),
    ("social_force_on_robot", "m/s²", 1.0),
    ("obstacle_force_on_agents", "m/s²", 1.0),
    ("obstacle_force_on_robot", "m/s²", 1.0),
    ("social_work", "m/s²", 1.0),
)

_PASSING = {
    "dwb": "25.5 15.2 0.47 6.36 0.40 3.66 19.7 17.0 100 0.18 0.18 0 0 0.00"
    " 0.51 0.02 0.05 0.08 0.47 0.57 0.52 0.52 8.14 0.00 1.04",
    "scl": "26.6 15.7 1.89 7.95 0.90 0 5.8 26.7 100 0.19 0.19 0 0 1.04"
    " 0.51 0.09 0.05 0.06 0.44 0.51 0.97 0.92 0.13 0.00 1.89",
    "sfw": "35.7 15.2 1.89 7.49 0.55 0 14.7 21.4 100 0.11 0.11 0 0 1.78"
    " 0.38 0.09 0.08 0.08 0.34 0.39 0.49 0.49 0.81 0.00 0.98",
}
_CROSSING = {
    "dwb": "10.1 4.9 2.15 1.45 0.23 13.7 28.5 57.9 100 0.19 0.19 0 0 0.00"
    " 0.35 0.44 0.09 0.10 0.46 0.27 0.67 0.67 2.08 0.00 1.33",
    "scl": "14.6 5.7 6.68 1.37 0.21 14.6 25.2 60.2 100 0.22 0.22 0 0 0.00"
    " 0.31 0.55 0.12 0.13 0.36 0.31 1.10 1.10 6.07 0.00 2.20",
    "sfw": "14.0 4.9 2.03 1.51 0.49 1.6 44.9 53.4 100 0.13 0.13 0 0 0.38"
    " 0.28 0.25 0.14 0.26 0.36 0.23 0.44 0.44 2.08 0.00 0.88",
}

# Tables II and III: by scenario, planner and metric.
PUBLISHED: dict[str, dict[str, dict[str, float]]] = {
    scenario: {
        planner: {
            name: float(number)
            for (name, _, _), number in zip(
                METRICS, numbers.split(), strict=True
            )
        }
        for planner, numbers in table.items()
    }
    for scenario, table in (("passing", _PASSING), ("crossing", _CROSSING))
}

_BEHAVIORS = ("regular", "curious", "threatening")
_COMBINED: dict[str, str] = {
    "min_dist_to_people": "0.96 1.07 1.05  0.77 0.80 0.75  0.21 0.20 0.15",
    "avg_dist_to_closest_person": "11.42 11.31 12.85  3.56 3.99 8.05"
    "  3.55 3.54 3.29",
    "intimate_space_intrusions": "0 0 0  0 0 0  52.84 45.24 58.46",
    "personal_space_intrusions": "4.27 4.76 1.54  10.03 11.90 13.85"
    "  14.56 21.43 4.62",
    "avg_pedestrian_velocity": "0.22 0.21 0.13  0.59 0.56 0.46  0.66 0.67 0.60",
    "social_force_on_robot": "0 0 0  0.07 0.08 0.30  3.23 1.91 2.91",
    "social_work": "0 0 0  0.14 0.15 0.60  6.46 3.83 5.83",
}

# Table IV: by behavior, planner and metric.
PUBLISHED_BY_BEHAVIOR: dict[str, dict[str, dict[str, float]]] = {
    behavior: {
        planner: {
            name: float(numbers.split()[len(PLANNERS) * b + p])
            for name, numbers in _COMBINED.items()
        }
        for p, planner in enumerate(PLANNERS)
    }
    for b, behavior in enumerate(_BEHAVIORS)
}


def printed_values(
    suite: str, scenario: str, behavior: str = ""
) -> dict[str, dict[str, float]]:
    """Returns what the paper prints, by planner and metric.

    Args:
        suite: The name of a suite; of others than the paper's it is nothing.
        scenario: That of the runs.
        behavior: That of the people who alone count; by default all do.
    """
    if suite != "paper":
        return {}
    if not behavior:
        return PUBLISHED.get(scenario, {})
    if scenario != "combined":
        return {}
    return PUBLISHED_BY_BEHAVIOR.get(behavior, {})
