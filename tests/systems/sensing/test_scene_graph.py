"""Lidar and cameras agree with the geometry of Drake."""

import math

import numpy as np
from pydrake.geometry import (
    Box as BoxShape,
    Cylinder,
    GeometryInstance,
    MakeRenderEngineVtk,
    ProximityProperties,
    RenderEngineVtkParams,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.scene.labels import human_label
from hunav_drake.systems.sensing import AddCamera, CameraConfig, LidarConfig
from hunav_drake.systems.sensing.camera import camera_pose, focal_length
from hunav_drake.systems.world.shapes import Box, Model, World
from tests.systems.common.models.gazebo_files import (
    block,
    mesh,
    model,
    sdf,
    stl,
)
from tests.systems.sensing.scans import directions_of, rows, scan


def anchored(scene_graph, source, shape, X_WG, name):
    """Adds a shape that stands still to a SceneGraph."""
    instance = GeometryInstance(X_WG, shape, name)
    instance.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)


def free_place(rng, taken):
    """Returns a place 1 m from all places taken."""
    while True:
        place = rng.uniform(-8, 8, 2)
        if all(math.dist(place, other) > 1 for other in taken):
            return place


@pytest.mark.parametrize("seed", range(5))
def test_rays_end_on_the_surface_and_not_before(seed):
    """By Drake's signed distances, in a random scene."""
    rng = np.random.default_rng(seed)
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource("random")
    start = rng.uniform(-3, 3, 2)
    walls, taken = [], [start]
    for i in range(12):
        center = free_place(rng, taken)
        taken.append(center)
        size, yaw = rng.uniform(0.1, 1.2, 2), rng.uniform(-4, 4)
        walls.append(Box(center=tuple(center), size=tuple(size), yaw=yaw))
        X_WG = RigidTransform(RollPitchYaw(0, 0, yaw), [*center, 1.0])
        anchored(scene_graph, source, BoxShape(*size, 2.0), X_WG, f"box_{i}")
    people = []
    for i in range(10):
        center = free_place(rng, taken)
        taken.append(center)
        people.append(center)
        X_WG = RigidTransform([*center, 0.85])
        anchored(scene_graph, source, Cylinder(0.3, 1.7), X_WG, f"human_{i}")
    config = LidarConfig(num_rays=300, people="discs", height=0.6)
    found = scan(
        config,
        obstacles=World(walls=walls).obstacles(),
        robot=(*start, 0.3),
        people=rows(*people),
    )
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)

    def distance(along):
        x, y = start + along
        near = query.ComputeSignedDistanceToPoint([x, y, 0.6])
        return min(d.distance for d in near)

    met = 0
    for far, u in zip(found, directions_of(config, 0.3), strict=True):
        for part in (0.3, 0.7, 0.999):
            assert distance(part * far * u) > 0
        if far < config.range_max:
            assert abs(distance(far * u)) < 1e-9
            met += 1
    assert 60 < met < 300


class View:
    """A camera that looks at a world with people who stand."""

    def __init__(self, config, *, world=None, people=()):
        builder = DiagramBuilder()
        self.config = config
        humans = [HumanConfig(pose=row[:3], radius=row[6]) for row in people]
        scene = AddScene(builder, world or World(), humans)
        self.camera = AddCamera(
            builder, config, scene.scene_graph, query_object=scene.query_object
        )
        builder.ExportInput(scene.human_states, "human_states")
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.fix(people, self.context)

    def fix(self, people, context):
        port = self.diagram.GetInputPort("human_states")
        port.FixValue(context, np.ravel(people))

    def image(self, name, context=None):
        own = self.camera.GetMyContextFromRoot(context or self.context)
        return self.camera.GetOutputPort(name).Eval(own).data


SMALL = CameraConfig(mount="world", image_size=(320, 240), height=1.0)


def test_a_person_has_one_label():
    people = rows((3, -0.6, 1.0), (4, 0.7, 3.0))
    dut = View(SMALL, people=people)
    labels = dut.image("label_image")[:, :, 0]
    assert set(np.unique(labels)) == {0, 32766, human_label(0), human_label(1)}
    for i, (row, column) in enumerate(((-0.6, 3), (0.7, 4))):
        pixels = np.argwhere(labels == human_label(i))
        # Upright: twice as high as wide; to the right of the image at y < 0.
        height, width = np.ptp(pixels, axis=0)
        assert height > 2 * width
        focal = focal_length(SMALL)
        middle = 0.5 * (pixels[:, 1].min() + pixels[:, 1].max())
        assert middle == pytest.approx(160 - focal * row / column, abs=6)
        assert height == pytest.approx(focal * 1.7 / column, rel=0.12)


