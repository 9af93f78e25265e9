import math

import numpy as np
import pytest
import shapely

from hunav_drake.systems.common.layout import OUTSIDE
from hunav_drake.systems.sensing import VisiblePeople, VisiblePeopleConfig
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.sensing.scans import NOWHERE, rows, scan

WALL = Obstacles.from_shapes([[(2, -1), (2, 1)]], solid=[False])


class Detector:
    """A VisiblePeople with held inputs."""

    def __init__(self, people, *, obstacles=NOWHERE, robot=(0, 0, 0), **config):
        self.dut = VisiblePeople(
            VisiblePeopleConfig(**config),
            obstacles=obstacles,
            num_humans=len(people),
        )
        self.context = self.dut.CreateDefaultContext()
        self.fix(people, robot)

    def fix(self, people, robot=(0, 0, 0)):
        for port, value in (
            (self.dut.get_robot_state_input_port(), rows(robot)),
            (self.dut.get_human_states_input_port(), people),
        ):
            port.FixValue(self.context, np.ravel(value))

    def visible(self):
        return self.dut.get_visible_output_port().Eval(self.context).tolist()

    def rows(self):
        port = self.dut.get_visible_people_output_port()
        return port.Eval(self.context).reshape(-1, 7)


def test_people_in_range_and_in_view_are_seen():
    people = rows((4, 0), (-4, 0), (0, 4), (6, 0))
    assert Detector(people, range_max=5).visible() == [1, 1, 1, 0]
    ahead = Detector(people, range_max=5, field_of_view=math.pi / 2)
    assert ahead.visible() == [1, 0, 0, 0]
    ahead.fix(people, (0, 0, math.pi / 2))
    assert ahead.visible() == [0, 0, 1, 0]
    back = Detector(
        people, range_max=5, field_of_view=1.0, pose=(0, 0, math.pi)
    )
    assert back.visible() == [0, 1, 0, 0]


def test_who_is_unseen_has_a_row_far_from_everything():
    people = rows((4, 0), (8, 0))
    people[:, 3:6] = 0.3
    dut = Detector(people, range_max=5)
    np.testing.assert_array_equal(dut.rows()[0], people[0])
    expected = [OUTSIDE, OUTSIDE, 0, 0, 0, 0, 0]
    np.testing.assert_array_equal(dut.rows()[1], expected)


def test_walls_hide_whom_they_cover():
    # A part of the last one is beside the wall.
    people = rows((4, 0), (4, 1), (4, 3), (4, 2.1))
    assert Detector(people, obstacles=WALL).visible() == [0, 0, 1, 1]


def test_people_hide_others_by_option():
    people = rows((2, 0), (4, 0), (4, 1.5))
    assert Detector(people).visible() == [1, 1, 1]
    assert Detector(people, hidden_by_people=True).visible() == [1, 0, 1]


def test_outputs_follow_each_input():
    dut = Detector(rows((4, 0)), range_max=5)
    assert dut.visible() == [1]
    dut.fix(rows((6, 0)))
    assert dut.visible() == [0]
    assert dut.rows()[0, 0] == OUTSIDE
    dut.fix(rows((6, 0)), (2, 0, 0))
    assert dut.visible() == [1]
    assert dut.rows()[0, 0] == 6


def test_without_people_nobody_is_seen():
    dut = VisiblePeople(num_humans=0)
    context = dut.CreateDefaultContext()
    assert dut.get_visible_output_port().Eval(context).size == 0
    assert dut.get_visible_people_output_port().Eval(context).size == 0


def test_two_contexts_do_not_disturb_each_other():
    dut = Detector(rows((4, 0)), range_max=5)
    assert dut.visible() == [1]
    clone = dut.context.Clone()
    dut.fix(rows((6, 0)))
    assert dut.visible() == [0]
    assert dut.dut.get_visible_output_port().Eval(clone)[0] == 1


def test_nobody_is_seen_through_walls():
    """Not by a lidar, nor by VisiblePeople; at random places."""
    rng = np.random.default_rng(2)
    hidden = shown = 0
    for _ in range(400):
        wall = rng.uniform(-4, 4, (2, 2))
        robot = (*rng.uniform(-6, 6, 2), rng.uniform(-4, 4))
        place = rng.uniform(-6, 6, 2)
        person = rows(place)
        line = shapely.LineString(wall)
        if line.distance(shapely.Point(place)) < 0.31:
            continue
        obstacles = Obstacles.from_shapes([wall], solid=[False])
        seen = Detector(person, obstacles=obstacles, robot=robot, range_max=50)
        with_person = scan(obstacles=obstacles, robot=robot, people=person)
        without = scan(obstacles=obstacles, robot=robot)
        # The lines to all of the disc.
        disc = shapely.Point(place).buffer(0.35)
        fan = shapely.MultiPoint([robot[:2], *disc.exterior.coords]).convex_hull
        if not fan.intersects(line):
            assert seen.visible() == [1]
            shown += 1
        shadow = shapely.Polygon(
            [*wall, *(wall[::-1] + 100 * (wall[::-1] - np.array(robot[:2])))]
        )
        if shadow.contains(disc):
            assert seen.visible() == [0]
            np.testing.assert_array_equal(with_person, without)
            hidden += 1
    assert hidden > 20
    assert shown > 100


def test_a_detector_that_cannot_be_is_refused():
    with pytest.raises(ValueError, match=r"in \(0, 1000\] m, got 0"):
        VisiblePeopleConfig(range_max=0.0)
    with pytest.raises(ValueError, match="num_humans must be at least 0"):
        VisiblePeople(num_humans=-1)
