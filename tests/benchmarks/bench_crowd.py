"""What a step of a crowd costs, by the number of people and by the way.

All figures are of one run on one machine: compare the ratios. The crowd has
0.3 people per square meter, who walk in all directions at up to 1.4 m/s.
"""

from collections.abc import Callable
import math
import time

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake import AddHumans, AgentServices, HumanConfig
from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import (
    MOTION_MODELS,
    CrowdConfig,
    HumanCrowd,
    Snapshot,
    SocialForceModel,
)
from hunav_drake.systems.world.shapes import Box, World
from tests.systems.crowd.crowds import make_snapshot, random_states

PEOPLE = (5, 20, 50, 100, 200, 500, 1000, 2000, 10000)
DENSITY = 0.3
TIME_STEP = 0.05
# Slower ways are not tried with more people than this.
NUMPY_MOST = 2000

# The least ratios of the reference to the fast kernel to aim at.
TARGETS = {5: 1, 20: 3, 100: 8, 200: 10, 1000: 20}


def walking_states(n: int, density: float = DENSITY) -> np.ndarray:
    """Returns people at random places, shape (n, 6)."""
    states: np.ndarray = random_states(n, density=density, slowest=0.5)
    return states


def walking_snapshot(n: int, density: float = DENSITY) -> Snapshot:
    """Returns a crowd that wants to go straight on."""
    states = walking_states(n, density)
    snapshot: Snapshot = make_snapshot(
        states,
        states[:, :2] + 50 * states[:, 3:5],
        speed=1.4,
        radius=0.35,
        time_step=TIME_STEP,
    )
    # As HumanCrowd has it, once for all steps.
    return snapshot._replace(eased=snapshot.at_walls)


def best(function: Callable[[], object], *, least: float = 0.15) -> float:
    """Returns the seconds of the fastest of a few calls."""
    function()
    started = time.perf_counter()
    function()
    once = time.perf_counter() - started
    repeats = max(1, int(least / 5 / max(once, 1e-7)))
    fastest = once
    for _ in range(5 if once < 1 else 1):
        started = time.perf_counter()
        for _ in range(repeats):
            function()
        fastest = min(fastest, (time.perf_counter() - started) / repeats)
    return fastest


def kernel_step(snapshot: Snapshot, kernel: str) -> float:
    """Returns the seconds of a step of forces and motion."""
    # The names are literals only where this is called.
    model = SocialForceModel(kernel=kernel)  # type: ignore[arg-type]
    return best(lambda: model.advance(snapshot, model.forces(snapshot)))


def model_step(snapshot: Snapshot, name: str) -> float:
    """Returns the seconds of a step of a motion model."""
    model = MOTION_MODELS.make(name)
    return best(lambda: model.advance(snapshot, model.forces(snapshot)))


def print_models() -> None:
    """Prints what a step of each motion model costs."""
    names = ["social_force", *sorted(set(MOTION_MODELS) - {"social_force"})]
    print("\nus per person and step (in times social_force)")
    print("people  " + " ".join(f"{name:>22}" for name in names))
    for n in (5, 20, 100, 1000):
        snapshot = walking_snapshot(n)
        us = [1e6 * model_step(snapshot, name) / n for name in names]
        print(
            f"{n:6}  " + " ".join(f"{t:13.2f} ({t / us[0]:6.2f})" for t in us),
            flush=True,
        )


def drake_step(snapshot: Snapshot, config: CrowdConfig | None = None) -> float:
    """Returns the seconds of a step of a HumanCrowd with given commands."""
    n = len(snapshot.states)
    humans = [HumanConfig(pose=(0, 0, 0))] * n
    crowd = HumanCrowd(humans, config=config, num_robots=0, time_step=TIME_STEP)
    context = crowd.CreateDefaultContext()
    context.SetDiscreteState(0, snapshot.states.ravel())
    crowd.get_commands_input_port().FixValue(context, snapshot.command.ravel())
    return simulate(Simulator(crowd, context), n)


def simulate(simulator: Simulator, n: int) -> float:
    """Returns the seconds of a step, of enough of them."""
    steps = max(3, min(2000, int(20000 / n)))
    simulator.AdvanceTo(TIME_STEP)
    fastest = math.inf
    for _ in range(3):
        begin = simulator.get_context().get_time()
        started = time.perf_counter()
        simulator.AdvanceTo(begin + steps * TIME_STEP)
        fastest = min(fastest, (time.perf_counter() - started) / steps)
    return fastest