def test_depth_is_the_distance_from_the_plane_of_the_camera():
    wall = Box(center=(5.0, 0.0), size=(0.2, 20.0), height=3.0)
    dut = View(SMALL, world=World(walls=[wall]))
    depth = dut.image("depth_image")[:, :, 0]
    # The wall fills the upper half; the floor begins below.
    np.testing.assert_allclose(depth[60:120], 4.9, atol=2e-3)
    near = CameraConfig(
        mount="world", image_size=(64, 48), range_min=5.0, range_max=9.0
    )
    assert (View(near, world=World(walls=[wall])).image("depth_image") == 0)[
        24
    ].all()
    far = CameraConfig(mount="world", image_size=(64, 48), range_max=4.0)
    image = View(far, world=World(walls=[wall])).image("depth_image")
    assert np.isinf(image[12]).all()


def test_a_camera_looks_where_its_pose_says():
    pose = camera_pose(
        CameraConfig(pose=(1, 2, np.pi / 2), height=0.7, pitch=0.3)
    )
    np.testing.assert_allclose(pose.translation(), [1, 2, 0.7])
    ahead = [0, np.cos(0.3), -np.sin(0.3)]
    np.testing.assert_allclose(pose.rotation().col(2), ahead, atol=1e-12)
    # Right in the image is to the right of the camera.
    np.testing.assert_allclose(pose.rotation().col(0), [1, 0, 0], atol=1e-12)


def test_lidar_and_camera_see_the_same_legs():
    """In a row of a depth image, at the height of the lidar."""
    people = rows((2.5, -0.5, 0.7), (3.0, 0.5, 2.8), (2.0, 0.1, 1.6))
    config = CameraConfig(
        mount="world", image_size=(640, 20), height=0.3, field_of_view_y=0.03
    )
    wall = Box(center=(4.5, 0.0), size=(0.2, 9.0), yaw=0.2, height=2.0)
    world = World(walls=[wall])
    dut = View(config, world=world, people=people)
    depth = dut.image("depth_image")[10, :, 0]
    columns = np.arange(640) + 0.5 - 320
    angles = -np.arctan(columns / focal_length(config))
    distances = depth / np.cos(angles)
    lidar = LidarConfig(
        mount="world", num_rays=20001, field_of_view=1.2, range_max=20
    )
    found = scan(
        lidar, obstacles=world.obstacles(), robot=(90, 90, 0), people=people
    )
    expected = np.interp(angles, lidar.angles(), found)
    error = abs(distances - expected)
    # At the edges of legs a pixel may see either.
    print(f"median {np.median(error):.4f} m, 95 %: {np.quantile(error, 0.95)}")
    assert (expected < 3).mean() > 0.15
    assert np.median(error) < 0.002
    assert (error < 0.02).mean() > 0.93


def test_two_contexts_show_each_their_own():
    people = rows((3, 0.0, 1.0))
    dut = View(SMALL, people=people)
    clone = dut.context.Clone()
    before = dut.image("label_image").copy()
    dut.fix(rows((3, 0.8, 1.0)), dut.context)
    after = dut.image("label_image")
    assert (before != after).any()
    np.testing.assert_array_equal(dut.image("label_image", clone), before)


def test_a_camera_by_a_name_that_is_taken_is_refused():
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    AddCamera(builder, SMALL, scene_graph)
    with pytest.raises(ValueError, match="'camera' already: give the camera"):
        AddCamera(builder, SMALL, scene_graph)


# People in a SceneGraph of one's own.


