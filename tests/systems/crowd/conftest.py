import dataclasses

import numpy as np
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd import Snapshot
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles

NO_WALLS = Obstacles.from_shapes([], solid=[])


def _make_snapshot(
    states,
    goals,
    *,
    speed=1.2,
    max_speed=None,
    radius=0.3,
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
    weights = dataclasses.astuple(SocialForceParameters())
    return Snapshot(
        states=states,
        radii=np.full(n, float(radius)),
        command=command,
        parameters=np.tile(weights, (n, 1)),
        robots=np.array(robots, dtype=float).reshape(-1, 7),
        obstacles=walls,
        obstacle_range=5.0,
        max_obstacles=0,
        time_step=time_step,
    )


@pytest.fixture(scope="session")
def make_snapshot():
    return _make_snapshot


@pytest.fixture(scope="session")
def walk():
    """Moves people by a model; returns their states after each step."""

    def walk(model, snapshot, time):
        states = [snapshot.states]
        for _ in range(round(time / snapshot.time_step)):
            now = snapshot._replace(states=states[-1])
            states.append(model.advance(now, model.forces(now)))
        return np.array(states)

    return walk
