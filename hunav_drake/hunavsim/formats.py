"""Registers HuNavSim's formats for scenarios and runs."""

from pathlib import Path
from typing import TYPE_CHECKING

from hunav_drake.runs.foreign_formats import (
    RECORDING_PARSERS,
    RECORDING_READERS,
    RESULT_TEXTS,
)
from hunav_drake.scenario.foreign_files import FOREIGN_FILES

if TYPE_CHECKING:
    from hunav_drake.hunavsim.hunav_import import HunavImport
    from hunav_drake.scenario.yaml_document import YamlDocument
    from hunav_drake.systems.evaluation.recording import Recording
    from hunav_drake.trial.result import TrialResult


# The functions import what they need when called, because this module is
# imported with the package.
def _read_agents(document: "YamlDocument") -> "HunavImport":
    from hunav_drake.hunavsim.agents_yaml import convert_agents

    return convert_agents(document)


def _parse_recording(text: str) -> "Recording":
    from hunav_drake.hunavsim.recording_json import parse_json

    return parse_json(text)


def _read_bag(path: Path, people: str, robot: str) -> "Recording":
    from hunav_drake.hunavsim.ros2.read_bag import ReadBag

    return ReadBag(path, people=people, robot=robot)


def _result_texts(result: "TrialResult", tag: str) -> dict[str, str]:
    from hunav_drake.hunavsim.result_files import hunav_texts

    return hunav_texts(result, tag)


FOREIGN_FILES["hunav_loader"] = _read_agents
RECORDING_PARSERS[".json"] = _parse_recording
for suffix in ("", ".mcap", ".db3", ".bag"):
    RECORDING_READERS[suffix] = _read_bag
RESULT_TEXTS["hunav"] = _result_texts
