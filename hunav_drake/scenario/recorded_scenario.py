"""Makes a scenario of the recorded people of a file."""

from collections.abc import Sequence
import dataclasses as dc
import math

import numpy as np

from hunav_drake.scenario.schema import Scenario, SimulationConfig
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.people.population_config import PopulationConfig
from hunav_drake.systems.people.track_config import TracksConfig
from hunav_drake.systems.robot.robots import DifferentialDriveConfig
from hunav_drake.systems.world.shapes import Polyline, World
from hunav_drake.tracks.recorded import load_tracks

Pose = tuple[float, float, float]

# The robot starts and ends where this share of all rows, along the longer side
# of the area, lies beyond it; halfway up the other side.
_MARGIN = 0.05

# How far from everybody it starts, if there is such a place beside the middle.
_APART = 1.0

_LONGEST = 86400.0


def import_tracks(
    config: TracksConfig, *, start: Pose | None = None, goal: Pose | None = None
) -> Scenario:
    """Returns a scenario with the recorded people of a file.

    The outlines that came with them become walls. The trial lasts as long as
    the recording, and begins with it unless it has a `start`. Without start or
    goal, the robot goes along the longer side of the area where people walk,
    through its middle, or beside it if somebody is where it starts: change it
    at will.

    Args:
        config: The file, and how its people are replayed.
        start: The start of the robot (x, y, yaw), in meters and radians.
        goal: Its goal, in the same way.

    Raises:
        OSError: If the file cannot be read.
        ValueError: If it is not valid.
    """
    tracks = load_tracks(config)
    if config.start == 0:
        first = min(it.times[0] for it in tracks.people)
        config = dc.replace(config, start=math.floor(10 * first) / 10)
        tracks = load_tracks(config)
    rows = np.vstack([it.positions for it in tracks.people])
    low, high = np.quantile(rows, [_MARGIN, 1 - _MARGIN], axis=0)
    longer = int(np.argmax(high - low))
    ends = np.tile(np.median(rows, axis=0), (2, 1))
    ends[:, longer] = low[longer], high[longer]
    step = SimulationConfig().time_step
    # (The first ones may come up to 0.1 s after the start.)
    there = [it.positions[0] for it in tracks.people if it.times[0] < 0.1]
    aside = np.eye(2)[1 - longer]
    ends += _free_place(ends[0], aside, low, high, there) - ends[0]
    yaw = round(longer * math.pi / 2, 4)
    poses = [(round(x, 2), round(y, 2), yaw) for x, y in ends.tolist()]
    last = max(it.times[-1] for it in tracks.people)
    (x0, y0), (x1, y1) = rows.min(axis=0), rows.max(axis=0)
    return Scenario(
        description=(
            f"{len(tracks.people)} recorded people, in an area from"
            f" ({x0:.1f}, {y0:.1f}) to ({x1:.1f}, {y1:.1f}) m"
        ),
        world=World(
            walls=[
                Polyline(points=np.round([*outline, outline[0]], 3).tolist())
                for outline in tracks.walls
            ]
        ),
        population=PopulationConfig(tracks=config),
        robot=DifferentialDriveConfig(
            start=poses[0] if start is None else start,
            goal=poses[1] if goal is None else goal,
        ),
        simulation=SimulationConfig(
            duration=min(
                round(math.ceil(last / step - 1e-9) * step, 9), _LONGEST
            )
        ),
    )


def _free_place(
    middle: Array,
    aside: Array,
    low: Array,
    high: Array,
    people: Sequence[Array],
) -> Array:
    """Returns the place nearest to `middle`, along `aside`, without people.

    It is in the box from `low` to `high`; without such a place, the middle.
    """
    step = _APART / 4
    most = math.ceil(math.dist(low, high) / step)
    for k in sorted(range(-most, most + 1), key=abs):
        place: Array = middle + k * step * aside
        is_in = k == 0 or ((low <= place) & (place <= high)).all()
        gaps = [math.dist(place, it) for it in people]
        if is_in and min(gaps, default=_APART) >= _APART:
            return place
    return middle
