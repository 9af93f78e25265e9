"""Reports on one or more runs, as HTML."""

from hunav_drake.report.writing import WriteReport

__all__ = ["WriteReport"]
