"""A house of rooms with doors and furniture, as a map from a robot has it."""

import numpy as np
import shapely
import shapely.affinity

from hunav_drake.systems.world.obstacles import Obstacles

# The extent of the house, in meters, and how many rooms it has each way.
SIZE = (30.0, 20.0)
ROOMS = (5, 4)
THICK = 0.2
DOOR = 1.0
PIXEL = 0.1


def lines() -> list[tuple[float, float, float, float]]:
    """Returns the walls as lines, with a door between any two rooms."""
    width, height = SIZE[0] / ROOMS[0], SIZE[1] / ROOMS[1]
    result = []
    for i in range(ROOMS[0] + 1):
        doors = ROOMS[1] * (0 < i < ROOMS[0])
        cuts = [0.0, SIZE[1]]
        cuts += [j * height + at for j in range(doors) for at in (1, 1 + DOOR)]
        pairs = np.sort(cuts).reshape(-1, 2)
        result += [(i * width, lo, i * width, hi) for lo, hi in pairs]
    for j in range(ROOMS[1] + 1):
        doors = ROOMS[0] * (0 < j < ROOMS[1])
        cuts = [0.0, SIZE[0]]
        cuts += [i * width + at for i in range(doors) for at in (2, 2 + DOOR)]
        pairs = np.sort(cuts).reshape(-1, 2)
        result += [(lo, j * height, hi, j * height) for lo, hi in pairs]
    return result


def furniture(rng: np.random.Generator) -> shapely.Polygon:
    """Returns a turned piece of furniture as the pixels it covers."""
    room = rng.integers(0, ROOMS)
    center = (room + rng.uniform(0.35, 0.65, 2)) * np.divide(SIZE, ROOMS)
    w, h = rng.uniform(0.5, 1.6, 2)
    angle = rng.uniform(0, 180)
    shape = shapely.affinity.rotate(
        shapely.box(-w / 2, -h / 2, w / 2, h / 2), angle
    )
    reach = np.arange(-1.5, 1.5, PIXEL)
    x, y = (grid.ravel() for grid in np.meshgrid(reach, reach))
    covered = shapely.contains_xy(shape, x + PIXEL / 2, y + PIXEL / 2)
    x, y = x[covered] + center[0], y[covered] + center[1]
    return shapely.union_all(shapely.box(x, y, x + PIXEL, y + PIXEL)).buffer(0)


def plan() -> Obstacles:
    """Returns the walls as lines: about 40 segments."""
    shapes = np.reshape(lines(), (-1, 2, 2))
    return Obstacles.from_shapes(list(shapes), solid=[False] * len(shapes))


def house(segments: int, seed: int = 0) -> Obstacles:
    """Returns the walls of a house, and furniture up to so many segments."""
    rng = np.random.default_rng(seed)
    walls = shapely.linestrings(np.reshape(lines(), (-1, 2, 2)))
    thick = shapely.union_all(
        shapely.buffer(walls, THICK / 2, cap_style="square")
    )
    # A wall may go around rooms: its outlines are lines.
    shapes = [
        shapely.get_coordinates(ring)
        for part in shapely.get_parts(thick)
        for ring in (part.exterior, *part.interiors)
    ]
    solid = [False] * len(shapes)
    count = sum(len(shape) - 1 for shape in shapes)
    while count < segments:
        piece = furniture(rng)
        if piece.geom_type == "Polygon":
            shapes.append(np.array(piece.exterior.coords)[:-1])
            solid.append(True)
            count += len(shapes[-1])
    return Obstacles.from_shapes(shapes, solid=solid)
