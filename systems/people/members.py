"""Draws the properties and the goals of people of a cohort or a source."""

from collections.abc import Mapping, Sequence
from functools import partial
import math
from typing import NamedTuple
import zlib

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.random_streams import Purpose, draw_uniform
from hunav_drake.systems.people.figure_config import (
    BUILDS,
    HEIGHTS,
    YOUNGEST,
    FigureConfig,
    Hair,
    Luggage,
    height_distribution,
)
from hunav_drake.systems.people.human_config import HumanConfig, NeedConfig
from hunav_drake.systems.people.placement import (
    Areas,
    Draws,
    Floor,
    choose,
    draw_point,
)
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    SourceConfig,
)
from hunav_drake.systems.people.walking_speeds import (
    mean_walking_speed,
    normal_quantiles,
    walking_speed_deviation,
)

# The people who start in one place, or come from it.
Members = CohortConfig | SourceConfig

# What men and women have, in equal parts.
_HAIR_OF: dict[bool, tuple[Hair, ...]] = {
    False: ("short", "short", "none"),
    True: ("long", "long", "bun"),
}
_CARRIED: tuple[Luggage, ...] = ("nothing", "nothing", "backpack", "bag")

# The number of streams of each cohort, and of each of its goals.
_PER_COHORT = 2**32
_PER_GOAL = 2**16


class NoRoomError(Exception):
    """Something has no place: the key, its item or None, and the reason."""

    def __init__(self, key: str, item: int | str | None, message: str) -> None:
        """Constructs the error."""
        super().__init__(message)
        self.key = key
        self.item = item
        self.message = message


def stream_of(name: str) -> int:
    """Returns the first stream number of a name."""
    return zlib.crc32(name.encode()) * _PER_COHORT


class Streams:
    """The random numbers of a cohort or a source."""

    def __init__(self, seed: int, name: str) -> None:
        """Constructs the random numbers of a name."""
        self._seed = seed
        self._first = stream_of(name)

    def draw(
        self, purpose: Purpose, numbers: Sequence[int], size: int
    ) -> Array:
        """Returns draws in [0, 1) of people or groups, (n, size)."""
        ids = [self._first + number for number in numbers]
        return draw_uniform(self._seed, ids, purpose, size)

    def of(self, purpose: Purpose, number: int) -> Draws:
        """Returns the function that gives the draws of one person or group."""
        return lambda size: self.draw(purpose, [number], size)[0]


class Bodies(NamedTuple):
    """The properties of n people of a cohort, apart from their goals.

    Attributes:
        ages: In years, shape (n,).
        is_woman: Booleans, shape (n,).
        speeds: The desired speed of each person alone, in m/s, shape (n,).
        radii: The radii of the bodies, in meters, shape (n,).
        yaws: The headings of people who go nowhere, in radians, shape (n,).
    """

    ages: Array
    is_woman: Mask
    speeds: Array
    radii: Array
    yaws: Array


class Manners(NamedTuple):
    """What people of a cohort do, and how they look.

    Attributes:
        behaviors: The behavior of each person.
        needs: The needs of each person.
        figures: How each person looks.
    """

    behaviors: list[str]
    needs: list[dict[str, NeedConfig]]
    figures: list[FigureConfig]


class Way(NamedTuple):
    """The goals of the people of a group.

    Attributes:
        goals: The points, one after the other, in W, in meters.
        sink: The name of the sink that is the last of them; "" for none.
    """

    goals: list[tuple[float, float]]
    sink: str


def draw_body_values(members: Members, streams: Streams) -> Bodies:
    """Returns the properties of people."""
    everybody = range(members.number)
    draws = streams.draw(Purpose.POPULATION_BODY, everybody, 6).T
    band = choose(draws[0], [it.weight for it in members.ages])
    low = np.array([it.low for it in members.ages])[band]
    high = np.array([it.high for it in members.ages])[band]
    ages = low + (high - low) * draws[1]
    is_woman = draws[2] < members.share_of_women
    if members.speed is None:
        mean = mean_walking_speed(ages, is_woman)
        deviation = walking_speed_deviation(mean)
    else:
        mean = np.full(members.number, members.speed.mean)
        deviation = np.full(members.number, members.speed.deviation)
    least, most = members.body_radius
    return Bodies(
        ages=ages,
        is_woman=is_woman,
        speeds=normal_quantiles(draws[3], mean, deviation),
        radii=least + (most - least) * draws[4],
        yaws=np.pi * (2 * draws[5] - 1),
    )


def draw_manners(members: Members, bodies: Bodies, streams: Streams) -> Manners:
    """Returns what people do, and how they look."""
    return Manners(
        _draw_behaviors(members, streams),
        _draw_needs(members, streams),
        _draw_figures(members, bodies, streams),
    )


def _draw_behaviors(members: Members, streams: Streams) -> list[str]:
    """Returns the behavior of each person."""
    draws = streams.draw(Purpose.POPULATION_BEHAVIOR, range(members.number), 1)
    names = list(members.behaviors)
    chosen = choose(draws[:, 0], list(members.behaviors.values()))
    return [names[i] for i in chosen.tolist()]


