"""What part of a trial is recorded, how often, and which metrics follow."""

from collections.abc import Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictFloat, StrictStr, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, Integer, within

# What is meant where a key is left out, by profile. The one of the paper is
# inferred from its tables: a sample a second, of which the last is repeated
# while the evaluator waits three seconds for more.
EVALUATOR_PROFILES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "default": {},
        "paper": {"period": 1.0, "stale_samples": 3, "forces": "hunavsim"},
    }
)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class EvaluatorConfig:
    """What an Evaluator records, and which metrics are computed."""

    profile: Literal["default", "paper"] = "default"
    """What is meant where a key is left out: the defaults written here, or, by
    "paper", what HuNavSim's evaluator recorded for the tables of its paper."""

    period: Annotated[StrictFloat, within(0, 60, "s", low_open=True)] = 0.1
    """The time between two samples, in seconds: a multiple of the step."""

    start: Literal["at_once", "at_goal_command", "by_trigger"] = "at_once"
    """When the recording begins: with the trial, when there first is a goal, or
    when port `trigger` of the Evaluator, and of the trial, first is high."""

    stop_at_goal: StrictBool = False
    """Whether it ends with the first sample at the goal."""

    timeout: (
        Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] | None
    ) = None
    """The time after its first sample at which it ends, in seconds; never, by
    default."""

    stale_samples: Annotated[Integer, Field(ge=0, le=1000)] = 0
    """How often the last sample is repeated in the recording of a result. It
    counts in means and shares, as in HuNavSim's evaluator, which goes on
    recording for a while after the last message."""

    forces: Literal["model", "hunavsim"] = "model"
    """How the metrics of forces are computed: "model", by the social force
    model; "hunavsim", as HuNavSim's evaluator does, which mixes up the
    arguments of an arctangent, so that they depend on how the world is turned,
    and is told of no walls near the robot."""

    metrics: list[StrictStr] = field(default_factory=lambda: ["all"])
    """The names of metrics (or their aliases), of families, or "all"."""

    @model_validator(mode="before")
    @classmethod
    def _apply_profile(cls, data: Any) -> Any:
        given = data.kwargs if isinstance(data, ArgsKwargs) else data
        if not isinstance(given, Mapping):
            return data
        name = given.get("profile")
        known = isinstance(name, str) and name in EVALUATOR_PROFILES
        return {**EVALUATOR_PROFILES[str(name)], **given} if known else data

    def defaults(self) -> "EvaluatorConfig":
        """Returns what this is by its profile alone."""
        return EvaluatorConfig(profile=self.profile)
