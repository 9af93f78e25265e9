"""Plots of what happens in a trial, and of many trials.

Every function takes data and an axes to draw on, `ax`, without which it makes
a figure of its own, as wide as a column of a paper; and it returns the axes.
None shows anything by itself: in a notebook a figure appears anyway, and in a
script call `matplotlib.pyplot.show` or `savefig`.

Colors are those of Okabe & Ito 2008, which people with color blindness can
tell apart.
"""

from hunav_drake.plots.activity import plot_behavior_activity
from hunav_drake.plots.approaches import Approach, find_approaches
from hunav_drake.plots.comparison import plot_comparison
from hunav_drake.plots.forces import plot_forces
from hunav_drake.plots.series import plot_distance_to_people, plot_robot_speed
from hunav_drake.plots.trajectories import plot_trajectories
from hunav_drake.plots.zones import plot_zones

__all__ = [
    "Approach",
    "find_approaches",
    "plot_behavior_activity",
    "plot_comparison",
    "plot_distance_to_people",
    "plot_forces",
    "plot_robot_speed",
    "plot_trajectories",
    "plot_zones",
]
