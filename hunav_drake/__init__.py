"""Simulated people for Drake: a trial of social navigation as one Diagram."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.context_file import LoadContext, SaveContext
    from hunav_drake.humans import AddHumans, HumanPorts, MakeHumans
    from hunav_drake.plots import (
        find_approaches,
        plot_behavior_activity,
        plot_comparison,
        plot_distance_to_people,
        plot_forces,
        plot_robot_speed,
        plot_trajectories,
        plot_zones,
    )
    from hunav_drake.recordings.readers import ReadRecording
    from hunav_drake.report.writing import WriteReport
    from hunav_drake.results.files import LoadResults, WriteResult
    from hunav_drake.results.run_table import ReadRuns
    from hunav_drake.results.statistics import compare, summarize
    from hunav_drake.results.trial_result import TrialResult
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
        MakeTrialSimulator,
        RunTrial,
    )
    from hunav_drake.systems.crowd import HumanConfig
    from hunav_drake.trial_diagram import MakeTrialDiagram

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
    "ReadRuns",
    "RunTrial",
    "SaveContext",
    "SaveScenario",
    "Scenario",
    "ScenarioError",
    "TrialResult",
    "WriteReport",
    "WriteResult",
    "compare",
    "find_approaches",
    "plot_behavior_activity",
    "plot_comparison",
    "plot_distance_to_people",
    "plot_forces",
    "plot_robot_speed",
    "plot_trajectories",
    "plot_zones",
    "summarize",
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
        "LoadResults": "hunav_drake.results.files",
        "LoadScenario": "hunav_drake.scenario",
        "MakeHumans": "hunav_drake.humans",
        "MakeTrialDiagram": "hunav_drake.trial_diagram",
        "MakeTrialSimulator": "hunav_drake.simulation",
        "ReadRecording": "hunav_drake.recordings.readers",
        "ReadRuns": "hunav_drake.results.run_table",
        "RunTrial": "hunav_drake.simulation",
        "SaveContext": "hunav_drake.context_file",
        "SaveScenario": "hunav_drake.scenario",
        "Scenario": "hunav_drake.scenario",
        "ScenarioError": "hunav_drake.scenario",
        "TrialResult": "hunav_drake.results.trial_result",
        "WriteReport": "hunav_drake.report.writing",
        "WriteResult": "hunav_drake.results.files",
        "compare": "hunav_drake.results.statistics",
        "find_approaches": "hunav_drake.plots",
        "plot_behavior_activity": "hunav_drake.plots",
        "plot_comparison": "hunav_drake.plots",
        "plot_distance_to_people": "hunav_drake.plots",
        "plot_forces": "hunav_drake.plots",
        "plot_robot_speed": "hunav_drake.plots",
        "plot_trajectories": "hunav_drake.plots",
        "plot_zones": "hunav_drake.plots",
        "summarize": "hunav_drake.results.statistics",
    },
)
