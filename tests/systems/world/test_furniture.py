import math

from hypothesis import given, strategies as st
import numpy as np
import pytest
import shapely

from hunav_drake import LoadScenario, SaveScenario, ScenarioError
from hunav_drake.systems.world.furniture import (
    FURNITURE,
    DoorFrame,
    Pallet,
    Plant,
    Table,
)
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import EYE_HEIGHT, Box, Polyline, World
from hunav_drake.systems.world.solids import Hull, rectangle

KINDS = sorted(FURNITURE)


def polygons(obstacles: Obstacles) -> list[shapely.Polygon]:
    return [
        shapely.Polygon(obstacles.segments[lo:hi, :2])
        for lo, hi in zip(obstacles.first, obstacles.first[1:], strict=False)
    ]


def area(obstacles: Obstacles) -> float:
    return shapely.union_all(polygons(obstacles)).area


def make(kind, **options):
    return FURNITURE.make({"type": kind, "center": [0.0, 0.0], **options})


@pytest.mark.parametrize("kind", KINDS)
@given(x=st.floats(0.02, 5), y=st.floats(0.02, 5), height=st.floats(0.02, 3))
def test_whatever_its_size_it_is_within_its_footprint_and_height(
    kind, x, y, height
):
    thing = make(kind, size=(x, y), height=height)
    outlines = thing.footprints() or [rectangle(-x / 2, -y / 2, x / 2, y / 2)]
    footprint = shapely.union_all([shapely.Polygon(it) for it in outlines])
    assert footprint.is_valid
    around = footprint.convex_hull.buffer(0.06 * max(x, y))
    for prism in thing.solids():
        assert 0 <= prism.low < prism.high
        piece = shapely.Polygon(prism.outline)
        assert piece.is_valid
        assert around.covers(piece)
        # Things on a desk, or at the head of a bed, are no part of it.
        assert prism.high <= height + 0.45


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_moved_and_turned_as_a_whole(kind):
    here = World(furniture=[make(kind)])
    there = World(furniture=[make(kind, center=[3.0, -1.0], yaw=math.pi / 2)])
    for height in (0.1, 0.5, 1.6):
        a, b = here.obstacles_at(height), there.obstacles_at(height)
        ends = a.segments.reshape(-1, 2)
        turned = np.column_stack([3.0 - ends[:, 1], ends[:, 0] - 1.0])
        np.testing.assert_allclose(
            b.segments.reshape(-1, 2), turned, atol=1e-12
        )


def test_a_table_is_legs_below_and_its_top_above():
    world = World(furniture=[Table(center=(0, 0), size=(1.2, 0.8))])
    assert area(world.obstacles()) == pytest.approx(0.96)
    assert len(world.obstacles_at(0.2)) == 4
    assert area(world.obstacles_at(0.2)) == pytest.approx(4 * 0.05**2)
    assert area(world.obstacles_at(0.74)) == pytest.approx(0.96)
    assert len(world.obstacles_at(0.75)) == 0
    assert len(world.sight_obstacles()) == 0


def test_a_round_table_has_the_area_of_its_disc():
    table = Table(center=(1, 2), size=(0.9, 0.9), round=True)
    world = World(furniture=[table])
    assert area(world.obstacles()) == pytest.approx(math.pi * 0.45**2)
    leg = math.pi * (0.06 * 0.9) ** 2
    assert area(world.obstacles_at(0.3)) == pytest.approx(leg)


def test_one_walks_and_sees_through_a_door():
    door = DoorFrame(center=(0, 0), size=(0.2, 1.1), jamb=0.1)
    world = World(furniture=[door])
    for obstacles in (world.obstacles(), world.sight_obstacles()):
        middle = shapely.LineString([(-1, 0), (1, 0)])
        assert not any(it.intersects(middle) for it in polygons(obstacles))
        assert area(obstacles) == pytest.approx(2 * 0.2 * 0.1)
    # Above heads is the lintel.
    assert area(world.obstacles_at(2.05)) == pytest.approx(0.2 * 1.1)


