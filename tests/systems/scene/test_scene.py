import subprocess
import sys

import numpy as np
from pydrake.geometry import GeometrySet, Mesh, Role, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake.systems.people.figure_config import FigureConfig
from hunav_drake.systems.people.gait import FIGURE_SIZE, GAIT_SIZE, SHIN, THIGH
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot import (
    DifferentialDriveConfig,
    PMB2Config,
    UrdfRobot,
)
from hunav_drake.systems.scene import AddScene, SceneKinematics, scene_bounds
from hunav_drake.systems.scene.human_body import AddHumanBody
from hunav_drake.systems.scene.palette import clothes
from hunav_drake.systems.scene.scene import frame_period
from hunav_drake.systems.scene.surroundings import ShowCut
from hunav_drake.systems.world.furniture import (
    FURNITURE,
    Chair,
    DoorFrame,
    Shelf,
    Sign,
)
from hunav_drake.systems.world.shapes import Box, Polygon, Polyline, World
from tests.systems.robot.crate import FOOTPRINT, STAGES, write_model

STATES = np.array(
    [
        [1.0, 2.0, 0.5, 1.2 * np.cos(0.5), 1.2 * np.sin(0.5), 0.0, 0.35],
        [-3.0, 0.5, 3.1, 0.0, 0.0, 0.0, 0.3],
        [4.0, -1.0, -2.0, 0.3 * np.cos(2.0), -0.3 * np.sin(2.0), 0.2, 0.4],
    ]
)
ROBOT_STATE = np.array([-1.0, -2.0, 0.7, 0.4, 0.1, 0.0, 0.35])
HUMANS = [HumanConfig(name=n, pose=(0.0, 0.0, 0.0)) for n in ("ana", "bo", "")]


class Trial:
    """A scene with states held at its inputs."""

    def __init__(self, world=None, humans=HUMANS, robot=None, **options):
        builder = DiagramBuilder()
        self.ports = AddScene(
            builder, world or World(), humans, robot, **options
        )
        builder.ExportInput(self.ports.human_states, "human_states")
        if robot:
            builder.ExportInput(self.ports.robot_state, "robot_state")
        builder.ExportOutput(self.ports.query_object, "query")
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        self.fix(STATES[: len(humans)])
        if robot:
            self.diagram.GetInputPort("robot_state").FixValue(
                self.context, ROBOT_STATE
            )

    def fix(self, states, context=None):
        self.diagram.GetInputPort("human_states").FixValue(
            context or self.context, np.ravel(states)
        )

    def query(self, context=None):
        return self.diagram.GetOutputPort("query").Eval(context or self.context)

    @property
    def inspector(self):
        return self.ports.scene_graph.model_inspector()

    def X_WB(self, instance, body="base", context=None) -> RigidTransform:
        plant = self.ports.plant
        frame = plant.GetBodyFrameIdOrThrow(
            plant.GetBodyByName(
                body, plant.GetModelInstanceByName(instance)
            ).index()
        )
        return self.query(context).GetPoseInWorld(frame)

    def geometry(self, name):
        """The illustration geometry of the world body by its name."""
        inspector = self.inspector
        return inspector.GetGeometryIdByName(
            inspector.world_frame_id(), Role.kIllustration, name
        )

    def gait(self, context=None):
        return (
            (context or self.context).get_discrete_state_vector().CopyToVector()
        )


def assert_pose(X_WB, x, y, yaw, z=0.0):
    np.testing.assert_allclose(X_WB.translation(), [x, y, z], atol=1e-12)
    forward = X_WB.rotation().col(0)
    np.testing.assert_allclose(
        forward, [np.cos(yaw), np.sin(yaw), 0.0], atol=1e-12
    )
    np.testing.assert_allclose(X_WB.rotation().col(2), [0, 0, 1], atol=1e-12)


def mesh_vertices(shape: Mesh) -> np.ndarray:
    text = shape.source().in_memory().mesh_file.contents().decode()
    return np.array(
        [
            [float(v) for v in line.split()[1:]]
            for line in text.splitlines()
            if line.startswith("v ")
        ]
    )


