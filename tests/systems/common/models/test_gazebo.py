"""Worlds and models of Gazebo: what is read, and how faults are told."""

import os

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
import pytest
import shapely
import trimesh
import yaml

from hunav_drake import LoadScenario, RunTrial, SaveScenario, ScenarioError
from hunav_drake.scenario.named_files import named_files
from hunav_drake.systems.common.models import mesh_files
from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.models.gazebo import is_gazebo_file, read_gazebo
from hunav_drake.systems.common.models.mesh_files import obj_of, read_mesh
from hunav_drake.systems.world.obstacles import Obstacles, inside
from hunav_drake.systems.world.shapes import Model, World
from tests.systems.common.models.gazebo_files import (
    BOX,
    block,
    dae,
    extruded,
    mesh,
    model,
    obj,
    room,
    sdf,
    stl,
    world,
)

CUBE = block((0, 0, 0), (1, 1, 1))


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("HUNAV_CACHE", str(folder))
    return folder


@pytest.fixture
def write(tmp_path):
    """Writes a text below the folder of the test; returns the path."""

    def write(name: str, text: str | bytes):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        data = text if isinstance(text, bytes) else text.encode()
        path.write_bytes(data)
        return path

    return write


def obstacles(path, **options) -> Obstacles:
    return World(models=[Model(file=str(path), **options)]).obstacles()


def is_inside(found: Obstacles, *points) -> list[bool]:
    return inside(found, np.array(points, dtype=float)).any(axis=-1).tolist()


def extent(found: Obstacles) -> list[float]:
    ends = found.segments.reshape(-1, 2)
    return [*ends.min(axis=0).tolist(), *ends.max(axis=0).tolist()]


def include(uri: str, more: str = "") -> str:
    return f"<include><uri>{uri}</uri>{more}</include>"


@pytest.mark.parametrize("version", ["1.4", "1.5", "1.6", "1.7", "1.8", "1.9"])
def test_a_model_beside_the_world_is_found_by_its_name(version, write):
    write(
        "models/shelf/model.config",
        '<model><sdf version="1.4">old.sdf</sdf>'
        '<sdf version="1.9">new.sdf</sdf></model>',
    )
    write("models/shelf/old.sdf", "<sdf")
    write("models/shelf/new.sdf", sdf(model(more="<pose>1 0 0.5 0 0 0</pose>")))
    shelf = include("model://shelf", "<name>a</name><pose>3 1 0.5 0 0 0</pose>")
    text = world(include("model://sun") + shelf, version)
    path = write("worlds/hall.world", text)
    # The pose of an include replaces that of the model.
    assert extent(obstacles(path)) == pytest.approx([2.5, 0.5, 3.5, 1.5])
    assert extent(obstacles(path, pose=(1, 0, np.pi / 2))) == pytest.approx(
        [-0.5, 2.5, 0.5, 3.5]
    )


def test_poses_of_nested_models_links_and_frames_are_joined(write):
    inner = model(more="<pose>1 0 0 0 0 0</pose>", name="inner")
    outer = (
        '<model name="outer"><pose>0 2 0.5 0 0 1.5707963267948966</pose>'
        f'<frame name="f"><pose>10 0 0 0 0 0</pose></frame>{inner}'
        '<link name="far"><pose relative_to="f" degrees="true">1 0 0 0 0 90'
        f'</pose><collision name="c">{BOX}</collision></link></model>'
    )
    found = read_gazebo(write("a.sdf", world(outer, "1.8")))
    places = {
        it.name: it.X_WG.translation().tolist() for it in found.collisions
    }
    assert places["outer::inner::l::c"] == pytest.approx([0, 3, 0.5])
    assert places["outer::far::c"] == pytest.approx([0, 13, 0.5])


# The collision shape of a link, one with a pose, and a model with a frame.
SHAPE = f'<collision name="c">{BOX}</collision>'
LINK = f'<link name="l"><pose>1 0 0 0 0 0.3</pose>{SHAPE}</link>'
FRAME = '<frame name="f"><pose>0 2 0 0 0 1</pose></frame>'
OF_FRAMES = {
    "a shape in another link": f"""<model name="m"><pose>4 5 0 0 0 1</pose>
        <link name="k"><pose>0 3 0 0 0 2</pose><collision name="c">
        <pose relative_to="l">1 0 0 0 0 0</pose>{BOX}</collision></link>{LINK}
        </model>""",
    "a shape in its model": f"""<model name="m"><pose>4 5 0 0 0 1</pose>
        <link name="k"><pose>0 3 0 0 0 2</pose><collision name="c">
        <pose relative_to="__model__">1 0 0 0 0 0</pose>{BOX}</collision></link>
        </model>""",
    "beside a model placed by a frame": f"""
        <model name="a" placement_frame="f"><pose>3 0 0 0 0 0.5</pose>{FRAME}
        {LINK}</model><model name="b"><pose relative_to="a">1 2 0 0 0 0</pose>
        {LINK}</model>""",
    "beside a link of a model": f"""<model name="a"><pose>3 0 0 0 0 0.5</pose>
        {LINK}</model><model name="b"><pose relative_to="a::l">1 2 0 0 0 0
        </pose>{LINK}</model>""",
    "placed by a frame of a model in it": f"""
        <model name="m" placement_frame="i::l"><pose>3 0 0 0 0 0.5</pose>
        <model name="i"><pose>0 4 0 0 0 0</pose>{LINK}</model>{LINK}</model>""",
}


