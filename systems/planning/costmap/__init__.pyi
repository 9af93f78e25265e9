from .costmap_config import (
    GlobalCostmap as GlobalCostmap,
    LocalCostmap as LocalCostmap,
    ObstacleLayer as ObstacleLayer,
    SocialLayer as SocialLayer,
)
from .inflation import inflate as inflate, inflation_costs as inflation_costs
from .layers import Surroundings as Surroundings, make_costs as make_costs
from .social_layer import (
    add_social_costs as add_social_costs,
    social_parameters as social_parameters,
)
from .static_layer import (
    costmap_from_obstacles as costmap_from_obstacles,
    costmap_from_occupancy as costmap_from_occupancy,
    static_map as static_map,
    walls_on as walls_on,
)
