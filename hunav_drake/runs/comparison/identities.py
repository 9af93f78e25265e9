"""Identities that must hold in every run of the paper's experiment.

With NaN they do not hold: `max` and `min` of Python would ignore it.
"""

from collections.abc import Callable

import numpy as np

from hunav_drake.runs.comparison.means import Means
from hunav_drake.systems.common.arrays import Array

P, C, K, FREE = "passing", "crossing", "combined", "free_run"
PLANNERS = ("dwb", "scl", "sfw")

# The straight distances from start to goal, in meters.
_WAYS = {P: 15.2, C: 4.9}

# Returns whether it holds, and its numbers.
Identity = Callable[[Means], tuple[bool, str]]


def _all_runs(means: Means, metric: str) -> Array:
    runs = list(means.runs(metric).values())
    if not runs:
        raise KeyError(metric)
    return np.concatenate(runs)


def _paper_runs(means: Means, metric: str) -> Array:
    """Returns the values in Passing and Crossing."""
    runs = [v for key, v in means.runs(metric).items() if key[1] in (P, C)]
    if not runs:
        raise KeyError(metric)
    return np.concatenate(runs)


def _work_is_a_sum(means: Means) -> tuple[bool, str]:
    parts = (
        "social_force_on_agents",
        "social_force_on_robot",
        "obstacle_force_on_robot",
    )
    total = sum(_all_runs(means, name) for name in parts)
    excess = float((_all_runs(means, "social_work") - total).max())
    return excess <= 1e-6, f"largest excess over the sum {excess:.2g}"


def _forces_are_mutual(means: Means) -> tuple[bool, str]:
    a = _all_runs(means, "social_force_on_agents")
    b = _all_runs(means, "social_force_on_robot")
    gap = float(np.abs(a - b).max())
    return gap <= 1e-9 * max(1.0, float(np.abs(a).max())), (
        f"largest difference {gap:.2g}"
    )


def _zones(means: Means) -> tuple[bool, str]:
    names = (
        "intimate_space_intrusions",
        "personal_space_intrusions",
        "social+_space_intrusions",
    )
    sums = {
        key: sum(means.runs(name)[key] for name in names)
        for key in means.runs(names[0])
        if key[1] in (P, C)
    }
    crossing = [v for key, v in sums.items() if key[1] == C]
    if not crossing:
        raise KeyError(C)
    largest = float(np.concatenate(list(sums.values())).max())
    least = float(np.concatenate(crossing).min())
    return largest <= 100 + 1e-9 and least >= 99, (
        f"largest sum {largest:.1f} %, least in crossing {least:.1f} %"
    )


def _final_distance(means: Means) -> tuple[bool, str]:
    final, least = (
        _paper_runs(means, metric)
        for metric in ("final_dist_to_target", "min_dist_to_target")
    )
    gap = float((final - least).max())
    return (
        gap <= 0.02 and float(final.max()) <= 0.25 + 1e-9,
        f"largest difference {gap:.3f} m, largest distance"
        f" {float(final.max()):.3f} m",
    )


def _length_and_speed(means: Means) -> tuple[bool, str]:
    lengths = means.runs("path_length")
    speeds = means.runs("avg_robot_linear_speed")
    times = means.runs("time_to_reach_goal")
    gaps, detours = [], []
    for key, length in lengths.items():
        if key[1] not in _WAYS:
            continue
        # One more sample than seconds, and three stale ones.
        told = speeds[key] * (times[key] + 4)
        gaps.append(np.abs(length.mean() - told.mean()) / length.mean())
        detours.append((length - _WAYS[key[1]]).min())
    if not gaps:
        raise KeyError(P)
    worst, shortest = float(np.max(gaps)), float(np.min(detours))
    return worst <= 0.05 and shortest >= -0.25, (
        f"length and speed times samples differ by {100 * worst:.1f} % at most;"
        f" shortest path {shortest:+.2f} m against the straight way"
    )


def _walked(means: Means) -> tuple[bool, str]:
    runs = means.runs("walked_per_person")
    told, holds = [], True
    for scenario, low, high in ((C, 6.0, 6.9), (P, 13.3, 14.5)):
        walked = [float(runs[p, scenario].mean()) for p in PLANNERS]
        least, most = float(np.min(walked)), float(np.max(walked))
        holds &= low <= least and most <= min(high, 1.05 * least)
        numbers = ", ".join(f"{w:.2f}" for w in walked)
        told.append(f"{scenario} {numbers} m (published {low} to {high})")
    return holds, "; ".join(told)


def _all_complete(means: Means) -> tuple[bool, str]:
    hits = sum(
        float(values.sum())
        for name in ("robot_on_person_collisions", "person_on_robot_collisions")
        for (_, scenario), values in means.runs(name).items()
        if scenario in (P, C)
    )
    completed = _paper_runs(means, "completed")
    done = int((completed == 1).sum())
    return done == len(completed) and hits == 0, (
        f"{done} of {len(completed)} complete, {hits:.0f} collisions"
    )


def _cruises(means: Means) -> tuple[bool, str]:
    runs = means.runs("cruising_speed")
    speeds = {p: float(runs[p, FREE].mean()) for p in ("dwb", "sfw")}
    told = ", ".join(f"{p} {v:.3f} m/s" for p, v in speeds.items())
    return all(0.55 <= v <= 0.62 for v in speeds.values()), told


# Number, scenarios, text and test.
IDENTITIES: tuple[tuple[int, str, str, Identity], ...] = (
    (1, "all", "social work is at most the sum of its forces", _work_is_a_sum),
    (2, "all", "forces on people equal those on the robot", _forces_are_mutual),
    (3, "both", "shares of zones sum to 100 %, in crossing to 99", _zones),
    (4, "both", "the robot ends where it is nearest", _final_distance),
    (5, "both", "length = mean speed x recorded time", _length_and_speed),
    (6, "both", "people walk as far with every planner", _walked),
    (7, "both", "all runs complete, without collision", _all_complete),
    (8, FREE, "cruising speed alone 0.55 to 0.62 m/s", _cruises),
)
