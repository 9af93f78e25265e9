"""Furniture to sit or stand at."""

from collections.abc import Sequence

import numpy as np
from pydantic import StrictBool
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.world.furniture.base import (
    Extents,
    Furniture,
    Height,
    Piece,
    block,
    legs,
    register_furniture,
)
from hunav_drake.systems.world.solids import disc


@register_furniture("table")
@dataclass(kw_only=True, config=CONFIG)
class Table(Furniture):
    """A table top on four legs; a round one has a leg in the middle."""

    size: Extents = (1.2, 0.8)
    height: Height = 0.75

    round: StrictBool = False
    """Whether it is round (an ellipse, if the extents differ)."""

    def outlines(self) -> Sequence[Array]:
        """Returns the outline of the top."""
        if self.round:
            return [disc(0.0, 0.0, 0.5) * np.array(self.size)]
        return super().outlines()

    def pieces(self) -> Sequence[Piece]:
        """Returns the top and its support."""
        under = 0.95 * self.height
        top = (self.outlines()[0], under, self.height, "wood")
        if not self.round:
            return [top, *legs(self.size, under, "dark wood")]
        least = min(self.size)
        return [
            top,
            (disc(0, 0, 0.06 * least), 0.0, under, "metal"),
            (disc(0, 0, 0.28 * least), 0.0, 0.03 * self.height, "metal"),
        ]


@register_furniture("desk")
@dataclass(kw_only=True, config=CONFIG)
class Desk(Furniture):
    """A desk with drawers and a screen; people sit on the side of +x."""

    size: Extents = (0.75, 1.5)
    height: Height = 0.74

    def pieces(self) -> Sequence[Piece]:
        """Returns top, back panel, drawers, and a screen on it."""
        (x, y), h = np.array(self.size) / 2, self.height
        under = h - 0.04
        w = min(0.4, 0.6 * y)
        return [
            block((-x, -y, x, y), (under, h), "wood"),
            block((-x, -y, -0.9 * x, y), (0.25 * h, under), "white"),
            block((-0.9 * x, y - w, 0.9 * x, y), (0.0, under), "white"),
            block((-0.9 * x, -y, 0.9 * x, 0.04 - y), (0.0, under), "white"),
            block((-0.5 * x, -0.08, -0.2 * x, 0.08), (h, h + 0.02), "dark"),
            block((-0.4 * x, -0.03, -0.34 * x, 0.03), (h, h + 0.12), "dark"),
            block(
                (-0.36 * x, -0.27, -0.3 * x, 0.27), (h + 0.1, h + 0.42), "dark"
            ),
        ]


@register_furniture("counter")
@dataclass(kw_only=True, config=CONFIG)
class Counter(Furniture):
    """A counter to stand at: a closed body with a top."""

    size: Extents = (0.6, 2.0)
    height: Height = 1.05

    def pieces(self) -> Sequence[Piece]:
        """Returns plinth, body and top."""
        (x, y), h = np.array(self.size) / 2, self.height
        return [
            block(
                (-0.9 * x, 0.05 - y, 0.9 * x, y - 0.05), (0.0, 0.08 * h), "dark"
            ),
            block(
                (-0.95 * x, 0.02 - y, 0.95 * x, y - 0.02),
                (0.08 * h, 0.96 * h),
                "white",
            ),
            block((-x, -y, x, y), (0.96 * h, h), "dark wood"),
        ]
