"""What people who react do from places drawn at random: a table of outcomes.

`python -m tests.reaction_table` prints it for all behaviors, or for those that
are named: `python -m tests.reaction_table curious scared`. With `--each` there
is a line for each placement, with `--model orca` people move by another model.

Each behavior is put into the room of its own scenario, with the robot driving
as there, and the person's start and goal drawn anew.
"""

import argparse
from collections.abc import Iterator
import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake import LoadScenario, RunTrial, Scenario
from hunav_drake.systems.common.layout import VX, VY, YAW, X, Y
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.people.behavior_choice import Behavior

BEHAVIORS = (
    "regular",
    "impassive",
    "surprised",
    "scared",
    "curious",
    "threatening",
    "distracted",
    "cooperative",
)
PLACEMENTS = 20

# People start and end so far from the walls, and start so far from the robot,
# in meters; their way is so long at least.
_FROM_WALLS = 0.8
_FROM_ROBOT = 2.0
_LEAST_WAY = 4.0

# Accelerations are means over this time, in seconds, as bodies show them.
_SMOOTH = 0.2

Array = NDArray[np.float64]


class Outcome(NamedTuple):
    """What came of a placement.

    Attributes:
        reacted: Whether the person did as the behavior says.
        active: How long a reaction was active, in seconds.
        gap: The least distance between the bodies, in meters.
        switches: How often a reaction began or ended.
        arrived: Whether the robot reached its goal.
        acceleration: The worst of the person's in a reaction, in m/s^2.
        braking: How fast the person slowed down at most, in m/s^2.
    """

    reacted: bool
    active: float
    gap: float
    switches: int
    arrived: bool
    acceleration: float
    braking: float


def scenario_of(behavior: str) -> Scenario:
    """Returns the scenario that a behavior is placed in."""
    shown = behavior
    if behavior in ("regular", "impassive"):
        shown = "distracted"
    scenario = LoadScenario(filename=f"reaction_{shown}")
    (human,) = scenario.humans
    human = dataclasses.replace(human, behavior=behavior)
    return dataclasses.replace(scenario, humans=[human])


def placed(
    scenario: Scenario,
    pose: tuple[float, float, float],
    goal: tuple[float, float],
    model: str = "",
    behavior: Behavior = "",
) -> Scenario:
    """Returns a scenario whose person starts and ends elsewhere."""
    (human,) = scenario.humans
    human = dataclasses.replace(
        human, pose=pose, goals=[goal], behavior=behavior or human.behavior
    )
    scenario = dataclasses.replace(scenario, humans=[human])
    if not model:
        return scenario
    crowd = dataclasses.replace(scenario.crowd, model=MOTION_MODELS.make(model))
    return dataclasses.replace(scenario, crowd=crowd)


def placements(
    behavior: str, count: int = PLACEMENTS
) -> Iterator[tuple[tuple[float, float, float], tuple[float, float]]]:
    """Yields starts and goals, always the same ones."""
    scenario = scenario_of(behavior)
    start = np.array(scenario.robot.start[:2])
    half = np.array([9.0, 1.5 if behavior == "cooperative" else 4.0])
    half -= _FROM_WALLS
    for number in range(count):
        rng = np.random.default_rng([2026, number])
        while True:
            pose, goal = rng.uniform(-half, half, (2, 2)).round(3)
            yaw = float(rng.uniform(-np.pi, np.pi).__round__(3))
            if (
                np.hypot(*(pose - start)) >= _FROM_ROBOT
                and np.hypot(*(goal - pose)) >= _LEAST_WAY
            ):
                break
        yield (
            (float(pose[0]), float(pose[1]), yaw),
            (float(goal[0]), float(goal[1])),
        )


