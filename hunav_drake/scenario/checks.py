"""Checks of a scenario as a whole."""

from collections.abc import Callable, Iterator, Sequence
import dataclasses as dc
import functools
import itertools
import math
from typing import Any
import warnings

from hunav_drake.scenario.building import Check, Places, build_scenario
from hunav_drake.scenario.error import (
    Fault,
    Finding,
    Loc,
    ScenarioError,
    path_text,
    shown,
    suggestion,
)
from hunav_drake.scenario.fleet import find_of_each
from hunav_drake.scenario.geometry import GEOMETRY_CHECKS, find_unseen
from hunav_drake.scenario.population import check_areas, check_population
from hunav_drake.scenario.reachability import check_ways
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.checks import is_multiple, nearest_multiples
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.crowd.doors import REST
from hunav_drake.systems.people.behavior_choice import (
    BehaviorConfig,
    is_path,
    is_xml,
    tree_of,
)
from hunav_drake.systems.people.furniture_places import with_furniture
from hunav_drake.systems.people.human_config import STAND_IN, HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.places import Place, complete_places
from hunav_drake.systems.people.profile import ProfileName
from hunav_drake.systems.people.track_config import TrackConfig, TracksConfig
from hunav_drake.systems.people.tracks import Track
from hunav_drake.systems.planning.planner import asked_scan_size
from hunav_drake.systems.sensing.sensor_config import (
    CameraConfig,
    LidarConfig,
    name_sensors,
)
from hunav_drake.systems.sensing.sensor_parameters import Delayed
from hunav_drake.tracks.recorded import load_tracks, track_of

# Times that differ by less are the same, in seconds.
_SAME_TIME = 1e-9

# What a person with a track has of its recording, and the defaults.
_RECORDED = {
    field.name: field.default
    for field in dc.fields(HumanConfig)
    if field.name in ("desired_speed", "max_speed", "goal_radius", "cyclic")
} | {"pose": STAND_IN, "goals": []}

_MAX_UNKNOWN = 100  # At most so many unknown names get suggestions.


def CheckScenario(scenario: Scenario, *, ways: bool = True) -> Scenario:
    """Checks a scenario, as `hunav check` does for a file.

    A heading of more than a full turn, which may be in degrees, gives a
    warning, and so does a robot model that is smaller than the robot's disc.

    Args:
        scenario: A scenario, for instance one made or changed in Python.
        ways: Whether to check that the robot and the people can reach their
            goals on ways that are wide enough for their bodies. Trials run
            without this check.

    Returns:
        An equal scenario.

    Raises:
        ScenarioError: If the scenario does not fit the schema, or cannot be
            simulated. The place of each fault is "scenario".
        TypeError: If the argument is not a Scenario.
    """
    if not isinstance(scenario, Scenario):
        raise TypeError(
            f"a Scenario is needed, got {type(scenario).__name__};"
            " LoadScenario(filename='passing') gives one"
        )
    data = plain(scenario)
    checks = (*ALL_CHECKS, check_ways) if ways else ALL_CHECKS
    checked, findings = build_scenario(data, checks)
    places = Places()
    if checked is None:
        raise ScenarioError(
            "scenario", [places.fault(found, data) for found in findings]
        )
    if ways:
        warn_of_doubts(checked, lambda found: places.fault(found, data))
    return checked


def warn_of_doubts(
    scenario: Scenario, place: Callable[[Finding], Fault]
) -> None:
    """Warns of headings that may be in degrees, and of doubtful robots.

    The scenario has no faults; `place` makes a fault with its place of a
    finding.
    """
    for found in find_doubts(scenario):
        warnings.warn(str(place(found)), UserWarning, stacklevel=4)


def find_doubts(scenario: Scenario) -> list[Finding]:
    """Returns what may be meant differently in a scenario without faults."""
    doubts = [*find_of_each(_check_angles, scenario)]
    return [*doubts, *find_of_each(_find_doubts, scenario)]


