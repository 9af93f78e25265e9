"""Runs branches of a trial from one instant, and compares them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario import SaveScenario
from hunav_drake.scenario.fleet import robots_of
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.checks import is_multiple
from hunav_drake.systems.common.layout import X, Y
from hunav_drake.systems.common.suggest import did_you_mean, shown
from hunav_drake.systems.people.names import people_names
from hunav_drake.systems.planning.planner_error import PlannerError
from hunav_drake.trial.branches.future import (
    QUANTITIES,
    Aims,
    Future,
    RunFuture,
)
from hunav_drake.trial.branches.kinds import (
    Branch,
    RobotGone,
    RobotShifted,
    changed_scenario,
)
from hunav_drake.trial.context_file import ContextDigest
from hunav_drake.trial.context_transfer import TransferContext
from hunav_drake.trial.diagram import (
    CheckTrialDiagram,
    MakeTrialDiagram,
    TrialDiagram,
)
from hunav_drake.trial.metric_facts import unit_of
from hunav_drake.trial.quantity_text import number_text
from hunav_drake.trial.result import TrialResult

if TYPE_CHECKING:
    import pandas as pd
else:
    import lazy_loader

    pd = lazy_loader.load("pandas")

# The branch in which nothing changes, and the default reference.
SAME, GONE = "same", "robot gone"

# By how much a robot is moved to see how small differences grow, in meters, and
# the growth from which on what differs may be chance.
_SHIFT, _MOST_GROWTH = 1e-6, 1000.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Branches:
    """What became of a trial in each of some branches from one instant.

    `branches["mppi"]` is the result of a branch, of the time from the instant
    to its end.

    Attributes:
        start: The instant, in seconds.
        until: The time until which the branches ran, in seconds.
        reference: The name of the branch that others are compared with.
        human_names: The names of the people.
        futures: The branches by name, at all steps.
        growth: How many times a tiny difference in the robot's place grows
            among people until the end; NaN if it was not asked for. From 1000
            on, differences between branches may be chance.
    """

    start: float
    until: float
    reference: str
    human_names: tuple[str, ...]
    futures: Mapping[str, Future]
    growth: float = math.nan

    def __repr__(self) -> str:
        return (
            f"<Branches from {self.start:.12g} s to {self.until:.12g} s:"
            f" {', '.join(self.futures)}>"
        )

    def __getitem__(self, name: str) -> TrialResult:
        """Returns the result of a branch.

        Raises:
            KeyError: If there is no such branch, or it has no robot.
        """
        result = self.futures[name].result
        if result is None:
            raise KeyError(
                f"the branch {name!r} has no robot, and so no result; see"
                " people, and futures"
            )
        return result

    @cached_property
    def people(self) -> "pd.DataFrame":
        """What each branch means for each person.

        Returns:
            A row per branch, person and quantity, with the "unit": "value", of
            the time from the instant to the person's arrival, "reference", the
            one of the reference, and "difference", value - reference: the extra
            time, path, social impulse (of |f|) and social work (of |f . v|).
            "censored" is 1 where the person did not arrive in one of both, so
            that there is no difference.
        """
        others = self.futures[self.reference].quantities
        rows = [
            (branch, person, name, unit, value, other)
            for branch, future in self.futures.items()
            for name, unit in QUANTITIES.items()
            for person, value, other in zip(
                self.human_names,
                future.quantities[name],
                others[name],
                strict=True,
            )
        ]
        table = _compared(rows, ["branch", "person", "quantity", "unit"])
        table["censored"] = table["difference"].isna().astype(int)
        return table

    @property
    def totals(self) -> "pd.DataFrame":
        """The sums over people of the differences.

        Returns:
            A row per branch, a column per quantity, and "people", the number of
            people who arrived in the branch and in the reference.
        """
        table = self.people
        sums = table.pivot_table(
            index="branch",
            columns="quantity",
            values="difference",
            aggfunc="sum",
            sort=False,
            observed=True,
        ).reindex(index=list(self.futures), columns=list(QUANTITIES))
        counted = table[table["quantity"] == "time"].groupby("branch")
        sums["people"] = counted["difference"].count()
        return sums

    @cached_property
    def metrics(self) -> "pd.DataFrame":
        """The metrics of each branch that has a robot, [instant, end].

        Where one of several robots is gone, they are those of the others.

        Returns:
            A row per branch and metric, with the "unit": "value", "reference",
            the one of the branch "same", and "difference".
        """
        same = self[SAME].metrics
        count = len(self.futures[SAME].robots)
        rows = []
        for branch, future in self.futures.items():
            robots = tuple(f"{it}." for it in future.robots)
            if not robots:
                continue
            # (The result of the only one that is left has no names of robots.)
            prefix = robots[0] if len(robots) == 1 < count else ""
            own = self[branch].metrics
            for name, value in own.items():
                told = f"{prefix}{name}"
                if len(robots) == count or told.startswith(robots):
                    unit, before = unit_of(own, name), same.get(told, math.nan)
                    rows.append((branch, told, unit, value, before))
        return _compared(rows, ["branch", "metric", "unit"])

    def delays(self, branch: str) -> "pd.DataFrame":
        """Returns how late people are in a branch, over time, in seconds.

        It has a value also for who does not arrive: the time since the person
        had come as near to the goal in the reference, in a straight line.

        Returns:
            A row per step, indexed by "time"; a column per person. NaN after
            the arrival, and where the reference never comes as near.

        Raises:
            KeyError: If there is no such branch.
        """
        future = self.futures[branch]
        return pd.DataFrame(
            future.delays(self.futures[self.reference]),
            index=pd.Index(future.times, name="time"),
            columns=list(self.human_names),
        )


def growth_text(growth: float) -> str:
    """Returns how small differences grow in branches; "" if not known."""
    if math.isnan(growth):
        return ""
    growth = float(f"{growth:.2g}")
    told = f"{number_text(growth)} um later, at most"
    if growth < _MOST_GROWTH:
        return f"A robot that is 1 um aside moves people by {told}."
    return (
        f"Small differences grow: a robot that is 1 um aside moves people by"
        f" {told}. So differences between branches may be chance: vary the"
        " start a little."
    )


def _compared(rows: Sequence[Any], keys: list[str]) -> "pd.DataFrame":
    """Returns a table of keys, values and references, with differences."""
    table = pd.DataFrame(rows, columns=[*keys, "value", "reference"])
    table = table.astype({"value": float, "reference": float})
    table["difference"] = table["value"] - table["reference"]
    return table


class Fork:
    """The instant of a trial from which branches begin."""

    def __init__(
        self,
        scenario: Scenario,
        diagram: Diagram,
        context: Context,
        *,
        until: float,
        goal: int = 0,
        may_leave: bool = False,
    ) -> None:
        """Constructs a Fork: see `RunBranches`.

        With `may_leave`, also branches in which nobody leaves run in diagrams
        whose people may. They go on alike, bit for bit, but slower.
        """
        CheckTrialDiagram(scenario, diagram)
        diagram.ValidateContext(context)
        start, step = context.get_time(), scenario.simulation.time_step
        if not start + (1 - 1e-6) * step <= until < math.inf:
            raise ValueError(
                f"until must be a time step ({step:g} s) or more after that of"
                f" the Context, {start:g} s, got {shown(until)}"
            )
        if goal < 0:
            raise ValueError(
                f"goal must be 0 for the present one, 1 for the next, ..., got"
                f" {goal}"
            )
        if is_multiple(until, step):
            # (Of several steps, 1.7 may be less than 17 of 0.1.)
            until = max(until, round(until / step) * step)
        self.scenario = scenario
        self.until = until
        self.names = tuple(people_names(diagram.humans))
        self.robots = list(robots_of(scenario))
        self._diagram, self._context = diagram, context
        self._may_leave = may_leave
        self._aims = Aims(diagram, context, goal)
        self._made: dict[tuple[str, bool], tuple[TrialDiagram, Context]] = {}

    @property
    def start(self) -> float:
        """The instant, in seconds."""
        return float(self._context.get_time())

    def Prepare(self, branch: Branch) -> tuple[Scenario, Diagram, Context]:
        """Returns the scenario of a branch, its diagram, and a new Context.

        Raises:
            ScenarioError: If the scenario cannot be simulated.
            ValueError: If the branch does not fit the trial.
        """
        scenario = changed_scenario(self.scenario, branch)
        may_leave = self._may_leave or branch.may_leave()
        key = SaveScenario(scenario), may_leave
        if key not in self._made:
            made = MakeTrialDiagram(scenario, may_leave=may_leave, drawn=False)
            moved = TransferContext(self._diagram, self._context, made)
            self._made[key] = made, moved
        diagram, moved = self._made[key]
        context = moved.Clone()
        branch.Apply(diagram, context)
        return scenario, diagram, context

    def Run(self, branch: Branch, *, whole: bool = True) -> Future:
        """Runs a branch: see `RunFuture`."""
        scenario, diagram, context = self.Prepare(branch)
        return RunFuture(
            scenario,
            diagram,
            context,
            until=self.until,
            aims=self._aims,
            robots_left=branch.robots_left(scenario),
            whole=whole,
        )

    def RunOriginal(self) -> Future:
        """Runs the trial itself on."""
        return RunFuture(
            self.scenario,
            self._diagram,
            self._context.Clone(),
            until=self.until,
            aims=self._aims,
            robots_left=self.robots,
            whole=False,
        )

    def CheckSame(self, original: Future, same: Future) -> None:
        """Checks that the branch in which nothing changes goes on alike.

        Raises:
            RuntimeError: If it does not, bit for bit.
        """
        pairs = [
            (original.times, same.times),
            (original.humans, same.humans),
            *zip(original.robots.values(), same.robots.values(), strict=True),
        ]
        for was, now in pairs:
            if was.tobytes() != now.tobytes():
                raise RuntimeError(
                    "the branch in which nothing changes differs from the trial"
                    f" that goes on from {self.start:g} s, so differences mean"
                    " nothing: a part of the trial has a state outside its"
                    " Context (see the rules for systems of your own)"
                )


def RunBranches(
    scenario: Scenario,
    diagram: Diagram,
    context: Context,
    *,
    until: float,
    branches: Mapping[str, Branch],
    reference: str = GONE,
    goal: int = 0,
    growth: bool | str = False,
) -> Branches:
    """Runs branches of a trial from one instant, and compares them.

    What if, from now on, the robot had another planner, or stood, or were not
    there, or one person were not there? Each branch begins from the same state,
    bit for bit, behavior trees included, so that differences are effects of the
    change alone. They go on until a common time, also after the robot's end, so
    that people's arrivals are seen.

    The branch "same", in which nothing changes, is always run, too; it must go
    on as the trial itself, bit for bit.

    Args:
        scenario: The scenario of the trial.
        diagram: Its diagram, from `MakeTrialDiagram`.
        context: Its Context at the instant, as after `AdvanceTo`; it is not
            changed.
        until: The time until which branches run, in seconds.
        branches: The branches by name: `WithPlanner`, `RobotStands`,
            `RobotGone`, `WithoutPerson`, `WithSettings`.
        reference: The name of the branch with which people are compared; the
            one without the robot need not be given.
        goal: Which goal of each person counts as the arrival: 0 for the one at
            the instant, 1 for the next, ...
        growth: Whether to find how small differences grow, in one branch more:
            the first robot, or the one of this name, is 1 um aside, along x
            and y. In symmetric encounters they do, as anything decides who
            passes on which side.

    Raises:
        PlannerError: If a planner fails; it names the branch.
        RuntimeError: If "same" differs from the trial.
        ScenarioError: If a branch cannot be simulated.
        ValueError: If a branch does not fit the trial, or an argument is out of
            its range; before any branch is run.
    """
    if SAME in branches:
        raise ValueError(f"the branch {SAME!r} is always there; leave it out")
    chosen: dict[str, Branch] = {SAME: Branch(), **branches}
    if reference == GONE:
        chosen.setdefault(GONE, RobotGone())
    if reference not in chosen:
        raise ValueError(
            f"reference must be the name of a branch, got {shown(reference)}"
            f"{did_you_mean(reference, chosen)}; valid: {', '.join(chosen)}"
        )
    may_leave = any(branch.may_leave() for branch in chosen.values())
    fork = Fork(
        scenario, diagram, context, until=until, goal=goal, may_leave=may_leave
    )
    moved = "" if growth is True else str(growth)
    shifted = [RobotShifted(_SHIFT, moved)] if growth else []
    for name, branch in [*chosen.items(), *(("growth", it) for it in shifted)]:
        try:
            fork.Prepare(branch)
        except ValueError as error:
            error.add_note(f"of the branch {name!r}")
            raise
    for prefix in diagram.prefixes.values():
        evaluator = diagram.GetSubsystemByName(f"{prefix}evaluator")
        evaluator.CheckGoesOn(evaluator.GetMyContextFromRoot(context))
    try:
        digest = ContextDigest(diagram, context)
    except ValueError:
        digest = ""
    futures = {}
    for name, branch in chosen.items():
        try:
            future = fork.Run(branch)
        except PlannerError as error:
            error.add_note(f"in the branch {name!r}")
            raise
        if name == SAME:
            fork.CheckSame(fork.RunOriginal(), future)
        if future.result is not None:
            future.result.provenance.update(
                branch=name,
                branch_text=str(branch),
                from_time=repr(fork.start),
                from_context_sha256=digest,
            )
        futures[name] = future
    grown = math.nan
    for branch in shifted:
        apart = _apart(fork.Run(branch, whole=False), futures[SAME])
        grown = apart / _SHIFT
    return Branches(
        start=fork.start,
        until=until,
        reference=reference,
        human_names=fork.names,
        futures=futures,
        growth=grown,
    )


def _apart(future: Future, other: Future) -> float:
    """Returns how far people of two futures are apart, at most, in meters."""
    apart = future.humans[..., : Y + 1] - other.humans[..., : Y + 1]
    away = np.hypot(apart[..., X], apart[..., Y])
    known = away[~np.isnan(away)]
    return float(known.max()) if len(known) else math.nan
