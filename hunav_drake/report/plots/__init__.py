"""Plots of one or more trials.

Every function gets data and the axes to draw on, `ax`, and returns the axes.
Without `ax` it creates a figure with the width of a column of a paper. It does
not show the figure: notebooks do, and scripts call `matplotlib.pyplot.show` or
`savefig`.

The colors are those of Okabe & Ito 2008, which color-blind people can
distinguish.
"""

from hunav_drake.report.plots.activity import plot_behavior_activity
from hunav_drake.report.plots.approaches import Approach, find_approaches
from hunav_drake.report.plots.branches import plot_branches, plot_delays
from hunav_drake.report.plots.comparison import (
    plot_comparison,
    plot_differences,
    plot_distribution,
)
from hunav_drake.report.plots.costmaps import plot_costmap
from hunav_drake.report.plots.forces import plot_forces
from hunav_drake.report.plots.series import (
    plot_distance_to_people,
    plot_robot_speed,
)
from hunav_drake.report.plots.tracks import plot_tracks
from hunav_drake.report.plots.trajectories import plot_trajectories
from hunav_drake.report.plots.zones import plot_zones

__all__ = [
    "Approach",
    "find_approaches",
    "plot_behavior_activity",
    "plot_branches",
    "plot_comparison",
    "plot_costmap",
    "plot_delays",
    "plot_differences",
    "plot_distance_to_people",
    "plot_distribution",
    "plot_forces",
    "plot_robot_speed",
    "plot_tracks",
    "plot_trajectories",
    "plot_zones",
]
