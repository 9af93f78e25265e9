"""The metrics, one file per family. Importing this registers them all."""

from hunav_drake.systems.evaluation.metric import (
    METRICS,
    Metric,
    register_metric,
    select_metrics,
)

# The metrics register themselves.
from hunav_drake.systems.evaluation.metrics import (  # noqa: F401
    clearance,
    collisions,
    comparison,
    contacts,
    danger,
    efficiency,
    fleet,
    forces,
    goal,
    path,
    proxemics,
    replay,
    smoothness,
    speeds,
    surprise,
)

__all__ = ["METRICS", "Metric", "register_metric", "select_metrics"]
