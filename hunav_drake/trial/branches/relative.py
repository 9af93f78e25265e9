"""Relative metrics: how robot and crowd hinder each other, from one instant."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import Literal, NamedTuple, cast, get_args

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.layout import VX, VY, YAW, Y
from hunav_drake.systems.common.poses import is_at_goal
from hunav_drake.systems.evaluation.features import surface_gaps
from hunav_drake.systems.evaluation.metric import (
    PAIRED_NAMES,
    RELATIVE_FAMILY,
    Direction,
    check_takes,
    origin_of,
)
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.trial.branches.future import Future, goal_of
from hunav_drake.trial.branches.kinds import Branch, Without
from hunav_drake.trial.branches.run import Fork
from hunav_drake.trial.leaving import ONLY_ROBOT
from hunav_drake.trial.result import TrialResult, with_values

# A person within this gap of the robot at any instant is a neighbour, in
# meters.
NEIGHBOUR = 3.6

# CrowdBot: Grzeskowiak et al., "Crowd against the machine", 2021; extra times:
# Francis et al., "Principles and guidelines for evaluating social robot
# navigation algorithms", 2023.
_CROWDBOT = "Grzeskowiak et al. 2021"
_FRANCIS = "Francis et al. 2023"

LeftOut = Literal["people", "robot"]

# A trial with the others, and the same without them.
PairedFunction = Callable[[Future, Future], float]


class PairedMetric(NamedTuple):
    """A metric of two futures from one instant.

    Attributes:
        unit: Its unit; "-" for ratios.
        direction: Whether lower or higher values are better, or neither.
        source: The origin of its definition.
        left_out: Who is not there in the second one.
        function: The function that computes it.
        definition: Its description.
    """

    unit: str
    direction: Direction
    source: str
    left_out: LeftOut
    function: PairedFunction
    definition: str


# All paired metrics by name, in the order of their registration.
PAIRED_METRICS: dict[str, PairedMetric] = {}


def register_paired_metric(
    name: str, unit: str, direction: Direction, source: str, left_out: LeftOut
) -> Callable[[PairedFunction], PairedFunction]:
    """Registers a function of two futures as a metric.

    It gets the trial from an instant on, and the same trial without the people,
    or without the robot, and returns a number, NaN for no value. Its docstring
    is the definition.

    Args:
        name: Its name in tables and files.
        unit: Its unit; "-" for ratios.
        direction: Whether "lower" or "higher" is better, or "none".
        source: The origin of its definition.
        left_out: Who is not there in the second future.

    Returns:
        A decorator that returns the function unchanged.

    Raises:
        ValueError: If another function has that name, or `direction` or
            `left_out` is none of these.
    """
    check_choice("direction", direction, get_args(Direction))
    check_choice("left_out", left_out, get_args(LeftOut))

    def register(function: PairedFunction) -> PairedFunction:
        check_takes(function, f"paired metric {name!r}", "with_", "without")
        known = PAIRED_METRICS.get(name)
        if known and origin_of(known.function) != origin_of(function):
            raise ValueError(
                f"a paired metric named {name!r} is registered already; choose"
                " another name"
            )
        text = " ".join((function.__doc__ or "").split())
        PAIRED_NAMES.add(name)
        PAIRED_METRICS[name] = PairedMetric(
            unit, direction, source, left_out, function, text
        )
        return function

    return register


@dataclass(frozen=True, kw_only=True, eq=False)
class Relative:
    """How the robot and the crowd hinder each other.

    Attributes:
        values: The `PAIRED_METRICS` by name; of several robots, those of each,
            as "anna.aggregated_time".
        costs: By the name of each neighbour, what the robot costs: the extra
            time in seconds, and the extra path in meters; NaN for who does not
            arrive with or without the robot. Of several robots, those of each,
            as "anna.luis".
        robots: The names of several robots.
    """

    values: Mapping[str, float]
    costs: Mapping[str, tuple[float, float]]
    robots: tuple[str, ...] = ()

    def texts(self) -> list[str]:
        """Returns the costs in words, as "the robot cost ana 1.3 s ..."."""
        # (Adding 0 takes away the sign of what rounds to 0.)
        return [
            f"{robot or 'the robot'} cost {person} {round(time, 2) + 0.0:.2f} s"
            f" and {round(path, 2) + 0.0:.2f} m"
            for key, (time, path) in self.costs.items()
            for robot, person in [self.split(key)]
            if not math.isnan(time)
        ]

    def split(self, name: str) -> tuple[str, str]:
        """Returns the robot of a name, empty for a single one, and the rest."""
        robot, _, rest = name.partition(".")
        return (robot, rest) if self.robots else ("", name)


def CompareAlone(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    until: float | None = None,
) -> Relative:
    """Compares a trial with itself without the people, and without the robot.

    Of several robots, each is compared: without it, the others are there.

    Args:
        scenario: The scenario of the trial.
        diagram: Its diagram, from `MakeTrialDiagram`.
        context: Its Context at the instant; it is not changed.
        until: The time until which trials run, in seconds; by default, the
            duration of the scenario.

    Raises:
        PlannerError: If a planner fails.
        ValueError: If somebody cannot be left out: see `LeaveOut` and
            `TakeRobotAway`.
    """
    if until is None:
        until = scenario.simulation.duration
    fork = Fork(scenario, diagram, context, until=until)
    without: list[Branch] = [Without(people=fork.names)]
    without += [Without(robots=(it or ONLY_ROBOT,)) for it in fork.robots]
    for branch in without:
        fork.Prepare(branch)
    with_all = fork.RunOriginal()
    alone, *robot_gone = (fork.Run(it, whole=False) for it in without)
    values: dict[str, float] = {}
    costs: dict[str, tuple[float, float]] = {}
    for (name, robot), gone in zip(
        robots_of(scenario).items(), robot_gone, strict=True
    ):
        own, other = (_of_one(it, name, robot) for it in (with_all, alone))
        others = {"people": other, "robot": gone}
        for metric, it in PAIRED_METRICS.items():
            value = it.function(own, others[it.left_out])
            values[_named(name, metric)] = float(value)
        extra = {
            quantity: own.quantities[quantity] - gone.quantities[quantity]
            for quantity in ("time", "path")
        }
        for i in np.flatnonzero(neighbours(own)):
            time, path = extra["time"][i], extra["path"][i]
            costs[_named(name, fork.names[i])] = float(time), float(path)
    return Relative(
        values=values, costs=costs, robots=tuple(filter(None, fork.robots))
    )


def _named(robot: str, name: str) -> str:
    """Returns a name of one of several robots; that of a single one is it."""
    return f"{robot}.{name}" if robot else name


def _of_one(future: Future, name: str, robot: RobotConfig) -> Future:
    """Returns a future with this robot as the first."""
    own = name or ONLY_ROBOT
    robots = {own: future.robots[own], **future.robots}
    return replace(future, robots=robots, robot_goal=goal_of(robot))


def unknown_relative(scenario: Scenario) -> Relative:
    """Returns metrics without a value, as of a trial that fails."""
    robots = robots_of(scenario)
    names = (_named(it, metric) for it in robots for metric in PAIRED_METRICS)
    return Relative(
        values=dict.fromkeys(names, math.nan),
        costs={},
        robots=tuple(filter(None, robots)),
    )


def with_relative(result: TrialResult, relative: Relative) -> TrialResult:
    """Returns a result that also has the relative metrics.

    "extra_time[ana]" and "extra_path[ana]" are what the robot costs ana; names
    of several robots come before, as in "anna.extra_time[ana]".
    """

    def facts(unit: str, direction: str) -> dict[str, str]:
        return {
            "units": unit,
            "families": RELATIVE_FAMILY,
            "directions": direction,
        }

    more = {
        name: (value, facts(metric.unit, metric.direction))
        for name, value in relative.values.items()
        if (metric := PAIRED_METRICS[relative.split(name)[1]])
    }
    for key, costs in relative.costs.items():
        robot, person = relative.split(key)
        for kind, unit, value in zip(
            ("time", "path"), "sm", costs, strict=True
        ):
            name = _named(robot, f"extra_{kind}[{person}]")
            more[name] = value, facts(unit, "lower")
    return with_values(result, more)


def neighbours(future: Future) -> Mask:
    """Returns who comes within `NEIGHBOUR` of the robot, shape (n,)."""
    gaps = surface_gaps(future.robot, future.humans)
    near: Mask = (gaps < NEIGHBOUR).any(axis=0)
    return near


def of_robot(future: Future) -> tuple[float, float, float]:
    """Returns time, path and jerk of the robot to its goal; NaN for never."""
    if future.robot_goal is None:
        return math.nan, math.nan, math.nan
    x, y, yaw, tolerance, yaw_tolerance = future.robot_goal
    there = is_at_goal(
        tuple(future.robot[:, : YAW + 1].T),
        (x, y, yaw),
        tolerance=tolerance,
        yaw_tolerance=yaw_tolerance,
    )
    if not np.any(there):
        return math.nan, math.nan, math.nan
    steps = slice(0, int(np.argmax(there)) + 1)
    robot, times = future.robot[steps], future.times[steps]
    way = np.diff(robot[:, : Y + 1], axis=0)
    heading = np.array([np.cos(robot[:, YAW]), np.sin(robot[:, YAW])]).T
    speed = (robot[:, VX : VY + 1] * heading).sum(axis=1, keepdims=True)
    time, path = float(times[-1] - times[0]), float(np.hypot(*way.T).sum())
    return time, path, _jerk(speed, times)


def _jerk(velocity: Array, times: Array) -> float:
    """Returns the integral of |jerk| of a velocity (k, d), in m/s^2."""
    steps = np.diff(times)[:, None]
    acceleration = np.diff(velocity, axis=0) / steps
    changes = np.diff(acceleration, axis=0)
    return float(np.sqrt((changes * changes).sum(axis=1)).sum())


def of_people(future: Future) -> Array:
    """Returns time, path and jerk of people until they arrive, (3, n)."""
    jerks = np.full(len(future.goals), math.nan)
    for i, arrival in enumerate(future.arrivals):
        steps = future.times <= arrival
        rows = future.humans[steps, i, VX : VY + 1]
        there = ~np.isnan(rows[:, 0])
        if steps.any():
            jerks[i] = _jerk(rows[there], future.times[steps][there])
    found = future.quantities
    return np.array([found["time"], found["path"], jerks])


def _mean(values: Array, nobody: float) -> float:
    """Returns the mean of numbers, without NaN; `nobody` without neighbours."""
    known = values[~np.isnan(values)]
    if not values.size:
        return nobody
    return float(known.mean()) if known.size else math.nan


@register_paired_metric("aggregated_time", "s", "lower", _FRANCIS, "robot")
def aggregated_time(with_: Future, without: Future) -> float:
    """The sum of the extra times of the neighbours until they arrive.

    Those who do not arrive in both do not count; NaN if nobody does.
    """
    extra = (with_.arrivals - without.arrivals)[neighbours(with_)]
    unknown = extra.size > 0 and np.isnan(extra).all()
    return math.nan if unknown else float(np.nansum(extra))


def _robot(row: int, is_ratio: bool, with_: Future, without: Future) -> float:
    """Returns the ratio alone / in the crowd, or the difference."""
    own, alone = of_robot(with_)[row], of_robot(without)[row]
    if not is_ratio:
        return own - alone
    return alone / own if own > _LEAST[row] else math.nan


def _crowd(row: int, is_ratio: bool, with_: Future, without: Future) -> float:
    """Returns the mean ratio with / without the robot, or the difference."""
    near = neighbours(with_)
    own, gone = (of_people(it)[row, near] for it in (with_, without))
    if not is_ratio:
        return _mean(own - gone, 0.0)
    return _mean(own / np.where(gone > _LEAST[row], gone, math.nan), 1.0)


# The smallest values of time, path and jerk to which ratios mean something.
_LEAST = (0.0, 0.0, 0.1)

_ROWS = (
    ("time", "time_to_goal", "s"),
    ("path", "path_length", "m"),
    ("jerk", "jerk", "m/s^2"),
)
for _row, (_of_crowd, _of_robot, _unit) in enumerate(_ROWS):
    for _name, _is_ratio, _better, _left_out, _function in (
        (f"relative_{_of_robot}", True, "higher", "people", _robot),
        (f"{_of_robot}_difference", False, "lower", "people", _robot),
        (f"crowd_relative_{_of_crowd}", True, "lower", "robot", _crowd),
        (f"crowd_{_of_crowd}_difference", False, "lower", "robot", _crowd),
    ):
        PAIRED_METRICS[_name] = PairedMetric(
            "-" if _is_ratio else _unit,
            cast(Direction, _better),
            _CROWDBOT,
            cast(LeftOut, _left_out),
            partial(_function, _row, _is_ratio),
            f"{_of_crowd}: {(_function.__doc__ or '').split(maxsplit=1)[1]}",
        )
