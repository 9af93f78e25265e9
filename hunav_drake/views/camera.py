"""The camera of a film: its pose, and its projection."""

from dataclasses import dataclass
import itertools
import math
from typing import Literal, get_args

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.scene.bounds import (
    Bounds,
    overview_rotation,
    view_axes,
)
from hunav_drake.views.replay import FIELD_OF_VIEW, camera_pose

View = Literal["perspective", "top", "follow", "plot"]
VIEWS: tuple[View, ...] = get_args(View)

# The distance of the camera from the robot that it follows, in meters.
FOLLOW_DISTANCE = 11.0

# The sun is so many times as far away as the scene is large; the size of a
# pixel of what it sees, in meters, and their largest number along a side.
_SUN_FAR, _SUN_PIXEL, _SUN_PIXELS = 60.0, 0.02, 1400


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Attributes:
        X_WC: Its pose, with x to the right, y down and z ahead.
        size: Width and height of the picture, in pixels.
        fov: The angle that it sees from top to bottom, in radians.
        clipping: The depths between which it sees things, in meters.
    """

    X_WC: RigidTransform
    size: tuple[int, int]
    fov: float = FIELD_OF_VIEW
    clipping: tuple[float, float] = (0.1, 2000.0)

    @property
    def focal_length(self) -> float:
        """In pixels."""
        return self.size[1] / 2 / math.tan(self.fov / 2)

    def Project(self, points: Array) -> tuple[Array, Array]:
        """Projects points of shape (k, 3) in W, in meters, to the picture.

        Returns:
            Pixels, shape (k, 2), to the right and down, NaN for points behind
            the camera; and depths, shape (k,), in meters.
        """
        p_CQ = (self.X_WC.inverse() @ np.asarray(points, dtype=float).T).T
        depth = p_CQ[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.where(depth > 0.01, self.focal_length / depth, np.nan)
        middle = np.array(self.size) / 2
        return middle + p_CQ[:, :2] * scale[:, None], depth

    def Unproject(self, depth: Array) -> Array:
        """Returns what pixels show, (height, width, 3) in W, by its depth."""
        w, h = self.size
        v, u = np.mgrid[:h, :w] + 0.5
        rays = [(u - w / 2), (v - h / 2), np.full((h, w), self.focal_length)]
        p_CQ = np.stack(rays, axis=-1) * (depth / self.focal_length)[..., None]
        R, p = self.X_WC.rotation().matrix(), self.X_WC.translation()
        points: Array = p_CQ @ R.T + p
        return points

    def FloorDepth(self) -> Array:
        """Returns the depth of the floor in each pixel, (height, width), in m.

        It is infinite where the floor is not visible.
        """
        w, h = self.size
        f = self.focal_length
        u = (np.arange(w) + 0.5 - w / 2) / f
        v = (np.arange(h) + 0.5 - h / 2) / f
        R = self.X_WC.rotation().matrix()
        down = -(R[2, 0] * u[None, :] + R[2, 1] * v[:, None] + R[2, 2])
        height = self.X_WC.translation()[2]
        with np.errstate(divide="ignore"):
            return np.where(down > 1e-6, height / down, np.inf)


def overview_camera(bounds: Bounds, size: tuple[int, int]) -> Camera:
    """Returns the camera that sees a rectangle of floor at an angle."""
    p_WC, _ = camera_pose(bounds, size[0] / size[1])
    return Camera(_posed(_optical(bounds), p_WC), size)


def top_camera(bounds: Bounds, size: tuple[int, int]) -> Camera:
    """Returns the camera that sees a rectangle of floor from above."""
    right, ahead = view_axes(bounds)
    axes = [right, -ahead, np.array([0.0, 0.0, -1.0])]
    longer, shorter = max(bounds.size), min(bounds.size)
    half = max(longer / 2 * size[1] / size[0], shorter / 2)
    # Heads, closer to the camera, must be in the picture, too.
    height = 1.05 * half / math.tan(FIELD_OF_VIEW / 2) + 1.0
    return Camera(_posed(np.column_stack(axes), [*bounds.center, height]), size)


def follow_camera(
    bounds: Bounds, robot: Array, size: tuple[int, int]
) -> Camera:
    """Returns a camera at the robot, in the direction of the overview."""
    R_WC = _optical(bounds)
    target = np.array([robot[0], robot[1], 0.4])
    return Camera(_posed(R_WC, target - FOLLOW_DISTANCE * R_WC[:, 2]), size)


def sun_camera(bounds: Bounds, fall: Array, *, height: float) -> Camera:
    """Returns a camera that sees a rectangle of floor as the sun does.

    `fall` is the direction of its light; the camera sees all up to a height, in
    meters.
    """
    ahead = fall / np.linalg.norm(fall)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(ahead, right), ahead])
    xs, ys = (bounds.x_min, bounds.x_max), (bounds.y_min, bounds.y_max)
    corners = np.array([*itertools.product(xs, ys, (0.0, height))]) @ axes
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = 1.02 * (high - low)
    distance = _SUN_FAR * extent.max()
    pixel = max(_SUN_PIXEL, extent[:2].max() / _SUN_PIXELS)
    width, depth = (math.ceil(it / pixel) for it in extent[:2])
    middle = axes @ ((low + high) / 2)
    reach = extent.max()
    return Camera(
        _posed(axes, middle - distance * ahead),
        (width, depth),
        2 * math.atan(depth * pixel / 2 / distance),
        (distance - reach, distance + reach),
    )


def _optical(bounds: Bounds) -> Array:
    """Returns right, down and ahead of the overview, as columns."""
    R_WC: Array = overview_rotation(bounds).matrix()
    return R_WC * [1.0, -1.0, -1.0]


def _posed(R_WC: Array, p_WC: Array | list[float]) -> RigidTransform:
    return RigidTransform(RotationMatrix(R_WC), np.asarray(p_WC))
