"""Furniture: kinds of things with a footprint, a body and a height."""

from hunav_drake.systems.world.furniture.base import (
    FURNITURE,
    Furniture,
    register_furniture,
)
from hunav_drake.systems.world.furniture.seats import Bed, Bench, Chair, Sofa
from hunav_drake.systems.world.furniture.tables import Counter, Desk, Table
from hunav_drake.systems.world.furniture.upright import (
    DoorFrame,
    Pallet,
    Pillar,
    Plant,
    Shelf,
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
