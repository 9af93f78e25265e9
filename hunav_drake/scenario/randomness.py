"""The random draws of a trial, and advice where there are none."""

from collections.abc import Iterator

from hunav_drake.scenario.checks import first_lidar
from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.population import people_seed
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.behavior import (
    BEHAVIORS,
    BehaviorTreeError,
    LoadBehaviors,
)
from hunav_drake.systems.crowd.motion_model import MotionModel
from hunav_drake.systems.people.behavior_choice import BehaviorConfig, tree_of
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.population_config import MembersConfig
from hunav_drake.systems.people.profile import ProfileName
from hunav_drake.systems.planning.planner import asked_scan_size

# The modes in which weights of forces are drawn at random.
_DRAWN_MODES = ("random_normal", "random_uniform")

# The behaviors in which the robot does not push; user-defined trees may ask
# for it.
_UNPUSHED = frozenset(BEHAVIORS) - {"scared"}


# The sizes of errors of sensors, perceptions and localizations.
_ERRORS = (
    *("noise", "noise_per_meter", "dropout", "velocity_noise"),
    *("missed", "missed_per_meter", "false_rate"),
    *("alpha1", "alpha2", "alpha3", "alpha4"),
    *("position_deviation", "yaw_deviation"),
)


def drawn_by_seed(scenario: Scenario) -> tuple[str, ...]:
    """Returns the random draws of a trial, in words; () if there are none.

    Without draws, all seeds give bitwise equal trials. With draws, recordings
    differ, unless a draw has no effect: weights of forces do not move a person
    without neighbors.

    User-defined sensors and perceptions, which get the seed, may draw.

    Args:
        scenario: The scenario. Its own seed does not matter.
    """
    return tuple(_draws(scenario))


def _draws(scenario: Scenario) -> Iterator[str]:
    population = scenario.population
    cohorts = [it for it in population.cohorts if it.number]
    sources = [it for it in population.sources if it.rate]
    if people_seed(scenario) is not None:
        yield "population"
    listed = [it for it in scenario.humans if it.track is None]
    if scenario.simulation.start_jitter and (listed or cohorts):
        yield "start jitter"
    people: list[HumanConfig | MembersConfig] = [*scenario.humans]
    people += [*cohorts, *sources]
    if any(_feels_weights(it, scenario.crowd.model) for it in people):
        yield "weights of forces"
    if sources:
        yield "arrivals at sources"
    if any(_draws_in(it, scenario.crowd.profile) for it in people):
        yield "chances of behaviors"
    decisions = scenario.crowd.decisions
    deciding = decisions is not None and decisions.sigma_heading > 0
    if deciding and (listed or cohorts or sources):
        yield "decisions of people"
    robots = [part.scenario for part in robot_parts(scenario)]
    if any(map(_is_noise_seen, robots)):
        yield "noise of the lidar"
    planners = [robot.planner for robot in robots]
    if any(_has_errors(planner.sees) for planner in planners):
        yield "errors of the detector"
    if any(_has_errors(planner.localization) for planner in planners):
        yield "error of the localization"
    own: list[object] = [it for robot in robots for it in robot.sensors]
    own += [it.sees for it in planners]
    own += [it.localization for it in planners]
    for part in (*own, *scenario.sensors):
        if is_own(part):
            yield f"user-defined {type(part).__name__}"


def _feels_weights(
    people: HumanConfig | MembersConfig, model: MotionModel
) -> bool:
    """Returns whether drawn weights of forces have an effect on people."""
    if people.forces_mode not in _DRAWN_MODES:
        return False
    if is_own(model) or model.uses_weights == "all":
        return True
    if isinstance(people, HumanConfig):
        grouped, behaviors = people.group_id >= 0, {people.behavior_name}
    else:
        grouped = any(people.group_sizes[1:])
        behaviors = {name for name, share in people.behaviors.items() if share}
    pushed = grouped or not behaviors <= _UNPUSHED
    return model.uses_weights == "pushed" and pushed


def _draws_in(
    people: HumanConfig | MembersConfig, profile: ProfileName
) -> bool:
    """Returns whether a behavior of people may draw at random."""
    behaviors: list[str | BehaviorConfig]
    if isinstance(people, HumanConfig):
        behaviors = [people.behavior]
    else:
        behaviors = [name for name, share in people.behaviors.items() if share]
    own = [it for it in behaviors if tree_of(it) not in BEHAVIORS]
    try:
        return any(it.draws for it in LoadBehaviors(own, profile=profile))
    except BehaviorTreeError:
        # (Whoever makes the trial is told.)
        return False


def _is_noise_seen(scenario: Scenario) -> bool:
    """Returns whether the planner gets measurements with noise."""
    planner = scenario.planner
    if is_own(planner) and not hasattr(planner, "scan_size"):
        # Its system may have an input port for what any sensor measures.
        return any(map(_has_errors, scenario.sensors))
    lidar = first_lidar(scenario)
    asks = planner.sees.by_lidar or asked_scan_size(planner) != 0
    return asks and lidar is not None and _has_errors(lidar)


def _has_errors(part: object) -> bool:
    """Returns whether a sensor, perception or localization draws errors."""
    return not is_own(part) and any(getattr(part, it, 0) for it in _ERRORS)


def is_own(part: object) -> bool:
    """Returns whether the class of a part of a scenario is user-defined."""
    return not type(part).__module__.startswith("hunav_drake.")


def how_to_draw(scenario: Scenario) -> str:
    """Returns the settings that make trials of different seeds differ."""
    population = scenario.population
    if not scenario.humans and not population.number:
        return "add people with simulation.start_jitter, or a population"
    words = ["set simulation.start_jitter", "crowd.decisions={}"]
    words.append("forces_mode: random_normal")
    if population.number:
        words.append("leave out population.seed")
    else:
        words.append("draw people by a population")
    return f"{', '.join(words[:-1])}, or {words[-1]}"


def same_for_all_seeds(scenario: Scenario) -> str:
    """Returns a note if all seeds give the same trial, else an empty text."""
    if drawn_by_seed(scenario):
        return ""
    return (
        "nothing is drawn at random, so all seeds give the same trial; for"
        f" others, {how_to_draw(scenario)}"
    )