@pytest.mark.parametrize("text", OF_FRAMES.values(), ids=OF_FRAMES)
def test_shapes_are_where_drake_has_them(text, write):
    path = write("a.sdf", world(text, "1.9"))
    assert placed(path) == placed_by_drake(path)


def placed(path) -> list:
    """Returns the sorted poses of all collision shapes."""
    return sorted(
        it.X_WG.GetAsMatrix34().round(9).tolist()
        for it in read_gazebo(path).collisions
    )


def placed_by_drake(path, models=None) -> list:
    """Returns the same as Drake reads it; `models` lies beside the models."""
    plant = MultibodyPlant(0.0)
    scene_graph = SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    parser = Parser(plant)
    if models is not None:
        for folder in models.parent.iterdir():
            if folder.is_dir():
                parser.package_map().Add(folder.name, str(folder))
    parser.AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    inspector = scene_graph.model_inspector()
    return sorted(
        (
            plant.get_body(it).EvalPoseInWorld(context)
            @ inspector.GetPoseInFrame(geometry)
        )
        .GetAsMatrix34()
        .round(9)
        .tolist()
        for it in map(BodyIndex, range(1, plant.num_bodies()))
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(it))
    )


def include_of(name: str, more: str = "") -> str:
    return include("model://box/model.sdf", f"<name>{name}</name>{more}")


OF_INCLUDES = {
    "beside an include": f"""{include_of("a", "<pose>3 0 0 0 0 1</pose>")}
        <model name="b"><pose relative_to="a">1 2 0 0 0 0</pose>{LINK}</model>
        """,
    "an include beside a model": f"""<model name="b"><pose>3 0 0 0 0 1</pose>
        {LINK}</model>{
        include_of("a", '<pose relative_to="b">1 2 0 0 0 0</pose>')
    }""",
    "an include in a model": f"""<model name="m"><pose>4 5 0 0 0 1</pose>
        {include_of("a", "<pose>0 3 0 0 0 1</pose>")}<link name="k">
        <pose relative_to="a::l">1 0 0 0 0 0</pose>{SHAPE}</link></model>""",
}


@pytest.mark.parametrize("text", OF_INCLUDES.values(), ids=OF_INCLUDES)
def test_included_models_are_where_drake_has_them(text, write):
    write(
        "models/box/model.config",
        '<model><name>box</name><sdf version="1.9">model.sdf</sdf></model>',
    )
    write(
        "models/box/model.sdf",
        f'<sdf version="1.9"><model name="box">{LINK}</model></sdf>',
    )
    path = write("a.sdf", world(text, "1.9"))
    assert placed(path) == placed_by_drake(
        path, write("models/package.xml", "")
    )


def test_a_place_by_a_model_that_is_missing_is_kept(write):
    text = (
        include("model://gone", "<name>g</name><pose>3 0 0 0 0 0</pose>")
        + '<model name="b"><pose relative_to="g">1 0 0 0 0 0</pose>'
        + f"{LINK}</model>"
    )
    path = write("a.world", world(text, "1.9"))
    (found,) = read_gazebo(path, skip_missing=True).collisions
    assert found.X_WG.translation() == pytest.approx([5, 0, 0])


def test_a_state_has_new_models_and_not_those_deleted(write):
    state = (
        '<state world_name="w"><deletions><name>a</name></deletions>'
        f"<insertions>{model(name='b')}</insertions>"
        '<model name="b"><pose>5 5 0.5 0 0 0</pose></model></state>'
    )
    path = write("a.world", world(model(name="a") + state))
    assert extent(obstacles(path)) == pytest.approx([4.5, 4.5, 5.5, 5.5])