class Run:
    """The recording of a trial of one person, in the person's terms.

    The behavior is by its name what the person is to do.
    """

    def __init__(self, scenario: Scenario, behavior: str = "") -> None:
        result = RunTrial(scenario)
        recording = result.recording
        self.scenario = scenario
        self.behavior = behavior or scenario.humans[0].behavior_name
        self.arrived = result.end_reason == "goal"
        self.times: Array = recording.times
        self.human: Array = recording.humans[:, 0]
        self.robot: Array = recording.robot
        # (2 is to make way.)
        assert recording.behavior_status is not None
        status = recording.behavior_status[:, 0]
        self.active: NDArray[np.bool_] = status == 1
        self.made_way: NDArray[np.bool_] = status == 2
        self.period = float(np.median(np.diff(self.times)))
        (human,) = scenario.humans
        self.goal = np.array(human.goals[-1])
        self.to_robot: Array = self.robot[:, :2] - self.human[:, :2]
        self.distance: Array = np.hypot(*self.to_robot.T)
        radii = human.radius + scenario.robot.radius
        self.gap: Array = self.distance - radii
        self.speed: Array = np.hypot(self.human[:, VX], self.human[:, VY])

    def in_front(self) -> Array:
        """Returns how far the person is from 1.1 m ahead of the robot."""
        yaw = self.robot[:, YAW]
        ahead = 1.1 * np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
        front: Array = np.hypot(*(ahead + self.to_robot).T)
        return front

    def off_bearing(self) -> Array:
        """Returns the angle between the heading and the robot, in radians."""
        bearing = np.arctan2(self.to_robot[:, Y], self.to_robot[:, X])
        off: Array = np.abs(
            np.angle(np.exp(1j * (bearing - self.human[:, YAW])))
        )
        return off

    def outcome(self) -> Outcome:
        """Returns what came of it."""
        span = max(round(_SMOOTH / self.period), 1)
        velocity = self.human[:, [VX, VY]]
        change = velocity[span:] - velocity[:-span]
        own = self.active[span:]
        slowed = self.speed[:-span] - self.speed[span:]
        return Outcome(
            reacted=bool(_RULES[self.behavior](self)),
            active=float(self.active.sum() * self.period),
            gap=float(self.gap.min()),
            switches=int(np.count_nonzero(np.diff(self.active))),
            arrived=self.arrived,
            acceleration=float(
                np.hypot(*change[own].T).max(initial=0.0) / (span * self.period)
            ),
            braking=float(slowed.max(initial=0.0) / (span * self.period)),
        )


def _walks(run: Run) -> bool:
    """It gets nearer to its goal, until it is there."""
    left = np.hypot(*(run.human[:, :2] - run.goal).T)
    later = left[round(5 / run.period) :]
    nearer = left[: len(later)] - later > 0.5
    # (Others may be in the way of the last steps.)
    there = np.logical_or.accumulate(later < 1.0)
    return bool((nearer | there).mean() > 0.9)


def _is_surprised(run: Run) -> bool:
    """It stands and looks, and walks on after that."""
    if not run.active.any():
        return _walks(run) and not _was_before(run, 4.0)
    settled = _settled(run, 1.5)
    walks = run.speed[settled] > 0
    # (A robot that passes close by is fast.)
    elsewhere = run.off_bearing()[settled] > 0.12
    return bool(max(walks.sum(), elsewhere.sum()) <= 0.05 * len(walks))


def _is_scared(run: Run) -> bool:
    """It is slow, and keeps off."""
    if not run.active.any():
        return not _was_before(run, 3.0)
    settled = _settled(run, 0.5)
    slow = run.speed[settled].max(initial=0.0) <= 0.6 + 1e-6
    return bool(slow and run.gap.min() > 0.2)


def _is_curious(run: Run) -> bool:
    """It comes near, for 30 s, and then goes its own way."""
    if not run.active.any():
        return not _was_before(run, 10.0)
    came = run.distance[run.active].min() < 1.75
    whole = run.active.sum() * run.period
    ended = not run.active[-1]
    return bool(came and (not ended or 29 < whole < 31))


