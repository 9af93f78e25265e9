"""Files of xacro, sound and damaged, and meshes that cannot be shown."""

import importlib.util
import os
from pathlib import Path
import struct

import numpy as np
from pydrake.geometry import Box, Mesh, Role, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
import pytest
import yaml

from hunav_drake import LoadScenario, ScenarioError
from hunav_drake.scenario.named_files import files_sha256, named_files
from hunav_drake.systems.common.models import apart, reading
from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.models.markup import find_markup_fault
from hunav_drake.systems.common.models.mesh_files import read_mesh
from hunav_drake.systems.common.models.xacro import nearby_packages, read_robot
from tests.choices import NEEDED, fast
from tests.systems.common.models.gazebo_files import block, stl

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'

WHEEL = """<xacro:macro name="wheel" params="side y">
  <link name="${side}_wheel">
    <inertial><mass value="0.5"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.002"/>
    </inertial>
    <collision><geometry><sphere radius="$(arg radius)"/></geometry></collision>
  </link>
  <joint name="${side}_joint" type="continuous">
    <parent link="$(arg prefix)base"/><child link="${side}_wheel"/>
    <origin xyz="0 ${y} 0"/><axis xyz="0 1 0"/>
  </joint>
</xacro:macro>"""

BODY = """<xacro:arg name="prefix" default=""/>
<xacro:arg name="radius" default="0.1"/>
<link name="$(arg prefix)base">
  <inertial><mass value="${2 * 5}"/>
    <inertia ixx="0.3" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.3"/>
  </inertial>
  <collision>
    <origin xyz="0 0 0.02"/><geometry><box size="0.4 0.3 0.1"/></geometry>
  </collision>
  <visual><geometry><mesh filename="package://cart/meshes/no.dae"/></geometry>
    <material name="red"><color rgba="1 0 0 1"/></material>
  </visual>
  <collision name="stand">
    <origin xyz="-0.15 0 -0.05"/><geometry><sphere radius="0.05"/></geometry>
  </collision>
</link>"""

CALLS = """<xacro:include filename="$(find cart_parts)/urdf/wheel.xacro"/>
<xacro:wheel side="left" y="0.15"/><xacro:wheel side="right" y="-0.15"/>"""

DRIVE = {
    "left_wheel": "left_joint",
    "right_wheel": "right_joint",
    "wheel_separation": 0.3,
    "wheel_radius": 0.1,
}


def robot_of(text):
    return f'<robot name="cart" {NAMESPACE}>{text}</robot>'


@pytest.fixture
def cart(tmp_path):
    """Returns the path of a file that includes one of another package."""
    for name, files in {
        "cart": {"cart.urdf.xacro": robot_of(BODY + CALLS)},
        "cart_parts": {"wheel.xacro": robot_of(WHEEL)},
    }.items():
        folder = tmp_path / "work" / name / "urdf"
        folder.mkdir(parents=True)
        (folder.parent / "package.xml").write_text(
            f"<package><name>{name}</name></package>"
        )
        for file, text in files.items():
            (folder / file).write_text(text)
    return tmp_path / "work/cart/urdf/cart.urdf.xacro"


def scenario(file, **more):
    robot = {"type": "urdf", "file": str(file), "base": "base", "drive": DRIVE}
    return yaml.safe_dump({"robot": robot | more})


@pytest.mark.slow
def test_a_file_of_xacro_is_read_with_the_package_beside_it(cart):
    found = reading.robot_text(str(cart), {})
    assert "xacro" not in found.text
    assert found.text.count("<link") == 3
    assert [it.name for it in found.files] == ["cart.urdf.xacro", "wheel.xacro"]
    loaded = LoadScenario(data=scenario(cart, radius=0.25))
    assert loaded.robot.arguments == {}


@pytest.mark.slow
def test_arguments_are_given_as_text_or_numbers(cart):
    more = {"arguments": {"prefix": "my_", "radius": 0.2}, "base": "my_base"}
    robot = LoadScenario(data=scenario(cart, **more)).robot
    text = reading.robot_text(robot.file, {}, robot.arguments).text
    assert '<link name="my_base">' in text
    assert '<sphere radius="0.2"/>' in text