@pytest.mark.parametrize(
    ("shape", "reach"),
    [
        ("<cylinder><radius>1</radius><length>1</length></cylinder>", 3),
        ("<sphere><radius>1</radius></sphere>", 4),
        ("<ellipsoid><radii>1 1 1</radii></ellipsoid>", 2),
    ],
)
def test_a_round_shape_stays_round_by_the_scale_of_a_state(shape, reach, write):
    """The largest factor counts, as in Gazebo."""
    state = (
        '<state world_name="w"><model name="a"><pose>0 0 1 0 0 0</pose>'
        "<scale>2 3 4</scale></model></state>"
    )
    text = model(f"<geometry>{shape}</geometry>", name="a")
    path = write("a.world", world(text + state))
    assert extent(obstacles(path))[2] == pytest.approx(reach, rel=0.02)


def test_a_cone_is_narrower_farther_up(write):
    cone = "<cone><radius>2</radius><length>4</length></cone>"
    text = model(
        f"<geometry>{cone}</geometry>", more="<pose>1 0 2 0 0 0</pose>"
    )
    found = World(models=[Model(file=str(write("a.world", world(text))))])
    for height in (0.5, 1.0, 3.0):
        radius = 2 - height / 2
        expected = [1 - radius, -radius, 1 + radius, radius]
        cut = extent(found.obstacles_at(height))
        assert cut == pytest.approx(expected, abs=0.003)


def test_a_comment_may_have_dashes_and_space_come_first(write):
    """Gazebo reads these; lines of faults stay those of the file."""
    text = "\n " + world("<!--\ngz sim -v 4 --levels\n-->\n" + model())
    assert len(obstacles(write("a.world", text))) == 1
    path = write("b.world", text.replace("1 1 1", "1 1"))
    with pytest.raises(ModelFault, match=r"b\.world:9: <size> must be 3"):
        read_gazebo(path)


def test_the_state_of_a_world_is_where_things_stand(write):
    state = (
        '<state world_name="w"><model name="a"><pose>5 5 0.5 0 0 0</pose>'
        '<scale>2 1 1</scale><link name="l"><pose>5 5 0.5 0 0 0</pose></link>'
        "</model></state>"
    )
    path = write("a.world", world(model(name="a") + state))
    assert extent(obstacles(path)) == pytest.approx([4, 4.5, 6, 5.5])


@pytest.mark.parametrize(
    ("name", "text", "size"),
    [
        ("cube.dae", dae(100 * CUBE), 1.0),
        ("cube.dae", dae(CUBE, '<unit meter="0.0254" name="inch"/>'), 0.0254),
        ("cube.stl", stl(CUBE), 1.0),
        ("cube.obj", obj(CUBE), 1.0),
    ],
    ids=["cm", "inch", "stl", "obj"],
)
def test_meshes_are_in_meters_seen_and_met(name, text, size, write):
    write(name, text)
    path = write("a.sdf", sdf(model(mesh(name, "<scale>40 40 40</scale>"))))
    found = obstacles(path)
    assert extent(found) == pytest.approx([0, 0, 40 * size, 40 * size])
    assert len(found) == 1
    (visual,) = read_gazebo(path).visuals
    file = obj_of(visual.shape)
    rows = [
        [float(word) for word in line.split()[1:]]
        for line in file.read_text().splitlines()
        if line.startswith("v ")
    ]
    assert np.ptp(rows, axis=0) == pytest.approx([size] * 3, abs=1e-4)


def test_a_building_of_one_mesh_has_rooms_and_doors(write):
    write("room.stl", stl(room()))
    path = write("a.sdf", sdf(model(mesh("room.stl"))))
    dut = World(models=[Model(file=str(path))])
    walls, door, middle = (2.1, 1.5), (2.1, 0), (0, 0)
    assert is_inside(dut.obstacles(), walls, door, middle) == [1, 0, 0]
    # The lintel begins at 2 m; below, the walls are the same at all heights.
    assert is_inside(dut.obstacles_at(2.2), walls, door) == [1, 1]
    assert is_inside(dut.sight_obstacles(), walls, door) == [1, 0]
    assert len(dut.obstacles_at(3)) == 0
    ways = shapely.MultiPolygon(
        [shapely.Polygon(it) for it in dut.fixtures()[0].footprints]
    ).buffer(0)
    assert ways.area == pytest.approx(4.4**2 - 4**2 - 0.2, abs=0.2)