def _find_doubts(scenario: Scenario) -> Iterator[Finding]:
    for loc, message in scenario.robot.find_doubts():
        yield Finding(("robot", *loc), message)


def _check_angles(scenario: Scenario) -> Iterator[Finding]:
    """Finds headings of more than a full turn, which may be in degrees."""
    robot = scenario.robot
    headings: list[tuple[Loc, float]] = [
        (("robot", "start", 2), robot.start[2])
    ]
    if robot.goal is not None:
        headings.append((("robot", "goal", 2), robot.goal[2]))
    for i, human in enumerate(scenario.humans):
        headings.append((("humans", i, "pose", 2), human.pose[2]))
    for loc, yaw in headings:
        if abs(yaw) > 2 * math.pi:
            yield Finding(
                loc,
                f"is {yaw:g} rad, more than a whole turn; if it is in degrees,"
                f" write {math.radians(yaw):.4f}",
            )


def check_people(scenario: Scenario) -> Iterator[Finding]:
    """Checks names, numbers, starts and speeds of people."""
    names: dict[str, int] = {}
    ids: dict[int, int] = {}
    starts: dict[tuple[float, ...], int] = {}
    for i, human in enumerate(scenario.humans):
        loc: Loc = ("humans", i)
        if human.name:
            yield from _unique(scenario, names, human.name, loc, "name")
        if human.id is not None:
            yield from _unique(scenario, ids, human.id, loc, "id")
        if human.track is not None:
            # Its recording has its start and its speeds.
            continue
        first = starts.setdefault(human.pose[:2], i)
        if first != i:
            other = path_text(scenario, ("humans", first))
            yield Finding(
                (*loc, "pose"),
                f"starts on the same point as {other};"
                f" move it by {2 * human.radius:g} m",
                uses=(("humans", first, "pose"),),
            )
        if human.speed_limit < human.desired_speed:
            yield Finding(
                (*loc, "max_speed"),
                f"must be at least desired_speed ({human.desired_speed:g}"
                f" m/s), got {human.speed_limit:g}",
                uses=((*loc, "desired_speed"),),
            )


def check_tracks(scenario: Scenario) -> Iterator[Finding]:
    """Finds recorded people who cannot be replayed."""
    configs: list[tuple[Loc, TracksConfig]] = [
        (("humans", i, "track"), human.track)
        for i, human in enumerate(scenario.humans)
        if human.track is not None
    ]
    if scenario.population.tracks is not None:
        configs.append((("population", "tracks"), scenario.population.tracks))
    told = set()
    holders: dict[Any, Loc] = {}
    for loc, config in configs:
        try:
            tracks = load_tracks(config).people
            if isinstance(config, TrackConfig):
                tracks = (track_of(config),)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None)
            message = f"{config.file}: {reason}" if reason else str(error)
            if message not in told:
                told.add(message)
                yield Finding(loc, message)
            continue
        yield from _check_presence(scenario, loc, config, tracks)
        for it in tracks:
            person = config.file, config.start, it.id
            other = holders.setdefault(person, loc)
            if other != loc:
                yield Finding(
                    loc,
                    f"must not have person {it.id} again, whom"
                    f" {path_text(scenario, other)} has: both would be on one"
                    " place; leave one out",
                    uses=(other,),
                )
                break
    for i, human in enumerate(scenario.humans):
        if human.track is None:
            continue
        loc = ("humans", i)
        for key, default in _RECORDED.items():
            if getattr(human, key) != default:
                yield Finding(
                    (*loc, key),
                    "must not be given to a person with a track, whose"
                    " recording has the way and the speed; leave it out",
                )
        if human.track.mode == "blind" and human.behavior != "regular":
            yield Finding(
                (*loc, "behavior"),
                "must be regular for a person who follows a recording whatever"
                f" the robot does, got {shown(human.behavior_name)}; leave it"
                " out, or take the mode hand_over or reactive",
                uses=((*loc, "track", "mode"),),
            )


