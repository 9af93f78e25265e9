"""Simulated people for Drake: a trial of social navigation as one Diagram."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.context_file import LoadContext, SaveContext
    from hunav_drake.humans import AddHumans, HumanPorts, MakeHumans
    from hunav_drake.plots import plot_forces
    from hunav_drake.recording_readers import ReadRecording
    from hunav_drake.report import LoadResults, WriteReport
    from hunav_drake.results import TrialResult, WriteResult
    from hunav_drake.scenario import (
        CheckScenario,
        ListScenarios,
        LoadScenario,
        SaveScenario,
        Scenario,
        ScenarioError,
    )
    from hunav_drake.services import AgentServices
    from hunav_drake.simulation import (
        GetTrialResult,
        MakeTrialDiagram,
        MakeTrialSimulator,
        RunTrial,
    )
    from hunav_drake.systems.crowd import HumanConfig

__all__ = [
    "AddHumans",
    "AgentServices",
    "CheckScenario",
    "GetTrialResult",
    "HumanConfig",
    "HumanPorts",
    "ListScenarios",
    "LoadContext",
    "LoadResults",
    "LoadScenario",
    "MakeHumans",
    "MakeTrialDiagram",
    "MakeTrialSimulator",
    "ReadRecording",
    "RunTrial",
    "SaveContext",
    "SaveScenario",
    "Scenario",
    "ScenarioError",
    "TrialResult",
    "WriteReport",
    "WriteResult",
    "plot_forces",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "AddHumans": "hunav_drake.humans",
        "AgentServices": "hunav_drake.services",
        "CheckScenario": "hunav_drake.scenario",
        "GetTrialResult": "hunav_drake.simulation",
        "HumanConfig": "hunav_drake.systems.crowd",
        "HumanPorts": "hunav_drake.humans",
        "ListScenarios": "hunav_drake.scenario",
        "LoadContext": "hunav_drake.context_file",
        "LoadResults": "hunav_drake.report",
        "LoadScenario": "hunav_drake.scenario",
        "MakeHumans": "hunav_drake.humans",
        "MakeTrialDiagram": "hunav_drake.simulation",
        "MakeTrialSimulator": "hunav_drake.simulation",
        "ReadRecording": "hunav_drake.recording_readers",
        "RunTrial": "hunav_drake.simulation",
        "SaveContext": "hunav_drake.context_file",
        "SaveScenario": "hunav_drake.scenario",
        "Scenario": "hunav_drake.scenario",
        "ScenarioError": "hunav_drake.scenario",
        "TrialResult": "hunav_drake.results",
        "WriteReport": "hunav_drake.report",
        "WriteResult": "hunav_drake.results",
        "plot_forces": "hunav_drake.plots",
    },
)
