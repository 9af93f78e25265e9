"""Crowds among walls: forces, ways and walls together."""

import dataclasses

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd import Snapshot, SocialForceModel
from hunav_drake.systems.crowd.walls.keep_out import (
    keep_out_of_walls,
    wall_margins,
)
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.people.human_config import LARGEST_BODY
from hunav_drake.systems.world.obstacles import (
    Obstacles,
    inside,
    nearest_points,
)
from hunav_drake.systems.world.route_clearance import route_clearance
from hunav_drake.systems.world.routes import RouteMap
from hunav_drake.systems.world.shapes import Box, Polyline, World
from hunav_drake.systems.world.sweep import nearest_free
from hunav_drake.systems.world.walls import opened

# People who press on: walls hardly stop them.
PUSHING = SocialForceParameters(
    goal_factor=20.0, obstacle_factor=1.0, social_factor=20.0
)


@dataclasses.dataclass
class CrowdInRoom:
    """People who walk to goals, without a diagram around them."""

    obstacles: Obstacles
    states: np.ndarray
    goals: np.ndarray
    radius: float = 0.25
    speed: float = 1.3
    forces: SocialForceParameters = dataclasses.field(
        default_factory=SocialForceParameters
    )
    routed: bool = True
    walled: bool = True

    def __post_init__(self):
        n = len(self.states)
        self.states = np.hstack([self.states, np.zeros((n, 4))])
        self.radii = np.full(n, self.radius)
        self.command = np.zeros((n, COMMAND_SIZE))
        self.command[:, :2] = self.goals
        self.command[:, Command.GOAL_RADIUS] = 0.3
        self.command[:, Command.HAS_GOAL] = 1
        self.command[:, Command.DESIRED_SPEED] = self.speed
        self.command[:, Command.MAX_SPEED] = self.speed
        self.command[:, Command.GROUP_ID] = -1
        self.parameters = np.tile(dataclasses.astuple(self.forces), (n, 1))
        self.model = SocialForceModel()
        self.routes = RouteMap.from_obstacles(
            self.obstacles, clearance=route_clearance(self.radii)
        )

    def step(self, dt):
        """Moves everybody; returns where they were."""
        before = self.states
        command = self.command
        if self.routed:
            command = self.routes.guide(before, command)
        snapshot = Snapshot(
            states=before,
            radii=self.radii,
            command=command,
            parameters=self.parameters,
            robots=np.zeros((0, 7)),
            obstacles=self.obstacles,
            obstacle_range=5.0,
            max_obstacles=0,
            time_step=dt,
        )
        self.states = self.model.advance(snapshot, self.model.forces(snapshot))
        if self.walled:
            self.states = keep_out_of_walls(
                before,
                self.states,
                wall_margins(np.minimum(self.radii, LARGEST_BODY)),
                self.obstacles.table,
            )
        return before

    def arrived(self):
        away = self.states[:, :2] - self.command[:, :2]
        return np.hypot(away[:, 0], away[:, 1]) < 0.5

    def clearances(self):
        p = self.states[:, :2]
        d = nearest_points(self.obstacles, p) - p[:, None]
        return np.hypot(d[..., 0], d[..., 1]).min(axis=1)

    def run(self, time, dt=0.05):
        """Walks until all have arrived, and checks that all stay in the room.

        Returns:
            The time, or infinity if a person has not arrived.
        """
        most = wall_margins(np.minimum(self.radii, LARGEST_BODY))
        for k in range(round(time / dt)):
            least = np.minimum(self.clearances(), most) - 1e-9
            before = self.step(dt)
            assert np.isfinite(self.states).all()
            if self.walled:
                assert not inside(self.obstacles, self.states[:, :2]).any()
                assert (self.clearances() >= least).all()
                assert not any_crossing(before, self.states, self.obstacles)
            speeds = np.hypot(self.states[:, 3], self.states[:, 4])
            assert speeds.max() <= self.speed * (1 + 1e-9)
            if self.arrived().all():
                return (k + 1) * dt
        return np.inf


