"""What a map of map_server costs as a world, made as a robot makes it."""

from collections.abc import Callable
from importlib import resources
from pathlib import Path
import tempfile
import time

import numpy as np
from PIL import Image
import shapely
import yaml

from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator
from hunav_drake.scenario import Scenario
from hunav_drake.scenario.population import draw_people
from tests import recorded
from tests.benchmarks.house import SIZE, house

RESOLUTION = 0.05
PEOPLE = 12
DURATION = 60.0


def write_house(folder: Path, segments: int) -> Path:
    """Writes a house with furniture as a map, and a scenario with people."""
    obstacles = house(segments)
    columns, rows = (round((it + 1) / RESOLUTION) for it in SIZE)
    grid = np.zeros((rows, columns), dtype=bool)
    x = (np.arange(columns) + 0.5) * RESOLUTION - 0.5
    y = (np.arange(rows) + 0.5) * RESOLUTION - 0.5
    xs, ys = np.meshgrid(x, y)
    for k, solid in enumerate(obstacles.solid):
        lo, hi = obstacles.first[k : k + 2]
        ring = obstacles.segments[lo:hi, :2]
        if solid:
            grid |= shapely.contains_xy(shapely.Polygon(ring), xs, ys)
        else:
            # The outlines of walls: those inside others are rooms.
            grid ^= shapely.contains_xy(shapely.Polygon(ring), xs, ys)
    write_map(folder, "house", grid, -0.5)
    rectangle = [0.5, 0.5, SIZE[0] - 0.5, SIZE[1] - 0.5]
    return write_scenario(folder, "house.yaml", rectangle)


def write_map(folder: Path, name: str, grid: np.ndarray, least: float) -> None:
    """Writes occupied cells as a map whose least x and y are `least`."""
    image = np.where(grid, 0, 254).astype(np.uint8)[::-1]
    Image.fromarray(image).save(folder / f"{name}.pgm")
    settings = {
        "image": f"{name}.pgm",
        "resolution": RESOLUTION,
        "origin": [least, least, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.25,
    }
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(settings))


def write_scenario(folder: Path, map_file: str, rectangle: list[float]) -> Path:
    """Writes a trial of people who walk everywhere on a map."""
    everywhere = {"rectangle": rectangle}
    cohort = {
        "number": PEOPLE,
        "start": [everywhere],
        "goals": [everywhere] * 4,
        "cyclic": True,
    }
    scenario = {
        "world": {"map": map_file},
        "population": {"cohorts": [cohort]},
        "robot": {"start": [-20.0, 0.0, 0.0]},
        "simulation": {"duration": DURATION},
    }
    (folder / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    return folder / "scenario.yaml"


def large_map(folder: Path, noise: int) -> Path:
    """Writes a map of 2000 x 2000 cells, 100 rooms, and so much noise."""
    rng = np.random.default_rng(0)
    size, room = 2000, 200
    grid = np.zeros((size, size), dtype=bool)
    for k in range(0, size + 1, room):
        grid[max(k - 2, 0) : k + 2] = True
        grid[:, max(k - 2, 0) : k + 2] = True
    y, x = np.mgrid[0:room, 0:room]
    for j, i in np.ndindex(size // room, size // room):
        row, column = j * room, i * room
        if j:
            grid[row - 2 : row + 2, column + 60 : column + 84] = False
        if i:
            grid[row + 60 : row + 84, column - 2 : column + 2] = False
        for _ in range(6):
            u, v = rng.uniform(30, 170, 2)
            w, h = rng.uniform(5, 18, 2)
            turn = rng.uniform(0, 3)
            c, s = np.cos(turn), np.sin(turn)
            along, aside = (x - u) * c + (y - v) * s, (y - v) * c - (x - u) * s
            grid[row : row + room, column : column + room] |= (
                abs(along) < w
            ) & (abs(aside) < h)
    grid[tuple(rng.integers(0, size, (2, noise)))] = True
    write_map(folder, "large", grid, 0.0)
    return write_scenario(folder, "large.yaml", [0.5, 0.5, 99.5, 99.5])


def small_house(folder: Path) -> Path | None:
    """Writes a trial in the house of HuNavSim, if its map is there."""
    map_file = recorded.FULL / "hunav" / "small_house.yaml"
    if not map_file.exists():
        return None
    rectangle = [-8.8, -4.95, 9.3, 4.85]
    return write_scenario(folder, str(map_file.resolve()), rectangle)


def furnished_house() -> Scenario:
    """Returns a trial of 12 people in the rooms of the scenario `house`."""
    everywhere = {"rectangle": [0.5, 0.5, 18.5, 10.7]}
    cohort = {
        "number": PEOPLE,
        "start": [everywhere],
        "goals": [everywhere] * 4,
        "cyclic": True,
    }
    house_file = resources.files("hunav_drake.scenarios") / "house.yaml"
    scenario = {
        "world": yaml.safe_load(house_file.read_text())["world"],
        "population": {"cohorts": [cohort]},
        "robot": {
            "start": [1.2, 5.2, 0],
            "goal": [1.25, 5.2, 0],
            "goal_tolerance": 1e-6,
        },
        "simulation": {"duration": DURATION, "stuck_time": 1e4},
    }
    return LoadScenario(data=yaml.safe_dump(scenario))


def main() -> None:
    """Prints the times, of the processor: one thread does all."""
    # What is compiled or read once does not count. A small room to compare:
    cafe = 0.0
    for _ in range(3):
        diagram = MakeTrialDiagram(LoadScenario(filename="cafe"))
        started = time.process_time()
        MakeTrialSimulator(diagram).AdvanceTo(DURATION)
        cafe = max(cafe, DURATION / (time.process_time() - started))
    print(f"cafe, 5 people: {cafe:.0f} times faster than real time")
    rooms = furnished_house()
    diagram = MakeTrialDiagram(rooms)
    simulator = MakeTrialSimulator(diagram)
    simulator.Initialize()
    started = time.process_time()
    simulator.AdvanceTo(DURATION)
    fast = DURATION / (time.process_time() - started)
    print(
        f"house, {PEOPLE} people: {fast:.0f} times faster than real time,"
        f" {fast / cafe:.2f} of cafe"
    )
    worlds: list[tuple[str, Callable[[Path], Path | None]]] = [
        ("house, 1500", lambda folder: write_house(folder, 1500)),
        ("house, 8000", lambda folder: write_house(folder, 8000)),
        ("small_house", small_house),
        ("2000 x 2000 cells", lambda folder: large_map(folder, 0)),
        ("the same with noise", lambda folder: large_map(folder, 7000)),
    ]
    for name, write in worlds:
        with tempfile.TemporaryDirectory() as folder:
            file = write(Path(folder))
            if file is None:
                print(f"{name}: no map, as HUNAV_REFERENCE names no folder")
                continue
            started = time.process_time()
            scenario = LoadScenario(filename=file)
            checked = time.process_time()
            diagram = MakeTrialDiagram(scenario)
            built = time.process_time()
            simulator = MakeTrialSimulator(diagram)
            simulator.AdvanceTo(DURATION)
            ran = time.process_time()
            people = len(draw_people(scenario))
            fast = DURATION / (ran - built)
            print(
                f"{name}: {len(scenario.world.obstacles().segments)} segments,"
                f" {len(scenario.world.obstacles())} polygons: checked in"
                f" {checked - started:.2f} s, built in"
                f" {built - checked:.2f} s; {people} people run"
                f" {fast:.0f} times faster than real time, {fast / cafe:.2f}"
                " of cafe"
            )


if __name__ == "__main__":
    main()
