"""Recording a trial, and computing social-navigation metrics from it.

What needs Drake or pandas is loaded when it is first asked for, so that a
scenario can be read, or metrics be listed, without them.
"""

import importlib
from typing import TYPE_CHECKING, Any

from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.evaluation.metrics import (
    METRICS,
    Metric,
    register_metric,
    select_metrics,
)
from hunav_drake.systems.evaluation.recording import Recording

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.compute import (
        compute_by_behavior,
        compute_metrics,
        compute_steps,
    )
    from hunav_drake.systems.evaluation.evaluator import (
        Evaluator,
        RunningMetric,
    )

__all__ = [
    "METRICS",
    "Evaluator",
    "EvaluatorConfig",
    "Metric",
    "Recording",
    "RunningMetric",
    "compute_by_behavior",
    "compute_metrics",
    "compute_steps",
    "register_metric",
    "select_metrics",
]

_LATE = {
    "Evaluator": "evaluator",
    "RunningMetric": "evaluator",
    "compute_by_behavior": "compute",
    "compute_metrics": "compute",
    "compute_steps": "compute",
}


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_LATE[name]}"), name)
