"""What it costs to sense: a scan, who is visible, an image. CPU time.

All figures are of one run on one machine.
"""

from collections.abc import Callable
import time

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.sensing import (
    AddCamera,
    CameraConfig,
    Lidar,
    LidarConfig,
    VisiblePeople,
)
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import World
from tests.benchmarks.bench_world import free_places
from tests.benchmarks.house import house, plan

PEOPLE = 20

# The most that a scan may cost, in ms, by the number of segments.
TARGETS = {42: 0.3, 2008: 1.0}


def cpu_ms(function: Callable[[int], object], repeats: int) -> float:
    """Returns the median CPU time of calls, in ms."""
    costs = []
    for i in range(repeats):
        started = time.process_time()
        function(i)
        costs.append(time.process_time() - started)
    return 1e3 * float(np.median(costs))


def rows(places: np.ndarray) -> np.ndarray:
    """Returns bodies at places (k, 2) that walk along x, shape (k, 7)."""
    result = np.zeros((len(places), STATE_SIZE))
    result[:, :2] = places
    result[:, 3] = 1.2
    result[:, 6] = 0.35
    return result


def sensing_ms(dut: Lidar | VisiblePeople, world: Obstacles) -> float:
    """Returns what a sensor costs at many places of a world, in ms."""
    context = dut.CreateDefaultContext()
    people = rows(free_places(world, PEOPLE, 1)).ravel()
    dut.get_human_states_input_port().FixValue(context, people)
    robots = rows(free_places(world, 200, 2))
    output = dut.get_output_port(0)

    def sense(i: int) -> None:
        # What the robot's place costs is not the sensor's.
        dut.get_robot_state_input_port().FixValue(context, robots[i])
        output.Eval(context)

    sense(0)
    return cpu_ms(sense, len(robots))


def image_ms(port: str, size: tuple[int, int]) -> float:
    """Returns what a new image of 20 people costs, in ms."""
    builder = DiagramBuilder()
    world = World()
    humans = [HumanConfig(pose=(0.0, 0.0, 0.0))] * PEOPLE
    scene = AddScene(builder, world, humans)
    camera = AddCamera(
        builder,
        CameraConfig(mount="world", image_size=size),
        scene.scene_graph,
        query_object=scene.query_object,
    )
    builder.ExportInput(scene.human_states, "human_states")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = camera.GetMyContextFromRoot(context)
    rng = np.random.default_rng(0)

    def render(i: int) -> None:
        places = rng.uniform((1, -6), (15, 6), (PEOPLE, 2))
        states = rows(places).ravel()
        diagram.GetInputPort("human_states").FixValue(context, states)
        camera.GetOutputPort(port).Eval(own)

    render(0)
    return cpu_ms(render, 10)


def main() -> None:
    """Prints the tables."""
    print("A scan of 360 rays with 20 people, in ms of CPU time")
    for world in (plan(), house(2000)):
        count = len(world.segments)
        for people in ("legs", "discs"):
            for noise in (0.0, 0.02):
                # (mypy takes the names of the loop for any text.)
                config = LidarConfig(
                    people=people,  # type: ignore[arg-type]
                    noise=noise,
                    range_max=20.0,
                )
                dut = Lidar(config, obstacles=world, num_humans=PEOPLE)
                cost = sensing_ms(dut, world)
                print(
                    f"{count:5} segments, {people:5}, noise {noise:4.2f}:"
                    f" {cost:6.3f} (at most {TARGETS[count]})",
                    flush=True,
                )

    print("\nWho of 20 people is visible, in ms of CPU time")
    for world in (plan(), house(2000)):
        finder = VisiblePeople(obstacles=world, num_humans=PEOPLE)
        cost = sensing_ms(finder, world)
        print(f"{len(world.segments):5} segments: {cost:6.3f}")

    print("\nAn image of 20 people, in ms of CPU time (at most 1000)")
    for port in ("color_image", "depth_image", "label_image"):
        for size in ((640, 480), (1280, 720)):
            print(
                f"{port:12} {size[0]} x {size[1]}: {image_ms(port, size):6.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