def test_an_unknown_argument_is_told(cart):
    with pytest.raises(ScenarioError, match="did you mean 'prefix'") as info:
        LoadScenario(data=scenario(cart, arguments={"prefx": "my_"}))
    (fault,) = info.value.faults
    assert fault.path == "robot.arguments.prefx"


def test_included_files_count_among_those_of_a_scenario(cart):
    loaded = LoadScenario(data=scenario(cart))
    part = cart.parents[2] / "cart_parts/urdf/wheel.xacro"
    assert {cart, part} <= set(named_files(loaded))
    before = files_sha256(loaded)
    part.write_text(part.read_text().replace("0.5", "0.6"))
    assert files_sha256(loaded) != before
    # What was read before is not remembered.
    assert 'mass value="0.6"' in reading.robot_text(str(cart), {}).text


@pytest.mark.slow
def test_a_package_that_is_not_there_is_told(cart):
    (cart.parents[2] / "cart_parts/package.xml").unlink()
    words = (
        "unknown macro name: xacro:wheel; that may be from the package"
        " 'cart_parts', not there; clone .*packages: {cart_parts: FOLDER}"
    )
    with pytest.raises(ScenarioError, match=words):
        LoadScenario(data=scenario(cart))
    parts = {"cart_parts": str(cart.parents[2] / "cart_parts")}
    assert LoadScenario(data=scenario(cart, packages=parts))


def test_what_is_not_needed_of_absent_packages_is_left_out(cart):
    extra = '<xacro:include filename="$(find lamps)/urdf/lamp.xacro"/></robot>'
    cart.write_text(cart.read_text().replace("</robot>", extra))
    robot = LoadScenario(data=scenario(cart, radius=0.25)).robot
    doubts = [message for _, message in robot.find_doubts()]
    assert any("left out: lamps; if the robot lacks" in it for it in doubts)


def test_a_mesh_that_cannot_be_shown_gives_way_to_the_collision_shape(cart):
    robot = LoadScenario(data=scenario(cart, radius=0.25)).robot
    doubts = [message for _, message in robot.find_doubts()]
    assert any("meshes that are not there, or of a" in it for it in doubts)
    scene_graph = SceneGraph()
    plant = MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    reading.AddModels(plant, str(cart))
    inspector = scene_graph.model_inspector()
    (shown, *_) = [
        it
        for it in inspector.GetAllGeometryIds(Role.kIllustration)
        if isinstance(inspector.GetShape(it), Box)
    ]
    assert inspector.GetShape(shown).size().tolist() == [0.4, 0.3, 0.1]
    assert inspector.GetPoseInFrame(shown).translation()[2] == 0.02
    color = inspector.GetIllustrationProperties(shown).GetProperty(
        "phong", "diffuse"
    )
    assert (color.r(), color.g(), color.b()) == (1, 0, 0)


def test_a_robot_without_visuals_is_shown_as_its_collision_shapes():
    scene_graph = SceneGraph()
    plant = MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    reading.AddModels(plant, str(NEEDED["urdf"]["file"]))
    inspector = scene_graph.model_inspector()
    for role in (Role.kIllustration, Role.kPerception):
        shown = inspector.GetAllGeometryIds(role)
        assert len(shown) == inspector.NumGeometriesWithRole(Role.kProximity)
        assert len(shown) == 5


