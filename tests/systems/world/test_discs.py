"""Round walls: their polygon, what is near them, and their body."""

from hypothesis import given, strategies as st
import numpy as np
from pydrake.geometry import Cylinder, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
import pytest
import shapely

from hunav_drake import LoadScenario, SaveScenario, ScenarioError
from hunav_drake.systems.robot.plant_walls import AddFloorAndWalls
from hunav_drake.systems.world.furniture import Table
from hunav_drake.systems.world.nearest import nearest_on_walls
from hunav_drake.systems.world.ray_cast import ray_cast
from hunav_drake.systems.world.shapes import Box, Disc, Polygon, World
from hunav_drake.systems.world.solids import as_disc, turned

# How far the polygon of a disc is from its circle at most, in meters.
CLOSE = 0.005
radii = st.floats(0.01, 50)
coordinate = st.floats(-100, 100)


@given(coordinate, coordinate, radii)
def test_its_polygon_has_its_area_and_is_within_5_mm(x, y, radius):
    points = Disc(center=(x, y), radius=radius).vertices()
    polygon = shapely.Polygon(points)
    assert polygon.exterior.is_ccw
    assert polygon.area == pytest.approx(np.pi * radius**2, rel=1e-6)
    rim = shapely.Point(x, y).buffer(radius, quad_segs=2000).exterior
    assert polygon.exterior.hausdorff_distance(rim) <= CLOSE
    assert as_disc(points) == pytest.approx((x, y, radius), abs=1e-9)


@given(st.floats(0, 6.3), st.floats(0.05, 5), st.floats(0.1, 20))
def test_distance_and_rays_are_those_of_a_disc_from_all_sides(
    angle, radius, gap
):
    table = World(walls=[Disc(center=(1, -2), radius=radius)]).obstacles().table
    away = np.array([np.cos(angle), np.sin(angle)])
    x, y = np.array([1, -2]) + (radius + gap) * away
    (near,) = nearest_on_walls(np.array([[x, y]]), table)
    assert np.hypot(*(near - [x, y])) == pytest.approx(gap, abs=CLOSE)
    # A ray to the center meets the rim.
    part = ray_cast(x, y, 1.0, -2.0, table)
    assert part * (radius + gap) == pytest.approx(gap, abs=CLOSE)
    # One beside it does not.
    aside = (radius + CLOSE) * np.array([-away[1], away[0]])
    start = np.array([x, y]) + aside
    end = start - 2 * (radius + gap) * away
    assert ray_cast(*start, *end, table) == np.inf


def test_a_moved_or_turned_polygon_of_a_disc_is_one_and_others_are_not():
    ring = Disc(center=(0, 0), radius=2.0).vertices()
    assert as_disc(turned(ring, (3, 4, 0.7))) == pytest.approx((3, 4, 2))
    assert as_disc(ring[::-1]) == pytest.approx((0, 0, 2))
    assert as_disc(ring * [1.0, 1.001]) is None
    assert as_disc(Box(center=(0, 0), size=(1, 1)).vertices()) is None
    assert as_disc(np.zeros((16, 2))) is None
    # A star whose sides are equal, but not its corners' distances.
    star = ring * np.where(np.arange(len(ring)) % 2, 1.0, 0.9)[:, None]
    assert as_disc(star) is None


def test_its_body_in_a_plant_is_one_cylinder():
    plant = MultibodyPlant(0.01)
    scene_graph = SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    world = World(
        walls=[
            Disc(center=(1, 2), radius=0.075),
            Box(center=(5, 5), size=(1, 1)),
        ],
        furniture=[
            Table(center=(-3, 0), size=(0.8, 0.8), round=True),
            Table(center=(-6, 0), size=(0.8, 0.9), round=True),
        ],
    )
    AddFloorAndWalls(plant, world.obstacles(), (0, 0))
    inspector = scene_graph.model_inspector()
    ids = plant.GetCollisionGeometriesForBody(plant.world_body())
    found = [
        (
            *inspector.GetPoseInFrame(it).translation()[:2],
            inspector.GetShape(it).radius(),
        )
        for it in ids
        if isinstance(inspector.GetShape(it), Cylinder)
    ]
    assert np.array(found) == pytest.approx(
        np.array([(1, 2, 0.075), (-3, 0, 0.4)])
    )
    # Floor, disc, box, round table, elliptic table.
    assert len(ids) == 1 + 1 + 4 + 1 + 16


def test_it_is_saved_and_loaded_and_a_bad_radius_is_told():
    text = "world: {walls: [{type: disc, center: [1, 2], radius: 0.5}]}"
    scenario = LoadScenario(data=text)
    (wall,) = scenario.world.walls
    assert wall == Disc(center=(1, 2), radius=0.5)
    again = LoadScenario(data=SaveScenario(scenario))
    assert again.world == scenario.world
    for bad in ("0", "-1", ".nan", "1e9", "wide"):
        with pytest.raises(ScenarioError, match=r"walls\[0\]\.radius"):
            LoadScenario(data=text.replace("0.5", bad))


def test_a_person_in_a_disc_is_told():
    text = (
        "world: {walls: [{type: disc, center: [1, 2], radius: 0.5}]}\n"
        "humans: [{pose: [1.6, 2, 0], goals: [[9, 9]]}]"
    )
    with pytest.raises(ScenarioError, match=r"overlaps world\.walls\[0\]"):
        LoadScenario(data=text)
    LoadScenario(data=text.replace("1.6", "1.9"))


def test_a_polygon_may_have_any_number_of_points():
    angles = 2 * np.pi * np.arange(5000) / 5000
    ring = 20 * np.column_stack([np.cos(angles), np.sin(angles)])
    wall = Polygon(points=ring.tolist())
    scenario = LoadScenario(
        data=f"world: {{walls: [{{type: polygon, points: {ring.tolist()}}}]}}\n"
        "robot: {start: [30, 0, 0]}"
    )
    assert len(scenario.world.obstacles().segments) == len(wall.vertices())


def test_a_large_building_with_equal_sides_is_no_disc():
    angles = np.arange(16) * np.pi / 8
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    assert as_disc(0.3 * ring) is not None
    assert as_disc(10 * ring) is None