def _draw_needs(
    members: Members, streams: Streams
) -> list[dict[str, NeedConfig]]:
    """Returns the needs of each person."""
    people, needs = range(members.number), members.needs
    draws = streams.draw(Purpose.POPULATION_NEEDS, people, len(needs))
    low, high = np.array([it.initial for it in needs.values()]).reshape(-1, 2).T
    return [
        {
            name: NeedConfig(initial=level, rate=need.rate)
            for (name, need), level in zip(needs.items(), levels, strict=True)
        }
        for levels in (low + (high - low) * draws).tolist()
    ]


def _draw_figures(
    members: Members, bodies: Bodies, streams: Streams
) -> list[FigureConfig]:
    """Returns how each person looks."""
    if members.figures == "alike":
        return [FigureConfig() for _ in range(members.number)]
    people = range(members.number)
    draws = streams.draw(Purpose.POPULATION_FIGURE, people, 3).T
    heights = normal_quantiles(
        draws[0], *height_distribution(bodies.ages, bodies.is_woman)
    )
    radii = bodies.radii / np.mean(members.body_radius)
    return [
        FigureConfig(
            age=max(age, YOUNGEST),
            height=float(np.clip(height, *HEIGHTS)),
            build=float(np.clip(build, *BUILDS)),
            hair=_pick(hair, _HAIR_OF[bool(is_woman)]),
            carries=_pick(luggage, _CARRIED),
        )
        for age, height, build, is_woman, hair, luggage in zip(
            *(bodies.ages.tolist(), heights, radii, bodies.is_woman),
            *draws[1:],
            strict=True,
        )
    ]


def _pick[T](draw: float, things: Sequence[T]) -> T:
    """Returns one of some things, by a draw in [0, 1)."""
    return things[int(draw * len(things))]


def draw_groups(members: Members, streams: Streams) -> list[list[int]]:
    """Returns the indices in the cohort of the people of each group."""
    draws = streams.draw(Purpose.POPULATION_GROUP, range(members.number), 1)
    sizes = choose(draws[:, 0], members.group_sizes) + 1
    groups = []
    first = 0
    for size in sizes.tolist():
        if first < members.number:
            last = min(first + size, members.number)
            groups.append(list(range(first, last)))
            first = last
    return groups


def draw_way(
    members: Members,
    goal_areas: Sequence[Areas],
    sink_areas: Mapping[str, Areas],
    streams: Streams,
    floor: Floor,
    group: int,
) -> Way:
    """Returns the goals of the people of a group, one after the other.

    `goal_areas` are those of the goals, one after the other, `sink_areas` those
    of the sinks, by name; `group` is the number of the group among those of
    these people. If a goal or a sink has no place that is free of walls, a
    NoRoomError says so.
    """

    def place(area: Areas, i: int, key: str, item: int | str) -> list[float]:
        # A given point may be near a wall, as in the goals of a listed person.
        radius = 0.0 if area.is_point else members.radius
        stream = streams.of(Purpose.POPULATION_GOAL, group + i * _PER_GOAL)
        is_clear = partial(floor.is_clear_of_walls, radius=radius)
        point = draw_point(area, stream, is_clear)
        if point is None:
            where = (
                "is inside a wall; move it"
                if area.is_point
                else f"has no place {radius:g} m from all walls; enlarge or"
                " move it"
            )
            raise NoRoomError(key, item, where)
        return [float(x) for x in point]

    goals = [place(area, i, "goals", i) for i, area in enumerate(goal_areas)]
    if members.shuffle_goals and goals:
        draws = streams.draw(Purpose.POPULATION_ORDER, [group], len(goals))
        goals = [goals[i] for i in np.argsort(draws[0])]
    sink = ""
    if members.sinks:
        draws = streams.draw(Purpose.POPULATION_SINK, [group], 1)
        names = list(members.sinks)
        sink = names[int(choose(draws[:, 0], list(members.sinks.values()))[0])]
        goals.append(place(sink_areas[sink], len(goals), "sinks", sink))
    return Way([(x, y) for x, y in goals], sink)


def make_group(
    members: Members,
    rows: Sequence[int],
    points: Array,
    bodies: Bodies,
    manners: Manners,
    group_id: int,
    way: Way,
) -> list[HumanConfig]:
    """Returns drawn people of a cohort or a source who walk together.

    They walk as fast as the slowest of them. If they have a goal, they look to
    the first one. A single person is in no group.
    """
    speed = float(bodies.speeds[rows].min())
    people = []
    for k, (x, y) in zip(rows, points.tolist(), strict=True):
        yaw = float(bodies.yaws[k])
        if way.goals and way.goals[0] != (x, y):
            yaw = math.atan2(way.goals[0][1] - y, way.goals[0][0] - x)
        person = HumanConfig(
            name=f"{members.name}_{k + 1}" if members.name else "",
            pose=(x, y, yaw),
            behavior=manners.behaviors[k],
            needs=manners.needs[k],
            figure=manners.figures[k],
            desired_speed=speed,
            radius=members.radius,
            body_radius=float(bodies.radii[k]),
            group_id=group_id if len(rows) > 1 else -1,
            goals=list(way.goals),
            cyclic=False if way.sink else members.cyclic,
            goal_radius=members.goal_radius,
            forces=members.forces,
            forces_mode=members.forces_mode,
        )
        people.append(person)
    return people
