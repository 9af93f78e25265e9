"""Draws the people of a population."""

from collections.abc import Mapping, Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.random_streams import Purpose
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.members import (
    Bodies,
    NoRoomError,
    Streams,
    Way,
    draw_body_values,
    draw_groups,
    draw_manners,
    draw_way,
    make_group,
)
from hunav_drake.systems.people.placement import Areas, Floor, draw_group
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
)
from hunav_drake.systems.people.sources import draw_source
from hunav_drake.systems.people.traffic import Sink, Source, Traffic
from hunav_drake.systems.world.obstacles import Obstacles


class PopulationFault(NamedTuple):
    """The reason why people of a population cannot be drawn.

    Attributes:
        cohort: The index of their cohort or source.
        key: The field of it that is at fault, as "start" or "goals".
        item: The item of its list or mapping; None for the whole.
        kind: Whether it is one of the "cohorts" or of the "sources".
    """

    cohort: int
    key: str
    item: int | str | None
    message: str
    kind: str = "cohorts"


class PopulationError(ValueError):
    """A population that does not fit into the world.

    Attributes:
        faults: All faults, at most one for each cohort and source.
    """

    def __init__(self, faults: Sequence[PopulationFault]) -> None:
        """Constructs the error from the faults."""
        self.faults = tuple(faults)
        super().__init__(
            "\n".join(
                f"{it.kind}[{it.cohort}].{it.key}"
                f"{'' if it.item is None else f'[{it.item}]'}: {it.message}"
                for it in self.faults
            )
        )


class Drawn(NamedTuple):
    """The people of a population, and their sources and sinks.

    Attributes:
        people: All of them, cohort by cohort, then source by source.
        traffic: The sources and sinks of these people; None if there are none.
            Its rows are those of `people`.
    """

    people: list[HumanConfig]
    traffic: Traffic | None


def draw_population(
    config: PopulationConfig,
    obstacles: Obstacles,
    *,
    taken: ArrayLike = (),
    first_group_id: int = 0,
) -> list[HumanConfig]:
    """Draws the people of a population: see `draw_with_traffic`.

    Returns:
        The people, cohort by cohort, then source by source. Those of a cohort
        with a name, and of a source, have names.
    """
    return draw_with_traffic(
        config, obstacles, taken=taken, first_group_id=first_group_id
    ).people


def draw_with_traffic(
    config: PopulationConfig,
    obstacles: Obstacles,
    *,
    taken: ArrayLike = (),
    first_group_id: int = 0,
) -> Drawn:
    """Draws the people of a population, and their sources and sinks.

    A person is a function of the population's seed, the cohort's name (or
    index) and the person's index in the cohort. Adding people, or a cohort,
    changes nobody else, except people who would start in their way.

    Args:
        config: The population, with its seed.
        obstacles: The walls, in which nobody starts or has goals.
        taken: Discs in which nobody starts, shape (k, 3), rows (x, y, radius)
            in W, in meters.
        first_group_id: The number of the first group; the others follow.

    Returns:
        The people, and their sources and sinks.

    Raises:
        PopulationError: If there is no room for a person or for a goal, or if
            a source has too few people for its rate. It has at most one fault
            for each cohort and source.
    """
    floor = Floor(obstacles, taken, config.number)
    sink_areas = {sink.name: Areas([sink.area]) for sink in config.sinks}
    seed = config.seed or 0
    people: list[HumanConfig] = []
    ways: list[Way] = []
    sources: list[Source] = []
    faults = []
    group_id = first_group_id
    for i, cohort in enumerate(config.cohorts):
        streams = Streams(seed, cohort.name or f"#{i}")
        before = floor.num_bodies
        try:
            drawn = _draw_cohort(cohort, sink_areas, streams, floor, group_id)
            people += drawn[0]
            ways += drawn[1]
        except NoRoomError as error:
            # This fault must not cause others.
            floor.keep_bodies(before)
            where = error.key, error.item, error.message
            faults.append(PopulationFault(i, *where))
        group_id = max([group_id, *(it.group_id + 1 for it in people)])
    for i, source in enumerate(config.sources):
        try:
            own = draw_source(
                source, sink_areas, seed, floor, len(people), group_id
            )
        except NoRoomError as error:
            where = error.key, error.item, error.message
            faults.append(PopulationFault(i, *where, "sources"))
            continue
        people += own.people
        ways += own.ways
        sources.append(own.source)
        group_id = max([group_id, *(it.group_id + 1 for it in people)])
    if faults:
        raise PopulationError(faults)
    return Drawn(people, _traffic(config, sources, ways))


def _traffic(
    config: PopulationConfig, sources: list[Source], ways: list[Way]
) -> Traffic | None:
    """Returns the sources and sinks of people, if there are any."""
    if not sources and not any(way.sink for way in ways):
        return None
    places = {sink.name: i for i, sink in enumerate(config.sinks)}
    return Traffic(
        sources=tuple(sources),
        sinks=tuple(
            Sink(it.name, it.area.vertices(), it.radius, it.rate or math.inf)
            for it in config.sinks
        ),
        sink_of=np.array([places.get(way.sink, -1) for way in ways], dtype=int),
        exits=np.array(
            [way.goals[-1] if way.sink else (0.0, 0.0) for way in ways]
        ).reshape(-1, 2),
    )


def draw_bodies(cohort: CohortConfig, seed: int, name: str = "") -> Bodies:
    """Draws ages, sexes, speeds and radii of the people of a cohort.

    They are those of `draw_population` (in which groups walk at the speed of
    their slowest member) if the cohort has this name.

    Args:
        cohort: The cohort.
        seed: In [0, 2^63).
        name: By default that of the cohort, or "#0", the name of the first one
            without a name.

    Raises:
        ValueError: If the seed is not such a number.
    """
    return draw_body_values(cohort, Streams(seed, name or cohort.name or "#0"))


def _draw_cohort(
    cohort: CohortConfig,
    sink_areas: Mapping[str, Areas],
    streams: Streams,
    floor: Floor,
    group_id: int,
) -> tuple[list[HumanConfig], list[Way]]:
    """Draws the people of one cohort, and adds their bodies to the floor."""
    bodies = draw_body_values(cohort, streams)
    manners = draw_manners(cohort, bodies, streams)
    start = Areas(cohort.start)
    goal_areas = [Areas([area]) for area in cohort.goals]
    people: list[HumanConfig] = []
    ways: list[Way] = []
    for g, members in enumerate(draw_groups(cohort, streams)):
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
            raise NoRoomError("start", None, _no_room(cohort, len(people)))
        floor.add_bodies(np.column_stack([points, radii]))
        way = draw_way(cohort, goal_areas, sink_areas, streams, floor, g)
        people += make_group(
            *(cohort, members, points, bodies, manners, group_id, way)
        )
        ways += [way] * len(members)
        group_id += len(members) > 1
    return people, ways


def _no_room(cohort: CohortConfig, placed: int) -> str:
    return (
        f"has room for {placed} of {cohort.number} people who are"
        f" {cohort.radius:g} m from walls and {cohort.spacing:g} m apart, as"
        " they were drawn; enlarge the areas, or lower number, radius or"
        " spacing"
    )
