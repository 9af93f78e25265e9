"""The places of people, robots and walls, told fast, are told right."""

import itertools
import math
import re

from hypothesis import given, strategies as st
import numpy as np
import pytest
import shapely

from hunav_drake import LoadScenario, ScenarioError
from hunav_drake.scenario.geometry import check_places, check_walls
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import Box, Polygon, Polyline, World

COORDINATES = st.floats(-4, 4).map(lambda x: round(x, 2))
POINTS = st.tuples(COORDINATES, COORDINATES)
SIZES = st.floats(0.1, 3).map(lambda x: round(x, 2))
WALLS = st.one_of(
    st.builds(
        Box, center=POINTS, size=st.tuples(SIZES, SIZES), yaw=st.floats(-3, 3)
    ),
    st.builds(Polygon, points=st.lists(POINTS, min_size=3, max_size=6)),
    st.builds(Polyline, points=st.lists(POINTS, min_size=2, max_size=5)),
)
FURNITURE_PARTS = st.builds(
    lambda kind, center: FURNITURE.make({"type": kind, "center": center}),
    st.sampled_from(sorted(FURNITURE)),
    POINTS,
)


@st.composite
def scenarios(draw):
    humans = [
        HumanConfig(
            pose=(*draw(POINTS), 0.0),
            radius=draw(st.floats(0.1, 1.0)),
            goals=draw(st.lists(POINTS, max_size=4)),
        )
        for _ in range(draw(st.integers(0, 5)))
    ]
    world = World(
        walls=draw(st.lists(WALLS, max_size=6)),
        furniture=draw(st.lists(FURNITURE_PARTS, max_size=3)),
    )
    return Scenario(world=world, humans=humans)


def taken_places(scenario):
    """Yields each place with the first thing that takes it up, one by one."""
    shapes = [
        (fixture.place, fixture.closed, outline)
        for fixture in scenario.world.fixtures()
        for outline in fixture.footprints
    ]
    robot = scenario.robot
    spots = [(("robot", "start"), robot.start, robot.radius)]
    for i, human in enumerate(scenario.humans):
        spots.append((("humans", i, "pose"), human.pose, human.radius))
        spots += [
            (("humans", i, "goals", k), goal, 0.0)
            for k, goal in enumerate(human.goals)
        ]
    for loc, place, radius in spots:
        point = shapely.Point(place[:2])
        for where, closed, outline in shapes:
            kind = shapely.Polygon if closed else shapely.LineString
            shape = kind(outline)
            border = shape.boundary if closed else shape
            inside = closed and shape.contains(point)
            distance = border.distance(point)
            depth = radius + distance if inside else radius - distance
            if depth > 1e-9:
                yield loc, ("world", *where), depth
                break


@given(scenarios())
def test_each_place_is_told_with_the_first_wall_that_takes_it(scenario):
    found = check_places(scenario)
    overlaps = [it for it in found if it.uses[-1][0] == "world"]
    wanted = list(taken_places(scenario))
    assert [(it.loc, it.uses[-1]) for it in overlaps] == [
        (loc, wall) for loc, wall, _ in wanted
    ]
    for finding, (_, _, depth) in zip(overlaps, wanted, strict=True):
        told = float(finding.message.split("move it ")[1].split(" m")[0])
        # (In whole centimeters; it may be farther to where others can get to.)
        assert told >= depth - 0.01


def test_the_way_out_of_a_wall_that_crosses_itself_is_far_enough():
    bow = Polygon(points=[(0.0, 0.0), (3.5, -1.0), (0.0, 4.0), (3.0, 0.0)])
    human = HumanConfig(pose=(0.0, 3.0, 0.0), radius=1.0, goals=[(0.0, 2.0)])
    scenario = Scenario(world=World(walls=[bow]), humans=[human])
    found = {it.loc: it for it in check_places(scenario)}
    finding = found["humans", 0, "pose"]
    nearest = shapely.LineString([(3.5, -1.0), (0.0, 4.0)])
    depth = 1.0 - nearest.distance(shapely.Point(0.0, 3.0))
    assert float(finding.message.split("move it ")[1].split()[0]) >= depth


@given(st.lists(POINTS, min_size=3, max_size=6))
def test_polygons_are_sound_just_as_shapely_says(points):
    scenario = Scenario(world=World(walls=[Polygon(points=points)]))
    found = list(check_walls(scenario))
    # What is remembered is the same.
    assert found == list(check_walls(scenario))
    shape = shapely.Polygon(points)
    assert len(found) <= 1
    is_repeated = points[0] in (points[1], points[-1]) or any(
        one == other for one, other in itertools.pairwise(points)
    )
    is_sound = shape.is_valid and shape.area > 1e-9 and not is_repeated
    assert (not found) == is_sound


def test_walls_are_told_by_their_own_places():
    bow = Polygon(points=[(0, 0), (2, 2), (2, 0), (0, 2)])
    line = Polygon(points=[(0, 0), (1, 1), (2, 2)])
    walls = [bow, line, bow]
    found = list(check_walls(Scenario(world=World(walls=walls))))
    assert [it.loc for it in found] == [
        ("world", "walls", i, "points") for i in range(3)
    ]
    assert "cross itself" in found[0].message
    assert "enclose an area" in found[1].message
    assert found[0].message == found[2].message


