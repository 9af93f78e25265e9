"""Places that people go to, look at and use."""

from collections.abc import Sequence
from dataclasses import field, replace
import itertools
import math
from typing import Annotated, Literal, get_args

from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Name,
    Point,
    Pose,
    PositiveLength,
    fault,
    within,
)

PlaceType = Literal[
    "point",
    "counter",
    "seat",
    "bus_stop",
    "shelf",
    "door_button",
    "screen",
    "workplace",
    "bed",
    "door",
]
PLACE_TYPES: tuple[PlaceType, ...] = get_args(PlaceType)

# The time of each type, in seconds.
_SECONDS: dict[PlaceType, float] = {
    "point": 5.0,
    "counter": 5.0,
    "seat": 60.0,
    "bus_stop": 30.0,
    "shelf": 8.0,
    "door_button": 1.5,
    "screen": 20.0,
    "workplace": 600.0,
    "bed": 3600.0,
    "door": 5.0,
}

# The largest distance of a seat from where people sit down on it, in meters.
_REACH = 3.0

# The least distance of two slots, in meters.
_APART = 0.2

# The places before a screen without slots: how many, how far, in meters, and up
# to which angle on either side.
_SPOTS, _AWAY, _ASIDE = 5, 2.0, math.pi / 4


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Place:
    """A place that behavior trees know by its name or number."""

    name: Name = ""
    """Name of the place; by default "place_1", "place_2", ... in order."""

    id: Annotated[Integer, Field(ge=0, le=2**31 - 1)] | None = None
    """Number of the place, by which HuNavSim knows it; by default 1, 2, ... in
    order."""

    type: PlaceType = "point"
    """What it is: people queue at a "counter", sit on a "seat", wait at a
    "bus_stop", take things from a "shelf", press a "door_button", look at a
    "screen", sit and work at a "workplace", lie in a "bed", and let each other
    pass at a "door"."""

    pose: Pose
    """Where the first one stands and faces (x, y, yaw), in W, in meters and
    radians; of a screen, where it is and faces; of a door, its middle, and the
    way through it."""

    slots: list[Pose] = field(default_factory=list)
    """Where people use it (x, y, yaw), in W, in meters and radians; by default
    the pose, and five places 2 m before a screen."""

    approaches: list[Point] = field(default_factory=list)
    """For each slot of a seat or bed, where people stand before they sit down
    (x, y), in W, in meters; by default the slot itself."""

    spacing: PositiveLength = 0.9
    """Distance of people in a queue, in meters."""

    width: PositiveLength = 0.9
    """Free width of a door, in meters."""

    seconds: Annotated[StrictFloat, within(0, 86400, "s")] | None = None
    """Time for which people use it, in seconds; by default 5 s, on a seat 60 s,
    at a bus stop 30 s, a shelf 8 s, a button 1.5 s, a screen 20 s, a
    workplace 10 min and a bed 1 h."""

    def all_slots(self) -> list[tuple[float, float, float]]:
        """Returns the poses at which people use it, in W."""
        if self.slots:
            return [(x, y, yaw) for x, y, yaw in self.slots]
        x, y, yaw = self.pose
        if self.type != "screen":
            return [(x, y, yaw)]
        step = 2 * _ASIDE / (_SPOTS - 1)
        bearings = [yaw - _ASIDE + step * i for i in range(_SPOTS)]
        return [
            (x + _AWAY * math.cos(it), y + _AWAY * math.sin(it), it + math.pi)
            for it in bearings
        ]

    def __post_init__(self) -> None:
        for (i, a), (k, b) in itertools.combinations(enumerate(self.slots), 2):
            away = math.dist(a[:2], b[:2])
            # (But for rounding.)
            if away < _APART - 1e-9:
                raise fault(
                    f"slots[{k}]: must be at least {_APART:g} m from"
                    f" slots[{i}], got {away:.3g}: two people cannot use both;"
                    " move or remove one"
                )
        slots = len(self.slots) or 1
        if self.approaches and len(self.approaches) != slots:
            raise fault(
                f"approaches: must be {slots}, one for each slot, got"
                f" {len(self.approaches)}"
            )
        for k, (x, y) in enumerate(self.approaches):
            away = math.dist((x, y), self.all_slots()[k][:2])
            if away > _REACH:
                raise fault(
                    f"approaches[{k}]: must be within {_REACH:g} m of its slot,"
                    f" got {away:.3g}: people sit down from there"
                )

    def all_approaches(self) -> list[tuple[float, float]]:
        """Returns where people stand before they use each slot, in W."""
        if self.approaches:
            return [(x, y) for x, y in self.approaches]
        return [(x, y) for x, y, _ in self.all_slots()]

    def way_to(self) -> tuple[float, float]:
        """Returns where people walk to who only want to get there, in W."""
        if self.type == "screen":
            spots = self.all_slots()
            x, y, _ = spots[len(spots) // 2]
        elif self.type in ("seat", "workplace", "bed"):
            x, y = self.all_approaches()[0]
        else:
            x, y, _ = self.pose
        return x, y

    @property
    def time(self) -> float:
        """The time for which people use it, in seconds."""
        return _SECONDS[self.type] if self.seconds is None else self.seconds


def complete_places(places: Sequence[Place]) -> list[Place]:
    """Returns places with all names and numbers.

    Raises:
        ValueError: If two places have the same name or number, or one has
            another number as its name.
    """
    result = [
        replace(
            it, name=it.name or f"place_{i}", id=i if it.id is None else it.id
        )
        for i, it in enumerate(places, 1)
    ]
    for i, it in enumerate(result):
        if it.name.isdecimal() and it.name != str(it.id):
            raise ValueError(
                f"places[{i}] has the name {it.name!r} and the number {it.id},"
                " and trees name places by both; give it a name in words"
            )
    for what in ("name", "id"):
        taken: dict[object, int] = {}
        for i, it in enumerate(result):
            value = getattr(it, what)
            if value in taken:
                raise ValueError(
                    f"places[{taken[value]}] and places[{i}] have the same"
                    f" {what} {value!r}; give each its own"
                )
            taken[value] = i
    return result
