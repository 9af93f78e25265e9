"""What part of a trial is recorded, how often, and which metrics follow."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import StrictBool, StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, within


@dataclass(kw_only=True, slots=True, config=CONFIG)
class EvaluatorConfig:
    """What an Evaluator records, and which metrics are computed."""

    # The time between two samples, in seconds: a multiple of the step.
    # HuNavSim's paper used 1.0.
    period: Annotated[StrictFloat, within(0, 60, "s", low_open=True)] = 0.1

    # When the recording begins: with the trial, when there first is a goal, or
    # when port `trigger` of the Evaluator, and of the trial, first is high.
    start: Literal["at_once", "at_goal_command", "by_trigger"] = "at_once"

    # Whether it ends with the first sample at the goal.
    stop_at_goal: StrictBool = False

    # The time after its first sample at which it ends, in seconds; never, by
    # default.
    timeout: (
        Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] | None
    ) = None

    # The names of metrics (or their aliases), of families, or "all".
    metrics: list[StrictStr] = field(default_factory=lambda: ["all"])
