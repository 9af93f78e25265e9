"""The colors of people, robot and world."""

from dataclasses import dataclass

from pydrake.geometry import Rgba

from hunav_drake.systems.people.figure_config import (
    ADULT_AGE,
    GRAY,
    FigureConfig,
    Hair,
)


@dataclass(frozen=True)
class Clothes:
    """The colors of a person; `top`, the shirt's, distinguishes people."""

    top: Rgba
    trousers: Rgba
    shoes: Rgba
    skin: Rgba
    hair: Rgba


# First Okabe and Ito's colors, which color-blind people can distinguish ("Color
# universal design", 2008); vermilion is the robot's. Then muted colors, each
# the farthest in CIELAB from all previous ones, from the robot, the skin and
# the floor: any two of the 24 are more than 25 apart (CIE76).
TOPS = (
    Rgba(0.000, 0.447, 0.698),
    Rgba(0.902, 0.624, 0.000),
    Rgba(0.000, 0.620, 0.451),
    Rgba(0.800, 0.475, 0.655),
    Rgba(0.941, 0.894, 0.259),
    Rgba(0.337, 0.706, 0.914),
    Rgba(0.435, 0.060, 0.060),
    Rgba(0.660, 0.960, 0.585),
    Rgba(0.285, 0.135, 0.510),
    Rgba(0.960, 0.435, 0.435),
    Rgba(0.060, 0.360, 0.360),
    Rgba(0.660, 0.585, 0.960),
    Rgba(0.360, 0.510, 0.060),
    Rgba(0.585, 0.060, 0.435),
    Rgba(0.435, 0.960, 0.960),
    Rgba(0.585, 0.435, 0.135),
    Rgba(0.285, 0.210, 0.285),
    Rgba(0.960, 0.810, 0.435),
    Rgba(0.660, 0.060, 0.285),
    Rgba(0.585, 0.660, 0.435),
    Rgba(0.210, 0.960, 0.735),
    Rgba(0.585, 0.360, 0.285),
    Rgba(0.960, 0.810, 0.960),
    Rgba(0.210, 0.210, 0.060),
)
ROBOT_ACCENT = Rgba(0.835, 0.369, 0.000)

# The accents of several robots, one after the other. Strong colors, far in
# CIELAB from each other, from the floor and from the first shirts.
ROBOT_ACCENTS = (
    ROBOT_ACCENT,
    Rgba(0.10, 0.10, 0.95),
    Rgba(0.95, 0.05, 0.60),
    Rgba(0.00, 0.68, 0.10),
    Rgba(0.66, 0.38, 1.00),
    Rgba(0.40, 0.46, 0.00),
    Rgba(0.00, 0.64, 0.70),
    Rgba(0.58, 0.05, 0.28),
    Rgba(0.85, 0.65, 0.00),
    Rgba(0.36, 0.22, 0.10),
)
ROBOT_SHELL = Rgba(0.93, 0.94, 0.95)
ROBOT_DARK = Rgba(0.13, 0.14, 0.16)

_TROUSERS = (
    Rgba(0.16, 0.19, 0.27),
    Rgba(0.42, 0.37, 0.30),
    Rgba(0.24, 0.25, 0.26),
    Rgba(0.27, 0.36, 0.47),
    Rgba(0.33, 0.25, 0.21),
)
_SKIN = (
    Rgba(0.91, 0.73, 0.60),
    Rgba(0.55, 0.38, 0.28),
    Rgba(0.80, 0.60, 0.46),
    Rgba(0.37, 0.25, 0.19),
)
_HAIR = (
    Rgba(0.23, 0.15, 0.10),
    Rgba(0.09, 0.08, 0.08),
    Rgba(0.50, 0.36, 0.20),
    Rgba(0.07, 0.06, 0.06),
    Rgba(0.55, 0.54, 0.53),
    Rgba(0.12, 0.09, 0.07),
    Rgba(0.35, 0.18, 0.09),
)
_GRAY_HAIR = Rgba(0.74, 0.73, 0.72)

