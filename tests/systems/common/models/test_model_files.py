"""Files of models that others wrote: what is wrong with them is told."""

import subprocess

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
import pytest
import yaml

from hunav_drake import LoadScenario, RunTrial, ScenarioError
from hunav_drake.systems.common.models import apart, reading
from hunav_drake.systems.common.models.apart import ModelFault, try_apart
from hunav_drake.systems.common.models.markup import find_markup_fault
from hunav_drake.systems.robot import ROBOTS
from hunav_drake.systems.world.shapes import Model, World
from hunav_drake.systems.world.solids import WorldFileError
from tests.robot_models import FILES, ROBOTS as MODELS
from tests.systems.robot.crate import FOOTPRINT

WHEEL = '<sphere radius="0.08"/>'
WHOLE_WHEEL = f"<geometry>{WHEEL}</geometry>"
AXIS = '<axis xyz="0 1 0"/>'
INERTIA = '<inertia ixx="0.003" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.003"'

# Texts of the turtle, their replacements, and the message about each.
IN_TEXT = {
    "radius": (
        *(WHEEL, '<sphere radius="-0.1"/>'),
        r"radius of <sphere> must be in \(0, 100000\], got '-0.1'; correct it",
    ),
    "no radius": (
        *('<cylinder radius="0.2"', '<cylinder radius="0"'),
        r"radius of <cylinder> must be in \(0, .* got '0'",
    ),
    "huge": (WHEEL, '<sphere radius="1e300"/>', "must be in .* got '1e300'"),
    "not finite": ("0.02 0 0.12", "nan 0 0.12", "must be 3 finite numbers"),
    "no number": ("0.02 0 0.12", "a 0 0.12", "xyz of <origin> .* got 'a 0 0.1"),
    "too few": ("0.02 0 0.12", "0 0.12", "xyz of <origin> must be 3 finite"),
    "empty": ("0.02 0 0.12", "", "xyz of <origin> .* got ''"),
    "mass": ('<mass value="12"/>', '<mass value="-1"/>', "must be in .0, 1e"),
    "speed": (
        *(AXIS, f'{AXIS}<limit effort="5" velocity="-20"/>'),
        "velocity of <limit> must be in .* got '-20'",
    ),
    "limits": (
        *(AXIS, f'{AXIS}<limit lower="2" upper="1"/>'),
        "lower of <limit> must be at most upper, got 2 and 1; swap them",
    ),
    "axis": (AXIS, '<axis xyz="0 0 0"/>', "xyz of <axis> must not be 0 along"),
    "friction": (
        'static value="0"',
        'static value="-1"',
        "value of <mu_static",
    ),
    "without shape": (WHEEL, "", "<collision> must have a <geometry> with a"),
    "without geometry": (WHOLE_WHEEL, "", "<collision> must have a <geometry>"),
    "kind of mesh": (
        *(WHEEL, '<mesh filename="part.STL"/>'),
        "mesh of <collision> must be one of .*, got 'part.STL'; convert it",
    ),
    "missing stl": (
        *(WHEEL, '<mesh filename="part.stl"/>'),
        ", or a .stl or .dae that is there and can be read, got 'part.stl'",
    ),
    "scale": (
        *(WHEEL, '<mesh filename="part.obj" scale="1 0 1"/>'),
        "scale of <mesh> must not be 0, got '1 0 1'",
    ),
    "macro": (
        *('name="base_link"', 'name="${prefix}base"'),
        "nothing gives it a value; .*among the arguments",
    ),
    "cut": ("</robot>", "", "Error parsing XML"),
    "nested": ("</robot>", "<a>" * 200, "elements in more than 100 others"),
    "entity": (
        *("<robot", '<!DOCTYPE a [<!ENTITY b "c">]><robot'),
        "declares an entity",
    ),
}


@pytest.mark.parametrize(("old", "new", "words"), IN_TEXT.values(), ids=IN_TEXT)
def test_what_is_wrong_in_the_text_has_a_line(old, new, words, tmp_path):
    assert old in FOOTPRINT
    file = tmp_path / "robot.urdf"
    file.write_text(FOOTPRINT.replace(old, new, 1))
    with pytest.raises(ModelFault, match=words) as info:
        reading.check_model_file(str(file), {}, "os:abort")
    message = str(info.value)
    assert message.startswith("cannot be read: robot.urdf:")
    assert int(message.split(":")[2]) > 0