def test_everybody_is_where_the_states_say():
    dut = Trial(robot=DifferentialDriveConfig())
    for name, state in zip(dut.ports.human_names, STATES, strict=True):
        assert_pose(dut.X_WB(name), *state[:3])
    assert_pose(dut.X_WB("robot"), *ROBOT_STATE[:3])


def test_a_changed_state_moves_its_person_alone():
    dut = Trial()
    dut.query()
    states = STATES.copy()
    states[1, :3] = [7.0, 8.0, -1.0]
    dut.fix(states)
    assert_pose(dut.X_WB("bo"), 7.0, 8.0, -1.0)
    assert_pose(dut.X_WB("ana"), *STATES[0, :3])


def test_the_trunk_is_upright_over_the_place_of_the_person():
    dut = Trial()
    dut.simulator.AdvanceTo(1.0)
    standing = dut.X_WB("bo", "trunk")
    assert_pose(standing, *STATES[1, :3], z=THIGH + SHIN)
    walking = dut.X_WB("ana", "trunk")
    assert_pose(walking, *STATES[0, :3], z=walking.translation()[2])


def test_the_gait_that_the_plant_shows_puts_the_feet_on_the_floor():
    """The arithmetic of the gait agrees with the joints of the figure."""
    dut = Trial()
    for t in np.arange(1, 40) * 0.05:
        dut.simulator.AdvanceTo(t)
        for name in dut.ports.human_names:
            heights = [
                (dut.X_WB(name, f"{side}_shin") @ np.array([x, 0, -SHIN]))[2]
                for side in ("left", "right")
                for x in (-0.06, 0.15)
            ]
            assert min(heights) == pytest.approx(0.0, abs=1e-9)


def test_the_left_side_is_on_the_left():
    dut = Trial()
    for part in ("shin", "arm"):
        sides = [
            dut.X_WB("ana").inverse() @ dut.X_WB("ana", f"{s}_{part}")
            for s in ("left", "right")
        ]
        assert sides[0].translation()[1] > 0.05
        assert sides[1].translation()[1] < -0.05


def test_a_figure_is_a_person_high_and_no_wider_than_its_disc():
    dut = Trial()
    inspector = dut.inspector
    points = []
    for body in ("trunk", "left_shin", "right_shin", "left_arm", "right_arm"):
        plant = dut.ports.plant
        frame = plant.GetBodyFrameIdOrThrow(
            plant.GetBodyByName(
                body, plant.GetModelInstanceByName("bo")
            ).index()
        )
        X_BF = dut.X_WB("bo").inverse() @ dut.X_WB("bo", body)
        for g in inspector.GetGeometries(frame, Role.kIllustration):
            shape = inspector.GetShape(g)
            points.append((X_BF @ (mesh_vertices(shape) * shape.scale3()).T).T)
    p = np.vstack(points)
    assert p[:, 2].min() == pytest.approx(0.0, abs=1e-3)
    assert p[:, 2].max() == pytest.approx(1.7, abs=0.04)
    assert np.abs(p[:, 1]).max() < 0.35
    # The feet and the nose are in front.
    assert p[p[:, 2] < 0.05, 0].max() > 0.15
    assert -p[p[:, 2] < 0.05, 0].min() < 0.10


@pytest.mark.parametrize("height", [0.8, 0.955, 1.4, 1.7, 2.2])
def test_a_figure_is_as_high_as_it_says(height):
    figure = FigureConfig(height=height)
    dut = Trial(humans=[HumanConfig(pose=(0.0, 0.0, 0.0), figure=figure)])
    plant, inspector = dut.ports.plant, dut.inspector
    trunk = plant.GetBodyByName("trunk").index()
    (head,) = (
        g
        for g in inspector.GetGeometries(
            plant.GetBodyFrameIdOrThrow(trunk), Role.kIllustration
        )
        if inspector.GetName(g).endswith("head")
    )
    shape = inspector.GetShape(head)
    X_WG = dut.X_WB("human_1", "trunk") @ inspector.GetPoseInFrame(head)
    top = (X_WG @ (mesh_vertices(shape) * shape.scale3()).T)[2].max()
    assert top == pytest.approx(height, abs=1e-3)


