"""The configuration of recording and metrics."""

from collections.abc import Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictFloat, StrictStr, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, Integer, within

# The default values of keys, by profile. The profile of the paper is inferred
# from its tables: a sample per second, of which the last is repeated while the
# evaluator waits three seconds for more.
EVALUATOR_PROFILES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "default": {},
        "paper": {"period": 1.0, "stale_samples": 3, "forces": "hunavsim"},
    }
)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class EvaluatorConfig:
    """Configuration of the recording and of the metrics."""

    profile: Literal["default", "paper"] = "default"
    """Default values of the other keys: "default", those given here; "paper",
    those of HuNavSim's evaluator for the tables of its paper."""

    period: Annotated[StrictFloat, within(0, 60, "s", low_open=True)] = 0.1
    """Time between two samples, in seconds; a multiple of the trial's time
    step."""

    start: Literal["at_once", "at_goal_command", "by_trigger"] = "at_once"
    """Start of the recording: with the trial ("at_once"), with the first goal
    ("at_goal_command"), or when port `trigger` of the Evaluator, and of the
    trial, is first high ("by_trigger")."""

    stop_at_goal: StrictBool = False
    """Whether the recording ends with the first sample at the goal."""

    timeout: (
        Annotated[StrictFloat, within(0, 86400, "s", low_open=True)] | None
    ) = None
    """Time after the first sample at which the recording ends, in seconds.
    None: no limit."""

    stale_samples: Annotated[Integer, Field(ge=0, le=1000)] = 0
    """Number of repetitions of the last sample in the recording of a result.
    They count in means and percentages, as in HuNavSim's evaluator, which
    continues to record for a while after the last message."""

    forces: Literal["model", "hunavsim"] = "model"
    """Computation of force metrics: "model", by the social force model;
    "hunavsim", as in HuNavSim's evaluator, which swaps the arguments of an
    arctangent, so that the forces depend on the orientation of the world, and
    which gets no walls near the robot."""

    metrics: list[StrictStr] = field(default_factory=lambda: ["all"])
    """Names of metrics (or their aliases), of families, or "all"."""

    situations: StrictBool = False
    """Whether results also have the metrics on the samples of each social
    situation, as `path_length[passing]`, and how long each lasts."""

    encounters: StrictBool = False
    """Whether results also have the metrics of encounters, as
    `time_in_intimate`, at exact instants: they are those of all time steps
    from the first to the last sample, whatever the period."""

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
        """Returns the configuration with the defaults of its profile."""
        return EvaluatorConfig(profile=self.profile)
