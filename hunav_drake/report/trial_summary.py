"""What a report on one trial tells, in three sentences."""

from collections.abc import Mapping
import math

import numpy as np

from hunav_drake.report.tables import number
from hunav_drake.runs.outcomes import GOAL
from hunav_drake.systems.common.suggest import counted, listed
from hunav_drake.systems.evaluation.encounters import Encounters
from hunav_drake.systems.evaluation.metric import LEAST_GAP
from hunav_drake.systems.scene.overlays.reactions import reactions
from hunav_drake.trial.result import TrialResult


def trial_summary(
    result: TrialResult, encounters: Mapping[str, Encounters]
) -> list[str]:
    """Returns three sentences on a trial: its end, distances, and contacts.

    Times are those since the recording began.

    Args:
        result: The trial.
        encounters: By robot, what `find_encounters` returns.
    """
    run = result.recording
    robots = list(run.robots)
    ends = result.robot_ends or {robots[0].robot_name: result.end_reason}
    arrived = sum(it == GOAL for it in ends.values())
    start = float(run.times[0])
    # (That of a file is its length: its clock may begin anywhere.)
    begin = 0.0 if "source" in result.provenance else start
    time = f"{number(result.end_time - begin)} s"
    lengths = [
        float(np.hypot(*np.diff(it.until_end().robot[:, :2], axis=0).T).sum())
        for it in robots
    ]
    length = f"{number(sum(lengths), 'm')} m"
    if start > 0:
        length += f", from {number(start)} s on"
    several = len(robots) > 1
    if all(it.goal is None for it in robots):
        end = f"had no goal; the trial ended after {time} and {length}"
        first = f"The robot{'s' * several} {end}."
    elif several:
        first = (
            f"{arrived} of {len(robots)} robots reached their goals; the trial"
            f" ended after {time}, in which they drove {length}."
        )
    elif arrived:
        first = f"The robot reached its goal after {time} and {length}."
    else:
        first = (
            f"The robot did not reach its goal: the trial ended after {time}"
            f" ({result.end_reason}), in which it drove {length}."
        )
    it, its = ("They", "a robot") if several else ("It", "the robot")
    gaps = [
        (gap, person, when)
        for found in encounters.values()
        for gap, person, when in zip(
            found.by_person[LEAST_GAP].tolist(),
            run.human_names,
            found.by_person["min_gap_time"].tolist(),
            strict=True,
        )
        if math.isfinite(gap)
    ]
    if not gaps:
        speeds = np.concatenate(
            [it.until_end().features.forward_speed for it in robots]
        )
        people = "There were no people." if not run.num_humans else ""
        return [
            first,
            people or "Nobody was there at the same time.",
            f"{it} drove at {number(float(speeds.mean()), 'm/s')} m/s on"
            " average.",
        ]
    gap, name, when = min(gaps)
    moment = f"{number(when - start, 's')} s"
    near = f"{number(max(gap, 0.0), 'm')} m" if gap > 0 else "a contact"
    second = (
        f"{it} came nearest to {name}, after {moment}: {near}"
        f"{', from surface to surface' * (gap > 0)}."
    )
    touched = list(dict.fromkeys(who for gap, who, _ in gaps if gap <= 0))
    n = run.num_humans
    found = reactions(run.times, run.behavior_status, run.social_signals)
    reacting = len({i for i, _, _ in found})
    third = (
        f"{it} touched {listed(touched)}" if touched else f"{it} touched nobody"
    )
    return [
        first,
        second,
        f"{third}, and {reacting} of {counted(n, 'person', 'people')}"
        f" reacted to {its}.",
    ]
