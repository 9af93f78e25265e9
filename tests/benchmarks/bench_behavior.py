"""How long behavior trees take: `python tests/benchmarks/bench_behavior.py`.

Prints how long a thousand people take to build, beside one parse of their
tree; microseconds of the compiled call that ticks the trees of n people, all
regular and of six behaviors, and of a tree with a leaf in Python; the time of
people in a diagram with a system for each tree, and with one for all; and how
many times faster than real time a whole trial with curious people is.
"""

import dataclasses
import math
import time

import numpy as np
from pydrake.systems.analysis import Simulator

from hunav_drake import MakeHumans
from hunav_drake.systems.behavior import (
    BehaviorTree,
    LoadTree,
    ParseTree,
    register_condition,
)
from hunav_drake.systems.common.layout import RADIUS, STATE_SIZE
from hunav_drake.systems.people import HumanConfig

SIX = ("regular", "impassive", "surprised", "scared", "curious", "threatening")

# Ten nodes, all of which are ticked.
TEN_NODES = (
    "<root><BehaviorTree><Sequence>"
    + "<AlwaysSuccess/>" * 9
    + "</Sequence></BehaviorTree></root>"
)


@register_condition("IsSlow")
def is_slow(context):
    return context.state[3] < 0.5


def crowd(n, behaviors):
    """Returns n people with goals in a square, of 0.25 persons/m^2."""
    generator = np.random.default_rng(1)
    side = 2 * np.sqrt(n)
    return [
        HumanConfig(
            pose=(*generator.uniform(0, side, 2), 0.0),
            goals=generator.uniform(0, side, (3, 2)),
            behavior=behaviors[i % len(behaviors)],
            cyclic=True,
        )
        for i in range(n)
    ]


