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


def walls() -> list[shapely.Polygon]:
    """Returns the walls, with a door between any two neighboring rooms."""
    width, height = SIZE[0] / ROOMS[0], SIZE[1] / ROOMS[1]
    pieces = []
    for i in range(ROOMS[0] + 1):
        for y in height * np.arange(ROOMS[1]):
            x = i * width
            door = y + 1.0, y + 1.0 + DOOR * (0 < i < ROOMS[0])
            for lo, hi in ((y, door[0]), (door[1], y + height)):
                pieces.append(shapely.box(x, lo, x + THICK, hi))
    for j in range(ROOMS[1] + 1):
        for x in width * np.arange(ROOMS[0]):
            y = j * height
            door = x + 2.0, x + 2.0 + DOOR * (0 < j < ROOMS[1])
            for lo, hi in ((x, door[0]), (door[1], x + width + THICK)):
                pieces.append(shapely.box(lo, y, hi, y + THICK))
    return list(shapely.get_parts(shapely.union_all(pieces)))


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


def coarse(pieces: int = 10, seed: int = 0) -> Obstacles:
    """Returns the same extent with few boxes, of four segments each."""
    rng = np.random.default_rng(seed)
    low = rng.uniform((1, 1), np.subtract(SIZE, 4), (pieces, 2))
    high = low + rng.uniform(0.2, 3.0, (pieces, 2))
    boxes = shapely.box(*low.T, *high.T)
    return Obstacles.from_shapes(
        [shapely.get_coordinates(box)[:-1] for box in boxes],
        solid=[True] * pieces,
    )


def house(segments: int, seed: int = 0) -> Obstacles:
    """Returns the walls of a house, and furniture up to so many segments."""
    rng = np.random.default_rng(seed)
    shapes = [
        np.array(ring.coords)[:-1]
        for part in walls()
        for ring in (part.exterior, *part.interiors)
    ]
    solid = [False] * len(shapes)
    shapes = [np.vstack([ring, ring[:1]]) for ring in shapes]
    count = sum(len(shape) - 1 for shape in shapes)
    while count < segments:
        piece = furniture(rng)
        if piece.geom_type == "Polygon":
            shapes.append(np.array(piece.exterior.coords)[:-1])
            solid.append(True)
            count += len(shapes[-1])
    return Obstacles.from_shapes(shapes, solid=solid)
