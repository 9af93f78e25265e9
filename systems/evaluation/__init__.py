"""Recording a trial, and computing social-navigation metrics from it.

What needs Drake, pandas or numba is loaded when it is first asked for, so that
a scenario can be read, or metrics be listed, without them.
"""

from typing import TYPE_CHECKING

from hunav_drake.systems.evaluation.evaluator_config import EvaluatorConfig
from hunav_drake.systems.evaluation.metrics import (
    METRICS,
    Metric,
    register_metric,
    select_metrics,
)
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.compute import (
        compute_by_behavior,
        compute_metrics,
        compute_steps,
    )
    from hunav_drake.systems.evaluation.evaluator import Evaluator
    from hunav_drake.systems.evaluation.running_metrics import RunningMetric

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

__getattr__ = lazy_exports(
    __name__,
    {
        "Evaluator": "hunav_drake.systems.evaluation.evaluator",
        "RunningMetric": "hunav_drake.systems.evaluation.running_metrics",
        "compute_by_behavior": "hunav_drake.systems.evaluation.compute",
        "compute_metrics": "hunav_drake.systems.evaluation.compute",
        "compute_steps": "hunav_drake.systems.evaluation.compute",
    },
)
