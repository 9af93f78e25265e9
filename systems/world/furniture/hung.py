"""Furniture that hangs on walls or from ceilings."""

from collections.abc import Sequence
import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, StrictStr
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import CONFIG
from hunav_drake.systems.world.furniture.base import (
    Extents,
    Furniture,
    Height,
    Piece,
    Spot,
    block,
    register_furniture,
)
from hunav_drake.systems.world.solids import Lettering

# One walks under what begins at this height or above, in meters.
_OVERHEAD = 1.8

# The part of a board that its text may fill, across and upwards.
_FILLED = (0.9, 0.84)

# Where people look at a picture: how far in front, and at which angles.
_AWAY, _ANGLES = 2.0, tuple(k * math.pi / 8 for k in range(-2, 3))

Motif = Literal["landscape", "sea", "flowers", "portrait", "street", "blocks"]

# What pictures show, as patches of color: from left to right, from the bottom
# up, in parts of the canvas, and the material.
_PATCHES: dict[Motif, list[tuple[float, float, float, float, str]]] = {
    "landscape": [
        (0.0, 1.0, 0.4, 1.0, "light blue"),
        (0.0, 1.0, 0.0, 0.4, "green"),
        (0.22, 0.28, 0.3, 0.55, "dark wood"),
        (0.12, 0.38, 0.5, 0.8, "green"),
        (0.7, 0.85, 0.7, 0.9, "yellow"),
    ],
    "sea": [
        (0.0, 1.0, 0.45, 1.0, "light blue"),
        (0.0, 1.0, 0.0, 0.45, "blue"),
        (0.4, 0.7, 0.4, 0.5, "dark wood"),
        (0.5, 0.6, 0.5, 0.8, "white"),
    ],
    "flowers": [
        (0.0, 1.0, 0.0, 1.0, "light blue"),
        (0.36, 0.64, 0.06, 0.36, "pot"),
        (0.28, 0.72, 0.36, 0.56, "green"),
        (0.2, 0.42, 0.54, 0.86, "yellow"),
        (0.44, 0.6, 0.6, 0.94, "yellow"),
        (0.62, 0.8, 0.5, 0.8, "red"),
    ],
    "portrait": [
        (0.0, 1.0, 0.0, 1.0, "dark wood"),
        (0.22, 0.78, 0.0, 0.42, "red"),
        (0.36, 0.64, 0.42, 0.78, "card"),
        (0.34, 0.66, 0.72, 0.86, "dark"),
    ],
    "street": [
        (0.0, 1.0, 0.0, 0.25, "dark"),
        (0.0, 1.0, 0.25, 1.0, "light blue"),
        (0.04, 0.34, 0.25, 0.85, "red"),
        (0.36, 0.62, 0.25, 0.65, "yellow"),
        (0.64, 0.96, 0.25, 0.92, "card"),
    ],
    "blocks": [
        (0.0, 1.0, 0.0, 1.0, "dark"),
        (0.02, 0.3, 0.02, 0.3, "blue"),
        (0.33, 0.98, 0.33, 0.98, "red"),
        (0.02, 0.3, 0.33, 0.98, "white"),
        (0.33, 0.76, 0.02, 0.3, "white"),
        (0.79, 0.98, 0.02, 0.3, "yellow"),
    ],
}


@explain
@dataclass(kw_only=True, config=CONFIG)
class _Board(Furniture):
    """A board whose two sides face along +x and -x."""

    size: Extents = (0.06, 1.6)

    tall: Height = 0.4
    """Height of the board itself, in meters; `height` is that of its top."""

    def outlines(self) -> Sequence[Array]:
        """Returns its outline, and none if one walks under it."""
        # (But for rounding.)
        overhead = self.low >= _OVERHEAD - 1e-9
        return [] if overhead else super().outlines()

    @property
    def low(self) -> float:
        """The height of its lower edge, in meters."""
        return max(self.height - self.tall, 0.0)


@register_furniture("sign")
@dataclass(kw_only=True, config=CONFIG)
class Sign(_Board):
    """A sign with a text, which hangs on a wall or from the ceiling."""

    height: Height = 2.6

    text: Annotated[StrictStr, Field(max_length=1000)] = ""
    """What it says, in one line or several, in the letters of the font DejaVu
    Sans (Latin, Greek, Cyrillic, Arabic, ...); boxes stand for others."""

    def pieces(self) -> Sequence[Piece]:
        """Returns the board."""
        x, y = np.array(self.size) / 2
        return [block((-x, -y, x, y), (self.low, self.height), "navy")]

    def letters(self) -> Sequence[Lettering]:
        """Returns its text, on both sides."""
        if not self.text.strip():
            return []
        x, y = self.center
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        away = self.size[0] / 2
        room = _FILLED[0] * self.size[1], _FILLED[1] * (self.height - self.low)
        return [
            Lettering(
                text=self.text,
                pose=(x + side * away * c, y + side * away * s, yaw),
                middle=(self.low + self.height) / 2,
                size=room,
            )
            for side, yaw in ((1, self.yaw), (-1, self.yaw + math.pi))
        ]


@register_furniture("picture")
@dataclass(kw_only=True, config=CONFIG)
class Picture(_Board):
    """A framed picture on a wall; people look at it from the side of +x."""

    size: Extents = (0.06, 1.4)
    height: Height = 2.0
    tall: Height = 1.05

    motif: Motif = "landscape"
    """What it shows."""

    use: ClassVar[str] = "screen"

    def spots(self) -> Sequence[Spot]:
        """Returns where people look at it: five places, 2 m before it."""
        return [
            (_AWAY * math.cos(it), _AWAY * math.sin(it), it + math.pi)
            for it in _ANGLES
        ]

    def pieces(self) -> Sequence[Piece]:
        """Returns frame and canvas, painted on both sides."""
        (x, y), low = np.array(self.size) / 2, self.low
        edge = min(0.06, 0.3 * y, 0.15 * (self.height - low))
        wide, tall = 2 * (y - edge), self.height - low - 2 * edge
        bottom, top = low + edge, self.height - edge
        frame = (
            (-y, edge - y, low, self.height),
            (y - edge, y, low, self.height),
            (edge - y, y - edge, low, bottom),
            (edge - y, y - edge, top, self.height),
        )
        result = [
            block((-x, a, x, b), (under, over), "dark wood")
            for a, b, under, over in frame
        ]
        for k, (left, right, under, over, material) in enumerate(
            _PATCHES[self.motif]
        ):
            # (Seen from +x, left is at -y. Each lies over those before, so far
            # that viewers tell them apart.)
            depth = x * (0.2 + 0.13 * k)
            sides = (edge - y + left * wide, edge - y + right * wide)
            result.append(
                block(
                    (-depth, sides[0], depth, sides[1]),
                    (bottom + under * tall, bottom + over * tall),
                    material,
                )
            )
        return result
