"""Skipping boxes of the table changes nothing, to the last bit."""

import dataclasses

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command
from hunav_drake.systems.crowd.orca.model import OrcaModel, orca_accelerations
from hunav_drake.systems.crowd.social_force import jacobian, kernel
from hunav_drake.systems.crowd.walls.keep_out import keep_out_of_walls
from hunav_drake.systems.crowd.walls.passages import ease
from hunav_drake.systems.people import SocialForceParameters
from hunav_drake.systems.planning.clearance import clearance_ahead
from hunav_drake.systems.world import visibility_graph
from hunav_drake.systems.world.nearest import nearest_on_walls
from hunav_drake.systems.world.obstacles import Obstacles, nearest_points
from hunav_drake.systems.world.ray_cast import ray_cast
from hunav_drake.systems.world.walls import opened, out_of_box


def without_index(table):
    """The same walls in boxes that hold everything: nothing is left out."""
    result = table.copy()
    segments, _, _, boxes = table[:4].view(np.int64)
    begin = 4 + 4 * segments
    everything = np.array([-np.inf, -np.inf, np.inf, np.inf])
    result[begin : begin + 4 * boxes] = np.tile(everything, boxes)
    result.setflags(write=False)
    return result


def make_world(seed, shapes, extent, corners=6, grid=None):
    """Returns shapes of all kinds, in any order, perhaps all on a grid."""
    rng = np.random.default_rng(seed)
    vertices, solid = [], []
    for _ in range(shapes):
        count = rng.integers(1, corners + 1)
        p = rng.uniform(-extent, extent, 2) + rng.normal(size=(count, 2))
        vertices.append(p if grid is None else np.round(p / grid) * grid)
        solid.append(bool(count > 2 and rng.random() < 0.6))
    return Obstacles.from_shapes(vertices, solid=solid)


worlds = st.builds(
    make_world,
    st.integers(0, 2**32),
    st.integers(0, 60),
    st.sampled_from([2.0, 10.0, 1e5]),
    st.sampled_from([2, 6, 40]),
    st.sampled_from([None, 0.5]),
)