def test_a_dented_closed_mesh_is_solid_and_an_open_one_hollow(write):
    """An L of one closed surface, and the same without its floor and lid."""
    corners = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
    sides = []
    for i, (x, y) in enumerate(corners):
        u, v = corners[(i + 1) % 6]
        sides += [[(x, y, 0), (u, v, 0), (u, v, 1)]]
        sides += [[(x, y, 0), (u, v, 1), (x, y, 1)]]
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    lids = [
        [(*corners[i], z) for i in three] for three in flat for z in (0.0, 1.0)
    ]
    inside_point, dent = (0.5, 0.5), (2, 2)
    for name, triangles, solid in (
        ("closed", sides + lids, [1, 0]),
        ("open", sides, [0, 0]),
    ):
        write(f"{name}.stl", stl(triangles))
        path = write(f"{name}.sdf", sdf(model(mesh(f"{name}.stl"))))
        assert is_inside(obstacles(path), inside_point, dent) == solid


ROOMS = {
    "a block with two rooms": (
        shapely.box(0, 0, 20, 10)
        - shapely.box(0.5, 0.5, 8, 9.5)
        - shapely.box(12, 0.5, 19.5, 9.5)
    ),
    "a thick wall around an arena": (
        shapely.box(0, 0, 20, 20) - shapely.box(1, 1, 19, 19)
    ),
    "a block around a corridor": (
        shapely.box(0, 0, 20, 20)
        - (shapely.box(4, 4, 16, 16) - shapely.box(7, 7, 13, 13))
    ),
}


@pytest.mark.parametrize("plan", ROOMS.values(), ids=ROOMS)
def test_rooms_in_a_closed_block_are_free_and_the_rest_is_solid(plan, write):
    parts = [extruded(it, 2.5) for it in shapely.get_parts(plan)]
    write("m.stl", stl(np.concatenate(parts)))
    path = write("a.sdf", sdf(model(mesh("m.stl"))))
    (fixture,) = World(models=[Model(file=str(path))]).fixtures()
    ways = shapely.union_all([*map(shapely.Polygon, fixture.footprints)])
    assert shapely.hausdorff_distance(ways, plan) < 0.03
    assert ways.area == pytest.approx(plan.area, abs=1.2)


def test_parts_of_a_mesh_that_overlap_are_both_solid(write):
    one = shapely.box(0, 0, 8, 8) - shapely.box(4, 4, 8, 8)
    other = shapely.box(0, 0, 8, 8) - shapely.box(5, 5, 8, 8)
    both = np.concatenate([extruded(one, 2.5), extruded(other, 2.0)])
    for mirror in (1, -1):
        write("m.stl", stl(both * [mirror, 1, 1]))
        path = write("a.sdf", sdf(model(mesh("m.stl"))))
        found = obstacles(path)
        points = [(2.0 * mirror, 2.0), (6.0 * mirror, 2.0)]
        assert is_inside(found, *points, (7 * mirror, 7)) == [1, 1, 0]


def test_a_block_with_two_sides_to_each_face_is_a_block(write):
    dented = shapely.box(0, 0, 3, 3) - shapely.box(1, 1, 3, 3)
    for plan, expected in ((shapely.box(0, 0, 3, 3), [1, 1]), (dented, [1, 0])):
        both = extruded(plan, 1.0)
        both = np.concatenate([both, both[:, ::-1]])
        write("m.stl", stl(both))
        path = write("a.sdf", sdf(model(mesh("m.stl"))))
        assert is_inside(obstacles(path), (0.5, 0.5), (2, 2)) == expected


def test_a_part_of_a_gltf_is_taken_by_its_node(write, tmp_path):
    scene = trimesh.Scene()
    for name, x in (("Wheel", 0), ("Body", 5)):
        box = trimesh.creation.box((1, 1, 1))
        box.apply_translation((x, 0, 0))
        scene.add_geometry(box, node_name=name, geom_name=f"mesh of {name}")
    scene.export(tmp_path / "m.glb")
    for part, low in (("Wheel", -0.5), ("Body", 4.5)):
        given = f"<submesh><name>{part}</name></submesh>"
        path = write("a.sdf", sdf(model(mesh("m.glb", given))))
        (collision,) = read_gazebo(path).collisions
        assert collision.shape.triangles[:, :, 0].min() == low


def test_a_mesh_in_millimeters_may_be_long(write):
    write("m.stl", stl(200_000 * CUBE))
    scaled = mesh("m.stl", "<scale>0.001 0.001 0.001</scale>")
    path = write("a.sdf", sdf(model(scaled)))
    assert extent(obstacles(path)) == pytest.approx([0, 0, 200, 200])


@pytest.mark.parametrize("thickness", [0.01, 0.04, 0.06])
def test_the_door_of_a_thin_wall_is_open(thickness, write):
    front = shapely.box(0, 0, 10, 3) - shapely.box(4, -1, 5, 2.1)
    wall = extruded(front, thickness)[:, :, [0, 2, 1]]
    write("m.stl", stl(wall))
    path = write("a.sdf", sdf(model(mesh("m.stl"))))
    y = thickness / 2
    assert is_inside(obstacles(path), (2, y), (4.5, y), (7, y)) == [1, 0, 1]


