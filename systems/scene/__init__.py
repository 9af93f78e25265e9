"""The visible scene: world, people and robot as geometry."""

from hunav_drake.systems.scene.bounds import Bounds, scene_bounds
from hunav_drake.systems.scene.human_body import AddHumanBody
from hunav_drake.systems.scene.robot_body import AddRobotBody
from hunav_drake.systems.scene.scene import AddScene, ScenePorts
from hunav_drake.systems.scene.scene_kinematics import SceneKinematics

__all__ = [
    "AddHumanBody",
    "AddRobotBody",
    "AddScene",
    "Bounds",
    "SceneKinematics",
    "ScenePorts",
    "scene_bounds",
]