class CrowdAtWalls:
    """People on walls, near walls and anywhere, with goals like that."""

    def __init__(self, obstacles, seed, n=6):
        rng = np.random.default_rng(seed)
        ends = np.vstack([np.zeros((1, 2)), obstacles.segments.reshape(-1, 2)])
        self.states = rng.normal(size=(n, 6))
        self.states[:, :2] += ends[rng.integers(0, len(ends), n)]
        self.states[0, :2] = ends[-1]
        self.states[1, :2] = np.round(self.states[1, :2] * 2) / 2
        self.after = self.states + 0.3 * rng.normal(size=(n, 6))
        self.command = np.zeros((n, COMMAND_SIZE))
        self.command[:, Command.HAS_GOAL] = 1
        self.command[:, [Command.DESIRED_SPEED, Command.MAX_SPEED]] = 1.2
        self.command[:, Command.GROUP_ID] = -1
        near = self.states[: n // 2, :2] + rng.normal(size=(n // 2, 2))
        far = ends[rng.integers(0, len(ends), n - n // 2)]
        self.goals = np.vstack([near, far])
        self.command[:, :2] = self.goals
        self.parameters = np.tile(
            dataclasses.astuple(SocialForceParameters()), (n, 1)
        )
        self.radii = np.full(n, 0.3)
        self.at_walls = np.tile([0.3, 10.0], (n, 1))
        self.most = int(rng.integers(0, 4))

    def ask(self, table):
        """Yields everything that people ask about walls."""
        people = (
            *(self.states, self.radii, self.command, self.parameters),
            *(np.zeros((0, 7)), self.at_walls, table),
        )
        felt = (5.0, self.most)
        yield kernel.social_forces(*people, *felt)
        yield jacobian.force_jacobian(*people, *felt)
        model = np.array(dataclasses.astuple(OrcaModel()), dtype=float)
        yield orca_accelerations(*people, 5.0, 0.05, model)
        margins = np.full(len(self.states), 0.1)
        yield keep_out_of_walls(self.states, self.after, margins, table)
        yield ease(
            *(self.states, self.command, self.at_walls, self.parameters),
            *(0.0, 0.57, table, *felt, True),
        )
        places = np.ascontiguousarray(self.states[:, :2])
        yield visibility_graph.blocked(places, self.goals, 0.285, table)
        yield visibility_graph.free_points(places, 0.285, table)
        yield nearest_on_walls(places, table)
        for p, q in zip(places, self.goals, strict=True):
            yield ray_cast(*p, *q, table)
            yield clearance_ahead(*p, q[0], 0.3, 4.0, table)


@given(worlds, st.integers(0, 2**32))
def test_what_is_left_out_changes_no_bit(obstacles, seed):
    crowd = CrowdAtWalls(obstacles, seed)
    plain = without_index(obstacles.table)
    for with_it, without in zip(
        crowd.ask(obstacles.table), crowd.ask(plain), strict=True
    ):
        np.testing.assert_array_equal(with_it, without)


@given(worlds, st.integers(0, 2**32))
def test_the_nearest_wall_is_that_of_the_nearest_shape(obstacles, seed):
    p = np.ascontiguousarray(CrowdAtWalls(obstacles, seed).states[:, :2])
    nearest = nearest_on_walls(p, obstacles.table)
    each = nearest_points(obstacles, p) - p[:, None]
    if len(obstacles) == 0:
        assert np.isnan(nearest).all()
        return
    np.testing.assert_allclose(
        np.hypot(*(nearest - p).T), np.hypot(*each.T).min(axis=0), rtol=1e-14
    )


@given(worlds)
def test_every_segment_is_in_one_run_and_in_all_boxes_above_it(obstacles):
    walls = opened.py_func(obstacles.table)
    np.testing.assert_array_equal(walls.segments, obstacles.segments)
    np.testing.assert_array_equal(walls.first, obstacles.first)
    np.testing.assert_array_equal(walls.solid, obstacles.solid)
    covered = [s for lo, hi, _, _ in walls.runs for s in range(lo, hi)]
    assert covered == list(range(len(obstacles.segments)))
    for lo, hi, shape, _ in walls.runs:
        assert obstacles.first[shape] <= lo < hi <= obstacles.first[shape + 1]
    for box, (x0, y0, x1, y1) in enumerate(walls.boxes):
        inside = range(box, walls.links[box, 0])
        for run in walls.links[inside, 1]:
            if run >= 0:
                ends = walls.segments[slice(*walls.runs[run, :2])].reshape(
                    -1, 2
                )
                assert (ends >= [x0, y0]).all()
                assert (ends <= [x1, y1]).all()


def visited(obstacles, p, reach):
    """Returns the number of boxes that a query visits."""
    walls = opened.py_func(obstacles.table)
    count = box = 0
    while box < len(walls.boxes):
        count += 1
        out = out_of_box.py_func(*p, *p, reach, walls.boxes, box)
        box = walls.links[box, 0] if out else box + 1
    return count


def test_work_does_not_grow_with_the_world():
    """At the same density of walls, which are in no order."""
    works = []
    for shapes in (100, 10_000):
        extent = 2.0 * np.sqrt(shapes)
        obstacles = make_world(1, shapes, extent)
        places = np.random.default_rng(2).uniform(-extent, extent, (50, 2))
        works.append(np.mean([visited(obstacles, p, 5.0) for p in places]))
    assert works[1] < 2 * works[0]


@pytest.mark.parametrize("extent", [1e-3, 1.0, 1e5])
def test_memory_does_not_grow_with_the_extent(extent):
    obstacles = make_world(3, 500, extent)
    assert obstacles.table.nbytes < 6 * obstacles.segments.nbytes
