"""Places that people go to, look at and use."""

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import CONFIG, Integer, Name, Pose


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Place:
    """A place that behavior trees know by its name or number."""

    name: Name = ""
    """Name of the place; by default "place_1", "place_2", ... in order."""

    id: Annotated[Integer, Field(ge=0, le=2**31 - 1)] | None = None
    """Number of the place, by which HuNavSim knows it; by default 1, 2, ... in
    order."""

    pose: Pose
    """Where people stand there and face (x, y, yaw), in W, in meters and
    radians."""


def complete_places(places: Sequence[Place]) -> list[Place]:
    """Returns places with all names and numbers.

    Raises:
        ValueError: If two places have the same name or number.
    """
    result = [
        Place(
            name=it.name or f"place_{i}",
            id=i if it.id is None else it.id,
            pose=it.pose,
        )
        for i, it in enumerate(places, 1)
    ]
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
