"""Relative metrics: how robot and crowd hinder each other, from one instant."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import math
from typing import Literal

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import VX, VY, YAW, Y
from hunav_drake.systems.common.poses import is_at_goal
from hunav_drake.systems.evaluation.features import surface_gaps
from hunav_drake.systems.evaluation.metric import RELATIVE_FAMILY, Direction
from hunav_drake.trial.branches.future import Future
from hunav_drake.trial.branches.kinds import Branch, Without
from hunav_drake.trial.branches.run import Fork
from hunav_drake.trial.leaving import ONLY_ROBOT
from hunav_drake.trial.result import TrialResult, with_values

# A person within this gap of the robot at any instant is a neighbour, in
# meters.
NEIGHBOUR = 3.6

# Ratios to motions with less jerk than this say nothing, in m/s.
_LEAST_JERK = 0.1

# CrowdBot: Grzeskowiak et al., "Crowd against the machine", 2021; extra times:
# Francis et al., "Principles and guidelines for evaluating social robot
# navigation algorithms", 2023.
_CROWDBOT = "Grzeskowiak et al. 2021"
_FRANCIS = "Francis et al. 2023"

LeftOut = Literal["people", "robot"]

# A trial with the others, and the same without them.
PairedFunction = Callable[[Future, Future], float]


@dataclass(frozen=True, kw_only=True)
class PairedMetric:
    """A metric of two futures from one instant.

    Attributes:
        name: Its name in tables and files.
        unit: Its unit; "-" for ratios.
        direction: Whether lower or higher values are better, or neither.
        source: The origin of its definition.
        left_out: Who is not there in the second one.
        function: The function that computes it.
        definition: Its description.
    """

    name: str
    unit: str
    direction: Direction
    source: str
    left_out: LeftOut
    function: PairedFunction
    definition: str


# All paired metrics by name, in the order of their registration.
PAIRED_METRICS: dict[str, PairedMetric] = {}


def register_paired_metric(
    name: str,
    unit: str,
    direction: Direction,
    source: str,
    left_out: LeftOut,
    definition: str = "",
) -> Callable[[PairedFunction], PairedFunction]:
    """Registers a function of two futures as a metric.

    It gets the trial from an instant on, and the same trial without the people,
    or without the robot, and returns a number, NaN for no value.

    Args:
        name: Its name in tables and files.
        unit: Its unit; "-" for ratios.
        direction: Whether "lower" or "higher" is better, or "none".
        source: The origin of its definition.
        left_out: Who is not there in the second future.
        definition: Its description; by default the function's docstring.

    Returns:
        A decorator that returns the function unchanged.

    Raises:
        ValueError: If another function has that name.
    """

    def register(function: PairedFunction) -> PairedFunction:
        known = PAIRED_METRICS.get(name)
        if known is not None and known.function.__module__ != (
            function.__module__
        ):
            raise ValueError(
                f"a paired metric named {name!r} is registered already; choose"
                " another name"
            )
        PAIRED_METRICS[name] = PairedMetric(
            name=name,
            unit=unit,
            direction=direction,
            source=source,
            left_out=left_out,
            function=function,
            definition=" ".join((definition or function.__doc__ or "").split()),
        )
        return function

    return register


@dataclass(frozen=True, kw_only=True, eq=False)
class Relative:
    """How the robot and the crowd hinder each other.

    Attributes:
        values: The `PAIRED_METRICS` by name.
        costs: By the name of each neighbour, what the robot costs: the extra
            time in seconds, and the extra path in meters; NaN for who does not
            arrive with or without the robot.
    """

    values: Mapping[str, float]
    costs: Mapping[str, tuple[float, float]]

    def texts(self) -> list[str]:
        """Returns the costs in words, as "the robot cost ana 1.3 s ..."."""
        # (Adding 0 takes away the sign of what rounds to 0.)
        return [
            f"the robot cost {name} {round(time, 2) + 0.0:.2f} s and"
            f" {round(path, 2) + 0.0:.2f} m"
            for name, (time, path) in self.costs.items()
            if not math.isnan(time)
        ]


def CompareAlone(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    until: float | None = None,
) -> Relative:
    """Compares a trial with itself without the people, and without the robot.

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
    robot = fork.robots[0] or ONLY_ROBOT
    without: dict[str, Branch] = {
        "people": Without(people=fork.names),
        "robot": Without(robots=(robot,)),
    }
    for branch in without.values():
        fork.Prepare(branch)
    with_all = fork.Run(Branch(), whole=False)
    others = {
        name: fork.Run(branch, whole=False) for name, branch in without.items()
    }
    gone = others["robot"].quantities
    extra = {name: with_all.quantities[name] - gone[name] for name in gone}
    near = neighbours(with_all)
    return Relative(
        values={
            name: float(metric.function(with_all, others[metric.left_out]))
            for name, metric in PAIRED_METRICS.items()
        },
        costs={
            name: (float(extra["time"][i]), float(extra["path"][i]))
            for i, name in enumerate(fork.names)
            if near[i]
        },
    )