# The hair of people, in their order.
HAIR_STYLES: tuple[Hair, ...] = ("short", "long", "short", "short", "bun")
EYES = Rgba(0.08, 0.07, 0.07)
TELEPHONE = Rgba(0.07, 0.07, 0.08)
TELEPHONE_SCREEN = Rgba(0.72, 0.86, 0.98)
_SHOES = Rgba(0.10, 0.10, 0.11)
CUP = Rgba(0.93, 0.92, 0.89)
BAG = Rgba(0.36, 0.25, 0.17)
BACKPACK = Rgba(0.20, 0.23, 0.22)
BASKET = Rgba(0.76, 0.16, 0.13)
WHEELCHAIR, WHEELS = Rgba(0.19, 0.21, 0.25), Rgba(0.45, 0.47, 0.49)

FLOOR = (Rgba(0.83, 0.82, 0.79), Rgba(0.77, 0.76, 0.73))
WALL = Rgba(0.60, 0.65, 0.71)
WALL_CUT = Rgba(0.38, 0.43, 0.50)

# The colors of materials.
MATERIALS = {
    "wall": WALL,
    "stone": Rgba(0.66, 0.66, 0.65),
    "wood": Rgba(0.72, 0.58, 0.43),
    "dark wood": Rgba(0.45, 0.35, 0.27),
    "white": Rgba(0.90, 0.90, 0.88),
    "dark": Rgba(0.24, 0.25, 0.28),
    "metal": Rgba(0.52, 0.54, 0.56),
    "fabric": Rgba(0.45, 0.50, 0.55),
    "cushion": Rgba(0.62, 0.66, 0.66),
    "card": Rgba(0.76, 0.66, 0.52),
    "pot": Rgba(0.60, 0.46, 0.38),
    "leaf": Rgba(0.42, 0.54, 0.38),
    # Of signs, pictures and goods.
    "navy": Rgba(0.10, 0.18, 0.38),
    "blue": Rgba(0.16, 0.34, 0.62),
    "light blue": Rgba(0.60, 0.77, 0.90),
    "green": Rgba(0.33, 0.58, 0.30),
    "yellow": Rgba(0.95, 0.80, 0.25),
    "red": Rgba(0.78, 0.22, 0.18),
}
BODY_DISC = Rgba(0.1, 0.1, 0.12, 0.18)

# People who react to the robot, the robot's plan, and its lidar's hits.
REACTION = Rgba(0.86, 0.08, 0.24)
# People who follow a recording.
RECORDED = Rgba(0.10, 0.45, 0.85)
PLAN = Rgba(0.46, 0.16, 0.56)
SCAN = Rgba(0.85, 0.10, 0.10)

# The boundaries of the intimate, personal and social space.
PROXEMIC_RINGS = (
    Rgba(0.80, 0.15, 0.15, 0.55),
    Rgba(0.90, 0.55, 0.10, 0.50),
    Rgba(0.20, 0.45, 0.70, 0.45),
)

# The forces to the goal, from people, and from walls.
FORCE_ARROWS = (
    Rgba(0.10, 0.55, 0.20),
    Rgba(0.15, 0.30, 0.80),
    Rgba(0.55, 0.30, 0.10),
)


def accent(index: int) -> Rgba:
    """Returns the color of the robot at an index, from 0."""
    return ROBOT_ACCENTS[index % len(ROBOT_ACCENTS)]


def top_of(index: int) -> Rgba:
    """Returns the color of the top of the person at an index, from 0."""
    return TOPS[index % len(TOPS)]


def clothes(index: int, figure: FigureConfig | None = None) -> Clothes:
    """Returns the clothes of the person at an index, from 0.

    The cycles have different lengths, so that people with the same shirt
    differ in something else.
    """
    age = ADULT_AGE if figure is None else figure.age
    # (Of children, hair is neither gray nor dyed.)
    hair = _HAIR if age >= ADULT_AGE else _HAIR[:4]
    return Clothes(
        top=top_of(index),
        trousers=_TROUSERS[index % len(_TROUSERS)],
        shoes=_SHOES,
        skin=_SKIN[index % len(_SKIN)],
        hair=_GRAY_HAIR if age >= GRAY else hair[index % len(hair)],
    )
