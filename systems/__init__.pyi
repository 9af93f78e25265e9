from .behavior import BehaviorTree as BehaviorTree
from .crowd import HumanCrowd as HumanCrowd
from .evaluation import Evaluator as Evaluator
from .evaluation.trial_monitor import TrialMonitor as TrialMonitor
from .planning import LocalPlanner as LocalPlanner
from .robot import DifferentialDrive as DifferentialDrive
from .scene import AddScene as AddScene
from .sensing import (
    AddCamera as AddCamera,
    Lidar as Lidar,
    VisiblePeople as VisiblePeople,
)