def _check_presence(
    scenario: Scenario, loc: Loc, config: TracksConfig, tracks: Sequence[Track]
) -> Iterator[Finding]:
    """Finds bodies of a plant that would come, leave, or be elsewhere."""
    duration = scenario.simulation.duration
    stays = all(
        it.times[0] <= _SAME_TIME and it.times[-1] >= duration - _SAME_TIME
        for it in tracks
    )
    if scenario.robot.physical and (config.mode != "blind" or not stays):
        yield Finding(
            loc,
            "a physical robot needs recorded people with the mode blind who are"
            f" there from the start to the end of the trial ({duration:g} s):"
            " bodies of a MultibodyPlant cannot come and go; got robot"
            f" {name_of(scenario.robot)!r}; take differential_drive, or a"
            " shorter simulation.duration",
            uses=(("robot",), ("simulation", "duration")),
        )


def check_epsilon(scenario: Scenario) -> Iterator[Finding]:
    """Finds values of `epsilon` that the kernel of HuNavSim ignores."""
    model = scenario.crowd.model
    if getattr(model, "kernel", "") != "hunavsim":
        return
    default = SocialForceParameters().epsilon
    for i, human in enumerate(scenario.humans):
        epsilon = human.forces.epsilon if human.forces else default
        if epsilon not in (0, default):
            yield Finding(
                ("humans", i, "forces", "epsilon"),
                "has no part in the kernel 'hunavsim' of the crowd's model, got"
                f" {epsilon:g}; leave it out, or choose another kernel",
                uses=(("crowd", "model"), ("crowd", "profile")),
            )


def _unique(
    scenario: Scenario, taken: dict[Any, int], value: Any, loc: Loc, key: str
) -> Iterator[Finding]:
    """Finds a value that another member of the same list has."""
    first = taken.setdefault(value, int(loc[1]))
    if first != loc[1]:
        other = (loc[0], first)
        yield Finding(
            (*loc, key),
            f"must be unique, but {shown(value)} is already the {key} of"
            f" {path_text(scenario, other)}; change one",
            uses=((*other, key),),
        )


def check_jitter(scenario: Scenario) -> Iterator[Finding]:
    """Finds people that the start jitter may move out of the world."""
    jitter = scenario.simulation.start_jitter
    jitter_loc: Loc = ("simulation", "start_jitter")
    most = MAX_COORDINATE - jitter
    for i, human in enumerate(scenario.humans):
        for k in (0, 1):
            if abs(human.pose[k]) > most:
                yield Finding(
                    ("humans", i, "pose", k),
                    f"must be in [{-most:.9g}, {most:.9g}] m, got"
                    f" {human.pose[k]:.9g}: simulation.start_jitter"
                    f" ({jitter:g} m) may take the person beyond"
                    f" {MAX_COORDINATE:g} m; move it, or set the jitter to 0",
                    uses=(jitter_loc,),
                )


def check_times(scenario: Scenario) -> Iterator[Finding]:
    """Finds periods and durations that are no multiple of the time step."""
    step = scenario.simulation.time_step
    step_loc: Loc = ("simulation", "time_step")
    times: list[tuple[Loc, float]] = [
        (("planner", "period"), scenario.planner.period),
        (("evaluator", "period"), scenario.evaluator.period),
        (("simulation", "duration"), scenario.simulation.duration),
    ]
    if (decisions := scenario.crowd.decisions) is not None:
        times.append((("crowd", "decisions", "period"), decisions.period))
    delays: list[tuple[Loc, float]] = [
        (("robot", "command_delay"), scenario.robot.command_delay)
    ]
    places: list[tuple[Loc, Any]] = [
        (("planner", "sees"), scenario.planner.sees),
        *((("sensors", i), it) for i, it in enumerate(scenario.sensors)),
    ]
    for loc, part in places:
        if hasattr(part, "period"):
            times.append(((*loc, "period"), part.period))
        if isinstance(part, Delayed):
            delays.append(((*loc, "delay"), part.delay))
    for loc, time in times + [it for it in delays if it[1]]:
        if not is_multiple(time, step):
            yield Finding(
                loc,
                f"must be a multiple of simulation.time_step ({step:g} s),"
                f" got {time:g}; nearest: {nearest_multiples(time, step)}",
                uses=(step_loc,),
            )