def test_who_is_distracted_looks_at_a_telephone():
    """In the hand that does not swing, before the face, turned to the eyes."""

    def middles(behavior):
        dut = Trial(
            humans=[HumanConfig(pose=(0.0, 0.0, 0.0), behavior=behavior)]
        )
        plant, inspector = dut.ports.plant, dut.inspector
        instance = plant.GetModelInstanceByName("human_1")
        frame = plant.GetBodyFrameIdOrThrow(
            plant.GetBodyByName("trunk", instance).index()
        )
        result = {}
        for g in inspector.GetGeometries(frame, Role.kIllustration):
            shape = inspector.GetShape(g)
            vertices = (mesh_vertices(shape) * shape.scale3()).T
            name = inspector.GetName(g).split("::")[-1]
            points = inspector.GetPoseInFrame(g) @ vertices
            result[name] = points.mean(axis=1)
        return result

    assert "telephone" not in middles("regular")
    dut = middles("distracted")
    telephone, screen, eyes = (
        dut[name] for name in ("telephone", "telephone_screen", "eyes")
    )
    # Seen from the hips, in meters: as far off as an arm is long.
    assert 0.2 < np.linalg.norm(telephone - eyes) < 0.5
    assert np.hypot(*(telephone - dut["telephone_hand"])[:2]) < 0.1
    assert abs(telephone[1]) < 0.1
    outward = (screen - telephone) / np.linalg.norm(screen - telephone)
    to_eyes = (eyes - telephone) / np.linalg.norm(eyes - telephone)
    assert outward @ to_eyes > 0.8


def test_wider_people_have_wider_figures_and_discs():
    slim, wide = (
        Trial(humans=[HumanConfig(pose=(0.0, 0.0, 0.0), radius=r)])
        for r in (0.3, 0.45)
    )
    shoulders = [
        (
            t.X_WB("human_1").inverse() @ t.X_WB("human_1", "left_arm")
        ).translation()[1]
        for t in (slim, wide)
    ]
    assert shoulders[1] == pytest.approx(shoulders[0] * 0.45 / 0.3)


def test_walls_stand_where_the_world_says():
    world = World(
        walls=[
            Box(center=(2.0, 1.0), size=(4.0, 0.5), yaw=0.3, height=2.0),
            Polygon(
                points=[(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)],
                height=0.8,
            ),
            Polyline(points=[(-5, 0), (-5, 4), (-2, 4)], height=1.5),
        ]
    )
    dut = Trial(world)
    box, polygon, line = (dut.geometry(f"wall_{i}") for i in range(3))
    inspector = dut.inspector

    p = mesh_vertices(inspector.GetShape(box))
    c, s = np.cos(0.3), np.sin(0.3)
    own = (p[:, :2] - [2.0, 1.0]) @ [[c, -s], [s, c]]
    np.testing.assert_allclose(np.abs(own), [[2, 0.25]] * len(p), atol=1e-4)
    assert set(p[:, 2]) == {0.0, 2.0}

    p = mesh_vertices(inspector.GetShape(polygon))
    corners = {tuple(v) for v in p}
    assert corners == {
        (x, y, z) for x, y in world.walls[1].points for z in (0.0, 0.8)
    }

    p = mesh_vertices(inspector.GetShape(line))
    np.testing.assert_allclose(p.min(axis=0), [-5.025, -0.025, 0])
    np.testing.assert_allclose(p.max(axis=0), [-1.975, 4.025, 1.5])


def tops(inspector, role):
    """How high walls and furniture reach, by name, for eyes of a kind."""
    ids = inspector.GetGeometryIds(
        GeometrySet(inspector.world_frame_id()), role
    )
    return {
        inspector.GetName(it): mesh_vertices(inspector.GetShape(it))[:, 2].max()
        for it in ids
        if inspector.GetName(it).startswith(("wall", "furniture"))
    }


