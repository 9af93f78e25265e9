"""Furniture along walls, in walls and in halls."""

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
    Load,
    Piece,
    block,
    register_furniture,
)
from hunav_drake.systems.world.solids import disc, rectangle


@register_furniture("shelf")
@dataclass(kw_only=True, config=CONFIG)
class Shelf(Furniture):
    """A shelf full of things; its closed back is on the side of -x."""

    size: Extents = (0.4, 1.6)
    height: Height = 1.8

    def pieces(self) -> Sequence[Piece]:
        """Returns sides, back, boards, and the things on them."""
        (x, y), h = np.array(self.size) / 2, self.height
        side = min(0.03, y / 4)
        back = 0.02 * self.size[0] - x
        result = [
            block((-x, -y, x, side - y), (0.0, h), "dark wood"),
            block((-x, y - side, x, y), (0.0, h), "dark wood"),
            block((-x, side - y, back, y - side), (0.0, h), "dark wood"),
        ]
        boards = max(2, round(h / 0.4))
        step = h / boards
        colors = ("card", "cushion", "white", "fabric", "card")
        for k in range(boards):
            low = k * step
            board = low + 0.03
            result.append(
                block((back, side - y, x, y - side), (low, board), "wood")
            )
            # Things of different widths, the same in all runs.
            count = max(1, round((self.size[1] - 2 * side) / 0.35))
            width = (self.size[1] - 2 * side) / count
            for i in range(count):
                left = side - y + i * width
                fill = 0.55 + 0.1 * ((3 * i + 5 * k) % 4)
                result.append(
                    block(
                        (
                            back,
                            left + 0.03 * width,
                            0.85 * x,
                            left + 0.95 * width,
                        ),
                        (board, board + fill * (step - 0.03)),
                        colors[(2 * i + 3 * k) % len(colors)],
                    )
                )
        return result


@register_furniture("plant")
@dataclass(kw_only=True, config=CONFIG)
class Plant(Furniture):
    """A plant in a pot."""

    size: Extents = (0.5, 0.5)
    height: Height = 1.3

    def outlines(self) -> Sequence[Array]:
        """Returns the outline of the leaves, an ellipse."""
        return [disc(0.0, 0.0, 0.5) * np.array(self.size)]

    def pieces(self) -> Sequence[Piece]:
        """Returns pot, stem and leaves."""
        whole, h = self.outlines()[0], self.height
        return [
            (0.62 * whole, 0.0, 0.28 * h, "pot"),
            (0.1 * whole, 0.28 * h, 0.5 * h, "dark wood"),
            (whole, 0.4 * h, h, "leaf"),
        ]


@register_furniture("pillar")
@dataclass(kw_only=True, config=CONFIG)
class Pillar(Furniture):
    """A pillar from floor to ceiling."""

    size: Extents = (0.4, 0.4)
    height: Height = 2.5

    round: StrictBool = False
    """Whether it is round (an ellipse, if the extents differ)."""

    def outlines(self) -> Sequence[Array]:
        """Returns the outline of its section."""
        if self.round:
            return [disc(0.0, 0.0, 0.5) * np.array(self.size)]
        return super().outlines()

    def pieces(self) -> Sequence[Piece]:
        """Returns the pillar."""
        return [(self.outlines()[0], 0.0, self.height, "stone")]


@register_furniture("door_frame")
@dataclass(kw_only=True, config=CONFIG)
class DoorFrame(Furniture):
    """The frame of an open door, which people walk through along its x.

    Its extents are the thickness of the wall and the whole width. The opening
    is the whole width minus the two jambs.
    """

    size: Extents = (0.24, 1.2)
    height: Height = 2.1

    jamb: Height = 0.08
    """Width of each jamb, in meters; at most a third of the whole."""

    def outlines(self) -> Sequence[Array]:
        """Returns the outlines of the jambs."""
        x, y = np.array(self.size) / 2
        jamb = min(self.jamb, self.size[1] / 3)
        return [rectangle(-x, -y, x, jamb - y), rectangle(-x, y - jamb, x, y)]

    def pieces(self) -> Sequence[Piece]:
        """Returns jambs and lintel."""
        (x, y), h = np.array(self.size) / 2, self.height
        under = h - min(self.jamb, 0.1 * h)
        return [
            *(
                (outline, 0.0, under, "dark wood")
                for outline in self.outlines()
            ),
            block((-x, -y, x, y), (under, h), "dark wood"),
        ]


@register_furniture("pallet")
@dataclass(kw_only=True, config=CONFIG)
class Pallet(Furniture):
    """A pallet, perhaps with a load. The height is that of the pallet."""

    size: Extents = (1.2, 0.8)
    height: Height = 0.144

    load: Load = 0.0
    """Height of the boxes on it above the pallet, in meters."""

    def pieces(self) -> Sequence[Piece]:
        """Returns runners, deck and boxes."""
        (x, y), h = np.array(self.size) / 2, self.height
        result = [
            block((-x, b - 0.12 * y, x, b + 0.12 * y), (0.0, 0.7 * h), "wood")
            for b in (-0.88 * y, 0.0, 0.88 * y)
        ]
        result.append(block((-x, -y, x, y), (0.7 * h, h), "wood"))
        if self.load > 0:
            gap = 0.01
            result += [
                block(
                    (a0 * x + gap, b0 * y + gap, a1 * x - gap, b1 * y - gap),
                    (h, h + part * self.load),
                    "card",
                )
                for a0, a1, b0, b1, part in (
                    (-0.95, 0.1, -0.95, 0.0, 1.0),
                    (-0.95, 0.1, 0.0, 0.95, 0.85),
                    (0.1, 0.95, -0.95, 0.95, 0.92),
                )
            ]
        return result
