"""What a large world costs: a house with 2000 segments, as robots map it.

All figures are of one run on one machine: compare the ratios.
"""

import os
import tempfile
import time

import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.evaluation.curves import lines_blocked
from hunav_drake.systems.world.obstacles import Obstacles, inside, nearest_wall
from hunav_drake.systems.world.routes import RouteMap, _route_map
from tests.benchmarks.bench_crowd import TIME_STEP, best, simulate
from tests.benchmarks.house import SIZE, house, plan

PEOPLE = 20


def free_places(world: Obstacles, count: int, seed: int) -> np.ndarray:
    """Returns places with 0.4 m of room, shape (count, 2)."""
    p = np.random.default_rng(seed).uniform((0.5, 0.5), SIZE, (20 * count, 2))
    away = np.hypot(*(nearest_wall(world, p) - p).T)
    return p[(away > 0.4) & ~inside(world, p).any(axis=1)][:count]


def crowd_step(world: Obstacles, config: CrowdConfig) -> float:
    """Returns the seconds of a step of 20 people who walk somewhere."""
    starts = free_places(world, PEOPLE, 1)
    dut = HumanCrowd(
        [HumanConfig(pose=(x, y, 0.0)) for x, y in starts.tolist()],
        obstacles=world,
        config=config,
        num_robots=0,
        time_step=TIME_STEP,
    )
    context = dut.CreateDefaultContext()
    commands = np.zeros((PEOPLE, COMMAND_SIZE))
    commands[:, [Command.GOAL_X, Command.GOAL_Y]] = free_places(
        world, PEOPLE, 2
    )
    commands[:, Command.HAS_GOAL] = 1
    commands[:, [Command.DESIRED_SPEED, Command.MAX_SPEED]] = 1.2
    commands[:, Command.GROUP_ID] = -1
    dut.get_commands_input_port().FixValue(context, commands.ravel())
    return simulate(Simulator(dut, context), PEOPLE)


def rays_per_second(world: Obstacles) -> float:
    """Returns how many lines of sight of up to 10 m are checked in a second."""
    rng = np.random.default_rng(3)
    starts = rng.uniform((0, 0), SIZE, (2000, 2))
    lines = np.hstack([starts, starts + rng.uniform(-7, 7, (2000, 2))])
    return len(lines) / best(lambda: lines_blocked(lines, world.table))


def timed_map(world: Obstacles) -> tuple[float, RouteMap]:
    """Returns the seconds to get a map that this process does not have."""
    _route_map.cache_clear()
    started = time.perf_counter()
    result = RouteMap.from_obstacles(world)
    return time.perf_counter() - started, result


def main() -> None:
    """Prints the tables."""
    small, large = plan(), house(2000)
    RouteMap.from_obstacles(small).next_waypoint((0, 0), SIZE)

    print("A step of 20 people, in us; ratio to that with few segments")
    for name, config in (
        ("straight", CrowdConfig(route_planning=False)),
        ("with route planning", CrowdConfig()),
        ("orca", CrowdConfig(model="orca")),
    ):
        few, many = crowd_step(small, config), crowd_step(large, config)
        print(
            f"{name:20} {len(small.segments):5} segments: {1e6 * few:7.1f}"
            f" {len(large.segments):5} segments: {1e6 * many:7.1f}"
            f"   ratio {many / few:5.2f}",
            flush=True,
        )

    print("\nThe map of ways")
    with tempfile.TemporaryDirectory() as folder:
        before = os.environ.get("HUNAV_CACHE")
        os.environ["HUNAV_CACHE"] = folder
        built, route = timed_map(large)
        loaded, _ = timed_map(large)
        os.environ.pop("HUNAV_CACHE")
        if before is not None:
            os.environ["HUNAV_CACHE"] = before
    goals = free_places(large, 50, 4)
    started = time.perf_counter()
    for goal in goals:
        route.next_waypoint((3.0, 2.5), goal)
    goal = (time.perf_counter() - started) / len(goals)
    print(
        f"{len(large.segments)} segments, {len(route.vertices)} vertices,"
        f" {len(route.ways)} ways: built in {built:.2f} s,"
        f" loaded in {1e3 * loaded:.1f} ms, {1e3 * goal:.1f} ms for each goal"
    )

    print("\nLines of sight of up to 10 m, in millions per second")
    few, many = rays_per_second(small), rays_per_second(large)
    print(
        f"{len(small.segments)} segments: {few / 1e6:.2f},"
        f" {len(large.segments)} segments: {many / 1e6:.2f}"
    )

    started = time.perf_counter()
    field = large.distance_field(0.05, (0.0, 0.0, *SIZE))
    print(
        f"\nA distance field of {field.distances.size} places:"
        f" {time.perf_counter() - started:.2f} s"
    )


if __name__ == "__main__":
    main()
