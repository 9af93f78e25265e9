"""The people of a scenario: listed, recorded and drawn at random."""

from collections.abc import Iterator, Sequence
import dataclasses as dc

from hunav_drake.scenario.error import Finding, Loc, path_text, shown
from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.people.human_config import MAX_GROUP_ID, HumanConfig
from hunav_drake.systems.people.population import (
    Drawn,
    PopulationError,
    draw_with_traffic,
)
from hunav_drake.systems.people.population_config import PopulationConfig
from hunav_drake.systems.people.traffic import Traffic
from hunav_drake.systems.world.solids import WorldFileError
from hunav_drake.tracks.recorded import (
    load_tracks,
    people_of,
    present,
    track_of,
    with_track,
)


def draw_people(scenario: Scenario) -> list[HumanConfig]:
    """Returns all people of a scenario, with names and numbers.

    The order is: listed people, recorded people of the population, its cohorts,
    arrivals at sources. The pose of an arrival is a possible place of arrival,
    that of a recorded person the first one of its recording.

    Raises:
        PopulationError: If there is no room for a person.
        OSError: If a file of recorded people cannot be read.
        ValueError: If it is not valid, or a person is not in it.
    """
    return with_drawn_people(scenario)[0].humans


def with_drawn_people(scenario: Scenario) -> tuple[Scenario, Traffic | None]:
    """Returns a scenario with the people of its population in its list.

    Returns:
        The scenario; and the arrivals at sources and departures at sinks,
        None if there are none.

    Raises: As `draw_people`.
    """
    known = _known_people(scenario)
    drawn = _draw(scenario, known)
    listed = dc.replace(
        scenario, humans=[*known, *drawn.people], population=PopulationConfig()
    )
    traffic = drawn.traffic
    return listed, traffic and traffic.after(len(known))


def _known_people(scenario: Scenario) -> list[HumanConfig]:
    """Returns the people who are not drawn: listed, then recorded ones."""
    listed = [with_track(human) for human in scenario.humans]
    tracks = scenario.population.tracks
    if tracks is None:
        return listed
    groups = [human.group_id for human in listed]
    first = _first_free(groups, len(load_tracks(tracks).people))
    return [*listed, *people_of(tracks, first)]


def has_recorded_people(scenario: Scenario) -> bool:
    """Returns whether any person of a scenario follows a recording."""
    listed = any(human.track is not None for human in scenario.humans)
    return listed or scenario.population.tracks is not None


def people_who_never_come(scenario: Scenario) -> str:
    """Returns a note on recorded people who are there at no step, or ""."""
    tracks = [track_of(it.track) for it in scenario.humans if it.track]
    if scenario.population.tracks is not None:
        tracks += load_tracks(scenario.population.tracks).people
    simulation = scenario.simulation
    step, duration = simulation.time_step, simulation.duration
    few = len(tracks) - len(present(tracks, step, duration))
    if not few:
        return ""
    return (
        f"{few} of {len(tracks)} recorded people are not there at any step of"
        f" the trial, which ends at {duration:g} s; leave them out (`end` of"
        " tracks), or set a longer simulation.duration"
    )


def num_people(scenario: Scenario) -> int:
    """Returns the number of people: listed, recorded and drawn ones.

    Raises:
        OSError: If a file of recorded people cannot be read.
        ValueError: If it is not valid.
    """
    population = scenario.population
    people = len(scenario.humans) + population.number
    if population.tracks is not None:
        people += len(load_tracks(population.tracks).people)
    return people


def people_seed(scenario: Scenario) -> int | None:
    """Returns the seed of the trial if it draws the people, else None.

    It draws the people of a population without its own `seed`. A diagram then
    holds the people of one seed.
    """
    population = scenario.population
    follows = population.seed is None and population.number > 0
    return scenario.simulation.seed if follows else None