def check_returns(scenario: Scenario) -> Iterator[Finding]:
    """Checks that nobody leaves and comes back between two samples."""
    period = scenario.evaluator.period
    if scenario.population.sources and period > REST:
        yield Finding(
            ("evaluator", "period"),
            f"must be at most {REST:g} s where people of sources come back, so"
            " that nobody seems to walk from a sink to a source between two"
            f" samples; got {period:g}",
            uses=(("population", "sources"),),
        )


def check_start(scenario: Scenario) -> Iterator[Finding]:
    """Finds a recording that would never begin."""
    start = scenario.evaluator.start
    if start == "at_goal_command" and scenario.robot.goal is None:
        yield Finding(
            ("evaluator", "start"),
            f"must not be {shown(start)} where the robot has no goal: nothing"
            " would be recorded; set robot.goal, or take at_once",
            uses=(("robot", "goal"),),
        )


def check_begins_alone(scenario: Scenario) -> None:
    """Checks that nobody needs to begin the recording of a trial.

    Raises:
        ScenarioError: If it waits for its trigger.
    """
    if scenario.evaluator.start == "by_trigger":
        source = scenario.name or "scenario"
        message = (
            "by_trigger waits for the input port trigger, which a trial that"
            " runs by itself leaves unconnected; take another start, or"
            " MakeTrialDiagram() in Python"
        )
        fault = Fault(source, 0, "evaluator.start", message)
        raise ScenarioError(source, [fault])


def check_sensors(scenario: Scenario) -> Iterator[Finding]:
    """Checks that the names of sensors are unique."""
    taken: dict[str, int] = {}
    for i, sensor in enumerate(scenario.sensors):
        if sensor.name:
            loc: Loc = ("sensors", i)
            yield from _unique(scenario, taken, sensor.name, loc, "name")


def first_lidar(scenario: Scenario) -> LidarConfig | None:
    """Returns the lidar whose scan the planner gets, if there is one."""
    lidars = (it for it in scenario.sensors if isinstance(it, LidarConfig))
    return next(lidars, None)


def scans_of(scenario: Scenario) -> Iterator[tuple[str, str, LidarConfig]]:
    """Yields the port, the name and the lidar of each scan of one robot.

    The name of the first is empty.
    """
    names = name_sensors(scenario.sensors)
    first = True
    for name, sensor in zip(names, scenario.sensors, strict=True):
        if isinstance(sensor, LidarConfig):
            yield (
                ("scan", "", sensor)
                if first
                else (f"{name}_scan", name, sensor)
            )
            first = False


def scan_fault(scenario: Scenario, scan_size: int | None) -> str:
    """Returns why a planner cannot get its scan; an empty text if it can.

    `scan_size` is the number of distances that it asks for: see
    `Planner.scan_size`.
    """
    lidar = first_lidar(scenario)
    planner = f"the planner {name_of(scenario.planner)!r}"
    if scan_size == 0:
        return ""
    if lidar is None:
        rays = f", num_rays: {scan_size}" if scan_size else ""
        return (
            f"{planner} needs a lidar (port scan), and there is none; add"
            f" sensors: [{{type: lidar{rays}}}], or choose another planner"
        )
    if scan_size not in (None, lidar.num_rays):
        return (
            f"{planner} needs a lidar of {scan_size} rays, but the first one"
            f" has {lidar.num_rays}; set its num_rays to {scan_size}"
        )
    return ""


