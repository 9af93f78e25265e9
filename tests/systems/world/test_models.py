"""Worlds of models of files."""

import math

import jsonschema
import numpy as np
from pydrake.geometry import Role
import pytest
import shapely
import yaml

from hunav_drake import (
    HumanConfig,
    LoadScenario,
    MakeTrialDiagram,
    RunTrial,
    SaveScenario,
    Scenario,
    ScenarioError,
)
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.systems.world.shapes import Model, World
from hunav_drake.systems.world.solids import WorldFileError

SDF = """<?xml version="1.0"?>
<sdf version="1.9"><model name="thing">{static}<link name="body">
<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
</inertial>
{parts}
</link></model></sdf>
"""
BOX = "<box><size>2 1 1</size></box>"


def write_sdf(folder, *parts, name="thing", static=False):
    """Writes a model of parts: geometries, each with its pose."""
    text = "".join(
        f'<{role} name="{role}_{i}"><pose>{pose}</pose>'
        f"<geometry>{geometry}</geometry></{role}>"
        for i, (geometry, pose) in enumerate(parts)
        for role in ("collision", "visual")
    )
    path = folder / f"{name}.sdf"
    fixed = "<static>true</static>" if static else ""
    path.write_text(SDF.format(parts=text, static=fixed))
    return path


def area(obstacles: Obstacles) -> float:
    """The area of all shapes, which must not overlap."""
    x0, y0, x1, y1 = obstacles.segments.T
    return float(np.sum(x0 * y1 - x1 * y0)) / 2


def world(path, pose=(0.0, 0.0, 0.0)):
    return World(models=[Model(file=str(path), pose=pose)])


def test_a_box_is_a_rectangle_where_it_stands(tmp_path):
    path = write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0"))
    dut = world(path, (3.0, 1.0, math.pi / 2))
    for obstacles in (dut.obstacles(), dut.obstacles_at(0.5)):
        low = obstacles.segments[:, :2].min(axis=0)
        high = obstacles.segments[:, :2].max(axis=0)
        np.testing.assert_allclose(low, [2.5, 0.0], atol=1e-12)
        np.testing.assert_allclose(high, [3.5, 2.0], atol=1e-12)
    # It is 1 m high.
    assert len(dut.sight_obstacles()) == 0


@pytest.mark.parametrize(
    ("geometry", "expected", "tolerance"),
    [
        (
            "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
            math.pi * 0.25,
            1e-6,
        ),
        ("<sphere><radius>0.5</radius></sphere>", math.pi * 0.25, 1e-6),
        (
            "<capsule><radius>0.3</radius><length>0.4</length></capsule>",
            math.pi * 0.09,
            1e-6,
        ),
        (
            "<ellipsoid><radii>0.5 0.2 0.3</radii></ellipsoid>",
            math.pi * 0.1,
            1e-6,
        ),
    ],
)
def test_what_is_round_has_its_area(tmp_path, geometry, expected, tolerance):
    path = write_sdf(tmp_path, (geometry, "0 0 0.7 0 0 0"))
    found = area(world(path).obstacles())
    assert found == pytest.approx(expected, rel=tolerance)
    assert area(world(path).obstacles_at(0.7)) == pytest.approx(found)


def test_a_sphere_is_narrower_above_its_middle(tmp_path):
    ball = "<sphere><radius>0.5</radius></sphere>"
    dut = world(write_sdf(tmp_path, (ball, "0 0 0.5 0 0 0")))
    for height in (0.1, 0.3, 0.8):
        r2 = 0.25 - (height - 0.5) ** 2
        cut = area(dut.obstacles_at(height))
        assert cut == pytest.approx(math.pi * r2, rel=0.12)


def test_what_one_walks_under_or_over_is_in_nobodys_way(tmp_path):
    path = write_sdf(
        tmp_path,
        ("<box><size>4 4 0.04</size></box>", "0 0 0.02 0 0 0"),
        (BOX, "0 0 2.4 0 0 0"),
        ("<box><size>0.2 0.2 2</size></box>", "1.5 0 1 0 0 0"),
    )
    dut = world(path)
    assert area(dut.obstacles()) == pytest.approx(0.04)
    assert area(dut.sight_obstacles()) == pytest.approx(0.04)
    assert area(dut.obstacles_at(2.3)) == pytest.approx(2.0)