def own_diagram(humans):
    """People beside a plant of one's own: a box falls on the first one."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    box = plant.AddRigidBody(
        "box", SpatialInertia.SolidBoxWithMass(1.0, 0.4, 0.4, 0.4)
    )
    shape, X_BG = BoxShape(0.4, 0.4, 0.4), RigidTransform()
    red = [1, 0, 0, 1]
    plant.RegisterVisualGeometry(box, X_BG, shape, "box", red)
    friction = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(box, X_BG, shape, "box", friction)
    x, y = humans[0].pose[:2]
    plant.SetDefaultFloatingBaseBodyPose(box, RigidTransform([x, y, 1.9]))
    plant.Finalize()
    people = AddHumans(builder, humans, num_robots=0, scene_graph=scene_graph)
    camera = AddCamera(builder, SMALL, scene_graph)
    builder.ExportOutput(people.human_states, "human_states")
    return builder.Build(), people, camera, plant


def test_ones_own_camera_sees_people_and_plant():
    humans = [
        HumanConfig(pose=(3, -0.5, 1.5), goals=[(3, 4)]),
        HumanConfig(pose=(4, -0.9, 1.5)),
    ]
    diagram, people, camera, plant = own_diagram(humans)
    simulator = Simulator(diagram)
    context = simulator.get_context()
    own = camera.GetMyContextFromRoot(context)
    middles = []
    for time in (0.0, 0.8):
        simulator.AdvanceTo(time)
        labels = camera.GetOutputPort("label_image").Eval(own).data[:, :, 0]
        # The box falls out of the picture.
        box = {int(plant.GetBodyByName("box").index())} if time == 0 else set()
        assert set(np.unique(labels)) == {32766, *box, *people.labels}
        pixels = np.argwhere(labels == people.labels[0])
        middles.append(pixels[:, 1].mean())
        x, y = diagram.GetOutputPort("human_states").Eval(context)[:2]
        expected = 160 - focal_length(SMALL) * y / x
        assert middles[-1] == pytest.approx(expected, abs=8)
    # To the left.
    assert middles[1] < middles[0] - 20
    # The box does not land on anybody.
    own = plant.GetMyContextFromRoot(context)
    height = plant.EvalBodyPoseInWorld(own, plant.GetBodyByName("box"))
    fallen = 1.9 - height.translation()[2]
    assert fallen == pytest.approx(0.5 * 9.81 * 0.8**2, rel=0.02)


def test_people_of_several_kinds_have_labels_of_their_own():
    builder = DiagramBuilder()
    _, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.01)
    first = AddHumans(
        builder,
        [HumanConfig(pose=(i, 0, 0)) for i in range(3)],
        num_robots=0,
        scene_graph=scene_graph,
    )
    second = AddHumans(
        builder,
        [HumanConfig(pose=(0, 3, 0))],
        name="visitors",
        num_robots=0,
        scene_graph=scene_graph,
    )
    assert first.labels == tuple(map(human_label, range(3)))
    assert second.labels == (human_label(3),)


def test_ones_own_renderer_is_left_as_it_is():
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    renderer = MakeRenderEngineVtk(RenderEngineVtkParams())
    scene_graph.AddRenderer("mine", renderer)
    AddHumans(
        builder,
        [HumanConfig(pose=(0, 0, 0))],
        num_robots=0,
        scene_graph=scene_graph,
    )
    assert scene_graph.HasRenderer("mine")
    assert scene_graph.RendererCount() == 1


def test_a_scene_graph_from_elsewhere_is_refused():
    builder = DiagramBuilder()
    people = [HumanConfig(pose=(0, 0, 0))]
    with pytest.raises(ValueError, match="in the same builder as the people"):
        AddHumans(builder, people, scene_graph=SceneGraph())
    with pytest.raises(
        TypeError, match="scene_graph must be a SceneGraph, got"
    ):
        AddHumans(builder, people, scene_graph="scene_graph")
    # Nothing has been added.
    assert not builder.HasSubsystemNamed("humans")


def test_there_are_labels_for_20_000_people():
    assert human_label(19_999) == 29_999
    with pytest.raises(ValueError, match="20000 people, got 20001; show fewer"):
        human_label(19_990, 10)
    # Drake keeps the largest ones for itself.
    assert human_label(19_999) < 32_000


def test_the_nearest_depth_is_one_that_a_renderer_can_sort():
    """With 1e-6 m, it took the back of a wall for its front."""
    with pytest.raises(ValueError, match=r"range_min.*\[0.001, 1000\] m"):
        CameraConfig(mount="world", range_min=1e-6)
    config = CameraConfig(
        mount="world", image_size=(64, 48), range_min=1e-3, range_max=60.0
    )
    wall = Box(center=(6.0, 0.0), size=(0.2, 8.0))
    depth = View(config, world=World(walls=[wall])).image("depth_image")
    np.testing.assert_allclose(depth[20, :, 0], 5.9, atol=1e-3)


def test_a_mirrored_mesh_is_lit_like_any(tmp_path):
    (tmp_path / "block.stl").write_text(stl(block((-1, -1, 0), (1, 1, 1))))
    images = []
    for sign in ("", "-"):
        scaled = mesh("block.stl", f"<scale>{sign}1 1 1</scale>")
        file = tmp_path / f"block{sign}.sdf"
        file.write_text(sdf(model(scaled)))
        world = World(models=[Model(file=str(file), pose=(4, 0, 0.3))])
        images.append(View(SMALL, world=world).image("color_image"))
    np.testing.assert_allclose(*images, atol=1)
    assert np.ptp(images[0]) > 100
