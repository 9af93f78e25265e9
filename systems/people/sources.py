"""Draws the people who come in at a source."""

from collections.abc import Mapping, Sequence
from functools import partial
import math
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.random_streams import Purpose
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.members import (
    NoRoomError,
    Streams,
    Way,
    draw_body_values,
    draw_groups,
    draw_manners,
    draw_way,
    make_group,
    stream_of,
)
from hunav_drake.systems.people.placement import Areas, Floor, draw_points
from hunav_drake.systems.people.population_config import SourceConfig
from hunav_drake.systems.people.traffic import Source, place_party

# The number of places of a source where people may come in, if it is no point.
_PLACES = 64


class DrawnSource(NamedTuple):
    """A source and its people.

    Attributes:
        source: The source.
        people: The people who come, in the order of its parties. Their poses
            are places where they may come in.
        ways: The goals of each of them.
    """

    source: Source
    people: list[HumanConfig]
    ways: list[Way]


def draw_source(
    config: SourceConfig,
    sink_areas: Mapping[str, Areas],
    seed: int,
    floor: Floor,
    first_row: int,
    group_id: int,
) -> DrawnSource:
    """Draws the people who come in at a source.

    `sink_areas` are those of the sinks, by name; `first_row` people come before
    those of the source, and `group_id` is the number of its first group. If
    there is no place to come in or to go to, or if the rate needs more people,
    a NoRoomError says so.
    """
    streams = Streams(seed, config.name)
    places = _draw_places(config, streams, floor)
    bodies = draw_body_values(config, streams)
    manners = draw_manners(config, bodies, streams)
    goal_areas = [Areas([area]) for area in config.goals]
    people: list[HumanConfig] = []
    ways: list[Way] = []
    groups = draw_groups(config, streams)
    for g, members in enumerate(groups):
        radii = bodies.radii[members].tolist()
        # Each group starts with another place.
        order = np.roll(places, -g, axis=0)
        free = np.ones((len(members), len(order)), dtype=bool)
        points = place_party(order, free, radii, config.spacing)
        if points is None:
            raise NoRoomError("start", None, _no_room_for(len(members)))
        way = draw_way(config, goal_areas, sink_areas, streams, floor, g)
        people += make_group(
            *(config, members, points, bodies, manners, group_id, way)
        )
        ways += [way] * len(members)
        group_id += len(members) > 1
    _check_number(config, people)
    source = Source(
        name=config.name,
        rate=config.rate * len(groups) / len(people),
        stream=stream_of(config.name),
        parties=tuple(
            tuple(first_row + k for k in members) for members in groups
        ),
        places=places,
        spacing=config.spacing,
    )
    return DrawnSource(source, people, ways)


def _draw_places(config: SourceConfig, streams: Streams, floor: Floor) -> Array:
    """Returns the places where people may come in, shape (k, 2)."""
    areas = Areas(config.start)
    places = draw_points(
        areas,
        streams.of(Purpose.SOURCE_PLACE, 0),
        partial(floor.is_clear_of_walls, radius=config.radius),
        1 if areas.is_point else _PLACES,
    )
    if not len(places):
        raise NoRoomError(
            "start",
            None,
            f"has no place {config.radius:g} m from all walls; move or enlarge"
            " it, or lower radius",
        )
    return places


def _no_room_for(size: int) -> str:
    return (
        f"has no room for a group of {size} who come in together; enlarge it,"
        " or lower spacing or the weights of large groups"
    )


def _check_number(config: SourceConfig, people: Sequence[HumanConfig]) -> None:
    """Checks that there are enough people for the rate of a source.

    By Little's law, the mean number of people present is the rate times their
    mean time of stay, which is at least that of straight ways at the desired
    speed. If there are fewer people, a NoRoomError says so.
    """
    times = []
    for human in people:
        points = [human.pose[:2], *human.goals]
        way = sum(map(math.dist, points[:-1], points[1:]))
        way -= 2 * human.goal_radius * len(human.goals)
        times.append(max(way, 0.0) / human.desired_speed)
    stay = float(np.mean(times))
    least = math.ceil(config.rate * stay)
    if least > config.max_present:
        raise NoRoomError(
            "max_present",
            None,
            f"must be at least {least} for {config.rate:g} people per second,"
            f" who need {stay:.0f} s or more to their sinks, got"
            f" {config.max_present}; raise it, or lower rate",
        )
