"""Results of trials: a folder per run, tables and statistics over runs."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.results.files import (
        LoadResults,
        WriteResult,
    )
    from hunav_drake.results.run_table import (
        ReadRuns,
    )
    from hunav_drake.results.statistics import (
        compare,
        summarize,
    )
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

__getattr__ = lazy_exports(
    __name__,
    {
        "FormatMetricsTable": "hunav_drake.results.trial_result",
        "LoadResults": "hunav_drake.results.files",
        "MakeTrialResult": "hunav_drake.results.trial_result",
        "ReadRuns": "hunav_drake.results.run_table",
        "TrialResult": "hunav_drake.results.trial_result",
        "WriteResult": "hunav_drake.results.files",
        "compare": "hunav_drake.results.statistics",
        "summarize": "hunav_drake.results.statistics",
    },
)