def scene_of(file):
    """Returns a scene with a model."""
    scene_graph = SceneGraph()
    plant = MultibodyPlant(0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    reading.AddModels(plant, str(file))
    return scene_graph


def shown_mesh(file):
    """Returns the only mesh that is shown of a model."""
    inspector = scene_of(file).model_inspector()
    (shown,) = inspector.GetAllGeometryIds(Role.kIllustration)
    return inspector.GetShape(shown)


def test_a_mirrored_mesh_is_shown_without_a_negative_scale(tmp_path):
    """With one, cameras would see it lit from inside."""
    corners = block((0, 0, 0), (1, 2, 3))
    (tmp_path / "block.stl").write_text(stl(corners))
    file = tmp_path / "robot.urdf"
    file.write_text(
        '<robot name="r"><link name="l"><visual>'
        '<material name="m"><color rgba="1 0 0 1"/></material>'
        '<geometry><mesh scale="2 -1 1" filename="block.stl"/></geometry>'
        "</visual></link></robot>"
    )
    mesh = shown_mesh(file)
    assert mesh.scale3().tolist() == [2, 1, 1]
    points = read_mesh(mesh.source().path()).triangles.reshape(-1, 3)
    assert points.min(axis=0).tolist() == [0, -2, 0]
    assert points.max(axis=0).tolist() == [1, 0, 3]
    # It has no material of its own, which would hide that of the robot.
    assert "mtl" not in mesh.source().path().read_text()


def test_a_mirrored_mesh_keeps_its_colors(tmp_path):
    (tmp_path / "two.mtl").write_text(
        "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n"
    )
    (tmp_path / "two.obj").write_text(
        "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
        "usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\n"
    )
    file = tmp_path / "robot.urdf"
    file.write_text(
        '<robot name="r"><link name="l"><visual><geometry><mesh'
        ' filename="two.obj" scale="1 -1 1"/></geometry></visual></link>'
        "</robot>"
    )
    path = shown_mesh(file).source().path()
    colors = path.with_name("model.mtl").read_text()
    assert "Kd 1.000 0.000 0.000" in colors
    assert "Kd 0.000 0.000 1.000" in colors


def test_lines_stay_where_a_visual_is_replaced(tmp_path):
    file = tmp_path / "robot.urdf"
    text = BODY.replace("$(arg prefix)", "").replace("${2 * 5}", "10")
    lines = [it for it in text.splitlines() if not it.startswith("<xacro")]
    bad = "\n".join(lines).replace('radius="0.05"', 'radius="-1"')
    file.write_text(f'<robot name="cart">\n{bad}\n</robot>')
    with pytest.raises(ModelFault, match=r"robot.urdf:13: radius of <sphere>"):
        reading.check_model_file(str(file), {}, "os:abort")


def test_the_hull_of_stl_stands_among_collision_shapes(tmp_path):
    corners = [(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    data = b"\0" * 80 + struct.pack("<I", len(faces))
    for face in faces:
        points = [x for k in face for x in corners[k]]
        data += struct.pack("<12fH", 0, 0, 0, *points, 0)
    (tmp_path / "part.stl").write_bytes(data)
    file = tmp_path / "robot.urdf"
    file.write_text(
        '<robot name="r"><link name="base"><inertial><mass value="1"/><inertia'
        ' ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<collision><geometry><mesh filename="part.stl" scale="2 2 2"/>'
        "</geometry></collision></link></robot>"
    )
    scene_graph = scene_of(file)
    inspector = scene_graph.model_inspector()
    (shape,) = inspector.GetAllGeometryIds(Role.kProximity)
    assert isinstance(inspector.GetShape(shape), Mesh)
    hull = inspector.GetConvexHull(shape)
    corners = np.array([hull.vertex(k) for k in range(hull.num_vertices())])
    assert sorted(corners.max(axis=0)) == pytest.approx([2, 2, 4])
    assert len(corners) == 4


def test_sdf_of_gazebo_is_read_and_its_meshes_are_shown(tmp_path, capfd):
    """Of what is for simulators, Drake refuses some, and warns of the rest."""
    (tmp_path / "part.stl").write_text(stl(block((0, 0, 0), (1, 1, 1))))
    mesh = "<geometry><mesh><uri>part.stl</uri></mesh></geometry>"
    file = tmp_path / "robot.sdf"
    file.write_text(
        '<sdf version="1.6"><model name="r"><!-- <plugin> --><link name="l">\n'
        '<sensor name="s" type="imu"><gz_frame_id>l</gz_frame_id></sensor>\n'
        f'<visual name="v">{mesh}</visual><collision name="c">{mesh}'
        '</collision></link><plugin name="p" filename="p.so"/>'
        '<plugin name="q" filename="q.so"><plugin name="r" filename="r.so">'
        "<a/></plugin><b/></plugin ></model></sdf>"
    )
    tried = f"{reading.__name__}:try_model_file"
    reading.check_model_file(str(file), {}, tried)
    inspector = scene_of(file).model_inspector()
    for role in (Role.kIllustration, Role.kProximity):
        (shape,) = inspector.GetAllGeometryIds(role)
        assert inspector.GetShape(shape).extension() == ".obj"
    assert "plugin" not in capfd.readouterr().err


def test_a_namespace_is_empty_unless_it_is_given(tmp_path):
    file = tmp_path / "robot.urdf"
    file.write_text('<robot name="r"><link name="${namespace}base"/></robot>')
    read = reading.robot_text
    assert '<link name="base"/>' in read(str(file), {}).text
    given = read(str(file), {}, {"namespace": "a/"}).text
    assert '<link name="a/base"/>' in given
    with pytest.raises(ModelFault, match="did you mean 'namespace'"):
        read(str(file), {}, {"namespac": "a/"})


def test_joints_that_ros2_control_commands_have_motors(tmp_path):
    file = tmp_path / "robot.urdf"
    inertia = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"'
        ' ixz="0" iyz="0"/></inertial>'
    )
    file.write_text(
        f'<robot name="r"><link name="a">{inertia}</link><link name="b">'
        f'{inertia}</link><joint name="hinge" type="continuous">'
        '<parent link="a"/><child link="b"/></joint>'
        '<ros2_control name="c" type="system"><joint name="mimic"/>'
        '<joint name="hinge">'
        '<command_interface name="position"/></joint></ros2_control></robot>'
    )
    plant = MultibodyPlant(0.0)
    reading.AddModels(plant, str(file))
    assert plant.HasJointActuatorNamed("hinge")


def test_the_extra_is_named_where_it_is_missing(cart, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ScenarioError, match=r"pip install 'hunav_drake\[xacro"):
        LoadScenario(data=scenario(cart))


def test_other_formats_have_no_arguments():
    robot = {
        "type": "urdf",
        "file": "package://hunav_drake/systems/robot/models/pmb2.sdf",
        "base": "base",
        "drive": "omnidirectional",
        "arguments": {"a": 1},
    }
    with pytest.raises(ScenarioError, match=r"pmb2.sdf is none; take them out"):
        LoadScenario(data=yaml.safe_dump({"robot": robot}))


def damaged(old, new):
    def change(text):
        assert old in text
        return text.replace(old, new, 1)

    return change


def added(text):
    return damaged("</robot>", f"{text}</robot>")


# What is changed in the file, and what is said about it.
DAMAGED = {
    "cut": (damaged("</robot>", ""), "cart.urdf.xacro: no element found"),
    "no declaration": (damaged(NAMESPACE, ""), "unbound prefix"),
    "unknown macro": (added("<xacro:wing/>"), "unknown macro name: xacro:wing"),
    "missing file": (
        added('<xacro:include filename="parts/no.xacro"/>'),
        "No such file or directory: .*no.xacro",
    ),
    "includes itself": (
        added('<xacro:include filename="cart.urdf.xacro"/>'),
        "includes or macros are in each other without an end",
    ),
    "calls itself": (
        added('<xacro:macro name="a"><xacro:a/></xacro:macro><xacro:a/>'),
        "includes or macros are in each other without an end",
    ),
    "property of itself": (
        added('<xacro:property name="a" value="${a}"/><link name="${a}"/>'),
        "circular variable definition",
    ),
    "too few parameters": (added('<xacro:wheel side="a"/>'), "Undefined param"),
    "unknown parameter": (
        added('<xacro:wheel side="a" y="1" z="2"/>'),
        'Invalid parameter "z"',
    ),
    "no number": (damaged("${2 * 5}", "${2 * }"), "invalid syntax"),
    "no name": (damaged("${2 * 5}", "${mass}"), "name 'mass' is not defined"),
    "division": (damaged("${2 * 5}", "${1 / 0}"), "division by zero"),
    "no condition": (
        added('<xacro:if value="maybe"/>'),
        '"maybe" evaluated to "maybe", which is not a boolean',
    ),
    "environment": (
        added('<link name="$(env HOME)"/>'),
        "environment variable 'HOME', and none is read; give it as one",
    ),
    "eval": (
        damaged("${2 * 5}", "$(eval open('/tmp/x', 'w'))"),
        r"has \$\(eval open.*, which can run any code",
    ),
    "lambda": (damaged("${2 * 5}", "${(lambda: 1)()}"), "could run other code"),
    "inner names": (
        damaged("${2 * 5}", "${().__class__.__base__.__subclasses__()}"),
        "could run other code; write it",
    ),
    "frames": (
        damaged("${2 * 5}", "${[x for x in [1]].gi_frame.f_back}"),
        "could run other code",
    ),
    "builtins": (damaged("${2 * 5}", "${open('/tmp/x')}"), "'open' is not def"),
    "classes": (
        damaged("${2 * 5}", "${python.vars(python.type(0))}"),
        "'vars' is not defined",
    ),
    "negative mass": (damaged("${2 * 5}", "${-5}"), "value of <mass> must be"),
    "nan": (
        damaged("${2 * 5}", "${math.nan}"),
        "value of <mass> must be a fin",
    ),
}


# These take a process each.
FAST = ("cut", "unknown macro", "includes itself", "eval", "inner names", "nan")


@pytest.mark.parametrize("name", fast(DAMAGED, *FAST))
def test_what_is_wrong_is_told_in_a_line(name, cart):
    change, words = DAMAGED[name]
    cart.write_text(change(cart.read_text()))
    with pytest.raises(ModelFault, match=words) as info:
        reading.check_model_file(str(cart), {}, "os:getpid")
    message = str(info.value)
    assert "\n" not in message
    assert "Traceback" not in message
    assert "cart.urdf.xacro" in message or "wheel.xacro" in message


def test_an_environment_variable_may_be_an_argument(cart, monkeypatch):
    monkeypatch.setenv("CART_LAMP", "no")
    text = '<link name="$(optenv CART_LAMP yes)_lamp"/></robot>'
    cart.write_text(cart.read_text().replace("</robot>", text))
    assert 'name="yes_lamp"' in reading.robot_text(str(cart), {}).text
    found = reading.robot_text(str(cart), {}, {"CART_LAMP": "red"})
    assert 'name="red_lamp"' in found.text


@pytest.mark.slow
def test_what_has_no_end_is_not_waited_for(cart, monkeypatch):
    monkeypatch.setattr(apart, "_PATIENCE", 3.0)
    text = cart.read_text().replace("${2 * 5}", "${9**9**9}")
    cart.write_text(text)
    with pytest.raises(ModelFault, match=r"cannot be read within 3 s"):
        reading.robot_text(str(cart), {})


def test_a_fixed_joint_may_have_no_axis(tmp_path):
    file = tmp_path / "robot.urdf"
    joint = '<joint name="j" type="{}"><axis xyz="0 0 0"/></joint>'
    file.write_text(f'<robot name="r">{joint.format("fixed")}</robot>')
    assert find_markup_fault(file) == ""
    file.write_text(f'<robot name="r">{joint.format("continuous")}</robot>')
    assert "xyz of <axis> must not be 0" in find_markup_fault(file)


def test_a_file_that_is_no_text_is_told(tmp_path):
    file = tmp_path / "robot.urdf"
    file.write_bytes(os.urandom(4000))
    with pytest.raises(ModelFault, match="Error parsing XML"):
        reading.check_model_file(str(file), {}, "os:getpid")
    assert read_robot(Path("a.sdf"), {}, {}) is None


def test_a_repository_beside_that_is_a_package_is_found(tmp_path):
    file = tmp_path / "robot/robot_description/urdf/robot.xacro"
    file.parent.mkdir(parents=True)
    for package in ("robot/robot_description", "robot/robot_x", "a/b", "utils"):
        folder = tmp_path / package
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "package.xml").touch()
    assert nearby_packages(file) == {
        folder.name: str(folder)
        for folder in map(
            tmp_path.joinpath,
            ("robot/robot_description", "robot/robot_x", "a/b", "utils"),
        )
    }