def check_scan(scenario: Scenario) -> Iterator[Finding]:
    """Finds a planner without the lidar that it needs."""
    planner = scenario.planner
    if planner.sees.by_lidar and first_lidar(scenario) is None:
        # The trial adds a lidar.
        return
    if message := scan_fault(scenario, asked_scan_size(planner)):
        yield Finding(("planner",), message, uses=(("sensors",),))


def check_names(scenario: Scenario) -> Iterator[Finding]:
    """Finds unknown or faulty behaviors, and unknown metrics."""
    yield from _check_behaviors(scenario)
    yield from _check_metrics(scenario)


def _check_behaviors(scenario: Scenario) -> Iterator[Finding]:
    # Imported here, as below: only reading or writing needs no systems.
    from hunav_drake.systems.behavior import BEHAVIORS, LoadBehavior, Tree

    profile = scenario.crowd.profile
    # Many people have the same behavior, which is checked once.
    known: dict[str, list[tuple[Loc, str]]] = {}
    trees: dict[str, Tree] = {}
    check = _name_check(scenario)
    for whole, behavior in _behaviors(scenario):
        if isinstance(behavior, str) and behavior in BEHAVIORS:
            continue
        key = repr(behavior)
        if key not in known:
            if len(known) == _MAX_UNKNOWN:
                return
            known[key] = list(_behavior_faults(behavior, profile))
            if not known[key]:
                trees[key] = LoadBehavior(behavior, profile=profile)
        for loc, message in known[key] or check(whole, trees[key]):
            yield Finding((*whole, *loc), message, uses=(whole,))


def _name_check(
    scenario: Scenario,
) -> Callable[[Loc, Any], list[tuple[Loc, str]]]:
    """Returns what finds the first person or place that is not there.

    It takes the place of a behavior in the scenario, and its tree.
    """
    from hunav_drake.systems.behavior import BehaviorTreeError
    from hunav_drake.systems.behavior.society import check_named

    @functools.cache
    def known() -> tuple[dict[Loc, list[int]], list[Place]] | None:
        try:
            return _numbers(scenario), with_furniture(
                scenario.places, scenario.world
            )
        except (OSError, ValueError):
            # (That is told by itself.)
            return None

    def check(whole: Loc, tree: Any) -> list[tuple[Loc, str]]:
        if not tree.is_social or (found := known()) is None:
            return []
        numbers, places = found
        is_listed = whole[0] == "humans"
        who = whole[:-1] if is_listed else whole[:3]
        everybody: dict[Any, Sequence[Any]] = {
            "humans": scenario.humans,
            "cohorts": scenario.population.cohorts,
            "sources": scenario.population.sources,
        }
        needs = everybody[who[-2]][int(who[-1])].needs
        own = numbers[who]
        ids = {*itertools.chain.from_iterable(numbers.values())}
        try:
            check_named(tree, own, ids, places, needs)
        except BehaviorTreeError as error:
            return [((), str(error))]
        return []

    return check


def _numbers(scenario: Scenario) -> dict[Loc, list[int]]:
    """Returns the numbers of all people, listed, recorded and drawn."""
    population = scenario.population
    counts: dict[Loc, int] = {}
    if population.tracks is not None:
        recorded = load_tracks(population.tracks).people
        counts["population", "tracks"] = len(recorded)
    for kind in ("cohorts", "sources"):
        for i, it in enumerate(getattr(population, kind)):
            counts["population", kind, i] = it.number
    drawn = [HumanConfig(pose=STAND_IN)] * sum(counts.values())
    ids = iter(people_ids([*scenario.humans, *drawn]))
    listed: dict[Loc, int] = {
        ("humans", i): 1 for i in range(len(scenario.humans))
    }
    return {
        loc: list(itertools.islice(ids, count))
        for loc, count in (listed | counts).items()
    }


def check_place_names(scenario: Scenario) -> Iterator[Finding]:
    """Finds places of the same name or number."""
    try:
        complete_places(scenario.places)
    except ValueError as error:
        yield Finding(("places",), str(error))