def test_a_slanted_box_is_cut_at_walking_height(tmp_path):
    beam = "<box><size>0.2 0.2 4</size></box>"
    path = write_sdf(tmp_path, (beam, "0 0 1 0 0.7853981633974483 0"))
    x = world(path).obstacles().segments[:, [0, 2]]
    # Its axis is at x = z - 1; half its width along x is 0.1 sqrt(2).
    half = 0.1 * math.sqrt(2)
    assert x.min() == pytest.approx(0.05 - 1 - half)
    assert x.max() == pytest.approx(1.8 - 1 + half)


def test_a_mesh_counts_as_its_hull(tmp_path):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(1, 3, 2), (1, 2, 4), (2, 3, 4), (1, 4, 3)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "tent.obj").write_text("\n".join(lines) + "\n")
    mesh = "<mesh><uri>tent.obj</uri></mesh>"
    dut = world(write_sdf(tmp_path, (mesh, "0 0 0 0 0 0")))
    assert area(dut.obstacles()) == pytest.approx(0.5 * 0.95**2)
    assert area(dut.obstacles_at(0.5)) == pytest.approx(0.5 * 0.5**2)


def test_directives_and_urdf_are_read(tmp_path):
    write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0"))
    directives = {
        "directives": [
            {
                "add_model": {
                    "name": "rack",
                    "file": f"file://{tmp_path}/thing.sdf",
                }
            },
            {
                "add_weld": {
                    "parent": "world",
                    "child": "rack::body",
                    "X_PC": {"translation": [5.0, 0.0, 0.0]},
                }
            },
        ]
    }
    path = tmp_path / "hall.dmd.yaml"
    path.write_text(yaml.safe_dump(directives))
    segments = world(path).obstacles().segments
    assert segments[:, 0].min() == pytest.approx(4.0)
    urdf = tmp_path / "post.urdf"
    urdf.write_text(
        '<robot name="post"><link name="base"><collision><origin xyz="0 0 1"/>'
        '<geometry><box size="0.2 0.4 2"/></geometry></collision></link>'
        "</robot>"
    )
    assert area(world(urdf, (1.0, 1.0, 0.3)).obstacles()) == pytest.approx(0.08)


def text_of(path, **more):
    return yaml.safe_dump(
        {
            "world": {"models": [{"name": "rack", "file": path, **more}]},
            "humans": [{"pose": [-3.0, 0.2, 0.0], "goals": [[3.0, 0.2]]}],
            "robot": {"start": [0.0, -4.0, 0.0]},
            "simulation": {"duration": 12.0},
        }
    )


def test_people_walk_around_it_and_it_is_in_the_scene(tmp_path):
    write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0"))
    file = tmp_path / "scenario.yaml"
    file.write_text(text_of("thing.sdf", pose=[0.0, 0.0, 1.57]))
    scenario = LoadScenario(filename=file)
    assert scenario.world.models[0].file == str(tmp_path / "thing.sdf")
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    way = RunTrial(scenario).recording.humans[:, 0, :2]
    np.testing.assert_allclose(way[-1], [3.0, 0.2], atol=0.35)
    assert np.abs(way[np.abs(way[:, 0]) < 0.4, 1]).min() > 1.0
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    query = diagram.GetOutputPort("query").Eval(context)
    inspector = query.inspector()
    (visual,) = (
        it
        for it in inspector.GetAllGeometryIds(Role.kIllustration)
        if "visual_0" in inspector.GetName(it)
    )
    X_WG = query.GetPoseInWorld(visual)
    np.testing.assert_allclose(X_WG.translation(), [0, 0, 0.5], atol=1e-12)


def test_bodies_must_be_clear_of_it(tmp_path):
    path = write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0"))
    text = text_of(str(path), pose=[-3.0, 0.0, 0.0])
    with pytest.raises(ScenarioError) as info:
        LoadScenario(data=text)
    (fault,) = info.value.faults
    assert fault.path == "humans[0].pose"
    assert "is inside world.models[0] ('rack'); move it 0.65 m" in fault.message


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "there is no file"),
        ("<sdf", "Error parsing XML"),
        ("<sdf version='1.9'><model name='a'/></sdf>", "link"),
        (SDF.format(static="", parts=""), "must have collision geometry"),
    ],
)
def test_a_faulty_model_is_one_fault(tmp_path, content, words):
    path = tmp_path / "bad.sdf"
    if content is not None:
        path.write_text(content)
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(data=text_of(str(path)))
    (fault,) = info.value.faults
    assert fault.path == "world.models[0] ('rack').file"
    assert fault.message.startswith(str(path))
    assert "\n" not in fault.message


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("package://nowhere/a.sdf", "there is no package 'nowhere'"),
        ("package://hunav_drake/a.sdf", "a.sdf"),
        ("thing.stl", "must be one of .sdf"),
    ],
)
def test_a_name_that_leads_nowhere_is_told(file, words):
    with pytest.raises(WorldFileError, match=words):
        world(file).obstacles()


