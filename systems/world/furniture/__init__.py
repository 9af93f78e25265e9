"""Furniture: kinds of things with a footprint, a body and a height."""

from hunav_drake.systems.world.furniture.base import (
    FURNITURE,
    Furniture,
    register_furniture,
)
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
    "Pillar",
    "Plant",
    "Shelf",
    "Sofa",
    "Table",
    "register_furniture",
]