def walls_step(boxes: int, people: int = 100) -> tuple[float, dict[str, float]]:
    """Returns what walls cost a crowd of people who walk among boxes.

    Args:
        boxes: How many there are, a square number, 3 m from each other.
        people: How many walk from somewhere to somewhere among them.

    Returns:
        The seconds to find the ways between the boxes, and those of a step
        without and with route planning.
    """
    side = math.isqrt(boxes)
    rng = np.random.default_rng(0)
    places = [(3.0 * i, 3.0 * j) for i in range(side) for j in range(side)]
    world = World(
        walls=[
            Box(center=place, size=(1.2, 1.2), yaw=rng.uniform(0, 1.5))
            for place in places
        ]
    ).obstacles()
    # People start, and have goals, in the middle between four boxes.
    starts, goals = 1.5 + 3.0 * rng.integers(0, side - 1, (2, people, 2))
    costs = {}
    built = math.nan
    for name, planned in (("without", False), ("with", True)):
        started = time.perf_counter()
        dut = HumanCrowd(
            [HumanConfig(pose=(x, y, 0.0)) for x, y in starts],
            obstacles=world,
            config=CrowdConfig(route_planning=planned),
            num_robots=0,
            time_step=TIME_STEP,
        )
        built = time.perf_counter() - started
        context = dut.CreateDefaultContext()
        commands = np.zeros((people, COMMAND_SIZE))
        commands[:, [Command.GOAL_X, Command.GOAL_Y]] = goals
        commands[:, Command.HAS_GOAL] = 1
        commands[:, [Command.DESIRED_SPEED, Command.MAX_SPEED]] = 1.2
        commands[:, Command.GROUP_ID] = -1
        dut.get_commands_input_port().FixValue(context, commands.ravel())
        costs[name] = simulate(Simulator(dut, context), people)
    return built, costs


def services_step(people: int = 200) -> dict[str, float]:
    """Returns the seconds of a step of everybody by `AgentServices`."""
    humans = [
        HumanConfig(pose=(x, y, 0.0), goals=[(x + 50 * vx, y + 50 * vy)])
        for x, y, vx, vy in walking_states(people)[:, [0, 1, 3, 4]].tolist()
    ]
    services = AgentServices(humans, num_robots=0)
    states = services.agents.states

    def one_by_one() -> None:
        for agent_id in range(1, people + 1):
            services.move_agent(states, None, agent_id)

    return {
        "compute_agents": best(lambda: services.compute_agents(states)),
        "move_agent for each": best(one_by_one),
    }


def make_diagram(n: int, config: CrowdConfig | None = None) -> Simulator:
    """Returns people with their trees, and a robot that stands still."""
    states = walking_states(n)
    humans = [
        HumanConfig(pose=(x, y, 0.0), goals=[(x + 50 * vx, y + 50 * vy)])
        for x, y, vx, vy in states[:, [0, 1, 3, 4]].tolist()
    ]
    builder = DiagramBuilder()
    ports = AddHumans(builder, humans, config=config, time_step=TIME_STEP)
    robot = builder.AddSystem(ConstantVectorSource([0, 0, 0, 0, 0, 0, 0.3]))
    builder.Connect(robot.get_output_port(), ports.robot_states)
    return Simulator(builder.Build())


def main() -> None:
    """Prints the tables."""
    print("us per person and step; ratio = reference / fast; growth of fast")
    print(
        "people      fast reference     NumPy     Drake   ratio (aim)  growth"
    )
    last: tuple[int, float] | None = None
    for n in PEOPLE:
        snapshot = walking_snapshot(n)
        fast = kernel_step(snapshot, "fast")
        reference = kernel_step(snapshot, "reference")
        plain = kernel_step(snapshot, "numpy") if n <= NUMPY_MOST else math.nan
        drake = drake_step(snapshot)
        growth = (
            math.log(fast / last[1]) / math.log(n / last[0])
            if last
            else math.nan
        )
        last = n, fast
        us = [1e6 * t / n for t in (fast, reference, plain, drake)]
        aim = f"({TARGETS[n]})" if n in TARGETS else ""
        print(
            f"{n:6} "
            + " ".join(f"{t:9.3f}" for t in us)
            + f" {reference / fast:7.1f} {aim:>5} {growth:7.2f}",
            flush=True,
        )

    print_models()

    costs = {}
    for n in (2000, 20000):
        costs[n] = kernel_step(walking_snapshot(n), "fast")
    growth = math.log10(costs[20000] / costs[2000])
    print(
        f"\nFrom 2000 to 20000 people: {1e3 * costs[2000]:.1f} to"
        f" {1e3 * costs[20000]:.1f} ms per step, as N^{growth:.2f}"
    )

    print("\nThe whole diagram with behavior trees, at steps of 0.05 s")
    for n in (5, 50, 100, 1000):
        cost = simulate(make_diagram(n), n)
        print(
            f"{n:6} people: {1e3 * cost:8.2f} ms per step,"
            f" {TIME_STEP / cost:6.1f} times faster than real time",
            flush=True,
        )

    print("\n100 people among boxes, with or without route planning")
    for boxes in (100, 400):
        built, costs = walls_step(boxes)
        print(
            f"{boxes:6} boxes: {1e3 * costs['without']:6.2f} or"
            f" {1e3 * costs['with']:6.2f} ms per step, {built:.1f} s to build",
            flush=True,
        )

    print("\n200 people by AgentServices")
    for name, cost in services_step().items():
        print(f"{name}: {1e3 * cost:.2f} ms per step of everybody", flush=True)


if __name__ == "__main__":
    main()
