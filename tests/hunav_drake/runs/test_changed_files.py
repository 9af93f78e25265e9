"""Runs of a map or a model that has changed since are not taken for its own."""

import os
from pathlib import Path

from PIL import Image
from pydantic.dataclasses import dataclass
import pytest

from hunav_drake import LoadScenario
from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.cells import make_cells
from hunav_drake.runs.tasks import Task, UnfitWorkerError, do_task
from hunav_drake.scenario.named_files import files_sha256, named_files
from hunav_drake.systems.planning import (
    Plan,
    Planner,
    PlannerStatus,
    register_planner,
)

SCENARIO = """
world: {map: maps/room.yaml, models: [{file: models/rack.sdf}]}
robot: {start: [1.0, 1.0, 0.0], goal: [4.0, 1.0, 0.0]}
humans: [{pose: [1.0, 4.0, 0.0]}]
simulation: {duration: 10.0}
"""
MAP = """
image: room.pgm # in gray
resolution: 0.1
origin: [0.0, 0.0, 0.0]
occupied_thresh: 0.65
free_thresh: 0.2
negate: 0
"""
# The apostrophe begins no quotation.
MODEL = """<?xml version="1.0"?>
<sdf version="1.7"><model name="rack"><!-- it's small --><static>true</static>
<link name="body"><pose>4 4 0.5 0 0 0</pose>
<collision name="c"><geometry><mesh><uri>MESH</uri></mesh></geometry>
</collision>
<visual name="v"><geometry><mesh><uri>MESH</uri></mesh></geometry></visual>
</link></model></sdf>
"""
MESH = """mtllib rack.mtl
v 0 0 0
v 0.1 0 0
v 0 0.1 0
v 0 0 0.1
f 1 2 3
f 1 2 4
f 1 3 4
f 2 3 4
"""
SUITE = """
name: mapped
scenarios: [trial.yaml]
planners: [pursuit]
seeds: 2
"""


def draw_map(path, wall):
    picture = Image.new("L", (60, 60), 254)
    picture.paste(0, (wall, 20, wall + 2, 40))
    picture.save(path)


@pytest.fixture
def folder(tmp_path):
    """A scenario with a map, and with a model that has a mesh."""
    for name in ("maps", "models"):
        (tmp_path / name).mkdir()
    (tmp_path / "trial.yaml").write_text(SCENARIO)
    (tmp_path / "maps" / "room.yaml").write_text(MAP)
    draw_map(tmp_path / "maps" / "room.pgm", 50)
    models = tmp_path / "models"
    (models / "rack.sdf").write_text(MODEL.replace("MESH", "rack.obj"))
    (models / "rack.obj").write_text(MESH)
    (models / "rack.mtl").write_text("newmtl x\nmap_Kd -s 1 1 1 rack.png\n")
    Image.new("L", (2, 2)).save(models / "rack.png")
    return tmp_path


FILES = [
    *("maps/room.yaml", "maps/room.pgm", "models/rack.sdf"),
    *("models/rack.obj", "models/rack.mtl", "models/rack.png"),
]


def test_the_files_of_a_scenario_and_theirs_are_found(folder):
    scenario = LoadScenario(filename=folder / "trial.yaml")
    assert named_files(scenario) == sorted(folder / name for name in FILES)
    assert files_sha256(LoadScenario(filename="crossing")) == ""


@pytest.mark.parametrize("name", FILES)
def test_the_content_of_each_file_counts(folder, name):
    scenario = LoadScenario(filename=folder / "trial.yaml")
    before = files_sha256(scenario)
    content = (folder / name).read_bytes()
    (folder / name).write_bytes(content + b"\n")
    assert files_sha256(scenario) != before
    (folder / name).write_bytes(content)
    os.utime(folder / name, (1.0, 1.0))
    assert files_sha256(scenario) == before


def test_files_of_packages_are_found(folder):
    package = folder / "models"
    (package / "package.xml").write_text(
        '<?xml version="1.0"?><package format="2"><name>racks</name></package>'
    )
    model = package / "rack.sdf"
    model.write_text(MODEL.replace("MESH", "package://racks/rack.obj"))
    (package / "rack.xml").write_text(
        '<mujoco><compiler meshdir="../models"/>'
        '<asset><mesh file="rack.obj"/></asset></mujoco>'
    )
    for name in (model, package / "rack.xml"):
        scenario = LoadScenario(data="{}", overrides=[f"description={name}"])
        assert package / "rack.obj" in named_files(scenario)


