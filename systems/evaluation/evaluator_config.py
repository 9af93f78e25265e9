"""When the evaluator takes its samples, and what is computed from them."""

from dataclasses import field
from typing import Annotated

from pydantic import StrictFloat, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, within


@dataclass(kw_only=True, slots=True, config=CONFIG)
class EvaluatorConfig:
    """What is recorded and computed."""

    # The time between two samples, in seconds: a multiple of the step.
    # HuNavSim's paper used 1.0.
    period: Annotated[StrictFloat, within(0, 60, "s", low_open=True)] = 0.1

    # The names of metrics (or their aliases), of families, or "all".
    metrics: list[StrictStr] = field(default_factory=lambda: ["all"])
