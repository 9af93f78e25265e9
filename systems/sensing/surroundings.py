"""What of the world a sensor meets, by its height."""

from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World


def obstacles_at(world: World, height: float) -> Obstacles:
    """Returns what a horizontal plane meets, at a height in meters.

    A world that does not know heights meets it with all that it has.
    """
    cut = getattr(world, "obstacles_at", None)
    result: Obstacles = world.obstacles() if cut is None else cut(height)
    return result


def sight_obstacles(world: World) -> Obstacles:
    """Returns what hides people: walls and what is as high as their eyes.

    In a world that does not know heights that is all that it has.
    """
    high = getattr(world, "sight_obstacles", None)
    result: Obstacles = world.obstacles() if high is None else high()
    return result