def test_sound_text_has_no_fault(tmp_path):
    for name, (text, *_) in MODELS.items():
        (tmp_path / name).write_text(text)
        assert find_markup_fault(tmp_path / name) == ""
    # Name spaces that nobody declares, and what is for other programs.
    text = FOOTPRINT.replace(' xmlns:drake="http://drake.mit.edu"', "")
    own = '<gazebo><sphere radius="none"/></gazebo></robot>'
    (tmp_path / "robot.urdf").write_text(text.replace("</robot>", own))
    assert find_markup_fault(tmp_path / "robot.urdf") == ""
    # Limits that are none.
    none = '<limit lower="-1e16" upper="1e16" effort="1e10" velocity="1e10"/>'
    text = FOOTPRINT.replace(AXIS, AXIS + none)
    assert find_markup_fault(tmp_path / "robot.urdf", text) == ""


# Faults that Drake finds, in the process that may crash.
BY_DRAKE = {
    "no inertia": (
        *(f"{INERTIA}/>", INERTIA.replace("0.003", "0") + "/>"),
        "not positive-definite.*body left_wheel",
    ),
    "unknown package": (
        *(WHEEL, '<mesh filename="package://nope/part.obj"/>'),
        "robot.urdf:20: .*unknown package 'nope'",
    ),
    "missing mesh": (
        *(WHEEL, '<mesh filename="missing.obj"/>'),
        "robot.urdf:20: .*'missing.obj' .* does not exist",
    ),
    "broken mesh": (
        *(WHEEL, '<mesh filename="broken.obj"/>'),
        "fewer than three vertices.*broken.obj",
    ),
    "mimics itself": (
        *(AXIS, f'{AXIS}<mimic joint="left_joint"/>'),
        "cannot mimic themselves",
    ),
    "two of a name": ("right_wheel", "left_wheel", "named 'left_wheel'"),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "words"), BY_DRAKE.values(), ids=BY_DRAKE
)
def test_what_drake_finds_is_told_before_anything_runs(
    old, new, words, tmp_path
):
    file = tmp_path / "robot.urdf"
    text = FOOTPRINT.replace(old, new)
    assert text != FOOTPRINT
    file.write_text(text)
    (tmp_path / "broken.obj").write_text(FILES["broken.obj"])
    _, base, drive = MODELS["turtle.urdf"]
    robot = {"type": "urdf", "file": str(file), "base": base, "drive": drive}
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(data=yaml.safe_dump({"robot": robot}))
    (fault,) = info.value.faults
    assert fault.path == "robot.file"
    assert "\n" not in fault.message


def test_a_crash_is_told():
    with pytest.raises(ModelFault, match=r"crashes Drake \(SIGABRT\)"):
        try_apart("crash", "os:abort")


def test_an_end_is_told():
    with pytest.raises(ModelFault, match="ends the process that reads it"):
        try_apart("end", "os:_exit", 3)


def test_who_takes_too_long_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(apart, "_PATIENCE", 0.3)
    with pytest.raises(ModelFault, match=r"cannot be read within 0.3 s"):
        try_apart("wait", "time:sleep", 60)


def test_what_went_well_is_not_tried_again(tmp_path):
    made = str(tmp_path / "made")
    try_apart(made, "os:mkdir", made)
    try_apart(made, "os:mkdir", made)
    for _ in range(2):
        with pytest.raises(ModelFault, match="File exists"):
            try_apart(f"{made} again", "os:mkdir", made)


def test_the_packages_own_models_are_known_to_be_sound(monkeypatch):
    def run(*words, **settings):
        raise AssertionError("a process was started")

    monkeypatch.setattr(subprocess, "run", run)
    config = ROBOTS.make("pmb2")
    assert list(config.find_faults()) == []
    file = "package://hunav_drake/systems/robot/models/pmb2.sdf"
    assert reading.AddModels(MultibodyPlant(0.0), file)


def hall(boxes: int) -> str:
    """SDF of a world with a ground plane and boxes of 1 m."""
    plane = "<geometry><plane><normal>0 0 1</normal></plane></geometry>"
    box = "<geometry><box><size>1 1 1</size></box></geometry>"
    models = "".join(
        f'<model name="m{i}"><static>true</static>'
        f"<pose>{2 * (i % 10)} {2 * (i // 10)} 0.5 0 0 0</pose>"
        f'<link name="l"><collision name="c">{box}</collision></link></model>\n'
        for i in range(boxes)
    )
    return (
        '<sdf version="1.9"><world name="hall"><model name="ground">'
        '<static>true</static><link name="l"><collision name="c">\n'
        f'{plane}</collision><visual name="v">{plane}</visual></link></model>\n'
        f"{models}</world></sdf>"
    )


