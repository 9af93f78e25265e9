"""The tables of a suite as text for a terminal."""

import math

from hunav_drake.benchmark.suite_result import SuiteResult