def test_what_is_fixed_by_itself_takes_no_pose(tmp_path):
    path = write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0"), static=True)
    assert area(world(path).obstacles()) == pytest.approx(2.0)
    with pytest.raises(WorldFileError, match="leave pose out"):
        world(path, (1.0, 0.0, 0.0)).obstacles()


def test_footprints_are_valid_polygons(tmp_path):
    path = write_sdf(tmp_path, (BOX, "0.1 0.2 0.5 0.3 0.2 0.1"))
    dut = world(path).obstacles()
    assert shapely.Polygon(dut.segments[:, :2]).exterior.is_ccw


def test_the_json_schema_has_maps_and_models():
    validator = jsonschema.Draft202012Validator(scenario_json_schema())
    world = {"map": "a.yaml", "models": [{"file": "a.sdf", "pose": [1, 2, 3]}]}
    assert validator.is_valid({"world": world})
    for wrong in ({"map": 1}, {"models": [{"pose": [1, 2, 3]}]}):
        assert not validator.is_valid({"world": wrong})


@pytest.mark.parametrize("name", ["ana", "robot"])
def test_a_model_may_be_called_like_a_person_or_the_robot(name, tmp_path):
    text = write_sdf(tmp_path, (BOX, "0 0 0.5 0 0 0")).read_text()
    (tmp_path / "thing.sdf").write_text(text.replace("thing", name))
    place = world(tmp_path / "thing.sdf", (3.0, 0.0, 0.0))
    people = [HumanConfig(name="ana", pose=(0, 2, 0))]
    diagram = MakeTrialDiagram(Scenario(world=place, humans=people))
    context = diagram.CreateDefaultContext()
    query = diagram.GetOutputPort("query").Eval(context)
    geometries = query.inspector().GetAllGeometryIds(Role.kPerception)
    names = {query.inspector().GetName(it) for it in geometries}
    assert f"models_0_{name}::visual_0" in names


DOOR = """<sdf version="1.9"><model name="cupboard">
<link name="box"><collision name="c"><pose>0 0 0.5 0 0 0</pose>
<geometry><box><size>0.4 0.4 1</size></box></geometry></collision></link>
<link name="door"><pose>0.2 0 0.5 0 0 0</pose>
<collision name="c"><pose>0.5 0 0 0 0 0</pose>
<geometry><box><size>1 0.1 1</size></box></geometry></collision>
<visual name="v"><pose>0.5 0 0 0 0 0</pose>
<geometry><box><size>1 0.1 1</size></box></geometry></visual></link>
<joint name="hinge" type="revolute"><parent>box</parent><child>door</child>
<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>
"""


def test_a_joint_is_seen_where_it_is_in_the_way(tmp_path):
    (tmp_path / "door.sdf").write_text(DOOR)
    file = tmp_path / "open.dmd.yaml"
    add = {"name": "cupboard", "file": f"file://{tmp_path}/door.sdf"}
    add |= {"default_joint_positions": {"hinge": [math.pi / 2]}}
    weld = {"parent": "world", "child": "cupboard::box"}
    weld |= {"X_PC": {"translation": [3, 0, 0]}}
    directives = [{"add_model": add}, {"add_weld": weld}]
    file.write_text(yaml.safe_dump({"directives": directives}))
    x, y = world(file).obstacles().segments.reshape(-1, 2).T
    assert (x.max(), y.max()) == pytest.approx((3.25, 1.0))
    diagram = MakeTrialDiagram(Scenario(world=world(file)))
    context = diagram.CreateDefaultContext()
    query = diagram.GetOutputPort("query").Eval(context)
    (door,) = (
        it
        for it in query.inspector().GetAllGeometryIds(Role.kPerception)
        if "cupboard" in query.inspector().GetName(it)
    )
    X_WG = query.GetPoseInWorld(door)
    np.testing.assert_allclose(X_WG.translation(), [3.2, 0.5, 0.5], atol=1e-9)
