import base64
import io
import itertools
import json

import numpy as np
from PIL import Image
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake.systems.behavior import ACTIVITIES
from hunav_drake.systems.common.layout import SILENT, Activity, Posture, Signal
from hunav_drake.systems.people import gait
from hunav_drake.systems.people.figure_config import adult_figures
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot import DifferentialDriveConfig
from hunav_drake.systems.scene import AddScene, SceneConfig, SceneInputs
from hunav_drake.systems.scene.human_body import disc_height
from hunav_drake.systems.scene.overlays import board as mut
from hunav_drake.systems.scene.overlays.costmaps import (
    CostmapBoard,
    ShowCostmap,
)
from hunav_drake.systems.scene.overlays.publisher import spread
from hunav_drake.systems.scene.overlays.tags import (
    CALM,
    REACTING,
    UNTOLD,
    WORDS,
    TagBoard,
    calm_activities,
    tag_picture,
    tag_text,
)
from hunav_drake.systems.scene.palette import TOPS, accent, clothes, top_of
from hunav_drake.systems.scene.scene_config import COSTMAPS, OVERLAYS, Rays
from hunav_drake.systems.world.maps.cost_picture import cost_colors
from hunav_drake.systems.world.maps.costs import LETHAL, NO_MAP, Costmap
from hunav_drake.systems.world.shapes import World

HUMANS = [
    HumanConfig(name=name, pose=(x, 0.0, 0.0), goals=[(x, 5.0)])
    for name, x in (("ana", 0.0), ("bo", 3.0))
]
ROBOT = DifferentialDriveConfig(start=(-3.0, 0.0, 0.0), goal=(5.0, 0.0, 0.0))
STATES = np.array(
    [[0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.3], [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3]]
)
ROBOT_STATE = np.array([-3.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.35])


def test_several_robots_have_names_goals_and_frames_of_their_own(monkeypatch):
    owners = {}

    def made(text, colors=CALM, *, owner=None):
        owners[text.split()[0]] = owner
        return TagBoard(text, colors, owner=owner)

    monkeypatch.setattr(mut, "TagBoard", made)
    builder = DiagramBuilder()
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    robots = {
        name: DifferentialDriveConfig(start=(-3, y, 0), goal=(5, y, 0))
        for name, y in (("anna", 0.0), ("bob", 2.0))
    }
    scene = AddScene(builder, World(), HUMANS, robots, meshcat=meshcat)
    builder.ExportInput(scene.human_states, "human_states")
    for name in robots:
        port = f"{name}_robot_state"
        builder.ExportInput(scene.system.GetInputPort(port), port)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("human_states").FixValue(context, STATES.ravel())
    for i, name in enumerate(robots):
        row = ROBOT_STATE + np.eye(7)[1] * 2 * i
        diagram.GetInputPort(f"{name}_robot_state").FixValue(context, row)
    simulator.Initialize()
    for name in robots:
        frame = f"{mut.PLACE}/overlay_robot/{name}"
        assert meshcat.HasPath(f"{frame}/overlay_names/0")
        assert meshcat.HasPath(f"{mut.FIGURES}/{name}_goal")
        assert meshcat.HasPath(f"{mut.PLACE}/overlay_plan/{name}/0")
    # Dots on tags have the colors of the figures.
    for i, human in enumerate(HUMANS):
        assert owners[human.name] == clothes(i).top
    assert [owners["anna"], owners["bob"]] == [accent(0), accent(1)]


def test_an_estimated_pose_has_an_outline_that_follows_it(meshcat, monkeypatch):
    place = f"{mut.PLACE}/overlay_estimate"
    run(meshcat)
    assert not meshcat.HasPath(f"{place}/ring")
    placed = []
    monkeypatch.setattr(
        Meshcat,
        "SetTransform",
        lambda _, path, X, *time: placed.append((path, X.translation())),
    )
    row = ROBOT_STATE + np.eye(7)[0] * 0.4
    run(meshcat, estimated_robot_state=row)
    assert meshcat.HasPath(f"{place}/ring")
    found = [xyz for path, xyz in placed if path == place]
    assert len(found) > 1
    np.testing.assert_array_equal(found[-1][:2], row[:2])


