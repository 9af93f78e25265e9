"""One branch of a trial, from an instant on."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.behavior import BehaviorTree
from hunav_drake.systems.behavior.leaves.walking import GOAL_MARGIN
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    FORCES_SIZE,
    SOCIAL_FORCE,
    STATE_SIZE,
    VX,
    VY,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.evaluation.chords import chords_within
from hunav_drake.systems.robot.robot_config import RobotConfig
from hunav_drake.trial.leaving import ONLY_ROBOT
from hunav_drake.trial.result import TrialResult
from hunav_drake.trial.simulation import GetTrialResult, MakeTrialSimulator

# What is told of each person until the arrival, and in which unit.
QUANTITIES: Mapping[str, str] = {
    "time": "s",
    "path": "m",
    "social_impulse": "m/s",
    "social_work": "m^2/s^2",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Future:
    """A trial from an instant on, at all its K + 1 steps.

    Attributes:
        times: Shape (K + 1,), in seconds; the first one is that of the instant.
        robots: By name, the states of each robot that is there, (K + 1, 7); the
            name of a single one is "robot".
        humans: The states of people, (K + 1, n, 7); NaN for who is not there.
        social: The size of the social force on each person, (K + 1, n), in
            m/s^2, which holds for the step that begins then.
        work: The size of its product with the person's velocity, in m^2/s^3.
        goals: The goal of each person that counts, (n, 3), rows (x, y, reach)
            in meters; NaN for none.
        goals_left: How many goals each person has yet to reach until then,
            (K + 1, n): 1 on the way to it, 0 or less afterwards.
        robot_goal: The goal of the first robot: see `goal_of`.
        result: The result of the trial from the instant to its end, of the
            robots that are there; None if it was not asked for, or if there is
            no robot.
    """

    times: Array
    robots: Mapping[str, Array]
    humans: Array
    social: Array
    work: Array
    goals: Array
    goals_left: Array
    robot_goal: tuple[float, ...] | None
    result: TrialResult | None

    @property
    def robot(self) -> Array:
        """The states of the first robot that is there, (K + 1, 7)."""
        return next(iter(self.robots.values()))

    @cached_property
    def arrivals(self) -> Array:
        """When each person arrives, (n,), in seconds; NaN for never.

        That is the first instant within reach of the goal. Between two steps
        people move on straight lines, so it is exact. People who go on to the
        next goal before, as where others stand at it, or who leave, have
        arrived at the end of that step.
        """
        away = self.humans[..., : Y + 1] - self.goals[:, : Y + 1]
        begin, _ = chords_within(away[:-1], away[1:], self.goals[:, 2])
        times = self.times[:-1, None] + begin * self._intervals[:, None]
        times[self.goals_left[:-1] > 1] = np.nan
        there = ~np.isnan(self.humans[..., X])
        content = there[1:] & (self.goals_left[1:] < 1)
        content |= there[:-1] & ~there[1:]
        ends = np.where(content, self.times[1:, None], np.nan)
        ends[:, np.isnan(self.goals[:, X])] = np.nan
        arrivals: Array = np.fmin.reduce(np.fmin(times, ends), axis=0)
        return arrivals

    @cached_property
    def quantities(self) -> dict[str, Array]:
        """By name, the `QUANTITIES` of each person until the arrival, (n,).

        NaN for who does not arrive.
        """
        steps = self._intervals[:, None]
        share = np.clip(
            (self.arrivals - self.times[:-1, None]) / steps, 0.0, 1.0
        )
        moved = np.diff(self.humans[..., : Y + 1], axis=0)
        rates = {
            "path": np.hypot(moved[..., X], moved[..., Y]) / steps,
            "social_impulse": self.social[:-1],
            "social_work": self.work[:-1],
        }
        arrived = np.where(np.isnan(self.arrivals), np.nan, 0.0)
        sums = {
            name: np.nansum(rate * share * steps, axis=0) + arrived
            for name, rate in rates.items()
        }
        return {"time": self.arrivals - self.times[0], **sums}

    def delays(self, reference: "Future") -> Array:
        """Returns how late each person is, (K + 1, n), in seconds.

        That is the time since the reference had come as near to the goal, in a
        straight line. NaN after the arrival, and where the reference never
        comes as near.
        """
        late = np.full(self.humans.shape[:2], np.nan)
        for i in range(len(self.goals)):
            own, other = self._nearest[:, i], reference._nearest[:, i]
            # (Only instants of progress count.)
            grows = np.flatnonzero(np.diff(other, prepend=np.inf) < 0)
            if not grows.size:
                continue
            when = np.interp(
                -own, -other[grows], reference.times[grows], right=np.nan
            )
            late[:, i] = self.times - np.maximum(when, self.times[0])
        late[self.times[:, None] > self.arrivals] = np.nan
        return late

    @property
    def _intervals(self) -> Array:
        return np.diff(self.times)

    @cached_property
    def _nearest(self) -> Array:
        """The least distance to the goal so far, (K + 1, n), in meters."""
        distance: Array = np.fmin.accumulate(
            np.hypot(
                self.humans[..., X] - self.goals[:, X],
                self.humans[..., Y] - self.goals[:, Y],
            ),
            axis=0,
        )
        return distance


def goal_of(robot: RobotConfig) -> tuple[float, ...] | None:
    """Returns (x, y, yaw, tolerance, yaw tolerance); None without a goal."""
    if robot.goal is None:
        return None
    tolerances = robot.goal_tolerance, robot.goal_yaw_tolerance
    return (*map(float, robot.goal), *tolerances)


class Aims:
    """The goals of people, as their behavior trees see them."""

    def __init__(
        self, diagram: Diagram, context: Context, later: int = 0
    ) -> None:
        """Constructs Aims.

        Args:
            diagram: The diagram of a trial.
            context: Its Context at the instant.
            later: Which goal counts: 0 for the present one, 1 for the next.
        """
        self._later = later
        self._first = self.indices(diagram, context)
        people = diagram.humans
        self.goals = np.full((len(people), 3), np.nan)
        for i, human in enumerate(people):
            k = int(self._first[i]) + later
            if human.cyclic and human.goals:
                k %= len(human.goals)
            if k < len(human.goals):
                reach = human.goal_radius + GOAL_MARGIN
                self.goals[i] = [*human.goals[k], reach]

    def indices(self, diagram: Diagram, context: Context) -> Array:
        """Returns the indices of the present goals, shape (n,)."""
        indices = np.zeros(len(diagram.humans))
        for system in diagram.GetSubsystemByName("humans").GetSystems():
            if isinstance(system, BehaviorTree):
                own = system.GetMyContextFromRoot(context)
                indices[system.rows()] = system.GetGoalIndices(own)
        return indices

    def left(self, indices: Array) -> Array:
        """Returns how many goals are left, (K + 1, n), from indices of them."""
        passed = np.diff(indices, axis=0, prepend=self._first[None]) != 0
        left: Array = self._later + 1 - np.cumsum(passed, axis=0)
        return left


class _Log:
    """Keeps the states of a trial at its steps."""

    def __init__(
        self, diagram: Diagram, gone: set[str], aims: Aims, *, forces: bool
    ) -> None:
        self._diagram, self._aims = diagram, aims
        self._forces = diagram.GetOutputPort("forces") if forces else None
        self._humans = diagram.GetOutputPort("human_states")
        self._robots = {
            part.name or ONLY_ROBOT: diagram.GetOutputPort(
                f"{part.prefix}robot_state"
            )
            for part in robot_parts(diagram.scenario)
            if part.name not in gone
        }
        self._monitor = diagram.GetSubsystemByName("monitor")
        self._rows: list[tuple[float, Array, Array, Array, list[Array]]] = []

    def Take(self, context: Context, *, first: bool = False) -> None:
        """Keeps the present states, if a step ends here."""
        own = self._monitor.GetMyContextFromRoot(context)
        if not first and not self._monitor.IsStep(own):
            return
        # (A simulator tells of the instant where it begins, too, which may be
        # that of the step but for rounding.)
        if self._rows and context.get_time() <= self._rows[-1][0] * (1 + 1e-9):
            return
        port = self._forces
        forces = np.zeros(0) if port is None else port.Eval(context)
        robots = [it.Eval(context) for it in self._robots.values()]
        humans = self._humans.Eval(context)
        aims = self._aims.indices(self._diagram, context)
        self._rows.append((context.get_time(), humans, aims, forces, robots))

    def future(self, result: TrialResult | None) -> Future:
        """Returns what was kept."""
        times, humans, aims, forces, robots = zip(*self._rows, strict=True)
        count, n = len(times), len(self._aims.goals)
        robot = robot_parts(self._diagram.scenario)[0].scenario.robot
        states = np.reshape(humans, (count, n, STATE_SIZE))
        states[is_outside(states)] = np.nan
        pairs = np.zeros((count, n, 2))
        if self._forces is not None:
            rows = np.reshape(forces, (count, n, FORCES_SIZE))
            pairs = rows[..., SOCIAL_FORCE : SOCIAL_FORCE + 2]
        power = (pairs * states[..., VX : VY + 1]).sum(axis=-1)
        return Future(
            times=np.array(times),
            robots={
                name: np.array([row[k] for row in robots])
                for k, name in enumerate(self._robots)
            },
            humans=states,
            social=np.hypot(pairs[..., 0], pairs[..., 1]),
            work=np.abs(power),
            goals=self._aims.goals,
            goals_left=self._aims.left(np.array(aims)),
            robot_goal=goal_of(robot),
            result=result,
        )


def RunFuture(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    until: float,
    aims: Aims,
    robots_left: list[str],
    whole: bool = True,
) -> Future:
    """Runs a trial on, also after the end of its robots.

    Args:
        scenario: The scenario.
        diagram: Its diagram.
        context: Where it begins; it is changed.
        until: The time until which it runs, in seconds.
        aims: The goals of people.
        robots_left: The names of the robots that are there.
        whole: Whether to compute forces, and the result if there is a robot.

    Raises:
        PlannerError: If a planner fails.
    """
    start = context.get_time()
    gone = {it.name for it in robot_parts(scenario)} - {*robots_left}
    log = _Log(diagram, gone, aims, forces=whole)
    log.Take(context, first=True)
    result = None
    if whole and robots_left:
        # The result is that of the end; people go on.
        context = _advance(diagram, context, until, log, ends=True)
        result = GetTrialResult(
            *(scenario, diagram, context), since=start, robots=robots_left
        )
        context = context.Clone()
    if context.get_time() < until:
        _advance(diagram, context, until, log, ends=False)
    return log.future(result)


def _advance(
    diagram: Diagram, context: Context, until: float, log: _Log, *, ends: bool
) -> Context:
    """Runs a trial on; returns its Context, which is the one that is given."""
    simulator = MakeTrialSimulator(
        diagram, context, progress=lambda _: log.Take(context), ends=ends
    )
    simulator.AdvanceTo(until)
    # The monitor refers to the simulator: a cycle of references.
    simulator.clear_monitor()
    result: Context = simulator.get_context()
    return result
