"""Finds the places with which the paper's tables come out nearest.

    python -m tests.paper_places passing

drives DWB, SCL and SFW along many lines, and prints those whose means are
nearest to the table of the paper, which does not tell the places; `crossing`
takes 150 s on two processors, `passing` longer. `combined` tries random places
of its three people, then places near the best ones, and takes 20 minutes.
"""

from collections.abc import Sequence
import dataclasses
import math
import sys

import numpy as np
import pandas as pd

from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.comparison.paper import (
    METRICS,
    PLANNERS,
    PUBLISHED,
    PUBLISHED_BY_BEHAVIOR,
)
from hunav_drake.runs.suite import planner_overrides
from hunav_drake.systems.common.arrays import Array

# What is the same in all columns, or follows from others, or says little.
_LEFT_OUT = (
    *("completed", "min_dist_to_target", "final_dist_to_target"),
    *("robot_on_person_collisions", "person_on_robot_collisions"),
    *("obstacle_force_on_robot", "obstacle_force_on_agents"),
    *("social_force_on_agents", "social_work", "avg_robot_jerk"),
)
# Smaller values count as this, by unit.
_LEAST = {
    **{"%": 5.0, "s": 0.5, "m": 0.2, "m/s": 0.1, "rad/s": 0.02},
    **{"rad": 0.2, "m/s²": 0.02, "m/s² by behavior": 0.1},
}
_UNITS = {name: unit for name, unit, _ in METRICS}
# The room that the people of combined may start and go in.
_LOW, _HIGH = np.array([-5.4, -9.4]), np.array([4.8, 8.8])

# Overrides by name.
Settings = dict[str, list[str]]


def error(value: float, published: float, unit: str) -> float:
    """Returns how far a value is from the published one, from 0 to 1."""
    if not math.isfinite(value):
        return 1.0
    least = max(abs(value), abs(published), _LEAST[unit])
    return min(1.0, abs(value - published) / least)


def lines(scenario: str) -> Settings:
    """Returns ways of the robot, and in passing also speeds of people."""
    if scenario == "crossing":
        return {
            f"x {x:g}": [
                f"robot.start=[{x}, -4.75, 1.57079633]",
                f"robot.goal=[{x}, 0.15, 0.0]",
            ]
            for x in np.linspace(0.1, 1.0, 37).round(3).tolist()
        }
    return {
        f"y {y:g}, {speed} m/s": [
            f"robot.start=[7.5, {y}, 3.14159265]",
            f"robot.goal=[-7.7, {y}, 3.14159265]",
            *(f"humans[{i}].desired_speed={speed}" for i in range(2)),
        ]
        for speed in (0.65, 0.7, 0.75)
        for y in np.arange(-0.85, -0.14, 0.05).round(2).tolist()
    }


def places(points: Array) -> list[str]:
    """Returns the overrides of combined for starts and goals.

    Args:
        points: Shape (4, 2, 2): start and goal of the robot and of the people.
    """
    points = points.round(2) + 0.0
    yaws = np.arctan2(*(points[:, 1] - points[:, 0]).T[::-1]).round(4)
    texts = []
    for i, ((start, goal), yaw) in enumerate(
        zip(points.tolist(), yaws.tolist(), strict=True)
    ):
        if i == 0:
            texts += [
                f"robot.start={[*start, yaw]}",
                f"robot.goal={[*goal, yaw]}",
            ]
        else:
            texts += [
                f"humans[{i - 1}].pose={[*start, yaw]}",
                f"humans[{i - 1}].goals={[goal]}",
            ]
    return texts


def random_places(random: np.random.Generator) -> Array:
    """Returns places that may be as those of Table IV: shape (4, 2, 2).

    The robot drives along the room. The regular person passes it, and ends
    where it began; the threatening one starts in its half of the room.
    """
    draw = random.uniform
    way, x = random.choice([-1, 1]), draw(-2, 2)
    beside = x + random.choice([-1, 1]) * draw(1.5, 3)
    curious, threatening = draw(-5, 4.5), x + draw(-3, 3)
    points = np.array(
        [
            [[x, -8.5], [x, 8.5]],
            [[beside, draw(-6, 8)], [beside, draw(-9.4, -8)]],
            [[curious, draw(-5, 9)], [curious, draw(-9, 9)]],
            [[threatening, draw(0, 9)], [threatening, draw(-6, 6)]],
        ]
    )
    points[..., 1] *= way
    return points.clip(_LOW, _HIGH)