def test_high_walls_are_shown_cut_but_whole_for_cameras():
    wall = Box(center=(0.0, 0.0), size=(4.0, 0.2))
    low = Box(center=(0.0, 5.0), size=(4.0, 0.2), height=2.0)
    dut = Trial(World(walls=[wall, low]))
    assert wall.height > 2.2
    shown = tops(dut.inspector, Role.kIllustration)
    perceived = tops(dut.inspector, Role.kPerception)
    assert max(z for name, z in shown.items() if "wall_0" in name) < 1.2
    assert perceived["wall_0_whole"] == 2.5
    # What is no higher than a door is the same for both.
    assert shown["wall_1"] == perceived["wall_1"] == 2.0


@pytest.mark.parametrize(("height", "cut"), [(2.5, True), (2.0, False)])
def test_high_furniture_is_cut_where_walls_are(height, cut):
    """Shelves and door frames would hide people beside cut walls."""
    wall = Box(center=(0.0, 0.0), size=(4.0, 0.2), height=height)
    furniture = [
        Shelf(center=(0, 1)),
        DoorFrame(center=(0, 3)),
        Chair(center=(2, 2)),
    ]
    dut = Trial(World(walls=[wall], furniture=furniture))
    shown = tops(dut.inspector, Role.kIllustration)
    perceived = tops(dut.inspector, Role.kPerception)

    def top(heights, stem):
        return max(z for name, z in heights.items() if stem in name)

    for stem in ("furniture_0", "furniture_1"):
        assert top(perceived, stem) > 1.7
        assert bool(top(shown, stem) < 1.2) is cut
    assert top(shown, "furniture_2") == top(perceived, "furniture_2")


def test_cameras_may_see_high_walls_cut():
    """As films do; low walls stay as they are."""
    walls = [
        Box(center=(0.0, 0.0), size=(4.0, 0.2)),
        Box(center=(0.0, 3.0), size=(4.0, 0.2), height=0.5),
    ]
    dut = AddScene(DiagramBuilder(), World(walls=walls))
    inspector = dut.scene_graph.model_inspector()
    shown = tops(inspector, Role.kIllustration)
    assert shown.keys() == {"wall_0", "wall_0_cut", "wall_1"}
    assert shown != tops(inspector, Role.kPerception)
    ShowCut(dut.plant, dut.scene_graph)
    assert shown == tops(inspector, Role.kPerception)
    assert shown == tops(inspector, Role.kIllustration)
    for name in shown:
        geometry = inspector.GetGeometryIdByName(
            inspector.world_frame_id(), Role.kPerception, name
        )
        colors = [
            properties.GetProperty("phong", "diffuse")
            for properties in (
                inspector.GetIllustrationProperties(geometry),
                inspector.GetPerceptionProperties(geometry),
            )
        ]
        assert colors[0] == colors[1]


@pytest.mark.parametrize("kind", sorted(FURNITURE))
@pytest.mark.parametrize("height", [0.02, 1.0, 2.3, 10.0])
def test_furniture_of_any_height_is_drawn(kind, height):
    """Whole for cameras; cut for viewers, if it is high and stands."""
    place = {"center": (0.0, 0.0), "height": height}
    furniture = FURNITURE.make({"type": kind, **place})
    dut = AddScene(DiagramBuilder(), World(furniture=[furniture]))
    inspector = dut.scene_graph.model_inspector()
    perceived = tops(inspector, Role.kPerception)
    top = max(solid.high for solid in furniture.solids())
    assert max(perceived.values()) == pytest.approx(top)
    shown = tops(inspector, Role.kIllustration)
    if min(solid.low for solid in furniture.solids()) > 0.5:
        assert shown == perceived
    else:
        assert max(shown.values()) < (1.2 if top > 2.2 else 2.21)
    ShowCut(dut.plant, dut.scene_graph)
    assert tops(inspector, Role.kPerception) == shown


def test_viewers_and_cameras_read_a_sign_over_walls_that_are_cut():
    sign = Sign(center=(0.0, 2.0), text="Exit", size=(0.1, 1.2))
    wall = Box(center=(0.0, 0.0), size=(4.0, 0.2))
    dut = AddScene(DiagramBuilder(), World(walls=[wall], furniture=[sign]))
    inspector = dut.scene_graph.model_inspector()
    for role in (Role.kIllustration, Role.kPerception):
        heights = tops(inspector, role)
        texts = sorted(it for it in heights if "_text_" in it)
        assert texts == ["furniture_0_text_0", "furniture_0_text_1"]
        assert heights["furniture_0_navy"] == pytest.approx(2.6)
        assert 2.2 < heights["furniture_0_text_0"] < 2.6