@pytest.mark.slow
def test_many_places_among_many_walls():
    """More than are compared at once, with a known answer."""
    grid = [(float(x), float(y)) for x in range(30) for y in range(20)]
    walls = [Box(center=place, size=(0.4, 0.4)) for place in grid]
    inside = [(x + 0.1, y) for x, y in grid]
    free = [(x + 0.5, y + 0.5) for x, y in grid]
    human = HumanConfig(pose=(-5.0, -5.0, 0.0), goals=[*inside, *free])
    scenario = Scenario(world=World(walls=walls), humans=[human])
    found = [it for it in check_places(scenario) if it.loc[0] == "humans"]
    assert [it.loc[3] for it in found] == list(range(len(inside)))
    assert [it.uses[-1] for it in found] == [
        ("world", "walls", i) for i in range(len(walls))
    ]
    assert all(
        "move it 0.10 m along (1.00, 0.00)" in it.message for it in found
    )
    assert math.isclose(np.hypot(*free[0]), math.sqrt(0.5))


@pytest.mark.parametrize("count", [0, 1])
def test_worlds_without_walls_take_no_place(count):
    humans = [HumanConfig(pose=(3.0, 3.0, 0.0)) for _ in range(count)]
    assert not list(check_places(Scenario(humans=humans)))


def far_walls(planner: str, half: float = 100.0, goal: float = 3.0) -> str:
    """A world of 200 m, as a map of 4000 x 4000 cells of 5 cm may give."""
    box = "{{type: box, center: [{0}, {0}], size: [1, 1]}}"
    walls = ", ".join(map(box.format, (-half, half)))
    return (
        f"world: {{walls: [{walls}]}}\nrobot: {{goal: [{goal}, 0, 0]}}\n"
        f"planner: {planner}\nsimulation: {{duration: 0.2}}\n"
    )


def test_maps_of_a_planner_that_are_too_large_are_told():
    with pytest.raises(ScenarioError, match="at most 25000000 cells") as info:
        LoadScenario(data=far_walls("mppi", 10.0, 9000.0))
    (fault,) = info.value.faults
    assert fault.path == "planner.global_costmap.resolution"
    least = re.search(r"a coarser one, (\S+) m at least", fault.message)[1]
    settings = f"{{type: mppi, global_costmap: {{resolution: {least}}}}}"
    assert LoadScenario(data=far_walls(settings, 10.0, 9000.0))


@pytest.mark.parametrize("planner", ["pursuit", "dwb"])
def test_planners_go_on_in_large_worlds(planner):
    assert LoadScenario(data=far_walls(planner))


def ring(count, radius):
    """Returns the corners of a regular polygon."""
    angles = 2 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return (radius * circle).tolist()


def test_corners_within_a_millimetre_are_one():
    spaced = Polygon(points=ring(100, 0.1))
    assert spaced.vertices().tolist() == ring(100, 0.1)
    dense = Polygon(points=ring(1000, 0.02)).vertices()
    assert 100 < len(dense) < 130
    steps = np.hypot(*(np.roll(dense, -1, axis=0) - dense).T)
    assert steps.min() >= 1e-3
    line = Polyline(points=[(0, 0), (0.0005, 0), (1, 0), (1.0005, 0)])
    assert line.vertices().tolist() == [[0, 0], [1, 0]]


@pytest.mark.parametrize(
    "wall",
    [
        Polygon(points=ring(1000, 0.0004)),
        Polygon(points=[(0, 0), (1, 0), (1, 0.0005)]),
        Polyline(points=[(0, 0), (0.0005, 0)]),
    ],
    ids=["ring", "needle", "line"],
)
def test_a_wall_within_a_millimetre_is_told(wall):
    scenario = Scenario(world=World(walls=[wall]))
    (found,) = check_walls(scenario)
    assert found.loc == ("world", "walls", 0, "points")
    assert "points within 1 mm are one" in found.message
    # The other checks do not mind.
    list(check_places(scenario))


def test_the_remedy_is_enough_with_the_direction_as_told():
    """Rounded to two digits, the direction may be shorter than 1."""
    text = """
robot: {{start: [{}, {}, 0], goal: [9, 9, 0]}}
world: {{walls: [{{type: box, yaw: 0.4042339541913771, center: [0, 0],
  size: [2, 1]}}]}}
"""
    place = np.array([-0.0871630899658144, -0.026100223707630765])
    with pytest.raises(ScenarioError) as caught:
        LoadScenario(data=text.format(*place.tolist()))
    found = re.search(
        r"move it ([\d.]+) m along \(([-\d.]+), ([-\d.]+)\)", str(caught.value)
    )
    amount, *way = map(float, found.groups())
    moved = place + amount * np.array(way)
    LoadScenario(data=text.format(*moved.tolist()))
