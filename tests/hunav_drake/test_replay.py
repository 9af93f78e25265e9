import base64
import dataclasses
import json
from pathlib import Path
import re

from hypothesis import given, strategies as st
import matplotlib.image
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
import pytest

from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot import DifferentialDriveConfig
from hunav_drake.systems.scene import AddScene, Bounds
from hunav_drake.systems.world.shapes import Box, World
from hunav_drake.views import replay as mut
from tests import screenshot

CORRIDOR = World(
    walls=[
        Box(center=(0.0, y), size=(12.0, 0.2), height=1.0) for y in (-2.6, 2.6)
    ]
)
HUMANS = [
    HumanConfig(name=name, pose=pose, goals=[(-pose[0], pose[1])])
    for name, pose in (
        ("ana", (4.5, 1.2, np.pi)),
        ("bo", (5.0, -0.6, np.pi)),
        ("cy", (-4.0, -1.6, 0.0)),
    )
]
ROBOT = DifferentialDriveConfig(start=(-5.0, 0.3, 0.0), goal=(5.0, 0.3, 0.0))
SPEED = 1.0
DURATION = 8.0


def moving(pose, radius):
    """A state that walks straight ahead."""
    x, y, yaw = pose
    v = SPEED * np.array([np.cos(yaw), np.sin(yaw)])
    start = np.array([x, y, yaw, *v, 0.0, radius])
    end = start.copy()
    end[:2] += v * DURATION
    return start, end


def record_replay(meshcat, duration=DURATION, **options):
    """Records people and a robot that walk through a corridor."""
    builder = DiagramBuilder()
    ports = AddScene(
        builder, CORRIDOR, HUMANS, ROBOT, meshcat=meshcat, **options
    )
    people = [moving(h.pose, h.radius) for h in HUMANS]
    for port, rows in (
        (ports.human_states, people),
        (ports.robot_state, [moving(ROBOT.start, ROBOT.radius)]),
    ):
        ends = np.stack([np.concatenate(r) for r in zip(*rows, strict=True)])
        source = builder.AddSystem(
            TrajectorySource(
                PiecewisePolynomial.FirstOrderHold([0.0, DURATION], ends.T)
            )
        )
        builder.Connect(source.get_output_port(), port)
    mut.SetView(meshcat, CORRIDOR, HUMANS, ROBOT)
    simulator = Simulator(builder.Build())
    with mut.RecordReplay(ports.visualizer):
        simulator.AdvanceTo(duration)
    return ports


def viewer_commands(html: str) -> bytes:
    """The commands that a static page gives to its viewer."""
    blobs = re.findall(r"base64,([A-Za-z0-9+/=]+)", html)
    return b"\n".join(base64.b64decode(blob) for blob in blobs)


@pytest.fixture(scope="module")
def meshcat():
    return mut.StartMeshcatLocal()


def test_a_local_meshcat_listens_to_this_computer_alone(meshcat):
    addresses = set()
    for table in ("tcp", "tcp6"):
        for line in (
            Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]
        ):
            address, port = line.split()[1].split(":")
            if int(port, 16) == meshcat.port():
                addresses.add(address)
    local = {"0100007F", "0" * 24 + "01000000"}
    assert addresses
    assert addresses <= local


def test_a_replay_holds_people_robot_view_and_recording(meshcat, tmp_path):
    record_replay(meshcat, duration=2.0)
    path = mut.SaveReplay(meshcat, tmp_path / "replay.html")
    html = screenshot.unpacked(path.read_text())
    said = viewer_commands(html)
    for part in (b"ana/trunk", b"bo/trunk", b"cy/left_shin", b"robot/base"):
        assert part in said
    for part in (b"set_animation", b"set_target", b"PerspectiveCamera"):
        assert part in said
    assert path.stat().st_size < 2e6


def test_a_replay_has_overlays_and_controls_for_them(meshcat, tmp_path):
    record_replay(meshcat, duration=2.0)
    path = mut.SaveReplay(meshcat, tmp_path / "replay.html")
    html = screenshot.unpacked(path.read_text())
    said = viewer_commands(html)
    for overlay in ("names", "rings", "forces", "reactions"):
        assert f"ana/base/overlay_{overlay}".encode() in said
    for overlay in ("walked", "plan", "clock"):
        assert f"overlays/overlay_{overlay}".encode() in said
    # The script of the page makes a check box of each that it finds.
    for overlay in ("goals", "walked", "plan", "rings", "forces", "names"):
        assert f'["{overlay}", ' in html
    for control in ("pause", "restart", "time", "speed"):
        assert f'id="hunav-{control}"' in html
    assert html.rstrip().endswith("</html>")


def test_a_replay_unpacks_itself_without_a_network(meshcat, tmp_path):
    path = mut.SaveReplay(meshcat, tmp_path / "replay.html")
    html = path.read_text()
    assert "DecompressionStream" in html
    assert not re.search(r"(src|href)=", html)
    page = screenshot.unpacked(html)
    assert page == mut.with_panel(meshcat.StaticHtml())


def test_the_view_shows_where_people_and_robot_will_be():
    far = World(walls=[Box(center=(0.0, 0.0), size=(100.0, 0.2))])
    bounds = mut.view_bounds(far, HUMANS, ROBOT)
    for human in HUMANS:
        for x, y in (human.pose[:2], *human.goals):
            assert bounds.x_min < x < bounds.x_max
            assert bounds.y_min <= y <= bounds.y_max
    assert bounds.size[0] < 20.0
    assert mut.view_bounds(far).size[0] > 100.0


