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
from hunav_drake.systems.evaluation.names import (
    AVG_DIST_TO_CLOSEST_PERSON,
    AVG_ROBOT_ACCELERATION,
    AVG_ROBOT_JERK,
    BEHAVIOR_ACTIVE,
    COMPLETED,
    FINAL_DIST_TO_TARGET,
    GROUP_SOCIAL_SPACE_INTRUSIONS,
    MAX_DIST_TO_PEOPLE,
    MIN_DIST_TO_PEOPLE,
    MIN_DIST_TO_TARGET,
    PERSON_ON_ROBOT_COLLISIONS,
    ROBOT_ON_PERSON_COLLISIONS,
    SOCIAL_SPACE_INTRUSIONS,
    TABLE_I,
)

# HuNavSim's names where they are others.
_RENAMED = {
    AVG_DIST_TO_CLOSEST_PERSON: "avg_distance_to_closest_person",
    MIN_DIST_TO_PEOPLE: "minimum_distance_to_people",
    MAX_DIST_TO_PEOPLE: "maximum_distance_to_people",
    SOCIAL_SPACE_INTRUSIONS: "social_space_intrusions",
    GROUP_SOCIAL_SPACE_INTRUSIONS: "group_social_space_intrusions",
    MIN_DIST_TO_TARGET: "minimum_distance_to_target",
    FINAL_DIST_TO_TARGET: "final_distance_to_target",
    ROBOT_ON_PERSON_COLLISIONS: "robot_on_person_collision",
    PERSON_ON_ROBOT_COLLISIONS: "person_on_robot_collision",
    AVG_ROBOT_ACCELERATION: "avg_acceleration",
    AVG_ROBOT_JERK: "avg_overacceleration",
}

# HuNavSim's names by those here.
HUNAV_NAMES = {
    name: _RENAMED.get(name, name) for name in (*TABLE_I, MAX_DIST_TO_PEOPLE)
}

# These are whole numbers.
_COUNTS = (ROBOT_ON_PERSON_COLLISIONS, PERSON_ON_ROBOT_COLLISIONS)


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
    if BEHAVIOR_ACTIVE in steps:
        table[BEHAVIOR_ACTIVE] = steps[BEHAVIOR_ACTIVE].astype(int)
    text = io.StringIO(newline="")
    table.to_csv(text, sep="\t", index=False, na_rep="nan", lineterminator="\n")
    return text.getvalue()


def _cell(name: str, value: float) -> str:
    if math.isnan(value):
        return "nan"
    if name == COMPLETED:
        return str(bool(value))
    return f"{value:.0f}" if name in _COUNTS else repr(float(value))
