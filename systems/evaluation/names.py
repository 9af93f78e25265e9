"""The names of the metrics: the columns of every table of results."""

TIME_TO_REACH_GOAL = "time_to_reach_goal"
PATH_LENGTH = "path_length"
CUMULATIVE_HEADING_CHANGES = "cumulative_heading_changes"
AVG_DIST_TO_CLOSEST_PERSON = "avg_dist_to_closest_person"
MIN_DIST_TO_PEOPLE = "min_dist_to_people"
INTIMATE_SPACE_INTRUSIONS = "intimate_space_intrusions"
PERSONAL_SPACE_INTRUSIONS = "personal_space_intrusions"
SOCIAL_SPACE_INTRUSIONS = "social+_space_intrusions"
GROUP_INTIMATE_SPACE_INTRUSIONS = "group_intimate_space_intrusions"
GROUP_PERSONAL_SPACE_INTRUSIONS = "group_personal_space_intrusions"
GROUP_SOCIAL_SPACE_INTRUSIONS = "group_social+_space_intrusions"
COMPLETED = "completed"
MIN_DIST_TO_TARGET = "min_dist_to_target"
FINAL_DIST_TO_TARGET = "final_dist_to_target"
ROBOT_ON_PERSON_COLLISIONS = "robot_on_person_collisions"
PERSON_ON_ROBOT_COLLISIONS = "person_on_robot_collisions"
TIME_NOT_MOVING = "time_not_moving"
AVG_ROBOT_LINEAR_SPEED = "avg_robot_linear_speed"
AVG_ROBOT_ANGULAR_SPEED = "avg_robot_angular_speed"
AVG_ROBOT_ACCELERATION = "avg_robot_acceleration"
AVG_ROBOT_JERK = "avg_robot_jerk"
AVG_PEDESTRIAN_VELOCITY = "avg_pedestrian_velocity"
AVG_CLOSEST_PEDESTRIAN_VELOCITY = "avg_closest_pedestrian_velocity"
SOCIAL_FORCE_ON_AGENTS = "social_force_on_agents"
SOCIAL_FORCE_ON_ROBOT = "social_force_on_robot"
OBSTACLE_FORCE_ON_AGENTS = "obstacle_force_on_agents"
OBSTACLE_FORCE_ON_ROBOT = "obstacle_force_on_robot"
SOCIAL_WORK = "social_work"

# Table I of Perez-Higueras et al., "HuNavSim", 2023, in its order.
TABLE_I = (
    TIME_TO_REACH_GOAL,
    PATH_LENGTH,
    CUMULATIVE_HEADING_CHANGES,
    AVG_DIST_TO_CLOSEST_PERSON,
    MIN_DIST_TO_PEOPLE,
    INTIMATE_SPACE_INTRUSIONS,
    PERSONAL_SPACE_INTRUSIONS,
    SOCIAL_SPACE_INTRUSIONS,
    GROUP_INTIMATE_SPACE_INTRUSIONS,
    GROUP_PERSONAL_SPACE_INTRUSIONS,
    GROUP_SOCIAL_SPACE_INTRUSIONS,
    COMPLETED,
    MIN_DIST_TO_TARGET,
    FINAL_DIST_TO_TARGET,
    ROBOT_ON_PERSON_COLLISIONS,
    PERSON_ON_ROBOT_COLLISIONS,
    TIME_NOT_MOVING,
    AVG_ROBOT_LINEAR_SPEED,
    AVG_ROBOT_ANGULAR_SPEED,
    AVG_ROBOT_ACCELERATION,
    AVG_ROBOT_JERK,
    AVG_PEDESTRIAN_VELOCITY,
    AVG_CLOSEST_PEDESTRIAN_VELOCITY,
    SOCIAL_FORCE_ON_AGENTS,
    SOCIAL_FORCE_ON_ROBOT,
    OBSTACLE_FORCE_ON_AGENTS,
    OBSTACLE_FORCE_ON_ROBOT,
    SOCIAL_WORK,
)

# Beyond Table I. Each sum of forces or costs has `<name>_rate` besides.
DURATION = "duration"
MAX_DIST_TO_PEOPLE = "max_dist_to_people"
PUBLIC_SPACE_INTRUSIONS = "public_space_intrusions"
SPACE_COMPLIANCE = "space_compliance"
PATH_IRREGULARITY = "path_irregularity"
PATH_EFFICIENCY = "path_efficiency"
SUCCESS_WEIGHTED_PATH_LENGTH = "success_weighted_path_length"
STALLED_TIME = "stalled_time"
MIN_CLEARANCE = "min_clearance"
AVG_CLEARANCE = "avg_clearance"
STATIC_OBSTACLE_COLLISIONS = "static_obstacle_collisions"
AVG_DISPLACEMENT_ERROR = "avg_displacement_error"
FINAL_DISPLACEMENT_ERROR = "final_displacement_error"
ASYMMETRIC_DTW = "asymmetric_dtw"
TOPOLOGICAL_COMPLEXITY = "topological_complexity"
MIN_TIME_TO_COLLISION = "min_time_to_collision"
DANGER_FEAR_COST = "danger_fear_cost"
DANGER_PANIC_COST = "danger_panic_cost"
SURPRISE_VISIBILITY_COST = "surprise_visibility_cost"
SURPRISE_SHOCK_COST = "surprise_shock_cost"
SURPRISE_REACT_COST = "surprise_react_cost"

# A column of the steps of one behavior: whether anyone shows it just then.
BEHAVIOR_ACTIVE = "behavior_active"

# What the other columns of tables of results are called, so no metric may be:
# what a run is, the times of its steps, and the names of rows.
RESERVED = (
    "tag",
    "scenario",
    "planner",
    "setting",
    "seed",
    "end_reason",
    "end_time",
    "behavior",
    BEHAVIOR_ACTIVE,
    "time",
    "metric",
)