@pytest.mark.parametrize("lively", [False, True])
def test_a_basket_is_in_the_left_hand(lively):
    figure = FigureConfig(carries="basket", height=1.6)
    plant = MultibodyPlant(0.0)
    graph = SceneGraph()
    plant.RegisterAsSourceForSceneGraph(graph)
    options = {"clothes": clothes(0), "figure": figure, "lively": lively}
    AddHumanBody(plant, "ana", radius=0.3, **options)
    plant.Finalize()
    inspector = graph.model_inspector()
    body = plant.GetBodyByName("left_forearm" if lively else "left_arm")
    points = {}
    for it in plant.GetVisualGeometriesForBody(body):
        shape = inspector.GetShape(it)
        vertices = (mesh_vertices(shape) * shape.scale3()).T
        name = inspector.GetName(it).split("::")[-1]
        points[name] = inspector.GetPoseInFrame(it) @ vertices
    hand = points["moving_hand" if lively else "hand"].mean(axis=1)
    basket = points["basket"]
    # It hangs by its grip, and to the left, so that the leg has room.
    grip = basket[:, basket[2] > basket[2].max() - 0.005].mean(axis=1)
    assert abs(grip[2] - hand[2]) < 0.08
    assert 0.15 < np.ptp(basket[2]) < 0.35
    assert basket.mean(axis=1)[1] > hand[1] + 0.03


def test_the_floor_reaches_under_everything():
    world = World(walls=[Polyline(points=[(-30, 5), (-28, 5)])])
    humans = [HumanConfig(pose=(4.0, 0.0, 0.0), goals=[(9.0, 20.0)])]
    dut = Trial(world, humans, DifferentialDriveConfig(start=(0, -7, 0)))
    floor = dut.geometry("floor")
    half = dut.inspector.GetShape(floor).size() / 2
    middle = dut.inspector.GetPoseInFrame(floor).translation()
    low, high = (middle - half)[:2], (middle + half)[:2]
    assert np.all(low < [-30, -7.35])
    assert np.all(high > [9.35, 20.35])
    assert (middle + half)[2] <= 0


def test_a_scene_is_built_for_any_size_of_world():
    for size in (0.01, 300.0, 1e5):
        world = World(walls=[Box(center=(0, 0), size=(size, size))])
        Trial(world).simulator.AdvanceTo(0.1)


def test_walls_that_are_degenerate_are_drawn_too():
    world = World(
        walls=[
            Polygon(points=[(0, 0), (1, 0), (2, 0)]),
            Polygon(points=[(0, 0), (2, 2), (2, 0), (0, 2)]),
            Polyline(points=[(1, 1), (1, 1)]),
        ]
    )
    Trial(world).simulator.AdvanceTo(0.1)


def test_cameras_see_people_and_walls_but_no_marks():
    humans = [HumanConfig(pose=(0.0, 0.0, 0.0), goals=[(1.0, 1.0)])]
    dut = Trial(
        humans=humans, robot=DifferentialDriveConfig(goal=(5.0, 0.0, 1.0))
    )
    inspector = dut.inspector
    ids = inspector.GetGeometryIds(
        GeometrySet(inspector.GetAllFrameIds()), Role.kPerception
    )
    names = {inspector.GetName(g).split("::")[-1] for g in ids}
    assert {"torso", "head", "deck", "floor"} <= names
    assert not {"disc", "robot_goal", "human_0_goal_0"} & names
    dut.geometry("human_0_goal_0")
    goal = inspector.GetPoseInFrame(dut.geometry("robot_goal"))
    assert_pose(goal, 5.0, 0.0, 1.0)


def test_nothing_collides():
    """The scene is for the eyes: it has no part in any physics."""
    dut = Trial(robot=DifferentialDriveConfig())
    assert dut.inspector.NumGeometriesWithRole(Role.kProximity) == 0


