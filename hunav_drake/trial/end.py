"""Explains why a robot did not reach its goal, and what helps."""

import math

import numpy as np

from hunav_drake.scenario.error import path_text
from hunav_drake.scenario.reachability import FreeSpace, free_space, no_way
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Mask
from hunav_drake.systems.common.layout import RADIUS, VX, VY, YAW, X, Y
from hunav_drake.systems.common.poses import turn_between
from hunav_drake.systems.evaluation.recording import Recording

# The distances, surface to surface, below which a person may block a robot, and
# below which a robot touches a wall, in meters.
_IN_THE_WAY = 0.5
_TOUCHES = 0.03

# The distance ahead of a robot, surface to surface, within which an object is
# named, in meters: cautious planners stop as early.
_AHEAD = 1.0

# A person who is there for less is only passing by, in seconds.
_LEAST_TIME = 1.0

# A robot that stays within this radius stands, in meters.
_STANDS = 0.3

# The shortest stop that counts, in seconds.
_LEAST_STOP = 3.0


def explain_end(recording: Recording, scenario: Scenario) -> str:
    """Returns why the robot is not at its goal at the end of a recording.

    Args:
        recording: A trial that ended without success.
        scenario: The scenario of the trial.

    Returns:
        The reason and a remedy, in one line; empty if there is no goal, or if
        it is reached.
    """
    goal = recording.goal
    if goal is None:
        return ""
    x, y, yaw = recording.robot[-1, [X, Y, YAW]].tolist()
    distance = math.hypot(goal[0] - x, goal[1] - y)
    off = turn_between(yaw, goal[2])
    where = f"{distance:.2f} m from the goal"
    if distance < recording.goal_tolerance:
        limit = recording.goal_yaw_tolerance
        if off <= limit:
            return ""
        return (
            f"{where}, but heading off by {off:.2f} rad (goal_yaw_tolerance"
            f" {limit:g}); raise robot.goal_yaw_tolerance, to 3.15 if any"
            " heading will do"
        )
    stands = _time_of_stop(recording)
    space = free_space(scenario)
    radius = float(recording.robot[-1, RADIUS])
    if space is not None:
        # (A robot that touches a wall has no room, by rounding.)
        words = no_way(
            *(scenario, space, (x, y), (goal[0], goal[1]), radius),
            tolerance=recording.goal_tolerance,
        )
        if words:
            return f"{where}: {words}"
    blocked = _blocked_by(recording, stands)
    if blocked:
        return (
            f"{where}, {blocked}; try another planner, or people who make way"
        )
    if stands < _LEAST_STOP:
        return f"{where}, {_on_its_way(recording, distance)}"
    wall = ""
    nearest = space and space.nearest((x, y))
    if nearest and nearest[1] <= radius + _TOUCHES:
        wall = path_text(scenario, ("world", *nearest[0]))
    before = wall or _ahead(recording, scenario, space)
    what = f"at {wall} for" if wall else "standing for"
    what += f" {stands:.0f} s" + (f", {before}" if before != wall else "")
    return (
        f"{where}, {what}; try another planner or other"
        " parameters of it, or give the robot more room"
    )


def _time_of_stop(recording: Recording) -> float:
    """Returns how long the robot has stayed at its last place, in seconds."""
    places = recording.robot[:, [X, Y]]
    away = np.hypot(*(places - places[-1]).T) > _STANDS
    return _time_since_last(recording, away)


def _time_since_last(recording: Recording, events: Mask) -> float:
    """Returns the time since the last event, in seconds."""
    happened = np.flatnonzero(events)
    first = 0 if len(happened) == 0 else min(happened[-1] + 1, len(events) - 1)
    return float(recording.times[-1] - recording.times[first])


def _blocked_by(recording: Recording, stands: float) -> str:
    """Returns the people in the way at the end, and since when; "" if none."""
    if not recording.num_humans or stands < _LEAST_STOP:
        return ""
    robot, people = recording.robot[:, None], recording.humans
    between = people[..., [X, Y]] - robot[..., [X, Y]]
    gaps = np.hypot(between[..., 0], between[..., 1])
    gaps = gaps - people[..., RADIUS] - robot[..., RADIUS]
    near = gaps < _IN_THE_WAY
    # Ahead means the heading of the robot, or the direction of its goal.
    assert recording.goal is not None
    yaw = recording.robot[-1, YAW]
    to_goal = np.subtract(recording.goal[:2], recording.robot[-1, [X, Y]])
    dx, dy = between[-1].T
    faced = dx * math.cos(yaw) + dy * math.sin(yaw) > 0
    ahead = faced | (dx * to_goal[0] + dy * to_goal[1] > 0)
    found = np.flatnonzero(near[-1] & ahead)
    if not len(found):
        return ""
    times = [_time_since_last(recording, ~near[:, i]) for i in found]
    longest = int(np.argmax(times))
    time = min(times[longest], stands)
    if time < _LEAST_TIME:
        return ""
    names = [recording.human_names[found[longest]]]
    names += [
        recording.human_names[i]
        for i, own in zip(found, times, strict=True)
        if i != found[longest] and own >= time / 2
    ]
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"blocked by {names[0]}{more} for {time:.0f} s"


def _on_its_way(recording: Recording, distance: float) -> str:
    """Returns the speed of a moving robot, and the time that it needs."""
    recent = recording.times >= recording.times[-1] - 5.0
    speeds = np.hypot(*recording.robot[recent][:, [VX, VY]].T)
    speed = float(speeds.mean())
    if speed < 0.01:
        return "about to move; raise simulation.duration"
    longer = math.ceil(1.2 * distance / speed)
    needed = math.ceil(float(recording.times[-1])) + longer
    return (
        f"and on its way at {speed:.2f} m/s; raise simulation.duration, to"
        f" {needed} or more"
    )


def _ahead(
    recording: Recording, scenario: Scenario, space: FreeSpace | None
) -> str:
    """Returns the nearest object ahead of the robot at the end, or "".

    Ahead means along its heading and towards its goal, as wide as the robot.
    """
    assert recording.goal is not None
    x, y, yaw = recording.robot[-1, [X, Y, YAW]].tolist()
    dx, dy = recording.goal[0] - x, recording.goal[1] - y
    radius = float(recording.robot[-1, RADIUS])
    reach = min(math.hypot(dx, dy), _AHEAD)
    found: list[tuple[float, str]] = []
    for heading, gap in ((math.atan2(dy, dx), reach), (yaw, _AHEAD)):
        along = np.array([math.cos(heading), math.sin(heading)])
        end = along * (gap + radius) + (x, y)
        thing = space and space.before((x, y), (end[0], end[1]), radius)
        if thing:
            name = path_text(scenario, ("world", *thing[0]))
            found.append((thing[1] - radius, name))
        away = recording.humans[..., [X, Y]] - (x, y)
        dx, dy = away[..., 0], away[..., 1]
        ahead = dx * along[0] + dy * along[1]
        side = np.abs(dy * along[0] - dx * along[1])
        gaps = ahead - recording.humans[..., RADIUS] - radius
        widths = recording.humans[..., RADIUS] + radius
        there = (gaps < gap) & (gaps > -widths) & (side < widths)
        for i in np.flatnonzero(there[-1]):
            if _time_since_last(recording, ~there[:, i]) >= _LEAST_TIME:
                found.append((float(gaps[-1, i]), recording.human_names[i]))
    if not found:
        return ""
    distance, name = min(found)
    return f"{max(distance, 0.0):.2f} m before {name}"
