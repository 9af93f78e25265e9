from .compute import (
    compute_by_behavior as compute_by_behavior,
    compute_metrics as compute_metrics,
    compute_steps as compute_steps,
    count_people as count_people,
)
from .encounters import (
    ZONES as ZONES,
    Encounters as Encounters,
    find_encounters as find_encounters,
)
from .evaluator import Evaluator as Evaluator
from .evaluator_config import EvaluatorConfig as EvaluatorConfig
from .metrics import (
    METRICS as METRICS,
    Metric as Metric,
    register_metric as register_metric,
    select_metrics as select_metrics,
)
from .recording import Recording as Recording
from .robustness import (
    ROBUSTNESS as ROBUSTNESS,
    register_robustness as register_robustness,
)
from .running_metrics import RunningMetric as RunningMetric
from .situations import (
    FindSituations as FindSituations,
    Situations as Situations,
)
