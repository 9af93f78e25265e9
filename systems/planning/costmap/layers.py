"""Costmaps made of layers, in any order."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.costmap.inflation import inflate
from hunav_drake.systems.planning.costmap.marks import Marks, moved
from hunav_drake.systems.planning.costmap.obstacle_layer import free_disc
from hunav_drake.systems.planning.costmap.raster import stamp_discs
from hunav_drake.systems.planning.costmap.social_layer import add_social_costs
from hunav_drake.systems.planning.costmap.static_layer import StaticMap
from hunav_drake.systems.world.maps.costs import FREE, LETHAL, Costs, Region

# Layers that mark walls.
_WALLS = ("static", "obstacle")

_ONLY_LETHAL = np.array([float(LETHAL)])


class Surroundings(NamedTuple):
    """The data that layers are made from, at one instant.

    `walls` are those of the world; `discs` (n, 3) the people to mark, (x, y,
    radius); `humans` the rows of those with social costs; `robot` the disc that
    stays free of marks, with a negative radius for none; `marks` those of a
    lidar, None for the ground truth. `graded` are `inflation_costs`, `social`
    are `social_parameters`.
    """

    walls: StaticMap
    discs: Array
    humans: Array
    robot: Array
    graded: Array
    social: Array
    marks: Marks | None = None


def make_costs(
    layers: Sequence[str], region: Region, around: Surroundings
) -> Costs:
    """Returns the costs of a region, made layer by layer.

    Each layer works on the result of the previous ones: "static" marks walls;
    "obstacle" marks walls and people, or the hits of a lidar; "inflation" adds
    costs near marked cells; "social" adds costs around people. Costs never
    decrease. "inflation" also counts walls just outside the region.
    """
    first = layers.index("inflation") if "inflation" in layers else -1
    before = layers[:first] if first > 0 else ()
    if around.marks is None and before and "social" not in before:
        # Equal to layer by layer: the inflation of walls is known, and that of
        # all obstacles is the maximum of their single ones.
        costs = around.walls.part(region, inflated=True)
        if "obstacle" in before:
            _stamp(costs, region, around, around.graded)
        rest = layers[first + 1 :]
    elif around.marks is None and layers and layers[0] in _WALLS:
        # The first layer of walls starts on an empty map.
        costs = around.walls.part(region, inflated=False)
        if layers[0] == "obstacle":
            _stamp(costs, region, around, _ONLY_LETHAL)
        rest = layers[1:]
    else:
        costs = np.full((region.rows, region.columns), FREE, dtype=np.uint8)
        rest = layers
    for layer in rest:
        if layer == "inflation":
            costs = inflate(costs, around.graded)
        elif layer == "social":
            add_social_costs(costs, region, around.humans, around.social)
        else:
            _mark(costs, region, around, people=layer == "obstacle")
    return costs


def _mark(
    costs: Costs, region: Region, around: Surroundings, *, people: bool
) -> None:
    """Marks walls, and people or the hits of a lidar."""
    if people and around.marks is not None:
        marks = moved(around.marks, region)
        if around.robot[2] >= 0:
            free_disc(marks, region, around.robot)
        np.maximum(costs, marks, out=costs)
        return
    np.maximum(costs, around.walls.part(region, inflated=False), out=costs)
    if people:
        _stamp(costs, region, around, _ONLY_LETHAL)


def _stamp(
    costs: Costs, region: Region, around: Surroundings, graded: Array
) -> None:
    if len(around.discs):
        stamp_discs(
            *(costs, *region.origin, region.resolution),
            *(around.discs, around.robot, graded),
        )