@pytest.mark.parametrize("robot", [None, DifferentialDriveConfig()])
def test_a_scene_without_people(robot):
    dut = Trial(humans=[], robot=robot)
    dut.simulator.AdvanceTo(0.2)
    if robot:
        assert_pose(dut.X_WB("robot"), *ROBOT_STATE[:3])
    else:
        assert dut.ports.robot_state is None
    dut.query()


def test_odd_names_become_valid_and_unique():
    names = ["a/b", "a b", "robot", "", "human_4", "José", "--", "a_b"]
    humans = [HumanConfig(name=n, pose=(0.0, 0.0, 0.0)) for n in names]
    builder = DiagramBuilder()
    dut = AddScene(builder, World(), humans, DifferentialDriveConfig())
    assert dut.human_names[0] == "a_b"
    assert len({*dut.human_names, "robot"}) == len(names) + 1
    for name in dut.human_names:
        assert name.isascii()
        assert name.isidentifier()


def test_people_with_the_same_shirt_differ_in_something_else():
    from hunav_drake.systems.scene.palette import clothes

    looks = [
        tuple(
            tuple(color.rgba) for color in (c.top, c.trousers, c.skin, c.hair)
        )
        for c in map(clothes, range(100))
    ]
    assert len(set(looks)) == 100
    assert len({look[0] for look in looks[:6]}) == 6


def test_two_contexts_do_not_disturb_each_other():
    dut = Trial()
    other = dut.context.Clone()
    before = dut.gait(other)
    dut.simulator.AdvanceTo(1.0)
    assert np.any(dut.gait() != before)
    np.testing.assert_array_equal(dut.gait(other), before)
    states = STATES.copy()
    states[0, :2] = [9.0, 9.0]
    dut.fix(states, other)
    assert_pose(dut.X_WB("ana", context=other), 9.0, 9.0, 0.5)
    assert_pose(dut.X_WB("ana"), *STATES[0, :3])


def test_a_cloned_context_continues_to_the_same_future():
    dut = Trial(robot=DifferentialDriveConfig())
    dut.simulator.AdvanceTo(0.7)
    fork = Simulator(dut.diagram, dut.context.Clone())
    fork.Initialize()
    dut.simulator.AdvanceTo(2.0)
    fork.AdvanceTo(2.0)
    np.testing.assert_array_equal(dut.gait(), dut.gait(fork.get_context()))


def test_phases_advance_with_the_speed_of_each_person():
    dut = Trial()
    before = dut.gait()[::GAIT_SIZE]
    states = STATES.copy()
    for step in range(10):
        dut.simulator.AdvanceTo(0.05 * step)
        states[:, :2] += 0.05 * states[:, 3:5]
        dut.fix(states)
    dut.simulator.AdvanceTo(0.5)
    phase, pace, *_ = dut.gait().reshape(-1, GAIT_SIZE).T
    advance = (phase - before) % (2 * np.pi)
    assert advance[0] > advance[2] > advance[1] == 0.0
    assert pace[0] == pytest.approx(1.2, rel=0.1)
    assert pace[2] == pytest.approx(0.3, rel=0.1)


def test_people_do_not_march_in_step():
    phases = np.sort(Trial().gait()[::GAIT_SIZE])
    assert np.diff(phases).min() > 0.5


@pytest.mark.parametrize("time_step", [0.05, 0.01, 0.02, 0.1, 1 / 60, 1 / 128])
def test_frames_fall_exactly_on_steps(time_step):
    period = frame_period(time_step)
    k = np.arange(20000)
    assert np.all(np.isin(k * period, np.arange(20000 * 32) * time_step))
    assert 0.07 <= period <= 0.15


def test_a_second_scene_in_a_diagram_is_an_error_and_not_an_exit():
    builder = DiagramBuilder()
    AddScene(builder, World())
    with pytest.raises(ValueError, match='"scene" already'):
        AddScene(builder, World())


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_the_time_step_is_positive(value):
    with pytest.raises(ValueError, match="time_step must be positive"):
        AddScene(DiagramBuilder(), World(), time_step=value)