def test_a_part_has_the_name_of_its_node_or_object(write):
    text = dae(CUBE, "", name="geom", node="Wheel")
    both = text.replace(
        "</visual_scene>",
        '<node id="o" name="Body"><translate>5 0 0</translate>'
        '<instance_geometry url="#geom"/></node></visual_scene>',
    )
    write("m.dae", both)
    lines = obj(CUBE) + "o Body\nv 5 0 0\nv 6 0 0\nv 5 1 1\nf 37 38 39\n"
    write("m.obj", "o Wheel\n" + lines)
    for name in ("m.dae", "m.obj"):
        for part, low in (("Wheel", 0), ("Body", 5)):
            given = f"<submesh><name>{part}</name></submesh>"
            path = write("a.sdf", sdf(model(mesh(name, given))))
            (collision,) = read_gazebo(path).collisions
            x = collision.shape.triangles[:, :, 0]
            assert (x.min(), x.max()) == (low, low + 1)


def test_a_part_of_a_mesh_is_taken_by_its_name_and_centered(write):
    write("a.dae", dae(100 * CUBE, name="body", node="trunk"))
    part = "<submesh><name>body</name><center>true</center></submesh>"
    path = write("a.sdf", sdf(model(mesh("a.dae", part))))
    assert extent(obstacles(path)) == pytest.approx([-0.5, -0.5, 0.5, 0.5])
    wrong = part.replace("body", "head")
    path = write("b.sdf", sdf(model(mesh("a.dae", wrong))))
    with pytest.raises(ModelFault, match=r"no part 'head'.*it has trunk"):
        read_gazebo(path)


def test_what_is_not_to_be_seen_shows_what_one_meets_and_the_reverse(write):
    write("a.stl", stl(CUBE))
    both = model().replace(
        f'<visual name="v">{BOX}', f'<visual name="v">{mesh("no.dae")}'
    )
    found = read_gazebo(write("v.sdf", sdf(both)))
    assert found.visuals[0].shape is found.collisions[0].shape
    assert "v.sdf:5: <mesh>: there is no file 'no.dae'" in found.losses[0]
    other = model(mesh("a.stl")).replace("a.stl", "no.stl", 1)
    path = write("c.sdf", sdf(other))
    assert extent(obstacles(path)) == pytest.approx([0, 0, 1, 1])
    assert "walk around what is shown" in read_gazebo(path).losses[0]


def test_what_has_no_meaning_is_noted_and_what_moves_stands(write):
    plane = model("<geometry><plane><size>9 9</size></plane></geometry>", "p")
    ball = model(name="ball").replace(
        "<static>1</static>", "<pose>1 1 1 0 0 0</pose>"
    )
    hill = model(
        "<geometry><heightmap><uri>a.png</uri></heightmap></geometry>", "h"
    )
    wall = model(
        "<geometry><plane><normal>1 0 0</normal></plane></geometry>", "q"
    )
    text = world(f'<light name="l"/><physics/>{plane}{hill}{wall}{ball}')
    found = read_gazebo(write("a.world", text))
    assert len(found.collisions) == 1
    notes = "\n".join(found.notes)
    assert "1 <light>" in notes
    assert "1 models that could move stand still: ball" in notes
    first, second = found.losses
    assert "<heightmap> is left out" in first
    assert "<plane> is left out" in second


@pytest.mark.parametrize(
    ("normal", "roll", "is_floor"),
    [
        ("0 0 1", 0.0, True),
        ("0 0 -2", 0.1, True),
        ("0 0 1", 1.5707963, False),
        ("0 1 0", 1.5707963, True),
        ("0 0 1", 0.3, False),
    ],
)
def test_planes_are_floors_where_they_are_level(write, normal, roll, is_floor):
    shape = f"<geometry><plane><normal>{normal}</normal></plane></geometry>"
    pose = f"<pose>0 0 0 {roll} 0 0</pose>"
    path = write("a.world", world(model() + model(shape, "p", more=pose)))
    assert bool(read_gazebo(path).losses) is not is_floor


def test_what_fell_out_of_the_world_is_lost(write):
    far = model(name="b", more="<pose>0 0 -7e8 0 0 0</pose>")
    link = model(name="c").replace("<coll", "<pose>1e6 0 0 0 0 0</pose><coll")
    text = world(model() + far + link)
    found = read_gazebo(write("a.world", text))
    assert len(found.collisions) == 1
    for name, loss in zip("bc", found.losses, strict=True):
        assert f"{name} is left out, as it is farther than 100000 m" in loss


