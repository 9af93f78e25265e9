"""The kinds of furniture: seats and beds, tables, and upright things."""

from collections.abc import Sequence
from typing import ClassVar

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
    Spot,
    block,
    legs,
    register_furniture,
)
from hunav_drake.systems.world.solids import disc, rectangle

# How far people stand before a counter or shelf, in meters.
_BEFORE = 0.45


@register_furniture("chair")
@dataclass(kw_only=True, config=CONFIG)
class Chair(Furniture):
    """A chair; its back is on the side of -x."""

    size: Extents = (0.45, 0.45)
    height: Height = 0.85
    use: ClassVar[str] = "seat"

    def spots(self) -> Sequence[Spot]:
        """Returns the place of the one who sits on it."""
        return [(0.0, 0.0, 0.0)]

    def pieces(self) -> Sequence[Piece]:
        """Returns seat, legs and back."""
        x, y = np.array(self.size) / 2
        seat = 0.53 * self.height
        under = seat - 0.04
        return [
            block((-x, -y, x, y), (under, seat), "fabric"),
            block((-x, -y, -0.84 * x, y), (seat, self.height), "fabric"),
            *legs(self.size, under, "dark wood", 0.035),
        ]


@register_furniture("bench")
@dataclass(kw_only=True, config=CONFIG)
class Bench(Furniture):
    """A bench without a back."""

    size: Extents = (0.4, 1.5)
    height: Height = 0.45
    use: ClassVar[str] = "seat"

    def spots(self) -> Sequence[Spot]:
        """Returns the places of those who sit on it."""
        return self.along(0.0, 0.0, 0.6)

    def pieces(self) -> Sequence[Piece]:
        """Returns the seat and two supports."""
        (x, y), h = np.array(self.size) / 2, self.height
        seat = (0.85 * h, h)
        return [
            block((-x, -y, x, y), seat, "wood"),
            *(
                block(
                    (-0.8 * x, b * y - 0.03, 0.8 * x, b * y + 0.03),
                    (0.0, seat[0]),
                    "metal",
                )
                for b in (-0.8, 0.8)
            ),
        ]


@register_furniture("sofa")
@dataclass(kw_only=True, config=CONFIG)
class Sofa(Furniture):
    """A sofa; its back is on the side of -x."""

    size: Extents = (0.85, 1.9)
    height: Height = 0.8
    use: ClassVar[str] = "seat"

    def spots(self) -> Sequence[Spot]:
        """Returns the places of those who sit on it, between the arms."""
        # (The arms have the room of a third one.)
        return [
            (0.06 * self.size[0], 0.8 * y, yaw)
            for x, y, yaw in self.along(0.0, 0.0, 0.75)
        ]

    def pieces(self) -> Sequence[Piece]:
        """Returns base, cushions, back and arms."""
        (x, y), h = np.array(self.size) / 2, self.height
        arm = min(0.16, 0.3 * y)
        inner = y - arm
        cushions = [
            block(
                (-0.5 * x, low, 0.96 * x, high), (0.3 * h, 0.53 * h), "cushion"
            )
            for low, high in ((-inner, -0.01), (0.01, inner))
        ]
        return [
            block((-x, -y, x, y), (0.06, 0.3 * h), "fabric"),
            block((-x, -y, -0.5 * x, y), (0.3 * h, h), "fabric"),
            block((-0.5 * x, -y, x, -inner), (0.3 * h, 0.72 * h), "fabric"),
            block((-0.5 * x, inner, x, y), (0.3 * h, 0.72 * h), "fabric"),
            *cushions,
        ]


@register_furniture("bed")
@dataclass(kw_only=True, config=CONFIG)
class Bed(Furniture):
    """A bed; its head is on the side of -x. The height is the headboard's."""

    size: Extents = (2.05, 1.0)
    height: Height = 0.9
    use: ClassVar[str] = "bed"

    def spots(self) -> Sequence[Spot]:
        """Returns the place of the hips of the one who lies in it."""
        return [(-0.05 * self.size[0], 0.0, 0.0)]

    def pieces(self) -> Sequence[Piece]:
        """Returns frame, mattress, blanket, pillow, headboard and legs."""
        (x, y), h = np.array(self.size) / 2, self.height
        low, top = 0.28 * h, 0.56 * h
        head = 0.06 - x
        return [
            block((-x, -y, x, y), (0.15 * h, low), "wood"),
            block((-x, -y, head, y), (low, h), "wood"),
            block((head, -0.96 * y, 0.98 * x, 0.96 * y), (low, top), "white"),
            block(
                (-0.35 * x, -0.98 * y, x, 0.98 * y),
                (low, 1.05 * top),
                "cushion",
            ),
            block(
                (head + 0.08, -0.7 * y, -0.5 * x, 0.7 * y),
                (top, 1.16 * top),
                "white",
            ),
            *legs(self.size, 0.15 * h, "dark wood", 0.07),
        ]


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
    use: ClassVar[str] = "counter"

    def spots(self) -> Sequence[Spot]:
        """Returns where the first of the queue stands, on the side of +x."""
        return [(self.size[0] / 2 + _BEFORE, 0.0, np.pi)]

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


@register_furniture("till")
@dataclass(kw_only=True, config=CONFIG)
class Till(Counter):
    """A till: a counter with a belt, and a register with a screen."""

    height: Height = 0.95

    def pieces(self) -> Sequence[Piece]:
        """Returns the counter, its belt, and the register."""
        (x, y), h = np.array(self.size) / 2, self.height
        return [
            *super().pieces(),
            block(
                (-0.5 * x, -0.95 * y, 0.9 * x, 0.2 * y), (h, h + 0.02), "dark"
            ),
            *(
                block((-0.2 * x, b * y, 0.6 * x, (b + 0.2) * y), (h, h + z), it)
                for b, z, it in (
                    (-0.85, 0.16, "red"),
                    (-0.55, 0.24, "card"),
                    (-0.25, 0.12, "yellow"),
                )
            ),
            block(
                (-0.6 * x, 0.4 * y, 0.4 * x, 0.9 * y), (h, h + 0.12), "metal"
            ),
            block((-0.2 * x, 0.6 * y, 0.0, 0.7 * y), (h, h + 0.3), "dark"),
            block(
                (-0.1 * x, 0.35 * y, 0.1 * x, 0.95 * y),
                (h + 0.2, h + 0.42),
                "dark",
            ),
        ]


@register_furniture("shelf")
@dataclass(kw_only=True, config=CONFIG)
class Shelf(Furniture):
    """A shelf full of things; its closed back is on the side of -x."""

    size: Extents = (0.4, 1.6)
    height: Height = 1.8
    use: ClassVar[str] = "shelf"

    def spots(self) -> Sequence[Spot]:
        """Returns where people take things from it, on the side of +x."""
        return self.along(self.size[0] / 2 + _BEFORE, np.pi, 0.8)

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
