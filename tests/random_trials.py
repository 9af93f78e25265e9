"""Random trials, and what must hold in all of them.

`python -m tests.random_trials 500` runs so many, and prints the worst of each;
with --worlds, those of `random_worlds`.
"""

import argparse
from collections.abc import Iterator
import json
import math
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, Diagram

from hunav_drake import LoadScenario, MakeTrialDiagram, RunTrial, Scenario
from hunav_drake.scenario import draw_people
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.world.obstacles import nearest_wall
from tests.random_worlds import draw_world

MODELS = ("social_force", "orca", "headed_social_force")
# How deep bodies may be in each other and in walls, in meters, to rounding.
DEEPEST = 0.01 + 1e-9

# Robots with bodies that are not round, about which people leave the robot's
# larger disc after their next step: what counts is how deep bodies are.
_NOT_ROUND = ("jackal", "turtlebot3_burger", "turtlebot3_waffle")

# Half the width of the body of the car in `tests/data`, in meters, between
# whose wheels a corner of furniture may be.
_CAR = 0.1
DURATION = 20.0
STEP = 0.05

# Rooms: the outer walls, and an inner wall with a door.
_WIDTH, _HEIGHT = 12.0, 9.0


class Worst(NamedTuple):
    """The worst of a trial.

    Attributes:
        overlap: Of two bodies, in meters.
        robot_overlap: Of a body and the robot, in meters.
        excess: Of a speed over the person's limit, as a part of it.
        in_wall: How deep a body, or the robot, is in a wall, in meters.
        finite: Whether all numbers are.
    """

    overlap: float
    robot_overlap: float
    excess: float
    in_wall: float
    finite: bool


def draw_trial(seed: int) -> dict[str, object]:
    """Returns a scenario of 2 to 30 people in two rooms, as plain data."""
    rng = np.random.default_rng([seed, 7])
    n = int(rng.integers(2, 31))
    door = float(rng.uniform(0.9, 2.4))
    middle = float(rng.uniform(2.5, _HEIGHT - 2.5))
    lines = [
        [[0, 0], [_WIDTH, 0]],
        [[_WIDTH, 0], [_WIDTH, _HEIGHT]],
        [[_WIDTH, _HEIGHT], [0, _HEIGHT]],
        [[0, _HEIGHT], [0, 0]],
        [[6, 0], [6, middle - door / 2]],
        [[6, middle + door / 2], [6, _HEIGHT]],
    ]
    walls = [{"type": "polyline", "points": line} for line in lines]
    places: list[np.ndarray] = [np.array([1.0, 1.0])]
    while len(places) < 2 * n + 2:
        place = rng.uniform([0.6, 0.6], [_WIDTH - 0.6, _HEIGHT - 0.6])
        starts = np.array(places[: n + 1])
        is_start = len(places) <= n
        if abs(place[0] - 6) < 0.6:
            continue
        if is_start and np.hypot(*(starts - place).T).min() < 0.9:
            continue
        places.append(place)
    humans = [
        {
            "pose": [*map(float, start), float(rng.uniform(-3, 3))],
            "goals": [[*map(float, goal)]],
            "behavior": str(rng.choice([*BEHAVIORS])),
            "desired_speed": float(rng.uniform(0.5, 1.6)),
            "radius": float(rng.uniform(0.2, 0.45)),
            "group_id": int(rng.choice([-1, -1, 1, 2])),
            "cyclic": bool(rng.random() < 0.3),
        }
        for start, goal in zip(
            places[1 : n + 1], places[n + 1 : -1], strict=True
        )
    ]
    return {
        "humans": humans,
        "robot": {
            "start": [*map(float, places[0]), 0.0],
            "goal": [*map(float, places[-1]), 0.0],
        },
        "world": {"walls": walls},
        "crowd": {"model": str(rng.choice(MODELS))},
        "evaluator": {"period": STEP, "metrics": ["duration"]},
        "simulation": {"duration": DURATION, "seed": seed, "stuck_time": 1e3},
    }


def run_trial(seed: int, planner: str = "pursuit") -> Worst:
    """Runs a random trial with a planner, and returns the worst of it."""
    data = {**draw_trial(seed), "planner": planner}
    return worst_of(LoadScenario(data=json.dumps(data)))


def run_world(seed: int) -> Worst:
    """Runs a trial of `random_worlds`, and returns the worst of it."""
    return worst_of(draw_world(seed))


