"""Benchmarks: suites of trials, run in parallel, resumed, and compared."""

from hunav_drake.benchmark.run_suite import RunSuite
from hunav_drake.benchmark.suite import Suite
from hunav_drake.benchmark.suite_file import ListSuites, LoadSuite
from hunav_drake.benchmark.suite_result import SuiteResult

__all__ = ["ListSuites", "LoadSuite", "RunSuite", "Suite", "SuiteResult"]