def us_per_call(n, trees):
    """Returns the time of one call for n people, with a robot among them."""
    humans = crowd(n, ("regular",))
    system = BehaviorTree([trees[i % len(trees)] for i in range(n)], humans)
    states = np.zeros((n, STATE_SIZE))
    states[:, :3] = [human.pose for human in humans]
    states[:, 3] = 1.0
    states[:, -1] = 0.35
    states = states.ravel()
    middle = np.sqrt(n)
    robot = np.array([middle, middle, 0.3, 0.5, 0.1, 0.0, 0.35])
    context = system.CreateDefaultContext()
    memory = context.get_discrete_state(0).value().copy()
    walk = system._walk
    for _ in range(40):
        memory = walk.tick(memory, states, robot)[walk.memory].copy()
    best, number = np.inf, max(20, 4000 // n)
    for _ in range(7):
        start = time.process_time()
        for _ in range(number):
            walk.tick(memory, states, robot)
        best = min(best, (time.process_time() - start) / number)
    return 1e6 * best


def us_per_step(n, behaviors, separate_trees):
    """Returns the time of a step of people without robots."""
    diagram = MakeHumans(
        crowd(n, behaviors), num_robots=0, separate_trees=separate_trees
    )
    simulator = Simulator(diagram)
    simulator.Initialize()
    best, steps = np.inf, 200
    for i in range(1, 6):
        start = time.process_time()
        simulator.AdvanceTo(i * steps * 0.05)
        best = min(best, time.process_time() - start)
    return 1e6 * best / steps


def real_time_factor(n):
    """Returns how fast a whole trial with n curious people is."""
    from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator

    scenario = LoadScenario(filename="crossing")
    humans = [
        HumanConfig(
            pose=(-5.0 + i % 10, -9.0 + 3.5 * (i // 10), 0.0),
            goals=[(4.0, -9.0 + 3.5 * (i // 10)), (-4.0, 0.0)],
            cyclic=True,
            radius=0.3,
            behavior="curious",
        )
        for i in range(n)
    ]
    scenario = dataclasses.replace(
        scenario,
        humans=humans,
        robot=dataclasses.replace(
            scenario.robot, goal_tolerance=1e-6, goal_yaw_tolerance=1e-6
        ),
        simulation=dataclasses.replace(scenario.simulation, stuck_time=1e4),
    )
    best = np.inf
    for _ in range(3):
        simulator = MakeTrialSimulator(MakeTrialDiagram(scenario))
        simulator.Initialize()
        start = time.perf_counter()
        simulator.AdvanceTo(60.0)
        best = min(best, time.perf_counter() - start)
    return 60.0 / best


def build_and_parse(n):
    """Returns how long it takes to build n curious people, and one parse."""
    from hunav_drake.systems.behavior.library import _parse

    humans = crowd(n, ("curious",))
    build = parse = np.inf
    for _ in range(5):
        _parse.cache_clear()
        start = time.perf_counter()
        LoadTree("curious")
        parsed = time.perf_counter()
        _parse.cache_clear()
        MakeHumans(humans)
        parse = min(parse, parsed - start)
        build = min(build, time.perf_counter() - parsed)
    return build, parse


def us_near_goals(n):
    """Returns the time of a person's tick in a crowd near its goals.

    A tenth of the people stand; all are within the distance of their goals at
    which others who stand there might bar the way: 0.4 m times the square root
    of their number.
    """
    rng = np.random.default_rng(0)
    states = np.zeros((n, STATE_SIZE))
    states[:, :2] = rng.uniform(0, math.sqrt(n / 0.3), (n, 2))
    states[:, 3] = rng.uniform(0, 1, n)
    states[:, RADIUS] = 0.35
    shift = rng.uniform(-0.2, 0.2, (n, 2)) * math.sqrt(n)
    humans = [
        HumanConfig(pose=(x, y, 0.0), goals=[(x + dx, y + dy)])
        for (x, y), (dx, dy) in zip(
            states[:, :2].tolist(), shift.tolist(), strict=True
        )
    ]
    trees = BehaviorTree([LoadTree("regular")] * n, humans, num_robots=0)
    context = trees.CreateDefaultContext()
    port = trees.get_human_states_input_port()
    best = math.inf
    for _ in range(5):
        port.FixValue(context, states.ravel())
        start = time.process_time()
        trees.get_commands_output_port().Eval(context)
        best = min(best, time.process_time() - start)
    return best / n * 1e6


def main():
    print("us per person and tick in a crowd that stands and walks near goals")
    for n in (200, 2000, 5000):
        print(f"{n:6} people: {us_near_goals(n):.1f}")
    build, parse = build_and_parse(1000)
    print(
        f"building 1000 curious people: {build:.2f} s, {build / parse:.0f}"
        f" times a parse of their tree ({1e3 * parse:.1f} ms)"
    )
    own = (
        "<root><BehaviorTree><Fallback><Sequence><IsSlow/><RegularNav/>"
        "</Sequence><RegularNav/></Fallback></BehaviorTree></root>"
    )
    trees = {
        "ten nodes": [ParseTree(TEN_NODES)],
        "regular": [LoadTree("regular")],
        "six behaviors": [LoadTree(name) for name in SIX],
        "a leaf in Python": [ParseTree(own)],
    }
    print("us of the call that ticks the trees of all people")
    for name, several in trees.items():
        for n in (1, 5, 20, 200):
            cost = us_per_call(n, several)
            print(f"  {name:16s} n = {n:3d} {cost:8.2f}, {cost / n:6.2f} each")
    print("us per step of people: a system for each tree, one for all")
    for behaviors in (("regular",), SIX):
        for n in (5, 20, 50):
            separate, one = (
                us_per_step(n, behaviors, x) for x in (True, False)
            )
            print(
                f"  {len(behaviors)} behaviors, n = {n:2d} {separate:6.0f}"
                f" {one:6.0f}"
            )
    print("times real time of a whole trial with curious people")
    for n in (5, 50):
        print(f"  n = {n:2d} {real_time_factor(n):6.0f}")


if __name__ == "__main__":
    main()