def worst_of(scenario: Scenario) -> Worst:
    """Runs a trial, and returns the worst of it."""
    diagram = MakeTrialDiagram(scenario)
    sensed = [
        diagram.get_output_port(i)
        for i in range(diagram.num_output_ports())
        if scenario.sensors
    ]
    finite = True

    is_not_round = name_of(scenario.robot) in _NOT_ROUND
    depths = [-math.inf]

    def look(context: Context) -> bool:
        nonlocal finite
        if is_not_round:
            depths.extend(_depths(diagram, context))
        # As often as costs little.
        if context.get_time() % 2.0 < 0.04:
            for port in sensed:
                value = port.Eval(context)
                value = getattr(value, "data", value)
                if isinstance(value, np.ndarray):
                    finite &= not np.isnan(value).any()
        return True

    recording = RunTrial(
        scenario, diagram=diagram, watch=look, on_planner_error="raise"
    ).recording
    humans, robot = recording.humans, recording.robot
    people = draw_people(scenario)
    bodies = np.array([human.contact_radius for human in people])
    # Whoever threatens the robot overtakes it.
    limits = np.array(
        [
            max(human.speed_limit, 2.0 * (human.behavior == "threatening"))
            for human in people
        ]
    )
    places = humans[..., :2]
    pairs = np.triu_indices(len(bodies), 1)
    gaps = np.linalg.norm(
        places[:, pairs[0]] - places[:, pairs[1]], axis=-1
    ) - (bodies[pairs[0]] + bodies[pairs[1]])
    robot_gaps = np.linalg.norm(places - robot[:, None, :2], axis=-1) - (
        bodies + robot[:, None, 6]
    )
    if is_not_round:
        robot_gaps = -np.array(depths)
    speeds = np.linalg.norm(humans[..., 3:5], axis=-1) / limits
    walls = scenario.world.obstacles()
    robot_radii = robot[:, 6]
    if name_of(scenario.robot) == "urdf":
        robot_radii = np.minimum(robot_radii, _CAR)
    in_wall = max(
        float(
            np.max(
                radii - np.hypot(*(nearest_wall(walls, p) - p).T).T,
                initial=-math.inf,
            )
        )
        for p, radii in ((places, bodies), (robot[:, :2], robot_radii))
    )
    if (places < 0).any() or (places > [_WIDTH, _HEIGHT]).any():
        in_wall = math.inf
    return Worst(
        overlap=-float(np.min(gaps, initial=math.inf)),
        robot_overlap=-float(np.min(robot_gaps, initial=math.inf)),
        excess=float(np.max(speeds, initial=0.0) - 1),
        in_wall=in_wall,
        finite=bool(
            finite and np.isfinite(humans).all() and np.isfinite(robot).all()
        ),
    )


def _depths(diagram: Diagram, context: Context) -> Iterator[float]:
    """Yields how deep bodies of people and of the robot are in each other."""
    scene_graph = diagram.GetSubsystemByName("scene_graph")
    own = scene_graph.GetMyContextFromRoot(context)
    plant = diagram.GetSubsystemByName("plant")
    query = scene_graph.get_query_output_port().Eval(own)
    inspector = query.inspector()
    for pair in query.ComputePointPairPenetration():
        names = {
            plant.GetBodyFromFrameId(inspector.GetFrameId(it)).model_instance()
            for it in (pair.id_A, pair.id_B)
        }
        if plant.HasModelInstanceNamed("people") and (
            plant.GetModelInstanceByName("people") in names
        ):
            yield pair.depth


def main() -> None:
    """Runs random trials, and prints the worst of each, and of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--worlds", action="store_true")
    arguments = parser.parse_args()
    run = run_world if arguments.worlds else run_trial
    found = []
    for seed in range(arguments.first, arguments.first + arguments.count):
        try:
            found.append(run(seed))
        except Exception as error:
            print(seed, f"{type(error).__name__}: {error}", flush=True)
            found.append(Worst(*(4 * [math.inf]), finite=False))
            continue
        worst = found[-1]
        if not is_good(worst):
            print(seed, worst, flush=True)
    print(f"{sum(map(is_good, found))} of {len(found)} trials are good")
    print(
        Worst(
            max(it.overlap for it in found),
            max(it.robot_overlap for it in found),
            max(it.excess for it in found),
            max(it.in_wall for it in found),
            all(it.finite for it in found),
        )
    )


def is_good(worst: Worst) -> bool:
    """Tells whether all holds that must hold in a trial."""
    return (
        max(worst.overlap, worst.robot_overlap, worst.in_wall) <= DEEPEST
        and worst.excess <= 0.2
        and worst.finite
    )


if __name__ == "__main__":
    main()