def _draw(scenario: Scenario, known: Sequence[HumanConfig]) -> Drawn:
    if not scenario.population.number:
        return Drawn([], None)
    population = scenario.population
    if population.seed is None:
        population = dc.replace(population, seed=people_seed(scenario))
    taken = [(*human.pose[:2], human.radius) for human in known]
    for part in robot_parts(scenario):
        robot = part.scenario.robot
        taken.append((*robot.start[:2], robot.radius))
    return draw_with_traffic(
        population,
        scenario.world.obstacles(),
        taken=taken,
        first_group_id=_first_free(
            [human.group_id for human in known], scenario.population.number
        ),
    )


def _first_free(groups: Sequence[int], number: int) -> int:
    """Returns the first of `number` consecutive numbers that no group has.

    They are the largest free ones.
    """
    taken = sorted({-1, *(it for it in groups if it >= 0)})
    ends = [*taken[1:], MAX_GROUP_ID + 1]
    gaps = [
        low + 1
        for low, end in zip(taken, ends, strict=True)
        if end - low > number
    ]
    return gaps[-1]


# The keys of a cohort or a source that depend on each other.
_KEYS = ("number", "max_present", "rate", "radius", "spacing", "start")


def check_population(scenario: Scenario) -> Iterator[Finding]:
    """Finds people of a population without room, or with a name in use."""
    uses: tuple[Loc, ...] = (
        ("humans",),
        ("robot", "start"),
        ("robot", "radius"),
        ("world",),
        ("population", "seed"),
        ("simulation", "seed"),
    )
    population = scenario.population
    if not population.number and population.tracks is None:
        return
    try:
        known = _known_people(scenario)
    except (OSError, ValueError):
        # The check of recorded people reports it.
        return
    try:
        people = [
            *known[len(scenario.humans) :],
            *_draw(scenario, known).people,
        ]
    except PopulationError as error:
        for fault in error.faults:
            loc: Loc = ("population", fault.kind, fault.cohort, fault.key)
            if fault.item is not None:
                loc = (*loc, fault.item)
            own = [(*loc[:3], key) for key in _KEYS]
            own.append(("population", "sinks"))
            yield Finding(loc, fault.message, uses=(*own, loc[:3], *uses))
        return
    except WorldFileError:
        # The check of the world reports it.
        return
    yield from _check_names(scenario, people)


def _check_names(
    scenario: Scenario, people: list[HumanConfig]
) -> Iterator[Finding]:
    listed = {h.name: i for i, h in enumerate(scenario.humans) if h.name}
    drawn = iter(people)
    if (tracks := scenario.population.tracks) is not None:
        recorded = len(load_tracks(tracks).people)
        names = [next(drawn).name for _ in range(recorded)]
        name = next((it for it in names if it in listed), None)
        if name is not None:
            yield _clash(scenario, ("population", "tracks"), name, listed)
    for kind in ("cohorts", "sources"):
        for i, members in enumerate(getattr(scenario.population, kind)):
            # Of each cohort or source, the first clash is reported.
            names = [next(drawn).name for _ in range(members.number)]
            name = next((it for it in names if it in listed), None)
            if name is None:
                continue
            loc: Loc = ("population", kind, i, "name")
            yield _clash(scenario, loc, name, listed)


def _clash(
    scenario: Scenario, loc: Loc, name: str, listed: dict[str, int]
) -> Finding:
    """Returns the finding of people with the name of a listed one."""
    human: Loc = ("humans", listed[name])
    return Finding(
        loc,
        f"must not give a name that somebody has, but {shown(name)} is"
        f" {path_text(scenario, human)}; rename one",
        uses=((*human, "name"),),
    )


def check_areas(scenario: Scenario) -> Iterator[Finding]:
    """Finds areas from which the start jitter may move people out of range."""
    most = MAX_COORDINATE - scenario.simulation.start_jitter
    for i, cohort in enumerate(scenario.population.cohorts):
        for k, area in enumerate(cohort.start):
            if abs(area.vertices()).max() > most:
                yield Finding(
                    ("population", "cohorts", i, "start", k),
                    f"must be within {most:.9g} m of the origin along x and y,"
                    " for simulation.start_jitter may take people beyond"
                    f" {MAX_COORDINATE:g} m; move it, or set the jitter to 0",
                    uses=(("simulation", "start_jitter"),),
                )
