from .distance_field import DistanceField as DistanceField
from .obstacles import Obstacles as Obstacles
from .routes import RouteMap as RouteMap
from .shapes import (
    Box as Box,
    Disc as Disc,
    Polygon as Polygon,
    Polyline as Polyline,
    Wall as Wall,
    World as World,
)
