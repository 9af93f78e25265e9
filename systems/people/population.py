"""Draws the people of a population."""

from collections.abc import Sequence
from functools import partial
import math
from typing import NamedTuple
import zlib

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.random_streams import Purpose, draw_uniform
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.placement import (
    Areas,
    Draws,
    Floor,
    choose,
    draw_group,
    draw_point,
)
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
)
from hunav_drake.systems.people.walking_speeds import (
    mean_walking_speed,
    normal_quantiles,
    walking_speed_deviation,
)
from hunav_drake.systems.world.obstacles import Obstacles

# The numbers of what is drawn by: of each cohort, of each of its goals.
_PER_COHORT = 2**32
_PER_GOAL = 2**16


class PopulationFault(NamedTuple):
    """Why people of a population cannot be drawn.

    Attributes:
        cohort: The place of their cohort.
        key: The field of the cohort that is at fault: "start" or "goals".
        item: Which one of its list; None for the whole.
        message: The rule, what was found, and a remedy.
    """

    cohort: int
    key: str
    item: int | None
    message: str


class PopulationError(ValueError):
    """A population that does not fit into the world.

    Attributes:
        faults: All that is wrong with it, one for each cohort at most.
    """

    def __init__(self, faults: Sequence[PopulationFault]) -> None:
        """Constructs the error from what is wrong."""
        self.faults = tuple(faults)
        super().__init__(
            "\n".join(
                f"cohorts[{it.cohort}].{it.key}"
                f"{'' if it.item is None else f'[{it.item}]'}: {it.message}"
                for it in self.faults
            )
        )


class _NoRoomError(Exception):
    """What `_draw_cohort` cannot place: key, index and message."""


class Bodies(NamedTuple):
    """What n people of a cohort are, apart from where they go.

    Attributes:
        ages: In years, shape (n,).
        is_woman: Truths, shape (n,).
        speeds: The desired ones of each alone, in m/s, shape (n,).
        radii: Of their bodies, in meters, shape (n,).
        yaws: Where those look who go nowhere, in radians, shape (n,).
    """

    ages: Array
    is_woman: Mask
    speeds: Array
    radii: Array
    yaws: Array


def draw_population(
    config: PopulationConfig,
    obstacles: Obstacles,
    *,
    taken: ArrayLike = (),
    first_group_id: int = 0,
) -> list[HumanConfig]:
    """Draws the people of a population.

    A person is a function of the population's seed, the cohort's name (or
    place) and the person's place in the cohort. To add people, or a cohort,
    changes nobody else, but for those in whose way they would start.

    Args:
        config: The population, with its seed.
        obstacles: The walls, which nobody starts or has goals in.
        taken: Discs that nobody starts in, shape (k, 3), rows (x, y, radius)
            in W, in meters.
        first_group_id: The number of the first group; the others follow.

    Returns:
        The people, cohort by cohort. Those of a cohort with a name have
        names.

    Raises:
        PopulationError: If there is no room for somebody or for a goal. It
            has one fault for each cohort, at most.
    """
    floor = Floor(obstacles, taken, config.number)
    people: list[HumanConfig] = []
    faults = []
    group_id = first_group_id
    for i, cohort in enumerate(config.cohorts):
        streams = _Streams(config.seed, cohort.name or f"#{i}")
        before = floor.num_bodies
        try:
            people += _draw_cohort(cohort, streams, floor, group_id)
        except _NoRoomError as error:
            # So that this fault makes no others.
            floor.keep_bodies(before)
            key, index, message = error.args
            faults.append(PopulationFault(i, key, index, message))
        group_id = max([group_id, *(it.group_id + 1 for it in people)])
    if faults:
        raise PopulationError(faults)
    return people


class _Streams:
    """The random numbers of a cohort."""

    def __init__(self, seed: int, name: str) -> None:
        self._seed = seed
        self._first = zlib.crc32(name.encode()) * _PER_COHORT

    def draw(
        self, purpose: Purpose, numbers: Sequence[int], size: int
    ) -> Array:
        """Returns draws in [0, 1) of people or groups, (n, size)."""
        ids = [self._first + number for number in numbers]
        return draw_uniform(self._seed, ids, purpose, size)

    def of(self, purpose: Purpose, number: int) -> Draws:
        """Returns what gives the draws of one, as many as asked for."""
        return lambda size: self.draw(purpose, [number], size)[0]


def draw_bodies(cohort: CohortConfig, seed: int, name: str = "") -> Bodies:
    """Draws ages, sexes, speeds and radii of the people of a cohort.

    They are those of `draw_population` (of whom groups walk at the speed of
    their slowest) if the cohort has this name.

    Args:
        cohort: The cohort.
        seed: In [0, 2^63).
        name: By default that of the cohort, or "#0", as the first one of
            those without a name is called.

    Raises:
        ValueError: If the seed is not such a number.
    """
    streams = _Streams(seed, name or cohort.name or "#0")
    return _draw_bodies(cohort, streams)


