"""The building blocks of a trial: Drake systems, each usable alone."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.systems.behavior import BehaviorTree
    from hunav_drake.systems.crowd import HumanCrowd
    from hunav_drake.systems.evaluation import Evaluator
    from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
    from hunav_drake.systems.planning import LocalPlanner
    from hunav_drake.systems.robot import DifferentialDrive
    from hunav_drake.systems.scene import AddScene

__all__ = [
    "AddScene",
    "BehaviorTree",
    "DifferentialDrive",
    "Evaluator",
    "HumanCrowd",
    "LocalPlanner",
    "TrialMonitor",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "AddScene": "hunav_drake.systems.scene",
        "BehaviorTree": "hunav_drake.systems.behavior",
        "DifferentialDrive": "hunav_drake.systems.robot",
        "Evaluator": "hunav_drake.systems.evaluation",
        "HumanCrowd": "hunav_drake.systems.crowd",
        "LocalPlanner": "hunav_drake.systems.planning",
        "TrialMonitor": "hunav_drake.systems.evaluation.trial_monitor",
    },
)