@pytest.mark.parametrize("kind", ["sign", "picture"])
def test_one_walks_under_what_hangs_high_enough(kind):
    for low, in_the_way in ((1.8, 0), (1.79, 1)):
        thing = make(kind, height=low + 0.5, tall=0.5, size=(0.1, 2.0))
        assert thing.low == pytest.approx(low)
        world = World(furniture=[thing])
        assert len(world.obstacles()) == in_the_way
        # A lidar sees it where it is, and nothing below.
        assert len(world.obstacles_at(low - 0.01)) == 0
        assert len(world.obstacles_at(low + 0.01)) > 0


def test_a_board_taller_than_high_stands_on_the_floor():
    sign = make("sign", height=1.0, tall=3.0, text="Open")
    assert sign.low == 0.0
    assert [it.middle for it in sign.letters()] == [0.5, 0.5]
    assert len(World(furniture=[sign]).obstacles()) == 1


def test_a_sign_is_read_from_both_sides():
    sign = make("sign", center=[2.0, 1.0], yaw=math.pi / 2, text="Exit")
    front, back = sign.letters()
    assert front.pose == pytest.approx((2.0, 1.03, math.pi / 2))
    assert back.pose == pytest.approx((2.0, 0.97, 1.5 * math.pi))
    assert front.size[0] < sign.size[1]
    assert front.size[1] < sign.tall
    assert not make("sign", text=" \n").letters()
    assert front in World(furniture=[sign]).fixtures()[0].solids


def test_what_is_higher_than_the_eyes_hides():
    hiding = {
        kind
        for kind in KINDS
        if len(World(furniture=[make(kind)]).sight_obstacles())
    }
    assert hiding == {"door_frame", "picture", "pillar", "shelf"}
    loaded = World(furniture=[Pallet(center=(0, 0), load=1.6)])
    assert area(loaded.sight_obstacles()) > 0.2
    assert not len(World(furniture=[Plant(center=(0, 0))]).sight_obstacles())


def test_walls_hide_unless_they_are_low():
    high = Polyline(points=[(0, 0), (1, 0)])
    low = Box(center=(0, 2), size=(1, 1), height=1.1)
    world = World(walls=[high, low])
    assert len(world.obstacles()) == 2
    sight = world.sight_obstacles()
    assert len(sight) == 1
    assert not sight.solid[0]
    np.testing.assert_array_equal(sight.segments, [[0, 0, 1, 0]])
    assert high.height > EYE_HEIGHT


def test_cuts_of_a_convex_hull_are_those_of_the_solid():
    pyramid = np.array(
        [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 2.0]]
    )
    dut = Hull(pyramid)
    for height in (0.0, 0.5, 1.0, 1.9):
        side = 2 * (1 - height / 2)
        cut = shapely.Polygon(*dut.cuts(height))
        assert cut.area == pytest.approx(side**2)
        assert cut.exterior.is_ccw
        assert shapely.Polygon(dut.slice(height, 5)).area == pytest.approx(
            side**2
        )
    assert not dut.cuts(2.0)
    assert not dut.cuts(-0.1)


CAFE = """
world:
  furniture:
    - type: table
      center: [2, 0]
      name: bar
    - type: door_frame
      center: [5, 0]
humans:
  - pose: [0, 0, 0]
robot: {start: [-5, -5, 0]}
"""


def test_it_survives_a_file():
    scenario = LoadScenario(data=CAFE)
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    assert scenario.world.furniture[0] == Table(center=(2, 0), name="bar")


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("type: table", "type: tabel", 4, "no kind of furniture 'tabel'"),
        (
            "name: bar",
            "size: [0, 1]",
            6,
            r"size\[0\]: must be in \[0.02, 100\]",
        ),
        ("name: bar", "color: red", 6, "color: unknown key"),
        (
            "[0, 0, 0]",
            "[2.1, 0.2, 0]",
            10,
            r"inside world.furniture\[0\] \('bar'\)",
        ),
        (
            "[0, 0, 0]",
            "[5, 0.3, 0]",
            10,
            r"overlaps world.furniture\[1\]; move",
        ),
    ],
)
def test_a_fault_is_told_once_with_its_place(old, new, line, words):
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(data=CAFE.replace(old, new))
    assert [fault.line for fault in info.value.faults] == [line]


def test_nothing_is_in_the_way_of_who_walks_through_a_door():
    LoadScenario(data=CAFE.replace("[0, 0, 0]", "[5, 0, 0]"))
