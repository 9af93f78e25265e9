"""The robot's figure: a round mobile base on two wheels."""

from functools import partial
import math

from pydrake.geometry import Cylinder, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, PlanarJoint

from hunav_drake.systems.scene.meshes import (
    TriangleMesh,
    ellipsoid,
    extrude,
    loft,
)
from hunav_drake.systems.scene.palette import (
    ROBOT_ACCENT,
    ROBOT_DARK,
    ROBOT_SHELL,
)
from hunav_drake.systems.scene.visuals import AddVisual

# Heights, in meters; a robot with a smaller radius is lower, too.
_FULL_SIZE_RADIUS = 0.3
_DECK_LOW, _DECK_HIGH = 0.20, 0.29

# The distance of the wheels from the center, and their width, in robot radii.
_WHEEL_Y = 0.80
_WHEEL_WIDTH = 0.17


def AddRobotBody(
    plant: MultibodyPlant,
    name: str,
    *,
    radius: float,
    accent: Rgba = ROBOT_ACCENT,
) -> Joint:
    """Adds the figure of a differential-drive robot as a model instance.

    Its deck is a disc of the robot's radius; a lidar, a lamp and an arrow on
    the deck show its heading (+x at yaw 0). It has no mass and no collision
    geometry. The plant is registered with a SceneGraph and not finalized.
    `accent` is the color of its marks.

    Returns:
        The joint of its base, with the positions x, y and yaw.
    """
    instance = plant.AddModelInstance(name)
    scale = min(radius / _FULL_SIZE_RADIUS, 1.0)
    low, high = _DECK_LOW * scale, _DECK_HIGH * scale
    wheel_radius, width = 0.09 * scale, _WHEEL_WIDTH * radius

    base = plant.AddRigidBody("base", instance)
    add = partial(AddVisual, plant, base)

    chassis = loft(
        [
            [0, 0, 0.04 * scale, 0.78 * radius, 0.60 * radius],
            [0, 0, 0.07 * scale, 0.86 * radius, 0.64 * radius],
            [0, 0, low, 0.90 * radius, 0.66 * radius],
        ],
        sides=32,
        power=2.6,
    )
    add("chassis", chassis, ROBOT_DARK)
    deck = loft(
        [
            [0, 0, low - 0.012 * scale, 0.96 * radius, 0.96 * radius],
            [0, 0, low, radius, radius],
            [0, 0, high - 0.03 * scale, radius, radius],
            [0, 0, high - 0.008 * scale, 0.965 * radius, 0.965 * radius],
            [0, 0, high, 0.90 * radius, 0.90 * radius],
        ],
        sides=40,
    )
    add("deck", deck, ROBOT_SHELL)
    add("arrow", _arrow(radius, high), accent)
    # Radius and x are in robot radii, the length is for a full-size robot.
    for part, color, r, length, x, z in (
        ("band", accent, 1.004, 0.022, 0.0, low + 0.018 * scale),
        ("lidar", ROBOT_DARK, 0.17, 0.07, 0.60, high + 0.035 * scale),
        ("lidar_cap", ROBOT_SHELL, 0.18, 0.012, 0.60, high + 0.076 * scale),
    ):
        shape = Cylinder(r * radius, length * scale)
        add(part, shape, color, RigidTransform([x * radius, 0.0, z]))
    lamp = ellipsoid(
        (0.985 * radius, 0, 0.5 * (low + high) + 0.012 * scale),
        (0.03 * radius, 0.30 * radius, 0.016 * scale),
    )
    add("lamp", lamp, ROBOT_DARK)

    for side, sign in (("left", 1.0), ("right", -1.0)):
        wheel = RigidTransform(
            RotationMatrix.MakeXRotation(math.pi / 2),
            [0.0, sign * _WHEEL_Y * radius, wheel_radius],
        )
        add(f"{side}_tire", Cylinder(wheel_radius, width), ROBOT_DARK, wheel)
        hub = Cylinder(0.6 * wheel_radius, 1.04 * width)
        add(f"{side}_hub", hub, ROBOT_SHELL, wheel)
    return plant.AddJoint(
        PlanarJoint("pose", plant.world_frame(), base.body_frame())
    )


def _arrow(radius: float, height: float) -> TriangleMesh:
    """Returns a flat chevron on the deck that points along +x."""
    outline = [
        [0.34, 0.0],
        [-0.30, 0.50],
        [-0.52, 0.50],
        [0.02, 0.0],
        [-0.52, -0.50],
        [-0.30, -0.50],
    ]
    scaled = [[x * radius, y * radius] for x, y in outline]
    return extrude(scaled, height - 0.002, height + 0.006)