def _draw_bodies(cohort: CohortConfig, streams: _Streams) -> Bodies:
    everybody = range(cohort.number)
    draws = streams.draw(Purpose.POPULATION_BODY, everybody, 6).T
    band = choose(draws[0], [it.weight for it in cohort.ages])
    low = np.array([it.low for it in cohort.ages])[band]
    high = np.array([it.high for it in cohort.ages])[band]
    ages = low + (high - low) * draws[1]
    is_woman = draws[2] < cohort.share_of_women
    if cohort.speed is None:
        mean = mean_walking_speed(ages, is_woman)
        deviation = walking_speed_deviation(mean)
    else:
        mean = np.full(cohort.number, cohort.speed.mean)
        deviation = np.full(cohort.number, cohort.speed.deviation)
    least, most = cohort.body_radius
    return Bodies(
        ages=ages,
        is_woman=is_woman,
        speeds=normal_quantiles(draws[3], mean, deviation),
        radii=least + (most - least) * draws[4],
        yaws=np.pi * (2 * draws[5] - 1),
    )


def _draw_cohort(
    cohort: CohortConfig, streams: _Streams, floor: Floor, group_id: int
) -> list[HumanConfig]:
    """Draws the people of one cohort, whose bodies the floor then has."""
    bodies = _draw_bodies(cohort, streams)
    draws = streams.draw(Purpose.POPULATION_BEHAVIOR, range(cohort.number), 1)
    names = list(cohort.behaviors)
    behaviors = choose(draws[:, 0], list(cohort.behaviors.values()))
    start = Areas(cohort.start)
    goal_areas = [Areas([area]) for area in cohort.goals]
    people: list[HumanConfig] = []
    for g, members in enumerate(_draw_groups(cohort, streams)):
        radii = bodies.radii[members].tolist()
        points = draw_group(
            start,
            [
                streams.of(Purpose.POPULATION_START, g),
                *(
                    streams.of(Purpose.POPULATION_MEMBER, k)
                    for k in members[1:]
                ),
            ],
            radii,
            lambda p, body: floor.is_free(
                p, cohort.radius, body, cohort.spacing
            ),
            cohort.spacing,
        )
        if points is None:
            raise _NoRoomError("start", None, _no_room(cohort, len(people)))
        floor.add_bodies(np.column_stack([points, radii]))
        goals = _draw_goals(cohort, goal_areas, streams, floor, g)
        in_group = len(members) > 1
        speed = float(bodies.speeds[members].min())
        for k, point in zip(members, points.tolist(), strict=True):
            yaw = float(bodies.yaws[k])
            if goals and goals[0] != tuple(point):
                yaw = math.atan2(goals[0][1] - point[1], goals[0][0] - point[0])
            people.append(
                HumanConfig(
                    name=f"{cohort.name}_{k + 1}" if cohort.name else "",
                    pose=(*point, yaw),
                    behavior=names[behaviors[k]],
                    desired_speed=speed,
                    radius=cohort.radius,
                    body_radius=float(bodies.radii[k]),
                    group_id=group_id if in_group else -1,
                    goals=list(goals),
                    cyclic=cohort.cyclic,
                    goal_radius=cohort.goal_radius,
                    forces=cohort.forces,
                    forces_mode=cohort.forces_mode,
                )
            )
        group_id += in_group
    return people


def _draw_groups(cohort: CohortConfig, streams: _Streams) -> list[list[int]]:
    """Returns the places in the cohort of the people of each group."""
    draws = streams.draw(Purpose.POPULATION_GROUP, range(cohort.number), 1)
    sizes = choose(draws[:, 0], cohort.group_sizes) + 1
    groups = []
    first = 0
    for size in sizes.tolist():
        if first < cohort.number:
            last = min(first + size, cohort.number)
            groups.append(list(range(first, last)))
            first = last
    return groups


def _draw_goals(
    cohort: CohortConfig,
    areas: Sequence[Areas],
    streams: _Streams,
    floor: Floor,
    group: int,
) -> list[tuple[float, float]]:
    """Returns where the people of a group go, one after the other."""
    goals = []
    for i, (area, config) in enumerate(zip(areas, cohort.goals, strict=True)):
        # Who is near a wall reaches a given point as well, as one listed.
        radius = 0.0 if config.point is not None else cohort.radius
        stream = streams.of(Purpose.POPULATION_GOAL, group + i * _PER_GOAL)
        point = draw_point(
            area, stream, partial(floor.is_clear_of_walls, radius=radius)
        )
        if point is None:
            where = (
                "is inside a wall; move it"
                if config.point is not None
                else f"has no place {radius:g} m from all walls; enlarge or"
                " move it"
            )
            raise _NoRoomError("goals", i, where)
        goals.append((float(point[0]), float(point[1])))
    if cohort.shuffle_goals and goals:
        draws = streams.draw(Purpose.POPULATION_ORDER, [group], len(goals))
        goals = [goals[i] for i in np.argsort(draws[0])]
    return goals


def _no_room(cohort: CohortConfig, placed: int) -> str:
    return (
        f"has room for {placed} of {cohort.number} people who are"
        f" {cohort.radius:g} m from walls and {cohort.spacing:g} m apart, as"
        " they were drawn; enlarge the areas, or lower number, radius or"
        " spacing"
    )
