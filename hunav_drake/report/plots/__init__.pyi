from .activity import plot_behavior_activity as plot_behavior_activity
from .approaches import Approach as Approach, find_approaches as find_approaches
from .branches import plot_branches as plot_branches, plot_delays as plot_delays
from .comparison import (
    plot_comparison as plot_comparison,
    plot_differences as plot_differences,
    plot_distribution as plot_distribution,
)
from .costmaps import plot_costmap as plot_costmap
from .forces import plot_forces as plot_forces
from .series import (
    plot_distance_to_people as plot_distance_to_people,
    plot_robot_speed as plot_robot_speed,
)
from .tracks import plot_tracks as plot_tracks
from .trajectories import plot_trajectories as plot_trajectories
from .zones import plot_zones as plot_zones