class RecordingMeshcat:
    """Records the properties set in a Meshcat, by path and name."""

    def __init__(self, meshcat, monkeypatch):
        self.told = {}
        tell = meshcat.SetProperty

        def SetProperty(path, property, value, time=None):
            self.told.setdefault((path, property), []).append((time, value))
            tell(path, property, value, time)

        monkeypatch.setattr(
            Meshcat, "SetProperty", lambda _, *a: SetProperty(*a)
        )

    def last(self, path, property="visible"):
        return self.told[path, property][-1][1]


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(host="localhost"))


def run(meshcat, *, seconds=0.3, states=STATES, config=None, **inputs):
    builder = DiagramBuilder()
    ports = AddScene(
        builder,
        World(),
        HUMANS,
        ROBOT,
        meshcat=meshcat,
        config=config,
        inputs=SceneInputs(
            scan_angles=inputs.pop("scan_angles", None),
            sayings=inputs.pop("sayings", None),
        ),
    )
    for i in range(ports.system.num_input_ports()):
        port = ports.system.get_input_port(i)
        builder.ExportInput(port, port.get_name())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    inputs = {
        "human_states": np.ravel(states),
        "robot_state": ROBOT_STATE,
    } | inputs
    for name, value in inputs.items():
        diagram.GetInputPort(name).FixValue(context, value)
    ports.visualizer.StartRecording()
    simulator.AdvanceTo(seconds)
    ports.visualizer.StopRecording()
    return ports