def test_bounds_hold_people_robot_and_goals():
    bounds = scene_bounds(
        World(),
        [HumanConfig(pose=(1.0, 2.0, 0.0), radius=0.5, goals=[(-4.0, 0.0)])],
        DifferentialDriveConfig(
            start=(0, 0, 0), goal=(3.0, -6.0, 0.0), radius=0.25
        ),
        margin=1.0,
    )
    assert bounds.x_min == -5.5
    assert bounds.x_max == 4.25
    assert bounds.y_min == -7.25
    assert bounds.y_max == 3.5
    assert bounds.center == (-0.625, -1.875)


def test_kinematics_alone_puts_positions_where_it_is_told():
    order = np.arange(FIGURE_SIZE)[::-1] + 3
    dut = SceneKinematics(
        [order], {"": [2, 1, 0]}, num_positions=FIGURE_SIZE + 3
    )
    context = dut.CreateDefaultContext()
    dut.get_human_states_input_port().FixValue(context, STATES[0])
    (port,) = dut.get_robot_state_input_ports()
    port.FixValue(context, ROBOT_STATE)
    q = dut.get_positions_output_port().Eval(context)
    np.testing.assert_array_equal(q[[2, 1, 0]], ROBOT_STATE[:3])
    np.testing.assert_array_equal(q[order[:3]], STATES[0, :3])


HEADLESS = """
import os
import pydrake.geometry

class Forbidden:
    def __init__(self, *args, **kwargs):
        raise SystemExit("a headless scene made a " + type(self).__name__)

pydrake.geometry.Meshcat = Forbidden
pydrake.geometry.MeshcatVisualizer = Forbidden

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from hunav_drake.systems.robot import DifferentialDriveConfig
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.world.shapes import World

builder = DiagramBuilder()
ports = AddScene(builder, World(), [], DifferentialDriveConfig())
assert ports.visualizer is None
builder.ExportInput(ports.robot_state)
diagram = builder.Build()
simulator = Simulator(diagram)
diagram.get_input_port().FixValue(simulator.get_mutable_context(), [0.0] * 7)
simulator.AdvanceTo(1.0)
assert simulator.get_num_publishes() == 0
fds = [os.readlink(f"/proc/self/fd/{fd}") for fd in os.listdir("/proc/self/fd")
       if os.path.exists(f"/proc/self/fd/{fd}")]
assert not [fd for fd in fds if fd.startswith("socket:")], fds
print("quiet")
"""


def test_a_headless_scene_publishes_nothing_and_opens_no_port():
    result = subprocess.run(
        [sys.executable, "-c", HEADLESS],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stdout == "quiet\n", result.stdout + result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pmb2", "base_link", "stages"])
def test_a_physical_robot_is_drawn_as_its_model(kind, tmp_path):
    if kind == "pmb2":
        robot, base, height = PMB2Config(), "base", 0.0
    elif kind == "base_link":
        robot = UrdfRobot(
            file=write_model(tmp_path, FOOTPRINT),
            base=kind,
            drive={
                "left_wheel": "left_joint",
                "right_wheel": "right_joint",
                "wheel_separation": 0.3,
                "wheel_radius": 0.08,
            },
        )
        base, height = kind, 0.12
    else:
        robot = UrdfRobot(
            file=write_model(tmp_path, STAGES),
            base="chassis",
            drive={
                "type": "omnidirectional",
                "x": "along_x",
                "y": "along_y",
                "yaw": "turn",
            },
        )
        base, height = "chassis", 0.2
    trial = Trial(robot=robot)
    plant = trial.ports.plant
    body = plant.GetBodyByName(base, plant.GetModelInstanceByName("robot"))
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    X_WB = trial.query().GetPoseInWorld(frame)
    np.testing.assert_allclose(
        X_WB.translation(), [*ROBOT_STATE[:2], height], atol=1e-9
    )
    x_axis = X_WB.rotation().matrix()[:, 0]
    np.testing.assert_allclose(x_axis, [np.cos(0.7), np.sin(0.7), 0], atol=1e-9)