URDF = """<robot name="cart"><link name="base"><inertial><mass value="9"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<visual><geometry><mesh filename="package://cart/hull.obj"/></geometry></visual>
</link></robot>"""
TREE = """<root BTCPP_format="4" main_tree_to_execute="mine">
<BehaviorTree ID="mine"><AlwaysSuccess/></BehaviorTree></root>"""


@pytest.mark.slow
def test_robots_and_trees_of_ones_own_count(tmp_path):
    robot, mesh, tree = (
        tmp_path / name for name in ("cart.urdf", "hull.obj", "mine.xml")
    )
    robot.write_text(URDF)
    mesh.write_text(MESH)
    tree.write_text(TREE)
    (tmp_path / "trial.yaml").write_text(
        "robot: {type: urdf, file: cart.urdf, base: base, packages: {cart: .},"
        " drive: {type: omnidirectional}}\n"
        "humans: [{pose: [3.0, 0.0, 0.0], behavior: mine.xml}]\n"
    )
    suite = LoadSuite(data="{scenarios: [trial.yaml], planners: [pursuit]}")
    hashes = [make_cells(suite, tmp_path)[0].sha256]
    for path, old, new in (
        (robot, "9", "8"),
        (mesh, "0.1", "0.2"),
        (tree, "Success", "Failure"),
    ):
        path.write_text(path.read_text().replace(old, new))
        hashes.append(make_cells(suite, tmp_path)[0].sha256)
    assert len(set(hashes)) == 4


@register_planner("learned")
@dataclass(kw_only=True)
class Learned(Planner):
    """Drives as fast as its policy says; without one it stands."""

    policy: str = ""

    def plan(self, task, view, memory):
        speed = Path(self.policy).read_text() if self.policy else 0.0
        return Plan(float(speed), 0.0, PlannerStatus.DRIVING)


def test_the_policy_of_a_planner_counts(tmp_path):
    policy = tmp_path / "policy.txt"
    hashes = []
    for speed in ("0.1", "0.2"):
        policy.write_text(speed)
        scenario = LoadScenario(
            filename="crossing",
            overrides=[f"planner={{type: learned, policy: {policy}}}"],
        )
        assert named_files(scenario) == [policy]
        hashes.append(files_sha256(scenario))
    assert hashes[0] != hashes[1]


