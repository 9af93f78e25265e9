"""Formats of other programs: recordings that are read, results written."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.recording import Recording
    from hunav_drake.trial.result import TrialResult

# What makes a recording of the text of a file, by the end of its name.
RECORDING_PARSERS: dict[str, Callable[[str], Recording]] = {}

# What gives the texts of files of a result and its tag, by the format.
RESULT_TEXTS: dict[str, Callable[[TrialResult, str], dict[str, str]]] = {}
