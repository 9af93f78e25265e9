"""Keeps what the suite `paper` has measured, of which the docs print means.

    hunav bench paper --out out && python -m tests.paper_results out/paper

writes `data/paper_results.json`. `test_paper_results.py` compares the docs
with it, and some of its runs with those of today.
"""

import json
from pathlib import Path
import sys

import pandas as pd

FILE = Path(__file__).parent / "data" / "paper_results.json"

# The rows of the table in docs/paper_results.md: scenario, behavior ("" for
# all) and metric.
ROWS = (
    ("passing", "", "time_to_reach_goal"),
    ("passing", "", "min_dist_to_people"),
    ("passing", "", "personal_space_intrusions"),
    ("crossing", "", "time_to_reach_goal"),
    ("crossing", "", "cumulative_heading_changes"),
    ("crossing", "", "social_work"),
    ("combined", "curious", "min_dist_to_people"),
    ("combined", "threatening", "min_dist_to_people"),
    ("combined", "threatening", "intimate_space_intrusions"),
)


def values_of(
    runs: pd.DataFrame, by_behavior: pd.DataFrame
) -> dict[str, dict[str, list[float]]]:
    """Returns the value of each run, by row and planner, by increasing seed.

    Args:
        runs: The table `SuiteResult.runs()`.
        by_behavior: The table `SuiteResult.runs(by_behavior=True)`.
    """
    by_behavior = by_behavior.set_index("behavior")
    values: dict[str, dict[str, list[float]]] = {}
    for scenario, behavior, metric in ROWS:
        table = by_behavior.loc[behavior] if behavior else runs
        cells = table[table["scenario"] == scenario].sort_values("seed")
        values[" ".join((scenario, behavior, metric)).replace("  ", " ")] = {
            planner: [float(f"{value:.9g}") for value in cell[metric]]
            for planner, cell in cells.groupby("planner")
        }
    return values


def main(folder: Path) -> None:
    """Writes the file, from the folder of a finished suite."""
    relations = pd.read_csv(folder / "relations.csv")
    holds = {
        strength: [
            int(some["verdict"].isin(["holds", "mean only"]).sum()),
            int((some["verdict"] == "holds").sum()),
            len(some),
        ]
        for strength, some in relations.groupby("strength")
    }
    values = values_of(
        pd.read_csv(folder / "runs.csv"),
        pd.read_csv(folder / "runs_by_behavior.csv"),
    )
    text = json.dumps({"holds": holds, "values": values}, indent=1)
    FILE.write_text(f"{text}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
