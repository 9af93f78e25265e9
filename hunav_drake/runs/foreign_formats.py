"""File formats of other programs, which their packages register."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hunav_drake.systems.evaluation.recording import Recording
    from hunav_drake.trial.result import TrialResult

# Functions that parse the text of a recording, by suffix.
RECORDING_PARSERS: dict[str, Callable[[str], "Recording"]] = {}

# Functions that read a recording from a bag, given the topics of people and of
# the robot, by suffix; "" for a folder.
RECORDING_READERS: dict[str, Callable[[Path, str, str], "Recording"]] = {}

# Functions that return the files of a result and its tag, by format.
RESULT_TEXTS: dict[str, Callable[["TrialResult", str], dict[str, str]]] = {}
