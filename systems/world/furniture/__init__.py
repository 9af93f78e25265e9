"""Furniture: kinds of things with a footprint, a body and a height."""

from hunav_drake.systems.world.furniture.base import (
    FURNITURE,
    Furniture,
    register_furniture,
)
from hunav_drake.systems.world.furniture.hung import Picture, Sign
from hunav_drake.systems.world.furniture.kinds import (
    Bed,
    Bench,
    Chair,
    Counter,
    Desk,
    DoorFrame,
    Pallet,
    Pillar,
    Plant,
    Shelf,
    Sofa,
    Table,
    Till,
)

__all__ = [
    "FURNITURE",
    "Bed",
    "Bench",
    "Chair",
    "Counter",
    "Desk",
    "DoorFrame",
    "Furniture",
    "Pallet",
    "Picture",
    "Pillar",
    "Plant",
    "Shelf",
    "Sign",
    "Sofa",
    "Table",
    "Till",
    "register_furniture",
]
