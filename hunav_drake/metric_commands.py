"""What `hunav evaluate` and `hunav metrics` do."""

from collections.abc import Sequence
import dataclasses
import math
from pathlib import Path
import shutil
import textwrap

from hunav_drake.recording_readers import ReadRecording
from hunav_drake.results import (
    MakeSourceProvenance,
    MakeTrialResult,
    TrialResult,
)
from hunav_drake.systems.evaluation.differences import DIFFERENCES
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.evaluation.recording import Recording

_DIRECTIONS = {
    "lower": "lower is better",
    "higher": "higher is better",
    "none": "neither is better",
}


def evaluate_file(
    filename: Path,
    *,
    metric_names: Sequence[str] = ("all",),
    goal: str | None = None,
    reference: Path | None = None,
) -> TrialResult:
    """Computes the metrics of a recording.

    Args:
        filename: The recording: see `ReadRecording`.
        metric_names: Names of metrics, their aliases, families, "paper" or
            "all".
        goal: A goal "x,y" or "x,y,yaw" instead of the recording's, in meters
            and radians; without yaw any heading will do.
        reference: A recording of a robot that went the way it should.

    Raises:
        OSError: If a file cannot be read.
        ValueError: If a file is not a recording, or a name or the goal makes
            no sense.
    """
    select_metrics(metric_names)
    recording = ReadRecording(filename)
    if goal is not None:
        recording = _with_goal(recording, goal)
    if reference is not None:
        recording = recording.compared_with(ReadRecording(reference))
    at_goal = bool(recording.derived.at_goal[-1])
    return MakeTrialResult(
        recording,
        scenario_name=filename.name.split(".")[0],
        metric_names=metric_names,
        provenance=MakeSourceProvenance(filename),
        end_reason="goal" if at_goal else "end",
        end_message="the robot is at its goal"
        if at_goal
        else "the recording ends",
        end_time=float(recording.times[-1] - recording.times[0]),
    )


def _with_goal(recording: Recording, text: str) -> Recording:
    try:
        x, y, *rest = (float(part) for part in text.split(","))
        (yaw,) = rest or [0.0]
    except ValueError:
        raise ValueError(
            f"--goal must be X,Y or X,Y,YAW in meters and radians, got {text!r}"
        ) from None
    tolerance = recording.goal_yaw_tolerance if rest else math.pi
    return dataclasses.replace(
        recording, goal=(x, y, yaw), goal_yaw_tolerance=tolerance
    )


def list_metrics() -> str:
    """Returns a line for each metric, by family: name, unit, and what it is.

    A minus sign before the unit says that less is better, a plus sign that
    more is.
    """
    width = shutil.get_terminal_size(fallback=(120, 24)).columns
    signs = {"lower": "-", "higher": "+", "none": " "}
    name_width = max(map(len, METRICS)) + 2
    lines = ["+ more is better, - less is better"]
    metrics = select_metrics(["all"])
    families = list(dict.fromkeys(metric.family for metric in metrics))
    metrics.sort(key=lambda metric: families.index(metric.family))
    family = None
    for metric in metrics:
        if metric.family != family:
            family = metric.family
            lines += ["", family]
        first = metric.definition.splitlines()[0]
        line = (
            f"  {metric.name:{name_width}}{signs[metric.direction]}"
            f" {metric.unit:6} {first}"
        )
        lines.append(line if len(line) <= width else line[: width - 3] + "...")
    return "\n".join(lines)


def show_metrics(names: Sequence[str]) -> str:
    """Returns all that is known about metrics.

    Args:
        names: Names of metrics, their aliases, families, "paper" or "all".

    Raises:
        ValueError: If a name is unknown.
    """
    blocks = []
    for metric in select_metrics(names):
        facts = [
            f"{metric.name} [{metric.unit}]",
            f"  family     {metric.family}",
            f"  direction  {_DIRECTIONS[metric.direction]}",
            f"  source     {metric.source}",
        ]
        if metric.aliases:
            facts.append(f"  also       {', '.join(metric.aliases)}")
        text = textwrap.indent(metric.definition, "  ")
        if metric.name in DIFFERENCES:
            text += "\n\n" + textwrap.fill(
                f"Not as in HuNavSim: {DIFFERENCES[metric.name]}.",
                width=80,
                initial_indent="  ",
                subsequent_indent="  ",
            )
        blocks.append("\n".join([*facts, "", text]))
    return "\n\n".join(blocks)
