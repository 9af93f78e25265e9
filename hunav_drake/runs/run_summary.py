"""The file `result.json` of a run: everything but its recording."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import pandas as pd
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    FiniteFloat,
    PlainSerializer,
    ValidationError,
)

from hunav_drake.trial.metric_facts import (
    FACTS,
    direction_of,
    family_of,
    unit_of,
)
from hunav_drake.trial.provenance import Provenance
from hunav_drake.trial.result import EndReason, TrialResult


def _from_json(value: Any) -> Any:
    if value is None:
        return math.nan
    return float(value) if value in ("Infinity", "-Infinity") else value


def _to_json(value: float) -> float | str | None:
    if math.isfinite(value):
        return value
    return None if math.isnan(value) else f"{'-' * (value < 0)}Infinity"


# JSON has finite numbers only.
JsonNumber = Annotated[
    float, BeforeValidator(_from_json), PlainSerializer(_to_json)
]


class MetricEntry(BaseModel):
    """A metric of a run: its value, and what is known of the metric."""

    model_config = ConfigDict(strict=True)

    value: JsonNumber
    unit: str
    family: str
    direction: Literal["lower", "higher", "none"]


class RunSummary(BaseModel):
    """What `result.json` holds; see `TrialResult` for the fields."""

    model_config = ConfigDict(strict=True)

    scenario: str
    setting: str = ""
    end_reason: EndReason
    end_message: str
    end_time: FiniteFloat
    provenance: Provenance
    metrics: dict[str, MetricEntry]
    # The values by behavior, then by metric.
    by_behavior: dict[str, dict[str, JsonNumber]]

    def metric_values(self) -> pd.Series:
        """Returns the metrics by name, with facts on them in `attrs`."""
        entries = self.metrics
        values = {name: entry.value for name, entry in entries.items()}
        series = pd.Series(values, dtype=float, name="value")
        series.index.name = "metric"
        for fact, key in FACTS.items():
            series.attrs[key] = {
                name: getattr(entry, fact) for name, entry in entries.items()
            }
        return series


def make_summary(result: TrialResult) -> RunSummary:
    """Returns the summary of a trial."""
    metrics = result.metrics
    return RunSummary.model_validate(
        {
            "scenario": result.scenario_name,
            "setting": result.setting,
            "end_reason": result.end_reason,
            "end_message": result.end_message,
            "end_time": result.end_time,
            "provenance": result.provenance,
            "metrics": {
                name: {
                    "value": value,
                    "unit": unit_of(metrics, name),
                    "family": family_of(metrics, name),
                    "direction": direction_of(metrics, name),
                }
                for name, value in metrics.items()
            },
            "by_behavior": {
                str(behavior): values.to_dict()
                for behavior, values in result.by_behavior.iterrows()
            },
        }
    )


def read_summary(path: Path) -> RunSummary:
    """Reads a file `result.json`.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is not such a file: which field, rule and value.
    """
    try:
        return RunSummary.model_validate_json(path.read_bytes())
    except ValidationError as error:
        fault = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(map(str, fault["loc"])) or "the file"
        got = f"{fault['input']!r:.60}"
        raise ValueError(
            f"{path}: is not a result: {place}: {fault['msg']}, got {got}"
        ) from error
