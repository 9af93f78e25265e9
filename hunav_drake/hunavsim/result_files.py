"""The files of HuNavSim's evaluator, as texts with tab-separated cells.

Names of files and columns are those of HuNavSim, for programs that read them.
The files contain only the metrics of HuNavSim, with the values of this package;
missing values are nan.
"""

import math

import pandas as pd

from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES
from hunav_drake.systems.evaluation.metric import TABLE_I
from hunav_drake.trial.result import TrialResult

# HuNavSim's names of metrics that have other names here.
_RENAMED = {
    "avg_dist_to_closest_person": "avg_distance_to_closest_person",
    "min_dist_to_people": "minimum_distance_to_people",
    "max_dist_to_people": "maximum_distance_to_people",
    "social+_space_intrusions": "social_space_intrusions",
    "group_social+_space_intrusions": "group_social_space_intrusions",
    "min_dist_to_target": "minimum_distance_to_target",
    "final_dist_to_target": "final_distance_to_target",
    "robot_on_person_collisions": "robot_on_person_collision",
    "person_on_robot_collisions": "person_on_robot_collision",
    "avg_robot_acceleration": "avg_acceleration",
    "avg_robot_jerk": "avg_overacceleration",
}

# HuNavSim's names by the names here.
HUNAV_NAMES = {
    name: _RENAMED.get(name, name) for name in (*TABLE_I, "max_dist_to_people")
}

# The metrics that are whole numbers.
_COUNTS = ("robot_on_person_collisions", "person_on_robot_collisions")


def hunav_texts(result: TrialResult, tag: str) -> dict[str, str]:
    """Returns HuNavSim's files of a run, by their names.

    `metrics_steps_<tag>.txt` has a row per sample, with the time since the
    first; `metrics_beh_<number>_steps_<tag>.txt` the same for the people of a
    behavior by its number, with the column `behavior_active`; `metrics.txt`
    and `metrics_beh_<number>.txt` have one row, for the whole run. Behaviors
    that HuNavSim does not have are left out. Each of several robots has files
    of its own, whose names begin with that of the robot: `anna_metrics.txt`.

    Args:
        result: The run.
        tag: The `experiment_tag`, which identifies this run.
    """
    numbers = {name: number for number, name in BEHAVIOR_NAMES.items()}
    robots = [it.robot_name for it in result.recording.robots]
    texts: dict[str, str] = {}
    for robot in robots if len(robots) > 1 else [""]:
        prefix, first = (f"{robot}.", f"{robot}_") if robot else ("", "")
        texts |= {
            f"{first}metrics.txt": _row(result.metrics, tag, prefix),
            f"{first}metrics_steps_{tag}.txt": _steps(result.steps, prefix),
        }
        for behavior, steps in result.steps_by_behavior.items():
            if behavior in numbers:
                stem = f"{first}metrics_beh_{numbers[behavior]}"
                own = result.by_behavior.loc[behavior]
                texts[f"{stem}.txt"] = _row(own, tag, prefix)
                texts[f"{stem}_steps_{tag}.txt"] = _steps(steps, prefix)
    return texts


def _row(metrics: pd.Series, tag: str, prefix: str) -> str:
    cells = {"experiment_tag": tag}
    for name, original in HUNAV_NAMES.items():
        if prefix + name in metrics:
            cells[original] = _cell(name, metrics[prefix + name])
    return "\t".join(cells) + "\n" + "\t".join(cells.values()) + "\n"


def _steps(steps: pd.DataFrame, prefix: str) -> str:
    names = {
        prefix + name: original
        for name, original in HUNAV_NAMES.items()
        if prefix + name in steps
    }
    table = steps[[*names]].rename(columns=names)
    table.insert(0, "time_stamps", steps.index - steps.index[0])
    if "behavior_active" in steps:
        table["behavior_active"] = steps["behavior_active"].astype(int)
    text: str = table.to_csv(
        sep="\t", index=False, na_rep="nan", lineterminator="\n"
    )
    return text


def _cell(name: str, value: float) -> str:
    if math.isnan(value):
        return "nan"
    if name == "completed":
        return str(bool(value))
    return f"{value:.0f}" if name in _COUNTS else repr(float(value))
