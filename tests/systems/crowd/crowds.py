"""Crowds for tests of motion models, and what they do."""

import dataclasses

import numpy as np

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd import Snapshot
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import Box

NO_WALLS = Obstacles.from_shapes([], solid=[])


# People without bodies: points that do at once all that forces ask for, as in
# HuNavSim.
BODILESS = {
    "keep_apart": False,
    "standing": False,
    "max_acceleration": None,
    "max_turn_rate": None,
}

# And who do not follow others, nor walk around robots, nor leave a group.
FREE = {
    **BODILESS,
    "model": {"type": "social_force", "time_gap": 0.0},
    "robot_gap": 0.0,
    "groups_part": False,
}


def box_between(x0, y0, x1, y1):
    """A box between two corners."""
    return Box(
        center=((x0 + x1) / 2, (y0 + y1) / 2), size=(abs(x1 - x0), abs(y1 - y0))
    )


def make_snapshot(
    states,
    goals,
    *,
    speed=1.2,
    max_speed=None,
    radius=0.3,
    parameters=None,
    robots=(),
    role=RobotRole.PEDESTRIAN,
    walls=NO_WALLS,
    time_step=0.05,
):
    """Returns a snapshot of people with rows (x, y, yaw, vx, vy, omega)."""
    states = np.array(states, dtype=float).reshape(-1, 6)
    n = len(states)
    command = np.zeros((n, COMMAND_SIZE))
    command[:, :2] = np.reshape(goals, (n, 2))
    command[:, Command.GOAL_RADIUS] = 0.3
    command[:, Command.HAS_GOAL] = 1
    command[:, Command.DESIRED_SPEED] = speed
    command[:, Command.MAX_SPEED] = speed if max_speed is None else max_speed
    command[:, Command.ROBOT_ROLE] = role
    command[:, Command.GROUP_ID] = -1
    if parameters is None:
        weights = dataclasses.astuple(SocialForceParameters())
        parameters = np.tile(weights, (n, 1))
    return Snapshot(
        states=states,
        radii=np.full(n, float(radius)),
        command=command,
        parameters=parameters,
        robots=np.array(robots, dtype=float).reshape(-1, 7),
        obstacles=walls,
        obstacle_range=5.0,
        max_obstacles=0,
        time_step=time_step,
    )


def random_snapshot(
    rng, n, m, *, walls, spread=2.0, epsilon=None, most=0, same=False
):
    """Returns a snapshot of n people in all moods, and m robots.

    Args:
        rng: The random generator.
        n: The number of people.
        m: The number of robots.
        walls: The obstacles.
        spread: The deviation of their distances from the origin, in meters.
        epsilon: Of the social force; drawn for each, by default.
        most: The largest number of obstacles that exert forces; 0 is all.
        same: Whether people all have the same weights.
    """
    command = np.zeros((n, COMMAND_SIZE))
    command[:, :2] = rng.uniform(-6, 6, (n, 2))
    command[:, Command.GOAL_RADIUS] = 0.3
    command[:, Command.HAS_GOAL] = rng.random(n) < 0.8
    command[:, Command.DESIRED_SPEED] = rng.uniform(0, 2, n)
    command[:, Command.MAX_SPEED] = rng.choice([0.0, 0.3, 9.0], n)
    command[:, Command.ROBOT_ROLE] = rng.choice(RobotRole, n)
    command[:, Command.ROBOT_REPULSION] = rng.choice([0.0, 2.0], n)
    command[:, Command.HOLD] = rng.random(n) < 0.2
    command[:, Command.TURN_RATE] = rng.choice([0.0, 0.3, 50.0], n)
    command[:, Command.YAW_TARGET] = rng.uniform(-3, 3, n)
    command[:, Command.GROUP_ID] = rng.integers(-1, max(2, n // 3), n)
    choices = [0.0, 0.005, -0.1] if epsilon is None else [epsilon]
    rows = [
        dataclasses.astuple(
            SocialForceParameters(
                social_factor=float(rng.uniform(1, 6)),
                gamma=float(rng.uniform(0.2, 0.5)),
                epsilon=float(rng.choice(choices)),
                obstacle_sigma=float(rng.uniform(0.1, 0.5)),
            )
        )
        for _ in range(n)
    ]
    parameters = np.array(rows).reshape(n, 13)
    if same:
        parameters[:] = parameters[:1]
    place = [spread, 0.75 * spread]
    return Snapshot(
        states=rng.normal(size=(n, 6)) * [*place, 1, 0.6, 0.6, 1],
        radii=rng.uniform(0.2, 0.6, n),
        command=command,
        parameters=parameters,
        robots=rng.normal(size=(m, 7)) * [*place, 1, 0.5, 0.5, 1, 1],
        obstacles=walls,
        obstacle_range=4.0,
        max_obstacles=most,
        time_step=0.05,
    )


def random_states(n, *, density=0.3, slowest=0.0, fastest=1.4, seed=0):
    """Returns people who walk any way in a square, shape (n, 6).

    Args:
        n: Their number.
        density: Of people, per square meter.
        slowest: The lowest speed, in m/s.
        fastest: The highest one.
        seed: Of what is drawn.
    """
    rng = np.random.default_rng(seed)
    states = np.zeros((n, 6))
    states[:, :2] = rng.uniform(0, np.sqrt(n / density), (n, 2))
    speed = rng.uniform(slowest, fastest, n)
    velocity = speed * np.exp(2j * np.pi * rng.random(n))
    states[:, 3], states[:, 4] = velocity.real, velocity.imag
    return states


def step(model, snapshot):
    """Returns the states of people after a step."""
    return model.advance(snapshot, model.forces(snapshot))


def walk(model, snapshot, time):
    """Returns the states of people at first, and after each step."""
    states = [snapshot.states]
    for _ in range(round(time / snapshot.time_step)):
        states.append(step(model, snapshot._replace(states=states[-1])))
    return np.array(states)


def human_states(dut, context):
    """Returns the states that a HumanCrowd gives, shape (n, 7)."""
    return dut.get_human_states_output_port().Eval(context).reshape(-1, 7)