@pytest.mark.parametrize(
    "uri",
    [
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Sun/3",
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground%20Plane",
        "model://ground_plane/model.sdf",
        "model://sun/",
    ],
)
def test_sun_and_ground_are_never_needed(uri, write):
    found = read_gazebo(write("a.world", world(include(uri) + model())))
    assert len(found.collisions) == 1


def test_the_version_of_a_model_of_fuel_is_that_asked_for(
    write, tmp_path, monkeypatch
):
    monkeypatch.setenv("GZ_FUEL_CACHE_PATH", str(tmp_path / "fuel"))
    place = "fuel/fuel.gazebosim.org/open robotics/models/my table"
    for version in (2, 10):
        size = BOX.replace("1 1 1", f"{version} 1 2")
        write(f"{place}/{version}/model.sdf", sdf(model(size)))
    base = "https://fuel.gazebosim.org/1.0/Open%20Robotics/models/My%20Table"
    for end, width in (("", 10), ("/2", 2), ("/tip", 10)):
        path = write("a.world", world(include(base + end)))
        x0, _, x1, _ = extent(obstacles(path))
        assert x1 - x0 == pytest.approx(width)
    with pytest.raises(ModelFault, match=r"no model 'My Table'.*/7`"):
        read_gazebo(write("a.world", world(include(base + "/7"))))


@pytest.mark.parametrize("given", ["field", "GAZEBO_MODEL_PATH", "fuel"])
def test_models_elsewhere_are_found(given, write, tmp_path, monkeypatch):
    uri, options = "model://rack", {}
    if given == "fuel":
        monkeypatch.setenv("HOME", str(tmp_path / "home"))
        uri = "https://fuel.gazebosim.org/1.0/Ann/models/A Rack"
        cache = "home/.gz/fuel/fuel.gazebosim.org/ann/models/a rack"
        write(f"{cache}/2/model.sdf", "<sdf")
        write(f"{cache}/10/model.sdf", sdf(model()))
    else:
        write("else/rack/model.sdf", sdf(model()))
        if given == "field":
            options["model_path"] = [str(tmp_path / "else")]
        else:
            monkeypatch.setenv(given, f"/nowhere:{tmp_path / 'else'}")
    path = write("w/a.world", world(include(uri, "<pose>2 0 1 0 0 0</pose>")))
    assert extent(obstacles(path, **options)) == pytest.approx(
        [1.5, -0.5, 2.5, 0.5]
    )


