"""Furniture to sit or lie on."""

from collections.abc import Sequence

import numpy as np
from pydantic.dataclasses import dataclass

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


@register_furniture("chair")
@dataclass(kw_only=True, config=CONFIG)
class Chair(Furniture):
    """A chair; its back is on the side of -x."""

    size: Extents = (0.45, 0.45)
    height: Height = 0.85

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