def test_the_view_cuts_off_no_wall_that_is_hardly_beyond_it():
    places = np.array([it.pose[:2] for it in HUMANS])
    east = places[:, 0].max() + 40.0
    person = dataclasses.replace(HUMANS[0], goals=[(east, 0.0)])
    shown = [
        mut.view_bounds(
            World(walls=[Box(center=(east + away, 0.0), size=(0.2, 8.0))]),
            [person],
        ).x_max
        > east + away
        for away in (3.0, 9.0)
    ]
    assert shown == [True, False]


def test_a_recording_has_ten_frames_per_second(meshcat):
    ports = record_replay(meshcat, duration=2.0)
    recording = ports.visualizer.get_mutable_recording()
    assert recording.frames_per_second() == pytest.approx(10.0)


def test_a_recording_is_kept_when_a_run_fails(meshcat, tmp_path):
    meshcat.Delete()
    builder = DiagramBuilder()
    ports = AddScene(builder, World(), [], ROBOT, meshcat=meshcat)
    builder.ExportInput(ports.robot_state)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    diagram.get_input_port().FixValue(
        simulator.get_mutable_context(), [1.0] + [0.0] * 6
    )

    def run():
        with mut.RecordReplay(ports.visualizer):
            simulator.AdvanceTo(1.0)
            raise KeyError("the run failed")

    with pytest.raises(KeyError):
        run()
    assert b"set_animation" in viewer_commands(meshcat.StaticHtml())


def test_a_failed_save_leaves_the_old_file(meshcat, tmp_path, monkeypatch):
    path = tmp_path / "replay.html"
    path.write_text("old")

    def fail(*args):
        raise OSError("disk full")

    monkeypatch.setattr(mut.os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        mut.SaveReplay(meshcat, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


coordinates = st.floats(-1e3, 1e3)
lengths = st.floats(0.5, 300.0)


@given(coordinates, coordinates, lengths, lengths, st.floats(0.7, 3.0))
def test_the_camera_sees_all_of_the_floor(x, y, width, depth, aspect):
    bounds = Bounds(x, y, x + width, y + depth)
    p_WC, p_WT = mut.camera_pose(bounds, aspect)
    ahead = (p_WT - p_WC) / np.linalg.norm(p_WT - p_WC)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    assert p_WC[2] > 1.8
    # The longer side lies along the width of the screen.
    assert abs(
        right[0 if bounds.size[0] >= bounds.size[1] else 1]
    ) == pytest.approx(1.0)

    extents = []
    for corner_x in (bounds.x_min, bounds.x_max):
        for corner_y in (bounds.y_min, bounds.y_max):
            for z in (0.0, 1.7):
                p_CQ = np.array([corner_x, corner_y, z]) - p_WC
                tan_up = np.tan(np.radians(32.0) / 2)
                scale = p_CQ @ ahead * tan_up
                assert scale > 0
                extents.append(
                    (p_CQ @ right / (scale * aspect), p_CQ @ up / scale)
                )
    largest = np.abs(extents).max()
    assert largest <= 1.001
    assert largest > 0.8


def hue_mask(picture, hue, tolerance=0.04):
    """Where a picture has a clear color of some hue, in [0, 1)."""
    hsv = matplotlib.colors.rgb_to_hsv(picture[..., :3])
    off = np.abs((hsv[..., 0] - hue + 0.5) % 1 - 0.5)
    return (off < tolerance) & (hsv[..., 1] > 0.55) & (hsv[..., 2] > 0.3)


@pytest.mark.slow
def test_a_replay_shows_people_walking(meshcat, tmp_path):
    meshcat.Delete()
    record_replay(meshcat)
    html = mut.SaveReplay(meshcat, tmp_path / "replay.html")
    seen = []
    for time in (0.0, 4.0, DURATION):
        # (The overview follows the robot.)
        png = screenshot.render(
            html, tmp_path / f"{time}.png", time=time, view="top"
        )
        picture = matplotlib.image.imread(png)
        assert picture.shape[:2] == (800, 1200)
        places = {}
        # Hues of the shirts: blue, yellow, green; the goals have them too.
        for name, hue in (("ana", 0.56), ("bo", 0.115), ("cy", 0.45)):
            columns = np.nonzero(hue_mask(picture, hue))[1]
            assert len(columns) > 150, f"{name} is not in the picture"
            places[name] = np.median(columns)
        seen.append(places)
    first, middle, last = seen
    assert first["ana"] > middle["ana"] + 100 > last["ana"] + 200
    assert first["bo"] > middle["bo"] + 100 > last["bo"] + 200
    assert first["cy"] < middle["cy"] - 100 < last["cy"] - 200


def test_marks_are_in_the_page(meshcat):
    marks = [[("</script> & 'so'", 0.5, 1.5, "#d55e00")]]
    page = mut.with_panel(meshcat.StaticHtml(), marks)
    panel = mut.with_panel("</body>", marks)
    assert "MARKED_TIMES" not in page
    assert panel.count("</script>") == 1
    told = re.search(r"for \(const marks of (.*)\) \{", panel)[1]
    assert json.loads(told) == [[list(marks[0][0])]]