def _behaviors(
    scenario: Scenario,
) -> Iterator[tuple[Loc, str | BehaviorConfig]]:
    """Yields the behaviors of all people with their places."""
    for i, human in enumerate(scenario.humans):
        yield ("humans", i, "behavior"), human.behavior
    for kind in ("cohorts", "sources"):
        for i, members in enumerate(getattr(scenario.population, kind)):
            for name in members.behaviors:
                yield ("population", kind, i, "behaviors", name), name


def _behavior_faults(
    behavior: str | BehaviorConfig, profile: ProfileName
) -> Iterator[tuple[Loc, str]]:
    """Yields the faults of a behavior, each with its place in it."""
    from hunav_drake.systems.behavior import (
        ACTIVITIES,
        BEHAVIORS,
        CheckBehavior,
        TreePortError,
    )

    tree = tree_of(behavior)
    loc: Loc = () if isinstance(behavior, str) else (TAG,)
    known = [*BEHAVIORS, *ACTIVITIES]
    if tree not in known and not is_xml(tree) and not is_path(tree):
        yield (
            loc,
            f"there is no behavior {shown(tree)}; {suggestion(tree, known)}",
        )
        return
    for error in CheckBehavior(behavior, profile=profile):
        if isinstance(error, TreePortError):
            yield (error.port,), error.message
        else:
            yield loc, str(error)


def _check_metrics(scenario: Scenario) -> Iterator[Finding]:
    from hunav_drake.systems.evaluation import select_metrics

    first: dict[str, int] = {}
    for i, name in enumerate(scenario.evaluator.metrics):
        first.setdefault(name, i)
    unknown = 0
    for name, i in first.items():
        try:
            select_metrics([name])
        except ValueError as error:
            yield Finding(("evaluator", "metrics", i), str(error))
            unknown += 1
            if unknown == _MAX_UNKNOWN:
                return


def check_robot(scenario: Scenario) -> Iterator[Finding]:
    """Finds faults of the robot: of its files, bodies and joints."""
    for place, message in scenario.robot.find_faults():
        yield Finding(("robot", *place), message)


def check_pictures(scenario: Scenario) -> Iterator[Finding]:
    """Finds models in files that cameras cannot render."""
    if not any(isinstance(it, CameraConfig) for it in scenario.sensors):
        return
    for loc, fault in find_unseen(scenario.world, scenario.robot):
        yield Finding(
            loc,
            f"no camera can see it: {fault}; export its meshes with normals, or"
            " leave the camera out",
        )


def check_bodies(scenario: Scenario) -> Iterator[Finding]:
    """Checks that people who are bodies of a plant never come or leave."""
    population = scenario.population
    if not scenario.robot.physical:
        return
    leave = [
        ("population", "cohorts", i, "sinks")
        for i, cohort in enumerate(population.cohorts)
        if cohort.sinks
    ]
    come = [("population", "sources")] if population.sources else []
    for loc in (come + leave)[:1]:
        yield Finding(
            loc,
            "a physical robot needs people who are there from the start to the"
            " end: bodies of a MultibodyPlant cannot come and go; got robot"
            f" {name_of(scenario.robot)!r}; take differential_drive, or people"
            " of cohorts without sinks",
            uses=(("robot",),),
        )


# Checks that need neither the geometry of the world nor what is installed.
OWN_CHECKS: tuple[Check, ...] = (
    check_people,
    check_place_names,
    check_epsilon,
    check_jitter,
    check_bodies,
    check_times,
    check_returns,
    check_start,
    check_sensors,
    check_scan,
    check_areas,
)
ALL_CHECKS: tuple[Check, ...] = (
    *OWN_CHECKS,
    *GEOMETRY_CHECKS,
    check_tracks,
    check_population,
    check_names,
    check_robot,
    check_pictures,
)