def with_relative(result: TrialResult, relative: Relative) -> TrialResult:
    """Returns a result that also has the relative metrics.

    "extra_time[ana]" and "extra_path[ana]" are what the robot costs ana.
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
        if (metric := PAIRED_METRICS[name])
    }
    for person, costs in relative.costs.items():
        for kind, unit, value in zip(
            ("time", "path"), "sm", costs, strict=True
        ):
            more[f"extra_{kind}[{person}]"] = value, facts(unit, "lower")
    return with_values(result, more)


def neighbours(future: Future) -> Mask:
    """Returns who comes within `NEIGHBOUR` of the robot, shape (n,)."""
    near: Mask = (surface_gaps(_robot(future), future.humans) < NEIGHBOUR).any(
        axis=0
    )
    return near


def _robot(future: Future) -> Array:
    """Returns the states of the first robot, (K + 1, 7)."""
    return next(iter(future.robots.values()))


def _at_goal(future: Future) -> int:
    """Returns the first step at which the robot is at its goal, or -1."""
    if future.robot_goal is None:
        return -1
    x, y, yaw, *tolerances = future.robot_goal
    robot = _robot(future)
    there = is_at_goal(
        tuple(robot[:, : YAW + 1].T),
        (x, y, yaw),
        tolerance=tolerances[0],
        yaw_tolerance=tolerances[1],
    )
    return int(np.argmax(there)) if np.any(there) else -1


def _of_robot(future: Future) -> tuple[float, float, float]:
    """Returns time, path and jerk of the robot to its goal; NaN for never."""
    last = _at_goal(future)
    if last < 0:
        return math.nan, math.nan, math.nan
    robot, times = _robot(future)[: last + 1], future.times[: last + 1]
    way = np.diff(robot[:, : Y + 1], axis=0)
    speed = robot[:, VX] * np.cos(robot[:, YAW])
    speed = speed + robot[:, VY] * np.sin(robot[:, YAW])
    return (
        float(times[-1] - times[0]),
        float(np.hypot(*way.T).sum()),
        _jerk(speed[:, None], times),
    )


def _jerk(velocity: Array, times: Array) -> float:
    """Returns the integral of |jerk| of a velocity (k, d), in m/s^2."""
    steps = np.diff(times)[:, None]
    acceleration = np.diff(velocity, axis=0) / steps
    return float(np.linalg.norm(np.diff(acceleration, axis=0), axis=1).sum())


def _ratio(value: float, reference: float, least: float = 0.0) -> float:
    return value / reference if reference > least else math.nan


def _of_people(future: Future) -> Array:
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


def _compare_people(with_: Future, without: Future) -> tuple[Array, Array]:
    """Returns both values of time, path and jerk of neighbours, (3, m) each."""
    near = neighbours(with_)
    return _of_people(with_)[:, near], _of_people(without)[:, near]


def _mean(values: Array, nobody: float) -> float:
    """Returns the mean of numbers, without NaN; `nobody` without neighbours."""
    if not values.size:
        return nobody
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else math.nan


@register_paired_metric(
    "aggregated_time", "s", "lower", _FRANCIS, left_out="robot"
)
def aggregated_time(with_: Future, without: Future) -> float:
    """The sum of the extra times of the neighbours until they arrive."""
    value, other = _compare_people(with_, without)
    return float(np.nansum(value[0] - other[0]))


def _register(row: int, name: str, unit: str) -> None:
    """Registers the ratios and differences of a row of values."""
    least = _LEAST_JERK if name == "jerk" else 0.0
    robot_name = {"time": "time_to_goal", "path": "path_length"}.get(name, name)

    def robot_ratio(with_: Future, without: Future) -> float:
        return _ratio(_of_robot(without)[row], _of_robot(with_)[row], least)

    def robot_difference(with_: Future, without: Future) -> float:
        return _of_robot(with_)[row] - _of_robot(without)[row]

    def crowd_ratio(with_: Future, without: Future) -> float:
        value, other = _compare_people(with_, without)
        good = np.where(other[row] > least, other[row], math.nan)
        return _mean(value[row] / good, 1.0)

    def crowd_difference(with_: Future, without: Future) -> float:
        value, other = _compare_people(with_, without)
        return _mean(value[row] - other[row], 0.0)

    words = {"time": "time", "path": "length of the path"}.get(
        name, "integral of |jerk|"
    )

    def register(
        key: str,
        own_unit: str,
        direction: Direction,
        left_out: LeftOut,
        definition: str,
    ) -> Callable[[PairedFunction], PairedFunction]:
        return register_paired_metric(
            key, own_unit, direction, _CROWDBOT, left_out, definition
        )

    robots = f"The {words} of the robot to its goal,"
    people = f"The {words} of a neighbour until the arrival, with the robot"
    register(
        f"relative_{robot_name}",
        *("-", "higher", "people"),
        f"{robots} alone / in the crowd.",
    )(robot_ratio)
    register(
        f"{robot_name}_difference",
        *(unit, "lower", "people"),
        f"{robots} in the crowd - alone.",
    )(robot_difference)
    register(
        f"crowd_relative_{name}",
        *("-", "lower", "robot"),
        f"{people} / without; the mean.",
    )(crowd_ratio)
    register(
        f"crowd_{name}_difference",
        *(unit, "lower", "robot"),
        f"{people} - without; the mean.",
    )(crowd_difference)


for _row, (_name, _unit) in enumerate(
    (("time", "s"), ("path", "m"), ("jerk", "m/s^2"))
):
    _register(_row, _name, _unit)