def _is_threatening(run: Run) -> bool:
    """It is in front of the robot, for 40 s."""
    if not run.active.any():
        return not _was_before(run, 4.0)
    settled = _settled(run, 5.0)
    far = run.in_front()[settled] > 0.6
    blocks = far.sum() <= 0.2 * len(far)
    whole = run.active.sum() * run.period
    ended = not run.active[-1]
    return bool(blocks and (not ended or 39 < whole < 41))


def _is_distracted(run: Run) -> bool:
    """It walks on, and looks up late."""
    near = run.distance[run.active]
    return bool(_walks(run) and near.max(initial=0.0) < 2.6)


def _is_cooperative(run: Run) -> bool:
    """It lets the robot pass."""
    return bool(run.arrived and run.gap.min() > 0)


def _settled(run: Run, seconds: float) -> NDArray[np.bool_]:
    """Tells when a reaction has been active for some seconds."""
    count = round(seconds / run.period)
    settled = run.active.copy()
    for i in range(1, count + 1):
        settled[i:] &= run.active[:-i]
        settled[:i] = False
    return settled


def _was_before(run: Run, distance: float) -> bool:
    """Tells whether the robot was near and in view, for half a second."""
    seen = (run.distance < distance - 0.1) & (run.off_bearing() < 1.6)
    return bool(seen.sum() * run.period > 0.5)


_RULES = {
    "regular": _walks,
    "impassive": _walks,
    "surprised": _is_surprised,
    "scared": _is_scared,
    "curious": _is_curious,
    "threatening": _is_threatening,
    "distracted": _is_distracted,
    "cooperative": _is_cooperative,
}


def outcomes(
    behavior: str, count: int = PLACEMENTS, model: str = "", tree: Behavior = ""
) -> list[Outcome]:
    """Returns what came of the placements of a behavior."""
    scenario = scenario_of(behavior)
    return [
        Run(placed(scenario, pose, goal, model, tree), behavior).outcome()
        for pose, goal in placements(behavior, count)
    ]


def summary(rows: list[Outcome]) -> dict[str, float]:
    """Returns the counts and the worst of some outcomes."""
    return {
        "reacted": sum(it.reacted for it in rows),
        "arrived": sum(it.arrived for it in rows),
        "overlaps": sum(it.gap < 0 for it in rows),
        "gap": min(it.gap for it in rows),
        "active": max(it.active for it in rows),
        "switches": max(it.switches for it in rows),
        "acceleration": max(it.acceleration for it in rows),
        "braking": max(it.braking for it in rows),
    }


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("behaviors", nargs="*")
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--model", default="")
    parser.add_argument("--tree", default="")
    parser.add_argument("--count", type=int, default=PLACEMENTS)
    options = parser.parse_args()
    head = (
        f"{'behavior':13}{'reacts':>7}{'robot':>6}{'active s':>9}{'gap m':>8}"
        f"{'switches':>9}{'m/s^2':>7}{'brakes':>7}"
    )
    print(head)
    for behavior in options.behaviors or BEHAVIORS:
        rows = outcomes(behavior, options.count, options.model, options.tree)
        for number, row in enumerate(rows if options.each else ()):
            print(
                f"  {number:<11}{row.reacted!s:>7}{row.arrived!s:>6}"
                f"{row.active:9.1f}{row.gap:8.2f}{row.switches:9}"
                f"{row.acceleration:7.1f}{row.braking:7.1f}"
            )
        all_ = summary(rows)
        print(
            f"{behavior:13}{all_['reacted']:7}{all_['arrived']:6}"
            f"{all_['active']:9.1f}{all_['gap']:8.2f}{all_['switches']:9}"
            f"{all_['acceleration']:7.1f}{all_['braking']:7.1f}"
            f"  {all_['overlaps']} overlap"
        )


if __name__ == "__main__":
    main()
