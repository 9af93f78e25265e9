"""The base of all kinds of furniture, and their parts."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.common.schema import (
    CONFIG,
    Angle,
    Labels,
    Name,
    Point,
    as_tuple,
    within,
)
from hunav_drake.systems.world.solids import Lettering, Prism, rectangle, turned

Extent = Annotated[StrictFloat, within(0.02, 100, "m")]
Extents = Annotated[
    tuple[Extent, Extent],
    BeforeValidator(as_tuple),
    Labels(("along x", "along y")),
]
Height = Annotated[StrictFloat, within(0.02, 100, "m")]
Load = Annotated[StrictFloat, within(0, 100, "m")]

# An upright piece in the frame of the furniture: outline, low, high, material.
Piece = tuple[Array, float, float, str]

# Where a person uses furniture, in its frame: x, y, yaw, in meters and radians.
Spot = tuple[float, float, float]


@explain
@dataclass(kw_only=True, config=CONFIG)
class Furniture(ABC):
    """The common options of all kinds of furniture.

    In its own frame, whose origin is at `center`, furniture that has a front
    faces along +x.
    """

    name: Name = ""
    """Name in messages and in the scene."""

    center: Point
    """Center of the footprint, in meters."""

    yaw: Angle = 0.0
    """Rotation about the vertical, in radians. At 0, furniture with a front (a
    seat, the side of a desk where one sits) faces along +x."""

    size: Extents = (0.5, 0.5)
    """Full extents along its own x and y, in meters."""

    height: Height = 1.0
    """Height, in meters."""

    # What people use it for: a type of place, or "".
    use: ClassVar[str] = ""

    def spots(self) -> Sequence[Spot]:
        """Returns where people use it, in its own frame."""
        return []

    @abstractmethod
    def pieces(self) -> Sequence[Piece]:
        """Returns its pieces in its own frame, in meters."""

    def along(self, x: float, yaw: float, space: float) -> list[Spot]:
        """Returns places side by side, each `space` wide, in its own frame."""
        count = max(int(self.size[1] / space), 1)
        step = self.size[1] / count
        first = (step - self.size[1]) / 2
        return [(x, first + k * step, yaw) for k in range(count)]

    def outlines(self) -> Sequence[Array]:
        """Returns its footprints in its own frame, each (k, 2), in meters."""
        x, y = np.array(self.size) / 2
        return [rectangle(-x, -y, x, y)]

    def footprints(self) -> list[Array]:
        """Returns the outlines to walk around, each (k, 2) in W, in meters."""
        pose = (*self.center, self.yaw)
        return [turned(outline, pose) for outline in self.outlines()]

    def solids(self) -> list[Prism]:
        """Returns its solids in W."""
        pose = (*self.center, self.yaw)
        half = np.array(self.size) / 2
        result = []
        for outline, low, high, material in self.pieces():
            # Parts for which furniture is too small are cut off.
            inner = np.clip(outline, -1.1 * half, 1.1 * half)
            low = max(low, 0.0)
            if np.ptp(inner, axis=0).min() > 0 and low < high:
                result.append(Prism(turned(inner, pose), low, high, material))
        return result

    def letters(self) -> Sequence[Lettering]:
        """Returns the texts on it, in W."""
        return []


FURNITURE = Registry("kind of furniture", Furniture)

register_furniture = FURNITURE.register


def block(
    box: tuple[float, float, float, float],
    heights: tuple[float, float],
    material: str,
) -> Piece:
    """Returns a box: (x0, y0, x1, y1), (low, high), in meters."""
    # The sides of a part for which furniture is too small may be swapped.
    (x0, x1), (y0, y1) = sorted(box[::2]), sorted(box[1::2])
    return rectangle(x0, y0, x1, y1), *heights, material


def legs(
    size: tuple[float, float], top: float, material: str, width: float = 0.05
) -> list[Piece]:
    """Returns four legs in the corners of a rectangle."""
    w = min(width, *(extent / 3 for extent in size))
    x, y = (extent / 2 - 0.6 * w for extent in size)
    return [
        block(
            (a * x - w / 2, b * y - w / 2, a * x + w / 2, b * y + w / 2),
            (0.0, top),
            material,
        )
        for a in (-1, 1)
        for b in (-1, 1)
    ]
