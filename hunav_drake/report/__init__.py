"""Reports on one run or many, as HTML."""

from hunav_drake.report.writing import WriteReport

__all__ = ["WriteReport"]