def any_crossing(before, after, obstacles):
    p, q = before[:, None, :2], after[:, None, :2]
    a, b = obstacles.segments[:, :2], obstacles.segments[:, 2:]

    def side(start, end, point):
        u, v = end - start, point - start
        return np.sign(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    return (
        (side(p, q, a) * side(p, q, b) < 0)
        & (side(a, b, p) * side(a, b, q) < 0)
    ).any()


def two_rooms(door, *, thickness=0.2):
    """Rooms of 5 x 6 m, with a door in the middle of the wall between."""
    half = (6 - door) / 2
    return World(
        walls=[
            Box(center=[5, -0.1], size=[10.4, 0.2]),
            Box(center=[5, 6.1], size=[10.4, 0.2]),
            Box(center=[-0.1, 3], size=[0.2, 6.4]),
            Box(center=[10.1, 3], size=[0.2, 6.4]),
            Box(center=[5, half / 2], size=[thickness, half]),
            Box(center=[5, 6 - half / 2], size=[thickness, half]),
        ]
    ).obstacles()


def stand_in_rows(n, x, y, spacing=0.7, columns=4):
    """Places n people in rows, from (x, y) on."""
    i = np.arange(n)
    # Not quite in line: no two people wait for each other.
    wiggle = 0.05 * np.sin(7.0 * i)
    return np.column_stack(
        [x + spacing * (i % columns), y + spacing * (i // columns) + wiggle]
    )


@pytest.mark.parametrize(("dt", "least"), [(0.05, 12), (0.5, 4)])
def test_a_pushing_crowd_passes_a_narrow_door_and_no_wall(dt, least):
    """Thin walls, and people of 0.8 m before a door as wide as they are."""
    n = 12
    dut = CrowdInRoom(
        two_rooms(0.8, thickness=0.02),
        stand_in_rows(n, 1.0, 1.0),
        np.tile([9.0, 3.0], (n, 1)),
        radius=0.4,
        speed=3.0,
        forces=PUSHING,
    )
    dut.run(20.0, dt)
    # There is not room for all at the goal; long steps jam at the door.
    assert (dut.states[:, 0] > 5).sum() >= least


@pytest.mark.parametrize("dt", [0.05, 0.5])
@pytest.mark.parametrize("routed", [False, True])
def test_a_crowd_pushed_into_a_corner_stays_in_the_room(dt, routed):
    n = 16
    dut = CrowdInRoom(
        two_rooms(0.8, thickness=0.02),
        stand_in_rows(n, 2.0, 2.0, spacing=0.5),
        np.tile([-20.0, -20.0], (n, 1)),
        radius=0.4,
        speed=8.0,
        forces=dataclasses.replace(PUSHING, goal_factor=200.0),
        routed=routed,
    )
    dut.run(5.0, dt)
    # They are all there, one behind the other.
    assert (dut.states[:, :2].sum(axis=1) < 6).all()


def test_without_the_option_people_are_pushed_through_walls():
    """The reason why people are kept out of walls."""
    n = 16
    dut = CrowdInRoom(
        two_rooms(0.8, thickness=0.02),
        stand_in_rows(n, 2.0, 2.0, spacing=0.5),
        np.tile([-20.0, -20.0], (n, 1)),
        forces=PUSHING,
        routed=False,
        walled=False,
    )
    dut.run(5.0)
    assert (dut.states[:, :2].min(axis=1) < -0.2).any()


def test_a_crowd_finds_the_door_only_by_its_way():
    n = 6
    starts = stand_in_rows(n, 1.0, 0.7, columns=3)
    goals = np.column_stack([np.full(n, 9.0), 0.5 + 0.8 * np.arange(n)])
    routed = CrowdInRoom(two_rooms(1.2), starts, goals)
    time = routed.run(40.0)
    print(f"\n6 people through a door of 1.2 m: {time:.1f} s")
    assert time < 20
    straight = CrowdInRoom(two_rooms(1.2), starts, goals, routed=False)
    assert straight.run(40.0) == np.inf


def test_a_lone_walker_leaves_a_dead_end():
    dead_end = World(
        walls=[Polyline(points=[[0, 2], [4, 2], [4, -2], [0, -2]])]
    ).obstacles()
    start, goal = np.array([[2.5, 0.1]]), np.array([[8.0, 0.0]])
    time = CrowdInRoom(dead_end, start, goal).run(40.0)
    # 2.5 m out, 2 m up, 8 m on, at 1.3 m/s.
    assert 8 < time < 14
    assert CrowdInRoom(dead_end, start, goal, routed=False).run(40.0) == np.inf


def test_twenty_people_turn_a_corner():
    """RiMEA 6: a corridor of 2 m with a corner; nobody leaves it."""
    walls = World(
        walls=[
            Polyline(points=[[0, 0], [12, 0], [12, 12]]),
            Polyline(points=[[0, 2], [10, 2], [10, 12]]),
        ]
    ).obstacles()
    n = 20
    starts = np.array(
        [[0.4 + 0.6 * (i // 3), 0.4 + 0.6 * (i % 3)] for i in range(n)]
    )
    # Past the end of the corridor, far apart.
    goals = np.array([[10.0 + i % 5 * 0.5, 14.0 + i // 5] for i in range(n)])
    dut = CrowdInRoom(walls, starts, goals, radius=0.2)
    time = dut.run(60.0)
    print(f"\n20 people around a corner: {time:.1f} s")
    assert time < 40


def test_people_who_meet_no_wall_walk_as_without_the_option():
    walls = two_rooms(1.2)
    starts = np.array([[1.0, 2.0], [1.2, 4.0], [3.5, 3.1]])
    goals = np.array([[4.0, 4.0], [4.0, 2.0], [1.0, 3.0]])
    dut = CrowdInRoom(walls, starts, goals)
    plain = CrowdInRoom(walls, starts, goals, walled=False, routed=False)
    for _ in range(60):
        dut.step(0.05)
        plain.step(0.05)
        np.testing.assert_array_equal(dut.states, plain.states)


@settings(max_examples=15)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 12),
    dt=st.sampled_from([0.05, 0.2, 0.5]),
    routed=st.booleans(),
)
def test_nobody_enters_a_wall_of_any_room(seed, n, dt, routed):
    """Random furniture, and people who may start inside of it."""
    rng = np.random.default_rng(seed)
    walls = [
        Box(
            center=rng.uniform(0, 8, 2),
            size=rng.uniform(0.02, 2.5, 2),
            yaw=rng.uniform(-2, 2),
        )
        for _ in range(6)
    ]
    walls.append(Polyline(points=rng.uniform(0, 8, (4, 2))))
    dut = CrowdInRoom(
        World(walls=walls).obstacles(),
        rng.uniform(0, 8, (n, 2)),
        rng.uniform(0, 8, (n, 2)),
        speed=5.0,
        forces=PUSHING,
        routed=routed,
    )
    # The first step puts everybody outside, if anything leads out.
    before = dut.step(dt)
    walls = opened(dut.obstacles.table)
    margin = wall_margins(dut.radii)[0]
    held = inside(dut.obstacles, dut.states[:, :2]).any(axis=1)
    for x, y in dut.states[held, :2]:
        assert not nearest_free(x, y, 1.0, 0.0, margin, walls)[2]
    np.testing.assert_array_equal(dut.states[held, :2], before[held, :2])
    assert not dut.states[held, 3:5].any()
    if not held.all():
        outside = dataclasses.replace(
            dut, states=dut.states[~held, :2], goals=dut.goals[~held]
        )
        outside.run(40 * dt, dt)
