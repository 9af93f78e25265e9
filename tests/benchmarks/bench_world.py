"""What a large world costs: a house with 2000 segments, as robots map it.

All figures are of one run on one machine: compare the ratios.
"""

import math
import time

import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.evaluation.curves import lines_blocked
from hunav_drake.systems.world.obstacles import Obstacles, inside, nearest_wall
from hunav_drake.systems.world.routes import RouteMap, _route_map
from hunav_drake.systems.world.shapes import Box, World
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


def boxes(count: int) -> tuple[Obstacles, float]:
    """Returns boxes in a square, 3 m from each other, and its side in m."""
    side = math.isqrt(count)
    rng = np.random.default_rng(0)
    walls = [
        Box(center=(3 * i, 3 * j), size=(1.2, 1.2), yaw=rng.uniform(0, 1.5))
        for i in range(side)
        for j in range(side)
    ]
    return World(walls=walls).obstacles(), 3.0 * (side - 1)


def goal_cost(count: int) -> float:
    """Returns the seconds that a new goal costs a person among boxes."""
    world, side = boxes(count)
    route = RouteMap.from_obstacles(world)
    goals = np.random.default_rng(1).uniform(1.5, side - 1.5, (400, 2))
    goals = goals[~inside(world, goals).any(axis=1)]
    # The first ones make known what is seen from the place of the person.
    half = len(goals) // 2
    for goal in goals[:half]:
        route.next_waypoint((1.5, 1.5), goal)
    started = time.process_time()
    for goal in goals[half:]:
        route.next_waypoint((1.5, 1.5), goal)
    return (time.process_time() - started) / (len(goals) - half)


def ways_of(people: int) -> tuple[float, float]:
    """Returns what it costs that people among 100 boxes have new goals.

    They are the seconds of the step in which all of them have, and of a step in
    which one has; most people do not see their goals.
    """
    world, side = boxes(100)
    route = RouteMap.from_obstacles(world)
    rng = np.random.default_rng(2)
    positions, goals = rng.uniform(0, side, (2, people, 2))
    command = np.zeros((people, COMMAND_SIZE))
    command[:, : Command.GOAL_Y + 1] = goals
    command[:, Command.HAS_GOAL] = 1
    seconds = []
    for _ in range(6):
        started = time.process_time()
        route.guide(positions, command)
        seconds.append(time.process_time() - started)
        command[0, Command.GOAL_X] += 0.01
    return seconds[0], min(seconds[1:])


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

    built, route = timed_map(large)
    goals = free_places(large, 50, 4)
    started = time.perf_counter()
    for goal in goals:
        route.next_waypoint((3.0, 2.5), goal)
    goal = (time.perf_counter() - started) / len(goals)
    print(
        f"\nThe map of ways: {len(large.segments)} segments,"
        f" {len(route.vertices)} vertices, built in {built:.2f} s;"
        f" {1e3 * goal:.1f} ms for each of the first 50 goals"
    )

    print(
        "\nGoals that nobody had before, from the corner of a square of boxes"
    )
    for count in (25, 100, 225, 400):
        print(f"{count:6} boxes: {1e6 * goal_cost(count):6.0f} us each")
    for people in (1500, 2500, 5000):
        first, next_one = ways_of(people)
        print(
            f"{people:6} people among 100 boxes, of whom one has a new goal:"
            f" {1e3 * next_one:.1f} ms (all: {1e3 * first:.0f} ms)"
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