def test_the_scenario_says_what_is_shown_to_begin_with(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    run(meshcat, config=SceneConfig(overlays=["rings", "goals"]))
    ana = f"{mut.FIGURES}/ana/base/overlay_"
    assert dut.last(ana + "rings") is True
    assert dut.last(ana + "names") is False
    assert dut.last(f"{mut.PLACE}/overlay_walked") is False
    assert dut.last(f"{mut.FIGURES}/robot_goal") is True
    for path in ("ana/base/overlay_rings/2", "bo/base/overlay_names/0"):
        assert meshcat.HasPath(f"{mut.FIGURES}/{path}")


def test_bubbles_tell_what_people_say(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    sayings = [{5.0: "good morning", 7.0: "good night"}, {}]
    signals = np.tile(SILENT, (2, 1))
    signals[0, Signal.UTTERANCE] = 7.0
    # (What nobody has a text for is not told.)
    signals[1, Signal.UTTERANCE] = 9.0
    run(meshcat, sayings=sayings, social_signals=signals.ravel())
    bubbles = f"{mut.FIGURES}/ana/base/overlay_speech"
    assert [dut.last(f"{bubbles}/{k}") for k in range(2)] == [False, True]
    assert dut.last(bubbles) is True
    assert not meshcat.HasPath(f"{mut.FIGURES}/bo/base/overlay_speech")
    dut.told.clear()
    run(meshcat, sayings=sayings)
    assert not any(
        value
        for (path, _), told in dut.told.items()
        if path.startswith(f"{bubbles}/")
        for _, value in told
    )


def test_tags_tell_what_people_do_with_each_other(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    signals = np.tile(SILENT, (2, 1))
    # Ana walks there still; Bo sits, which is no reaction to the robot.
    signals[:, Signal.ACTIVITY] = Activity.SIT
    signals[1, Signal.POSTURE] = Posture.SEATED
    run(
        meshcat,
        behavior_status=[1.0, 1.0],
        sayings=[{}, {}],
        social_signals=signals.ravel(),
    )
    words = [*mut.ACTIVITIES, *WORDS.values()]
    shown = {
        name: [
            word
            for k, word in enumerate(words)
            if dut.last(f"{mut.FIGURES}/{name}/base/overlay_names/{k}")
        ]
        for name in ("ana", "bo")
    }
    assert shown == {"ana": [""], "bo": ["sits"]}
    assert not dut.last(f"{mut.FIGURES}/bo/base/overlay_reactions/0")


def test_who_uses_a_desk_works():
    signals = np.tile(SILENT, (2, 1))
    signals[:, Signal.ACTIVITY] = Activity.USE
    signals[0, Signal.POSTURE] = Posture.SEATED
    assert calm_activities(signals.ravel(), 2) == ["works", "uses something"]


def test_who_lies_is_not_said_to_sit_nor_who_stands_before_a_seat():
    signals = np.tile(SILENT, (3, 1))
    signals[:, Signal.ACTIVITY] = Activity.SIT
    signals[:, Signal.POSTURE] = [*Posture]
    assert calm_activities(signals.ravel(), 3) == ["", "sits", "lies"]


def test_who_reacts_has_a_sign_and_another_tag(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    run(meshcat, behavior_status=[1.0, 0.0])
    visible = [
        [
            dut.last(f"{mut.FIGURES}/{name}/base/overlay_names/{k}")
            for k in range(len(mut.ACTIVITIES))
        ]
        for name in ("ana", "bo")
    ]
    # Ana reacts; Bo, whose speed is 0, stands.
    assert visible == [[False, False, True], [False, True, False]]
    signs = [
        dut.last(f"{mut.FIGURES}/{name}/base/overlay_reactions/0")
        for name in ("ana", "bo")
    ]
    assert signs == [True, False]


def test_arrows_point_along_forces(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    forces = np.zeros((2, 16))
    # To the goal: along +y, 1 m/s^2, of a person who looks along 0.5 rad.
    forces[0, :2] = [0.0, 1.0]
    run(meshcat, forces=forces.ravel())
    arrow = f"{mut.FIGURES}/ana/base/overlay_forces/0"
    x, y, z, w = dut.last(arrow, "quaternion")
    assert (x, y) == (0.0, 0.0)
    assert 2 * np.arctan2(z, w) + 0.5 == pytest.approx(np.pi / 2)
    assert dut.last(arrow, "scale")[0] == pytest.approx(0.5)


def test_the_plan_is_drawn_along_its_path(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    path = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 1.57]])
    run(meshcat, planner_path=Value(path))
    places = np.array(
        [
            dut.last(f"{mut.PLACE}/overlay_plan/{k}", "position")
            for k in range(mut.PLAN_DOTS)
        ]
    )
    np.testing.assert_allclose(places[0, :2], [0.0, 0.0])
    np.testing.assert_allclose(places[-1, :2], [3.0, 1.0])
    assert np.all((places[:, 1] == 0) | (np.abs(places[:, 0] - 3) < 1e-12))
    run(meshcat, planner_path=Value(np.zeros((0, 3))))
    assert dut.last(f"{mut.PLACE}/overlay_plan/0", "position")[2] < 0


def test_a_scan_is_drawn_where_its_rays_end(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    run(
        meshcat,
        scan_angles=np.array([0.0, np.pi / 2, np.pi]),
        scan=[2.0, 1.0, np.inf],
    )
    places = np.array(
        [
            dut.last(f"{mut.PLACE}/overlay_scan/{k}", "position")
            for k in range(3)
        ]
    )
    np.testing.assert_allclose(
        places[:2, :2], [[-1.0, 0.0], [-3.0, 1.0]], atol=1e-12
    )
    # What meets nothing is not seen.
    assert places[2, 2] < 0


@pytest.mark.parametrize("on_robot", [True, False])
def test_a_scan_begins_where_its_lidar_is(on_robot, meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    rays = Rays(np.array([np.pi / 2, 0.0]), (0.5, 0.2), 5.0, on_robot)
    run(meshcat, scan_angles=rays, scan=[2.0, 5.0])
    (x, y, _), nowhere = (
        dut.last(f"{mut.PLACE}/overlay_scan/{k}", "position") for k in range(2)
    )
    assert (x, y) == pytest.approx((-2.5 if on_robot else 0.5, 2.2))
    # A ray that meets nothing ends nowhere.
    assert nowhere[2] < 0


def a_costmap():
    costs = np.zeros((30, 20), dtype=np.uint8)
    costs[12, 3] = LETHAL
    return Costmap(costs, (-4.0, 1.0), 0.1)


@pytest.mark.parametrize("name", COSTMAPS)
def test_a_costmap_that_is_shown_is_recorded_twice_per_second(
    meshcat, monkeypatch, name
):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    costmap = AbstractValue.Make(a_costmap())
    shown = SceneConfig(overlays=[name])
    run(meshcat, seconds=1.2, config=shown, **{name: costmap})
    place = f"{mut.PLACE}/overlay_{name}"
    assert [meshcat.HasPath(f"{place}/{k}") for k in range(4)] == [
        *([True] * 3),
        False,
    ]
    # Each until the next one.
    for k in range(3):
        told = dict(dut.told[f"{place}/{k}", "visible"])
        when = {round(time, 6): visible for time, visible in told.items()}
        steps = {0.5 * k: True, 0.5 * k + 0.5: False}
        assert when == {0.0: k == 0} | steps


def test_a_costmap_that_is_hidden_is_not_made_for_a_recording(meshcat):
    run(meshcat, local_costmap=AbstractValue.Make(a_costmap()))
    assert not meshcat.HasPath(f"{mut.PLACE}/overlay_local_costmap/0")


def test_a_map_without_cells_is_not_drawn(meshcat):
    shown = SceneConfig(overlays=["local_costmap"])
    run(meshcat, config=shown, local_costmap=AbstractValue.Make(NO_MAP))
    assert not meshcat.HasPath(f"{mut.PLACE}/overlay_local_costmap/0")


def test_a_live_view_shows_each_costmap_in_the_place_of_the_last(
    meshcat, monkeypatch
):
    drawn = []
    monkeypatch.setattr(
        Meshcat, "SetObject", lambda _, path, *rest: drawn.append(path)
    )
    place = f"{mut.PLACE}/overlay_local_costmap"
    for count in range(3):
        ShowCostmap(meshcat, place, count, a_costmap(), 0.01)
    assert drawn.count(f"{place}/shown") == 3
    # The others are there for browsers that fetch them late; nobody sees them.
    dut = RecordingMeshcat(meshcat, monkeypatch)
    ShowCostmap(meshcat, place, 3, a_costmap(), 0.01)
    assert dut.last(f"{place}/kept") is False
    ShowCostmap(meshcat, place, 4, NO_MAP, 0.01)
    assert not meshcat.HasPath(f"{place}/shown")


def content(uri):
    return base64.b64decode(uri.partition(",")[2])


def test_a_board_lies_where_its_map_does_with_rows_up_along_y():
    costmap = a_costmap()
    mesh = CostmapBoard(costmap, 0.02)
    gltf = json.loads(mesh.source().in_memory().mesh_file.contents())
    data = content(gltf["buffers"][0]["uri"])
    places = np.frombuffer(data, "<f4", 12).reshape(4, 3)
    uv = np.frombuffer(data, "<f4", 8, 48).reshape(4, 2)
    # glTF has y up; z is away from the world's y.
    p_WC = np.column_stack([places[:, 0], -places[:, 2], places[:, 1]])
    x, y = costmap.center_of(12, 3)
    low, high = p_WC[:, :2].min(axis=0), p_WC[:, :2].max(axis=0)
    np.testing.assert_allclose(low, [-4.0, 1.0])
    np.testing.assert_allclose(high, [-2.0, 4.0])
    np.testing.assert_allclose(p_WC[:, 2], 0.02)
    # A picture begins at its top left, as its coordinates do.
    np.testing.assert_allclose(uv[:, 0], (p_WC[:, 0] - low[0]) / 2.0)
    np.testing.assert_allclose(uv[:, 1], (high[1] - p_WC[:, 1]) / 3.0)
    picture = Image.open(io.BytesIO(content(gltf["images"][0]["uri"])))
    pixels = np.array(picture.convert("RGBA"))
    row = int((high[1] - y) / 0.1)
    column = int((x - low[0]) / 0.1)
    np.testing.assert_array_equal(pixels[row, column], cost_colors()[LETHAL])
    # All but the edge and this cell is clear.
    assert np.count_nonzero(pixels[1:-1, 1:-1, 3]) == 1
    assert pixels[0, 0, 3] > 0


def test_dots_of_walked_paths_lie_where_people_were(meshcat, monkeypatch):
    dut = RecordingMeshcat(meshcat, monkeypatch)
    run(meshcat, seconds=1.3)
    # One every half second.
    for k in range(3):
        for walker, place in (("ana", STATES[0]), ("robot", ROBOT_STATE)):
            path = f"{mut.PLACE}/overlay_walked/{walker}/{k}"
            told = dut.told[path, "position"]
            np.testing.assert_allclose(told[-1][1][:2], place[:2])
            scales = dict(dut.told[path, "scale"])
            at = min(t for t, v in scales.items() if v[0] == 1.0)
            assert at == pytest.approx(0.5 * k, abs=0.05)
            # It has shrunk away when its time is over.
            assert scales[max(scales)][0] < 0.01
            assert max(scales) == pytest.approx(at + 6.0, abs=0.2)
    assert (f"{mut.PLACE}/overlay_walked/ana/3", "scale") not in dut.told


def test_who_is_absent_is_far_away_and_comes_back_standing():
    states = STATES.copy()
    states[1] = np.nan
    before = gait.initial_gait([1, 2])
    before[gait.GAIT_SIZE + gait.PACE] = 1.2
    after = gait.advance_gait(before, states.ravel(), 0.05)
    assert np.isfinite(after).all()
    assert after[gait.GAIT_SIZE + gait.PACE] == 0.0
    figures = gait.pose_figures(after, states.ravel(), adult_figures(2))
    assert np.isfinite(figures).all()
    assert figures[0, gait.BASE_X] == 0.0
    assert figures[1, gait.BASE_X] == gait.ABSENT


def test_absent_people_disturb_nothing(meshcat):
    states = STATES.copy()
    states[0] = np.nan
    forces = np.full((2, 16), np.nan)
    run(meshcat, states=states, forces=forces.ravel(), seconds=1.0)


def test_no_two_discs_that_may_overlap_share_a_height():
    heights = [disc_height(level) for level in range(12)]
    gaps = np.diff(sorted(heights))
    assert gaps.min() > 5e-4
    # Above all marks on the floor.
    assert min(heights) > 0.0095


def test_a_scene_without_meshcat_has_no_inputs_for_overlays():
    ports = AddScene(DiagramBuilder(), World(), HUMANS, ROBOT)
    assert ports.system.num_input_ports() == 2


def test_overlays_are_known_by_name():
    assert SceneConfig(overlays=list(OVERLAYS)).overlays == [*OVERLAYS]
    with pytest.raises(ValueError, match="overlays"):
        SceneConfig(overlays=["halo"])


def test_spread_gives_points_at_equal_distances():
    path = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.0], [3.0, 1.0]])
    points = spread(path, 5)
    np.testing.assert_allclose(
        points, [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1]], atol=1e-12
    )
    np.testing.assert_array_equal(spread(path[:1], 3), np.zeros((3, 2)))


def test_the_length_of_arrows_grows_to_a_limit():
    assert mut.force_scale(np.array([1.0, 0.0])) == (0.5, 0.0)
    length, angle = mut.force_scale(np.array([0.0, -100.0]))
    assert length == 2.0
    assert angle == pytest.approx(-np.pi / 2)
    assert mut.force_scale(np.zeros(2))[0] > 0


def test_tags_tell_name_behavior_and_activity():
    assert tag_text("ana", "sit", "sits") == "ana \N{MIDDLE DOT} sits"
    assert tag_text("ana", "lunch") == "ana"
    assert {"regular", *ACTIVITIES} == UNTOLD
    text = tag_text("ana", "curious", "reacts")
    assert [part in text for part in ("ana", "curious", "reacts")] == [True] * 3
    assert len(tag_text("x" * 90, "regular")) <= 40
    assert tag_text("ana", "xml", "stands") == "ana \N{MIDDLE DOT} stands"
    text = tag_text("doctor_nora", "distracted", "stands")
    assert text.endswith("stands")
    calm, reacting = (tag_picture(text, it) for it in (CALM, REACTING))
    assert calm.size == reacting.size
    middle = (calm.width // 2, 2)
    assert calm.getpixel(middle) != reacting.getpixel(middle)


def test_a_dot_on_a_tag_has_the_color_of_its_owner():
    plain = tag_picture("ana")
    for letters in (11, 28):
        for k in range(4):
            color = top_of(k)
            rgb = [round(255 * it) for it in (color.r(), color.g(), color.b())]
            tag = tag_picture("ana", letters=letters, owner=color)
            shown = tag.getpixel((round(0.8 * letters), tag.height // 2))
            np.testing.assert_allclose(shown, [*rgb, 255], atol=2)
    assert tag.height == plain.height
    assert tag.width > plain.width


def lab(rgb):
    """CIELAB of an sRGB color, D65."""
    c = np.array(rgb)
    linear = np.where(c > 0.04045, ((c + 0.055) / 1.055) ** 2.4, c / 12.92)
    xyz = linear @ np.array(
        [
            [0.4124, 0.2126, 0.0193],
            [0.3576, 0.7152, 0.1192],
            [0.1805, 0.0722, 0.9505],
        ]
    )
    x, y, z = np.cbrt(xyz / [0.9505, 1.0, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_twenty_four_shirts_can_be_told_apart():
    colors = [lab((c.r(), c.g(), c.b())) for c in TOPS]
    assert len(colors) == 24
    distances = [
        np.linalg.norm(a - b) for a, b in itertools.combinations(colors, 2)
    ]
    assert min(distances) > 25