@pytest.mark.parametrize(
    ("text", "file"),
    [
        *((name, name) for name in ("w (1).pt", "w-.pt", "w+.pt", "weights")),
        ("./weights", "weights"),
        ("policies/best", "policies/best/left/w.bin"),
        ("./best/", "best/w.bin"),
        ("best", "best/w.bin"),
    ],
)
def test_a_policy_counts_whatever_it_is_called(
    text, file, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("0.1")
    scenario = LoadScenario(filename="crossing")
    scenario.planner = Learned(policy=text)
    assert named_files(scenario) == [path]
    before = files_sha256(scenario)
    path.write_text("0.2")
    assert files_sha256(scenario) != before


@pytest.mark.parametrize("text", [".", "..", "/", "./", "a\0b", "x" * 5000, ""])
def test_what_names_no_file_is_none(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.config").write_text("")
    # Words that a planner knows are no folders.
    for word in ("learned", "dwb", "standard", "everything"):
        (tmp_path / word).mkdir()
        (tmp_path / word / "runs.csv").write_text("")
    scenario = LoadScenario(filename="crossing")
    scenario.planner = Learned(policy=text)
    assert named_files(scenario) == []
    assert named_files(LoadScenario(filename="crossing")) == []


@pytest.mark.slow
def test_a_robots_packages_count_by_what_is_used_of_them(tmp_path):
    (tmp_path / "cart.urdf").write_text(URDF)
    (tmp_path / "hull.obj").write_text(MESH)
    (tmp_path / "notes.txt").write_text("")
    robot = (
        f"robot={{type: urdf, file: {tmp_path}/cart.urdf, base: base,"
        f" packages: {{cart: {tmp_path}}}, drive: {{type: omnidirectional}}}}"
    )
    scenario = LoadScenario(filename="crossing", overrides=[robot])
    found = [tmp_path / name for name in ("cart.urdf", "hull.obj")]
    assert named_files(scenario) == found


@pytest.mark.parametrize(
    ("name", "text", "file"),
    [
        *(
            ("m.yaml", f"image: {image}\nresolution: 0.1\n", image)
            for image in ("map (1).pgm", "map-.pgm", "m+.pgm", "'map'")
        ),
        ("m.urdf", '<mesh filename="a (1).obj"/>', "a (1).obj"),
        ("m.urdf", '<m name=""/><mesh filename="a.obj"/>', "a.obj"),
        ("m.urdf", '<o rpy="0 0\n0"/><mesh filename="a.obj"/>', "a.obj"),
        ("m.urdf", f'<o p="{"0 " * 300}"/><mesh filename="a.obj"/>', "a.obj"),
        ("m.urdf", "<!-- it's --><mesh filename='a.obj'/>", "a.obj"),
        ("m.urdf", "<!-- = 'it --><mesh filename='a.obj'/>", "a.obj"),
        ("m.urdf", '<mesh filename="a&amp;b.obj"/>', "a&b.obj"),
        ("m.urdf", '<!-- <mesh filename="b.obj"/> --><a b="a"/>', None),
        ("m.sdf", "<uri>\n  a-.obj\n</uri>", "a-.obj"),
        ("m.gltf", '{"buffers": [{"uri": "a%20b.bin"}]}', "a b.bin"),
        ("m.gltf", '{"name": "", "uri": "a.bin"', None),
        ("m.dae", "<init_from>a%20b.png</init_from>", "a b.png"),
        ("m.xml", '<c meshdir="../meshes"/><m file="a.obj"/>', "meshes/a.obj"),
        ("m.obj", "mtllib a.mtl b (1).mtl\n", "a.mtl"),
        ("m.mtl", "map_Kd -s 1 1 1 wood (1).png\n", "wood (1).png"),
    ],
)
def test_files_are_found_whatever_they_are_called(name, text, file, tmp_path):
    models = tmp_path / "models"
    models.mkdir()
    path = models / name
    path.write_text(text)
    (models / "b.obj").write_text("")
    expected = [path]
    if file is not None:
        base = tmp_path if "/" in file else models
        expected.append(base / file.strip("'"))
        expected[1].parent.mkdir(exist_ok=True)
        expected[1].write_text("")
    scenario = LoadScenario(data="{}", overrides=[f"description={path}"])
    assert named_files(scenario) == sorted(expected)


@pytest.mark.slow
def test_runs_on_a_changed_map_are_not_those_of_before(folder):
    suite = LoadSuite(data=SUITE)
    out = folder / "out"
    before = RunSuite(suite, folder=folder, out=out, workers=1).runs()
    kept = {it.name: it.read_bytes() for it in (out / "recordings").iterdir()}
    # Now there is a wall in the way.
    picture = Image.open(folder / "maps" / "room.pgm")
    picture.paste(0, (25, 40, 27, 60))
    picture.save(folder / "maps" / "room.pgm")
    with pytest.raises(ValueError, match=r"1 of .*maps, models or other files"):
        RunSuite(suite, folder=folder, out=out, workers=1)
    after = RunSuite(suite, folder=folder, out=out, workers=1, fresh=True)
    assert (before.end_reason == "goal").all()
    assert (after.runs().completed == 0).all()
    # What was drawn of the old map is no longer of these runs.
    aside = (out / "recordings_old").iterdir()
    assert {it.name: it.read_bytes() for it in aside} == kept


def test_a_file_that_is_changed_while_a_suite_runs_ends_it(folder):
    suite = LoadSuite(data=SUITE)
    cell = make_cells(suite, folder)[0]
    task = Task(cell=cell, code=(), runs=((0, 0),))
    assert do_task(task)[0].end_reason == "goal"
    draw_map(folder / "maps" / "room.pgm", 55)
    with pytest.raises(UnfitWorkerError, match="if a map or a model was"):
        do_task(task)


def test_a_trial_tells_the_hash_of_its_files(folder):
    result = RunSuite(LoadSuite(data=SUITE), folder=folder, workers=1)
    # Nothing is drawn: the second seed would be the same trial.
    assert len(result.rows) == 1
    from hunav_drake import RunTrial

    scenario = LoadScenario(filename=folder / "trial.yaml")
    told = RunTrial(scenario).provenance["files_sha256"]
    assert told == files_sha256(scenario)
