"""Results of trials: a folder per run, tables and statistics over runs."""

from hunav_drake.results.files import LoadResults, WriteResult
from hunav_drake.results.run_table import ReadRuns
from hunav_drake.results.statistics import compare, summarize
from hunav_drake.results.trial_result import (
    FormatMetricsTable,
    MakeTrialResult,
    TrialResult,
)

__all__ = [
    "FormatMetricsTable",
    "LoadResults",
    "MakeTrialResult",
    "ReadRuns",
    "TrialResult",
    "WriteResult",
    "compare",
    "summarize",
]