def test_a_world_of_a_package_is_found(write, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    write("halls/package.xml", "<package><name>halls</name></package>")
    write("halls/worlds/hall.world", world(model()))
    found = obstacles("package://halls/worlds/hall.world")
    assert extent(found) == pytest.approx([-0.5, -0.5, 0.5, 0.5])


def test_missing_models_are_faults_unless_they_are_skipped(write):
    inner = include("model://rak") + include("model://rak") + model()
    write("models/rack/model.sdf", sdf(model()))
    path = write("a.world", world(inner))
    with pytest.raises(
        ModelFault, match=r"a.world:4 and 1 more: <include>"
    ) as info:
        read_gazebo(path)
    for words in ("'rak'", "did you mean 'rack'?", "git clone", "--model-path"):
        assert words in str(info.value)
    found = read_gazebo(path, skip_missing=True)
    assert len(found.collisions) == 1
    assert len(found.losses) == 1


def test_missing_meshes_are_faults_unless_they_are_skipped(write):
    """A world that Gazebo saved has its models, not their meshes."""
    inner = model(mesh("no.dae")) + model(name="other")
    path = write("a.world", world(inner))
    with pytest.raises(ModelFault, match=r"a.world:5: <mesh>: there is no "):
        read_gazebo(path)
    found = read_gazebo(path, skip_missing=True)
    assert len(found.collisions) == len(found.visuals) == 1
    assert any("it is left out" in line for line in found.losses)
    write("bad.dae", "no mesh")
    path = write("b.world", world(model(mesh("bad.dae"))))
    with pytest.raises(ModelFault, match=r"bad.dae cannot be read"):
        read_gazebo(path, skip_missing=True)


def test_what_was_read_is_kept_until_a_file_changes(write, cache, monkeypatch):
    path = write("a.stl", stl(CUBE))
    first = read_mesh(path).triangles
    mesh_files._read.cache_clear()
    monkeypatch.setattr(mesh_files, "_load", None)
    np.testing.assert_array_equal(read_mesh(path).triangles, first)
    monkeypatch.undo()
    monkeypatch.setenv("HUNAV_CACHE", str(cache))
    os.utime(write("a.stl", stl(2 * CUBE)), (1, 1))
    assert np.ptp(read_mesh(path).triangles) == 2.0
    # What is damaged on the disk is made again.
    for file in cache.glob("*.npy"):
        file.write_bytes(b"no array")
    mesh_files._read.cache_clear()
    assert np.ptp(read_mesh(path).triangles) == 2.0


@pytest.mark.parametrize("version", ["1.6", "1.9"])
def test_drake_reads_what_it_can_read(version, write):
    assert not is_gazebo_file(write("a.sdf", sdf(model(), version)))
    assert is_gazebo_file(write("b.sdf", world(model(), version)))
    assert not is_gazebo_file("package://nowhere/a.sdf")


def test_walls_that_joints_hold_in_a_loop_are_read(write):
    links = "".join(
        f'<link name="l{i}"><pose>{2 * i} 0 0.5 0 0 0</pose>{SHAPE}</link>'
        for i in range(3)
    )
    joints = "".join(
        f'<joint name="{i}" type="fixed"><parent>l{i}</parent>'
        f"<child>l{(i + 1) % 3}</child></joint>"
        for i in range(3)
    )
    text = sdf(f'<model name="m"><static>1</static>{links}{joints}</model>')
    found = obstacles(write("a.sdf", text))
    assert extent(found) == pytest.approx([-0.5, -0.5, 4.5, 0.5])


def scenario_text(path, **more) -> str:
    return yaml.safe_dump(
        {
            "world": {"models": [{"file": str(path), **more}]},
            "humans": [{"pose": [0.0, 0.0, 0.0], "goals": [[4.0, 0.0]]}],
            "robot": {"start": [5.0, 4.0, 0.0]},
            "simulation": {"duration": 6.0},
        }
    )


def test_a_person_leaves_a_room_by_its_door(write, tmp_path):
    write("models/room/meshes/room.dae", dae(100 * room()))
    uri = "model://room/meshes/room.dae"
    write("models/room/model.sdf", sdf(model(mesh(uri))))
    path = write("a b/hall ü.world", world(include("model://room")))
    file = write(
        "s.yaml", scenario_text("a b/hall ü.world", model_path=["models"])
    )
    scenario = LoadScenario(filename=file)
    assert scenario.world.models[0].model_path == [str(tmp_path / "models")]
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    way = RunTrial(scenario).recording.humans[:, 0, :2]
    np.testing.assert_allclose(way[-1], [4.0, 0.0], atol=0.4)
    names = {it.name for it in named_files(scenario)}
    assert names == {path.name, "model.sdf", "room.dae"}


CYCLE = include("model://a")
NAN = stl(CUBE).replace("vertex 1", "vertex nan", 1)
BAD_INDEX = obj(CUBE) + "f 1 2 999999999\n"

# The content of a world, a file that it names, and what the fault says.
DAMAGED = {
    "truncated": (world(model())[:-30], {}, "Error parsing XML"),
    "no world": (sdf("<light name='l'/>"), {}, "neither <world> nor <model>"),
    "no sdf": ("<robot/>", {}, "must be <sdf>"),
    "words for numbers": (
        *(world(model().replace("1 1 1", "1 one 1")), {}),
        "a.world:5: <size> must be 3 finite numbers, got '1 one 1'",
    ),
    "too few numbers": (
        *(world(model(more="<pose>1 2 3</pose>")), {}),
        "<pose> must be 6 finite numbers",
    ),
    "infinite": (
        *(world(model(more="<pose>inf 0 0 0 0 0</pose>")), {}),
        "<pose> must be 6 finite",
    ),
    "negative size": (
        world(model().replace("1 1", "-1 1")),
        {},
        "<size> must be in",
    ),
    "no shape": (world(model("<geometry/>")), {}, "must have one of box"),
    "zero scale": (
        world(model(mesh("m.stl", "<scale>0 1 1</scale>"))),
        {"m.stl": stl(CUBE)},
        "<scale> must not be 0",
    ),
    "missing mesh": (
        world(model(mesh("m.stl"))),
        {},
        "there is no file 'm.stl'",
    ),
    "windows path": (
        *(world(model(mesh(r"C:\models\m.stl"))), {}),
        "there is no file 'C:/models/m.stl'",
    ),
    "empty mesh": (
        *(world(model(mesh("m.stl"))), {"m.stl": "solid s\nendsolid s\n"}),
        "m.stl (has no triangles|cannot be read)",
    ),
    "binary mesh": (
        *(world(model(mesh("m.dae"))), {"m.dae": b"\x00\xff" * 50}),
        "m.dae cannot be read",
    ),
    "NaN corner": (
        *(world(model(mesh("m.stl"))), {"m.stl": NAN}),
        "corners that are not finite",
    ),
    "huge index": (
        *(world(model(mesh("m.obj"))), {"m.obj": BAD_INDEX}),
        "m.obj cannot be read|no triangles|not finite",
    ),
    "far corner": (
        *(world(model(mesh("m.stl"))), {"m.stl": stl(1e9 * CUBE)}),
        "farther than 100000 m",
    ),
    "huge scale": (
        world(model(mesh("m.stl", "<scale>9000 1 1</scale>"))),
        {"m.stl": stl(100 * CUBE)},
        "a.world:5: the mesh reaches farther than 100000 m",
    ),
    "unknown unit": (
        world(model(mesh("m.dae"))),
        {"m.dae": dae(CUBE, '<unit meter="ell"/>')},
        "must have a unit above 0 m, got .ell",
    ),
    "negative unit": (
        world(model(mesh("m.dae"))),
        {"m.dae": dae(CUBE, '<unit meter="-1"/>')},
        "must have a unit above 0 m",
    ),
    "truncated mesh": (
        *(world(model(mesh("m.dae"))), {"m.dae": dae(CUBE)[:900]}),
        "m.dae cannot be read",
    ),
    "other format": (
        world(model(mesh("m.fbx"))),
        {"m.fbx": "x"},
        "must be one of",
    ),
    "cycle": (
        world(CYCLE),
        {"models/a/model.sdf": sdf(f'<model name="a">{CYCLE}</model>')},
        "model.sdf -> model.sdf: includes itself",
    ),
    "frames in a circle": (
        world(
            '<model name="m"><frame name="f" attached_to="f"/><link name="l">'
            f'<pose relative_to="f"/><collision name="c">{BOX}</collision>'
            "</link></model>"
        ),
        {},
        "the frame 'f' leads back to itself",
    ),
    "unknown frame": (
        *(world(model(more='<pose relative_to="q">0 0 0 0 0 0</pose>')), {}),
        "the frame 'q' is not in the model",
    ),
    "tiny scale": (
        world(model(mesh("m.stl", "<scale>1e-9 1 1</scale>"))),
        {"m.stl": stl(CUBE)},
        "a.world:5: the sizes of <mesh>.* must be in .1e-06, 10000., got 1e-09",
    ),
    "many models": (
        world(include("models/a0")),
        {
            f"models/a{i}/model.sdf": sdf(
                f'<model name="m">{include(f"../a{i + 1}") * 10}</model>'
            )
            for i in range(9)
        }
        | {"models/a9/model.sdf": sdf('<model name="m"/>')},
        "must have at most 10000 models",
    ),
    "models in models": (
        world(include("models/a0")),
        {
            f"models/a{i}/model.sdf": sdf(
                "<model name='a'>" * 60
                + include(f"../a{i + 1}")
                + "</model>" * 60
            )
            for i in range(3)
        }
        | {"models/a3/model.sdf": sdf(model())},
        "100 in each other",
    ),
    "deep": (
        world("<model name='a'>" * 150 + "</model>" * 150),
        {},
        "in more than",
    ),
    "entity": (
        *('<!DOCTYPE a [<!ENTITY b "c">]>' + sdf("&b;"), {}),
        "declares an entity",
    ),
}


@pytest.mark.parametrize(
    ("text", "files", "words"), DAMAGED.values(), ids=DAMAGED
)
def test_a_damaged_file_is_one_fault(text, files, words, write):
    path = write("a.world", text)
    for name, content in files.items():
        write(name, content)
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(data=scenario_text(path))
    (fault,) = info.value.faults
    assert fault.path == "world.models[0].file"
    assert fault.message.startswith(str(path))
    assert "\n" not in fault.message


def test_a_loop_of_links_and_another_case_do_no_harm(write, tmp_path):
    write("models/rack/meshes/Cube.STL", stl(CUBE))
    (tmp_path / "models/rack/again").symlink_to(tmp_path / "models")
    (tmp_path / "loop.stl").symlink_to(tmp_path / "loop.stl")
    text = sdf(model(mesh("model://rack/meshes/cube.stl")))
    write("models/rack/model.sdf", text)
    path = write("a.world", world(include("model://rack")))
    assert extent(obstacles(path)) == pytest.approx([0, 0, 1, 1])
    path = write("b.world", world(model(mesh("loop.stl"))))
    with pytest.raises(ModelFault, match=r"no file 'loop.stl'|loop"):
        read_gazebo(path)
