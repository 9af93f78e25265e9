"""Reports in HTML, on a run or on many."""

from hunav_drake.report.writing import WriteReport

__all__ = [
    "WriteReport",
]
