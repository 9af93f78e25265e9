"""Pictures of costmaps: the color of each cost."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from hunav_drake.systems.world.maps.costs import (
    FREE,
    INSCRIBED,
    LETHAL,
    UNKNOWN,
    Costmap,
)

# Red, green, blue and alpha from 0 to 1: the range of graded costs, and the
# colors of the others. Free cells are transparent.
_LEAST, _MOST = (0.99, 0.86, 0.45, 0.35), (0.80, 0.22, 0.18, 0.70)
_INSCRIBED = (0.56, 0.09, 0.32, 0.75)
_LETHAL = (0.18, 0.05, 0.28, 0.85)
_UNKNOWN = (0.45, 0.47, 0.50, 0.50)


@cache
def cost_colors() -> NDArray[np.uint8]:
    """Returns the color of each cost.

    Free is transparent, graded costs are yellow to red, inscribed is purple,
    lethal near black, and unknown grey.

    Returns:
        Shape (256, 4), read-only: red, green, blue and alpha, 0 to 255.
    """
    share = np.linspace(0.0, 1.0, INSCRIBED)[:, None]
    colors = np.zeros((256, 4))
    colors[:INSCRIBED] = (1 - share) * _LEAST + share * _MOST
    colors[FREE] = 0.0
    colors[INSCRIBED] = _INSCRIBED
    colors[LETHAL] = _LETHAL
    colors[UNKNOWN] = _UNKNOWN
    result = (255 * colors).round().astype(np.uint8)
    result.setflags(write=False)
    return result


def costmap_picture(costmap: Costmap) -> Image.Image:
    """Returns a map as a picture with a pixel per cell, and +y up.

    Free cells at its edge have the color of unknown ones, which shows where
    the map ends.
    """
    costs = costmap.costs[::-1].copy()
    edge = np.ones(costs.shape, dtype=np.bool_)
    edge[1:-1, 1:-1] = False
    costs[edge & (costs == FREE)] = UNKNOWN
    picture = Image.fromarray(costs)
    picture.putpalette(cost_colors().tobytes(), "RGBA")
    return picture
