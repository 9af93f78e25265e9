from .editor.entry import EditScenario as EditScenario
from .hunavsim.ros2.live import RunBridge as RunBridge
from .hunavsim.ros2.read_bag import ReadBag as ReadBag
from .hunavsim.ros2.write_bag import WriteBag as WriteBag
from .hunavsim.services import AgentServices as AgentServices
from .report.branches_page import WriteBranchesPage as WriteBranchesPage
from .report.comparison_figures import WriteFigures as WriteFigures
from .report.plots import (
    find_approaches as find_approaches,
    plot_behavior_activity as plot_behavior_activity,
    plot_branches as plot_branches,
    plot_comparison as plot_comparison,
    plot_costmap as plot_costmap,
    plot_delays as plot_delays,
    plot_differences as plot_differences,
    plot_distance_to_people as plot_distance_to_people,
    plot_distribution as plot_distribution,
    plot_forces as plot_forces,
    plot_robot_speed as plot_robot_speed,
    plot_tracks as plot_tracks,
    plot_trajectories as plot_trajectories,
    plot_zones as plot_zones,
)
from .report.writing import WriteReport as WriteReport
from .runs import (
    ListSuites as ListSuites,
    LoadSuite as LoadSuite,
    RunSuite as RunSuite,
    Suite as Suite,
    SuiteResult as SuiteResult,
)
from .runs.failures.found import Failures as Failures
from .runs.failures.risk import (
    EstimateFailureProbability as EstimateFailureProbability,
    FailureProbability as FailureProbability,
)
from .runs.failures.search import Falsify as Falsify
from .runs.failures.space import LoadSearchSpace as LoadSearchSpace
from .runs.failures.splitting import (
    SplitEstimate as SplitEstimate,
    SplitFailureProbability as SplitFailureProbability,
)
from .runs.recording_files import ReadRecording as ReadRecording
from .runs.result_files import (
    LoadResults as LoadResults,
    WriteResult as WriteResult,
)
from .runs.run_table import ReadRuns as ReadRuns
from .runs.statistics import compare as compare, summarize as summarize
from .scenario import (
    CheckScenario as CheckScenario,
    GenerateScenario as GenerateScenario,
    ListScenarios as ListScenarios,
    LoadScenario as LoadScenario,
    SaveScenario as SaveScenario,
    Scenario as Scenario,
    ScenarioError as ScenarioError,
)
from .systems.evaluation.encounters import find_encounters as find_encounters
from .systems.evaluation.situations import FindSituations as FindSituations
from .systems.people import HumanConfig as HumanConfig
from .systems.people.tracks import Tracks as Tracks
from .systems.planning.planner_error import PlannerError as PlannerError
from .systems.robot import AddBodyState as AddBodyState
from .tracks.files import ReadTracks as ReadTracks, WriteTracks as WriteTracks
from .trial.branches.kinds import (
    RobotGone as RobotGone,
    RobotStands as RobotStands,
    Without as Without,
    WithoutPerson as WithoutPerson,
    WithPlanner as WithPlanner,
    WithSettings as WithSettings,
)
from .trial.branches.relative import (
    CompareAlone as CompareAlone,
    register_paired_metric as register_paired_metric,
)
from .trial.branches.run import Branches as Branches, RunBranches as RunBranches
from .trial.branches.who import WhoDelayedWhom as WhoDelayedWhom
from .trial.context_file import (
    LoadContext as LoadContext,
    SaveContext as SaveContext,
)
from .trial.context_transfer import TransferContext as TransferContext
from .trial.diagram import MakeTrialDiagram as MakeTrialDiagram
from .trial.humans import (
    AddHumans as AddHumans,
    HumanOptions as HumanOptions,
    HumanPorts as HumanPorts,
    MakeHumans as MakeHumans,
)
from .trial.leaving import (
    LeaveOut as LeaveOut,
    SetRobotCommand as SetRobotCommand,
    TakeRobotAway as TakeRobotAway,
)
from .trial.result import TrialResult as TrialResult
from .trial.seeds import (
    GetTrialSeed as GetTrialSeed,
    SetDecisionSeed as SetDecisionSeed,
    SetHumansSeed as SetHumansSeed,
    SetTrialSeed as SetTrialSeed,
)
from .trial.simulation import (
    GetTrialResult as GetTrialResult,
    MakeRandomSimulator as MakeRandomSimulator,
    MakeTrialSimulator as MakeTrialSimulator,
    RunTrial as RunTrial,
)
from .validation.fitting import Fit as Fit, FitForces as FitForces
from .validation.recorded import windows_of as windows_of
from .views.film import FilmConfig as FilmConfig, RenderFilm as RenderFilm