def near_places(
    points: Array, far: float, random: np.random.Generator
) -> Array:
    """Returns places near others: the robot's is moved aside only."""
    moved = points + far * random.standard_normal(points.shape)
    moved[0] = points[0] + [0.5 * far * random.standard_normal(), 0.0]
    return moved.clip(_LOW, _HIGH)


def are_apart(points: Array) -> bool:
    """Tells whether nobody starts in another, or has nowhere to go."""
    gaps = np.linalg.norm(points[:, None, 0] - points[None, :, 0], axis=-1)
    ways = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1)
    return bool((gaps[np.triu_indices(4, 1)] > 1.5).all() and ways.min() > 2)


def errors(
    scenario: str, settings: Settings, planners: tuple[str, ...], seeds: int
) -> pd.DataFrame:
    """Returns the mean error by setting and planner, the nearest first."""
    suite = LoadSuite(filename="paper")
    suite = dataclasses.replace(
        suite,
        scenarios=[scenario],
        planners=[
            it for it in suite.planners if planner_overrides(it)[0] in planners
        ],
        settings=settings,
        seeds=seeds,
        seeds_of={},
        relations=[],
        identities=False,
    )
    result = RunSuite(suite, workers=2)
    by = ["setting", "planner"]
    if scenario == "combined":
        runs = result.runs(by_behavior=True)
        names = list(PUBLISHED_BY_BEHAVIOR["curious"]["dwb"])
        names.remove("social_work")
        means = runs.groupby([*by, "behavior"])[names].mean().stack()
        found = [
            (
                *(setting, planner),
                error(
                    value,
                    PUBLISHED_BY_BEHAVIOR[behavior][planner][name],
                    _unit(name, " by behavior"),
                ),
            )
            for (setting, planner, behavior, name), value in means.items()
        ]
    else:
        runs = result.runs()
        names = [name for name in _UNITS if name not in _LEFT_OUT]
        means = runs.groupby(by)[names].mean().stack()
        found = [
            (*key, error(value, PUBLISHED[scenario][key[1]][name], _unit(name)))
            for (*key, name), value in means.items()
        ]
    table = pd.DataFrame(found, columns=[*by, "error"])
    table = table.pivot_table("error", "setting", "planner")
    table["all"] = table.mean(axis=1)
    return table.sort_values("all")


def _unit(name: str, suffix: str = "") -> str:
    unit = _UNITS[name]
    return unit + suffix if unit + suffix in _LEAST else unit


# How far places are from the best until then, in meters (0: anywhere), and how
# many are tried.
_ROUNDS = ((0.0, 700), (0.8, 110), (0.4, 110), (0.2, 110))


def search(
    rounds: Sequence[tuple[float, int]] = _ROUNDS, seed: int = 7
) -> pd.DataFrame:
    """Returns the errors of places of combined, of which many were tried.

    Random ones are chosen by DWB's column alone, and so are those near the
    best of them; all columns count for the last ones.
    """
    random = np.random.default_rng(seed)
    tried: dict[str, Array] = {}
    best: list[str] = []
    known: dict[str, float] = {}
    for far, count in rounds:
        new: dict[str, Array] = {}
        while len(new) < count:
            if far:
                rank = min(int(random.exponential(5)), len(best) - 1)
                points = near_places(tried[best[rank]], far, random)
            else:
                points = random_places(random)
            if are_apart(points):
                new[f"{len(tried) + len(new)}"] = points
        tried |= new
        settings = {name: places(points) for name, points in new.items()}
        table = errors("combined", settings, ("dwb",), 2)
        known |= table["all"].to_dict()
        best = sorted(known, key=known.__getitem__)[:20]
    settings = {name: places(tried[name]) for name in best}
    table = errors("combined", settings, PLANNERS, 10)
    return table.rename(index=lambda name: " ".join(settings[name]))


def main(scenario: str) -> None:
    """Prints the nearest places."""
    if scenario == "combined":
        table = search()
    else:
        table = errors(scenario, lines(scenario), PLANNERS, 10)
    print(table.head(15).round(3).to_string())


if __name__ == "__main__":
    main(sys.argv[1])