@pytest.mark.parametrize("name", ["hall.sdf", "hall.world"])
def test_a_plane_beside_many_shapes_is_read(name, tmp_path):
    """Drake's parser crashes at 14 of them."""
    file = tmp_path / name
    file.write_text(hall(60))
    world = World(models=[Model(file=str(file))])
    assert len(world.obstacles()) == 60
    text = {
        "world": {"models": [{"file": str(file)}]},
        "robot": {"start": [-3, -3, 0], "type": "pmb2", "radius": 0.27},
        "simulation": {"duration": 0.2},
    }
    recording = RunTrial(LoadScenario(data=yaml.safe_dump(text))).recording
    assert np.isfinite(recording.robot).all()


def test_a_model_of_a_world_file_is_found_from_there(tmp_path):
    (tmp_path / "rack.sdf").write_text(
        '<sdf version="1.9"><model name="rack"><static>true</static>'
        '<link name="l"><collision name="c"><geometry><box><size>1 1 1</size>'
        "</box></geometry></collision></link></model></sdf>"
    )
    file = tmp_path / "hall.world"
    file.write_text(
        '<sdf version="1.9"><world name="hall"><include><uri>rack.sdf</uri>'
        "<pose>3 0 0.5 0 0 0</pose></include></world></sdf>"
    )
    x = World(models=[Model(file=str(file))]).obstacles().segments[:, 0]
    assert (x.min(), x.max()) == pytest.approx((2.5, 3.5))


def test_a_file_that_crashes_drake_is_refused(tmp_path):
    """Here, by a plane in a file that the named one includes."""
    box = "<box><size>1 1 1</size></box>"
    shapes = "".join(
        f'<collision name="c{i}"><geometry>{shape}</geometry></collision>'
        for i, shape in enumerate(["<plane/>", *[box] * 60])
    )
    (tmp_path / "hall.sdf").write_text(
        '<sdf version="1.9"><model name="hall"><link name="l">'
        f"{shapes}</link></model></sdf>"
    )
    model = {"name": "hall", "file": f"file://{tmp_path}/hall.sdf"}
    file = tmp_path / "whole.dmd.yaml"
    file.write_text(yaml.safe_dump({"directives": [{"add_model": model}]}))
    with pytest.raises(WorldFileError, match=r"whole.*crashes Drake \(SIGSEGV"):
        World(models=[Model(file=str(file))]).obstacles()


@pytest.mark.slow
def test_a_plane_that_cannot_be_left_out_is_refused(tmp_path):
    """Beside the walls of a trial it would crash Drake."""
    file = tmp_path / "robot.xml"
    file.write_text(
        '<mujoco model="robot"><worldbody>'
        '<geom name="ground" type="plane" size="1 1 1"/><body name="base">'
        '<freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
    robot = {"type": "urdf", "file": str(file), "base": "base"}
    robot["drive"] = "omnidirectional"
    ((place, message),) = ROBOTS.make(robot).find_faults()
    assert place == ("file",)
    assert "has the plane" in message
    assert "ground" in message


@pytest.mark.slow
@pytest.mark.parametrize("mesh", ["part.obj", "empty.obj", "broken.gltf"])
def test_what_a_camera_cannot_see_is_refused_with_one(mesh, tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    file = tmp_path / "robot.urdf"
    look = '<visual><geometry><cylinder radius="0.2" length="0.1"/></geometry>'
    assert look in FOOTPRINT
    other = f'<visual><geometry><mesh filename="{mesh}"/></geometry>'
    file.write_text(FOOTPRINT.replace(look, other))
    _, base, drive = MODELS["turtle.urdf"]
    robot = {"type": "urdf", "file": str(file), "base": base, "drive": drive}
    robot["radius"] = 0.2
    assert LoadScenario(data=yaml.safe_dump({"robot": robot}))
    seen = {"robot": robot, "sensors": [{"type": "camera"}]}
    with pytest.raises(ScenarioError, match="no camera can see it") as info:
        LoadScenario(data=yaml.safe_dump(seen))
    (fault,) = info.value.faults
    assert fault.path == "robot.file"
