"""The social layer: what is near people, and on their way, costs more.

About each person there are Gaussians in the frame of walking: a wider one
ahead than behind, longer with speed, and one to the right. Who is slower than
0.1 m/s has a round one. Below a cutoff there is no cost, above it the floor of
the value. (nav2_social_costmap_plugin, `SocialLayer`.)
"""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import VX, VY, X, Y
from hunav_drake.systems.planning.costmap.costmap_config import SocialLayer
from hunav_drake.systems.planning.costmap.social_kernel import add_people
from hunav_drake.systems.world.maps.costs import Costs, Region


def social_parameters(config: SocialLayer) -> Array:
    """Returns the parameters of `add_people`, in its order."""
    factor = config.speed_factor_multiplier if config.use_vel_factor else 0.0
    return np.array(
        [
            config.amplitude,
            config.cutoff,
            config.covariance_when_still,
            config.covariance_front_height,
            config.covariance_front_width,
            config.covariance_rear_height,
            config.covariance_rear_width,
            config.covariance_right_height,
            config.covariance_right_width,
            factor,
            float(config.use_passing),
        ]
    )


def add_social_costs(
    costs: Costs, region: Region, humans: Array, parameters: Array
) -> None:
    """Writes the costs of people into a map, where they are higher.

    Args:
        costs: Shape (rows, columns), written in place; unknown cells stay.
        region: Where the map is.
        humans: Rows of `human_states`.
        parameters: See `social_parameters`.
    """
    if len(humans):
        people = np.ascontiguousarray(humans[:, [X, Y, VX, VY]])
        add_people(costs, *region.origin, region.resolution, people, parameters)
