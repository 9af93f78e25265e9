from .bounds import Bounds as Bounds, scene_bounds as scene_bounds
from .human_body import AddHumanBody as AddHumanBody
from .robot_body import AddRobotBody as AddRobotBody
from .scene import (
    AddScene as AddScene,
    SceneInputs as SceneInputs,
    ScenePorts as ScenePorts,
)
from .scene_config import SceneConfig as SceneConfig
from .scene_kinematics import SceneKinematics as SceneKinematics
