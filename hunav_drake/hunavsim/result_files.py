"""The files of HuNavSim's evaluator: tables of text, separated by tabs.

They have HuNavSim's names of files and columns, for programs that read those.
Only the metrics that HuNavSim has are in them; the values are those of this
package, and what has no value is nan.
"""

from collections.abc import Hashable, Iterable, Mapping
import io
import math
from pathlib import Path
from typing import Any

import pandas as pd

from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES
from hunav_drake.results.text_table import append_row
from hunav_drake.systems.common.files import atomic_write
from hunav_drake.systems.evaluation.metric import TABLE_I

# HuNavSim's names where they are others.
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

# HuNavSim's names by those here.
HUNAV_NAMES = {
    name: _RENAMED.get(name, name) for name in (*TABLE_I, "max_dist_to_people")
}

# These are whole numbers.
_COUNTS = ("robot_on_person_collisions", "person_on_robot_collisions")


def write_hunav_files(
    directory: Path,
    tag: str,
    *,
    metrics: pd.Series,
    steps: pd.DataFrame,
    by_behavior: pd.DataFrame,
    steps_by_behavior: Mapping[str, pd.DataFrame],
) -> list[Path]:
    """Writes the files of a run, or adds its row to them.

    `metrics_steps_<tag>.txt` has a row per sample, with the time since the
    first; `metrics_beh_<number>_steps_<tag>.txt` the same for the people of a
    behavior by its number, with the column `behavior_active`;
    `metrics_beh_<number>.txt` and `metrics.txt` get a row for this run.
    Behaviors that HuNavSim does not have are left out. The caller holds the
    lock of the folder.

    Args:
        directory: The folder.
        tag: What tells this run from others.
        metrics: The values by name.
        steps: A row per sample, indexed by time in seconds.
        by_behavior: A row per behavior.
        steps_by_behavior: The steps for each behavior.

    Returns:
        The files that were written or added to, `metrics.txt` last.

    Raises:
        OSError: If a file cannot be written.
        ValueError: If a table in the folder is damaged.
    """
    numbers = {name: number for number, name in BEHAVIOR_NAMES.items()}
    stems = {
        behavior: f"metrics_beh_{numbers[behavior]}"
        for behavior in steps_by_behavior
        if behavior in numbers
    }
    texts = {f"metrics_steps_{tag}.txt": _steps(steps)}
    rows: dict[str, Iterable[tuple[Hashable, Any]]] = {}
    for behavior, stem in stems.items():
        texts[f"{stem}_steps_{tag}.txt"] = _steps(steps_by_behavior[behavior])
        rows[f"{stem}.txt"] = by_behavior.loc[behavior].items()
    rows["metrics.txt"] = metrics.items()
    for name, text in texts.items():
        with atomic_write(directory / name) as file:
            file.write(text.encode())
    for name, values in rows.items():
        row = {
            HUNAV_NAMES[str(metric)]: _cell(str(metric), value)
            for metric, value in values
            if metric in HUNAV_NAMES
        }
        append_row(
            directory / name, {"experiment_tag": tag} | row, delimiter="\t"
        )
    return [directory / name for name in (*texts, *rows)]


def _steps(steps: pd.DataFrame) -> str:
    names = [name for name in steps.columns if name in HUNAV_NAMES]
    table = steps[names].rename(columns=HUNAV_NAMES)
    table.insert(0, "time_stamps", steps.index - steps.index[0])
    if "behavior_active" in steps:
        table["behavior_active"] = steps["behavior_active"].astype(int)
    text = io.StringIO(newline="")
    table.to_csv(text, sep="\t", index=False, na_rep="nan", lineterminator="\n")
    return text.getvalue()


def _cell(name: str, value: float) -> str:
    if math.isnan(value):
        return "nan"
    if name == "completed":
        return str(bool(value))
    return f"{value:.0f}" if name in _COUNTS else repr(float(value))
