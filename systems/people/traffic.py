"""The sources and sinks of people who have been drawn.

All people who may come are known beforehand: each source has a fixed number
of them, who come in turn. So vectors keep their size, and a trial its one
Context. People outside have rows of `layout.OUTSIDE`.
"""

from collections.abc import Sequence
import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask

# The largest distance of the others of a group from the first, in meters.
_GROUP_REACH = 3.0


class Source(NamedTuple):
    """A place where people come in.

    Attributes:
        name: Its name.
        rate: The mean number of parties, people or groups, that come per
            second.
        stream: The first stream number of its draws.
        parties: The rows of the people of each party. They come in turn.
        places: The places where people may come in, shape (k, 2), in W, in
            meters; clear of walls.
        spacing: The free gap around people who come in, in meters.
    """

    name: str
    rate: float
    stream: int
    parties: tuple[tuple[int, ...], ...]
    places: Array
    spacing: float


class Sink(NamedTuple):
    """A place where people leave.

    Attributes:
        name: Its name.
        vertices: The corners of its area in W, shape (k, 2), in meters; one
            for a point.
        radius: The distance from it at which people are gone, in meters.
        rate: The largest number of people who leave per second.
    """

    name: str
    vertices: Array
    radius: float
    rate: float = math.inf


class Traffic(NamedTuple):
    """The sources and sinks of people.

    Attributes:
        sources: The sources.
        sinks: The sinks.
        sink_of: The sink at which each person leaves, shape (n,); -1 for
            people who stay.
        exits: The last goal of each, in the sink, shape (n, 2), in meters.
    """

    sources: tuple[Source, ...]
    sinks: tuple[Sink, ...]
    sink_of: NDArray[np.int64]
    exits: Array

    def after(self, count: int) -> Self:
        """Returns the same, with `count` people before who stay."""
        return self._replace(
            sources=tuple(
                source._replace(
                    parties=tuple(
                        tuple(count + row for row in party)
                        for party in source.parties
                    )
                )
                for source in self.sources
            ),
            sink_of=np.concatenate([np.full(count, -1), self.sink_of]),
            exits=np.vstack([np.zeros((count, 2)), self.exits]),
        )

    def pool(self) -> list[int]:
        """Returns the rows of all people of sources."""
        return [
            row
            for source in self.sources
            for party in source.parties
            for row in party
        ]


def place_party(
    places: Array, free: Mask, bodies: Sequence[float], spacing: float
) -> Array | None:
    """Returns the places (m, 2) where a party comes in, or None.

    The first person comes in at the first of the places (k, 2) with room for
    all; the others near that one. `free` (m, k) says where each of them could
    stand, `bodies` are the radii of their bodies, and `spacing` is the least
    gap between two of them, in meters.
    """
    if len(bodies) == 1:
        first = np.flatnonzero(free[0])
        return places[first[:1]] if first.size else None
    for anchor in np.flatnonzero(free[0]):
        taken = [int(anchor)]
        away = np.hypot(*(places - places[anchor]).T)
        near = np.argsort(away, kind="stable")
        for m in range(1, len(bodies)):
            fits = free[m] & (away <= _GROUP_REACH)
            for other, place in enumerate(taken):
                apart = np.hypot(*(places - places[place]).T)
                fits &= apart >= bodies[m] + bodies[other] + spacing
            found = near[fits[near]]
            if not found.size:
                break
            taken.append(int(found[0]))
        else:
            return places[taken]
    return None
