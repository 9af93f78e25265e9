"""Adds models of files (SDF, URDF, model directives) to a plant."""

import logging
import os
from pathlib import Path
from typing import Any

from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

# The kinds of files that a world may be made of.
_ENDINGS = (".sdf", ".urdf", ".dmd.yaml", ".world")


def AddModelFile(
    plant: MultibodyPlant, filename: str, pose: tuple[float, float, float]
) -> list[Any]:
    """Adds the models of a file to a plant, all fixed to the world.

    Args:
        plant: The plant, which is not finalized.
        filename: A path, or "package://name/...": of a package that Drake
            knows, of "hunav_drake", or of one in ROS_PACKAGE_PATH.
        pose: Where the models stand: (x, y, yaw) in W, in meters and radians.
            A file that fixes its models to the world says so itself.

    Returns:
        The instances of the models.

    Raises:
        ValueError: If the file cannot be read, or if it fixes its models to
            the world and another pose is given.
    """
    if not filename.endswith(_ENDINGS):
        raise ValueError(
            f"{filename}: must be one of {', '.join(_ENDINGS)}, by its name"
        )
    is_url = filename.startswith("package://")
    if not is_url and not os.path.isfile(filename):
        raise ValueError(f"{filename}: there is no such file")
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    packages = parser.package_map()
    packages.Add("hunav_drake", str(Path(__file__).parents[2]))
    if "ROS_PACKAGE_PATH" in os.environ:
        packages.PopulateFromEnvironment("ROS_PACKAGE_PATH")
    log = logging.getLogger("drake")
    level = log.level
    # What is wrong is in the error, and what is only odd is no matter here.
    log.setLevel(logging.ERROR)
    try:
        if is_url:
            instances = parser.AddModels(url=filename)
        else:
            instances = parser.AddModels(filename)
    except RuntimeError as error:
        line = " ".join(str(error).split())
        raise ValueError(f"{filename}: {line:.300}") from error
    finally:
        log.setLevel(level)
    X_WM = RigidTransform(RollPitchYaw(0, 0, pose[2]), [*pose[:2], 0.0])
    free = list(_free_bodies(plant, instances))
    if not free and tuple(pose) != (0.0, 0.0, 0.0):
        raise ValueError(
            f"{filename}: fixes its models to the world by itself; leave pose"
            " out, or make them free (no static, no weld to the world)"
        )
    for body in free:
        X_MB = plant.GetDefaultFloatingBaseBodyPose(body)
        plant.WeldFrames(plant.world_frame(), body.body_frame(), X_WM @ X_MB)
    return list(instances)


def _free_bodies(plant: MultibodyPlant, instances: list[Any]) -> Any:
    """Yields the bodies of some models that no joint joins to another one."""
    held = {
        int(plant.get_joint(j).child_body().index())
        for j in plant.GetJointIndices()
    }
    for instance in instances:
        for index in plant.GetBodyIndices(instance):
            if int(index) not in held:
                yield plant.get_body(index)
