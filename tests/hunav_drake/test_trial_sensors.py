"""Sensors in trials: as the scenario says, by seed, and for planners."""

import dataclasses
import hashlib
from multiprocessing import get_context

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from hunav_drake import (
    AddHumans,
    HumanConfig,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    Scenario,
    ScenarioError,
    SetTrialSeed,
)
from hunav_drake.scenario import LidarConfig
from hunav_drake.systems.planning import (
    PLANNERS,
    LocalPlanner,
    Plan,
    Planner,
    PlannerStatus,
    PlanningTask,
    register_planner,
)
from hunav_drake.systems.robot import RobotLimits
from hunav_drake.systems.sensing import (
    SENSORS,
    Lidar,
    VisiblePeople,
    scan_points,
)
from hunav_drake.systems.sensing.camera import camera_pose
from hunav_drake.systems.world.obstacles import Obstacles
from tests.choices import NEEDED
from tests.hunav_drake.scenario.loading_failure import failure
from tests.robot_models import ROBOTS as MODELS

NOISY = "sensors=[{type: lidar, noise: 0.03, range_max: 8}]"
DURATION = 3.0


def make_scenario(*overrides, seed=0, name="crossing"):
    return LoadScenario(
        filename=name,
        overrides=[
            f"simulation.duration={DURATION}",
            f"simulation.seed={seed}",
            *overrides,
        ],
    )


def run(diagram, *, seed=None, context=None, end=DURATION):
    """Runs a trial; returns its scans every 0.5 s, and its Context."""
    if context is None:
        context = diagram.CreateDefaultContext()
        if seed is not None:
            SetTrialSeed(diagram, context, seed)
    simulator = MakeTrialSimulator(diagram, context)
    scans = []
    for time in np.arange(0.5, end + 0.1, 0.5):
        if time > context.get_time():
            simulator.AdvanceTo(time)
            scans.append(diagram.GetOutputPort("scan").Eval(context).copy())
    return np.array(scans), context


def digest(seed):
    """Returns a hash of the scans of a trial, and of where people went."""
    diagram = MakeTrialDiagram(make_scenario(NOISY))
    scans, context = run(diagram, seed=seed)
    people = diagram.GetOutputPort("human_states").Eval(context)
    return hashlib.sha256(scans.tobytes() + people.tobytes()).hexdigest()


@pytest.fixture(scope="module")
def noisy():
    return MakeTrialDiagram(make_scenario(NOISY))


def test_a_trial_with_noise_repeats_by_seed(noisy):
    first, _ = run(noisy, seed=7)
    other, _ = run(noisy, seed=8)
    again, _ = run(noisy, seed=7)
    fresh, _ = run(MakeTrialDiagram(make_scenario(NOISY, seed=7)))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(first, fresh)
    assert (first != other).mean() > 0.5


def test_a_clone_and_a_file_go_on_alike(noisy, tmp_path):
    expected, _ = run(noisy, seed=3)
    _, middle = run(noisy, seed=3, end=1.5)
    path = SaveContext(noisy, middle, tmp_path / "middle.npz")
    run(noisy, seed=4)
    for context in (middle.Clone(), LoadContext(noisy, path)):
        rest, _ = run(noisy, context=context)
        np.testing.assert_array_equal(rest, expected[3:])


@pytest.mark.slow
def test_another_process_measures_the_same():
    with get_context("spawn").Pool(1) as pool:
        assert pool.apply(digest, (5,)) == digest(5)


def test_the_sensors_of_a_trial_have_outputs_by_their_names():
    sensors = (
        "sensors=[{type: lidar}, {type: lidar, name: rear, num_rays: 9,"
        " pose: [-0.2, 0, 3.14]}, {type: visible_people}, {type: camera,"
        " image_size: [64, 48]}, {type: camera, mount: world, pose: [5, -3,"
        " 1.6], height: 2.0, image_size: [80, 48]}]"
    )
    diagram = MakeTrialDiagram(make_scenario(sensors))
    for name in ("lidar", "rear", "visible_people", "camera", "camera_2"):
        assert diagram.HasSubsystemNamed(f"sensor_{name}")
    context = diagram.CreateDefaultContext()

    def output(name):
        return diagram.GetOutputPort(name).Eval(context)

    assert output("scan").size == 360
    assert output("rear_scan").size == 9
    people = output("human_states").reshape(-1, 7)
    visible = output("visible").astype(bool)
    assert visible.any()
    rows = output("visible_people").reshape(-1, 7)
    np.testing.assert_array_equal(rows[visible], people[visible])
    for name, width in (("", 64), ("camera_2_", 80)):
        for image in ("color_image", "depth_image", "label_image"):
            assert output(name + image).data.shape[:2] == (48, width)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["turtle.urdf", "stages.urdf", "car"])
def test_a_camera_is_on_the_pose_of_a_physical_robot(model, tmp_path):
    """Whatever the first body of its model is, and how high its base."""
    robot = NEEDED["urdf"]
    if model in MODELS:
        text, base, drive = MODELS[model]
        (tmp_path / model).write_text(text)
        robot = {"file": str(tmp_path / model), "base": base, "drive": drive}
    robot = {**robot, "type": "urdf", "start": (1.0, 0.5, 0.4)}
    camera = {"type": "camera", "height": 1.2, "pose": (0.3, 0.1, 0.0)}
    scenario = Scenario(robot=robot, sensors=[camera])
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    x, y, yaw, *_ = diagram.GetOutputPort("robot_state").Eval(context)
    eye = diagram.GetSubsystemByName("sensor_camera")
    eye = eye.GetSubsystemByName("rgbd_sensor")
    port = eye.GetOutputPort("body_pose_in_world")
    X_WC = port.Eval(eye.GetMyContextFromRoot(context))
    expected = RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, 0])
    expected = expected @ camera_pose(scenario.sensors[0])
    np.testing.assert_allclose(
        X_WC.GetAsMatrix4(), expected.GetAsMatrix4(), atol=1e-9
    )


def test_a_scan_agrees_with_the_walls_of_the_trial():
    scenario = make_scenario("sensors=[{type: lidar, range_max: 30}]")
    scenario = dataclasses.replace(scenario, humans=[])
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    robot = diagram.GetOutputPort("robot_state").Eval(context)
    scan = diagram.GetOutputPort("scan").Eval(context)
    points = scan_points(scenario.sensors[0], scan, robot)
    assert len(points) > 100
    from hunav_drake.systems.world.obstacles import nearest_wall

    nearest = nearest_wall(scenario.world.obstacles(), points)
    assert np.hypot(*(points - nearest).T).max() < 1e-9


def test_a_trial_is_shown_with_the_scan_of_a_lidar_of_the_world():
    """It is the first scan, whatever lidars the robot has."""
    lidars = (
        "sensors=[{type: lidar, mount: world, num_rays: 9}, {type: lidar,"
        " name: own, num_rays: 20}]"
    )
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    diagram = MakeTrialDiagram(make_scenario(lidars), meshcat=meshcat)
    scene = diagram.GetSubsystemByName("scene")
    context = scene.GetMyContextFromRoot(diagram.CreateDefaultContext())
    assert scene.GetInputPort("scan").Eval(context).size == 9


def test_sensors_change_nothing_of_a_trial():
    """They are there to be asked."""
    plain = RunTrial(make_scenario())
    watched = RunTrial(make_scenario("sensors=[{type: lidar, noise: 0.1}]"))
    assert plain.recording == watched.recording


# Planners.


@pytest.fixture
def own_planners(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


class Careful(Planner):
    """Drives until the lidar has something ahead."""

    def plan(self, task, view, memory):
        lidar = task.lidar
        ahead = abs(lidar.angles()) < 0.5
        v = 0.5 if view.scan[ahead].min() > 1.2 else 0.0
        status = PlannerStatus.DRIVING if v else PlannerStatus.BLOCKED
        return Plan(v, 0.0, status)


WALL_AHEAD = """
world: {walls: [{type: box, center: [4, 0], size: [0.2, 4]}]}
robot: {goal: [8, 0, 0], start: [0, 0, 0]}
simulation: {duration: 12}
"""


@pytest.mark.parametrize("size", [None, 90])
def test_a_planner_gets_the_scan_that_it_asks_for(own_planners, size):
    @register_planner("careful")
    @dataclass
    class Asking(Careful):
        scan_size = size

    sensors = "sensors: [{type: lidar, num_rays: 90}]\nplanner: careful\n"
    scenario = LoadScenario(data=WALL_AHEAD + sensors)
    result = RunTrial(scenario)
    # It stops 1.2 m before the wall, and a little for its brakes.
    x = result.recording.robot[-1, 0]
    assert 3.9 - 1.2 - 0.05 < x < 3.9 - 1.2 + 0.4


@pytest.mark.parametrize(
    ("size", "sensors", "words"),
    [
        (
            None,
            "[]",
            r"needs a lidar \(port scan\), and there is none; add"
            r" sensors: \[{type: lidar}\], or choose another planner",
        ),
        (9, "[]", "add sensors: .{type: lidar, num_rays: 9}"),
        (
            9,
            "[{type: lidar}]",
            "needs a lidar of 9 rays, but the first one has 360; set its"
            " num_rays to 9",
        ),
    ],
)
def test_a_planner_without_its_lidar_is_refused(
    own_planners, size, sensors, words
):
    @register_planner("careful")
    @dataclass
    class Asking(Careful):
        scan_size = size

    with pytest.raises(ScenarioError, match=words):
        LoadScenario(data=f"planner: careful\nsensors: {sensors}\n")


def test_faults_of_sensors_are_told_with_their_places():
    text = """\
sensors:
- {type: lidar, range_max: -1}
- {type: lidat}
- {type: camera, mount: ceiling}
- {type: camera, image_size: [640]}
- {pose: [0, 0, 0]}
- {type: lidar, height: 1.0}
"""
    faults = failure(data=text).faults
    told = {(fault.line, fault.path): fault.message for fault in faults}
    assert told[2, "sensors[0].range_max"] == (
        "must be in (0, 1000] m, got -1.0"
    ) or told[2, "sensors[0].range_max"].startswith("must be in (0, 1000] m")
    assert "did you mean 'lidar'" in told[3, "sensors[1].type"]
    assert "unknown value 'ceiling'" in told[4, "sensors[2].mount"]
    assert "must be 2 numbers, got 1" in told[5, "sensors[3].image_size"]
    assert "is missing" in told[6, "sensors[4].type"]
    assert "height must be at most 0.7 m" in told[7, "sensors[5]"]


def test_faults_between_sensors_are_told():
    text = """\
sensors:
- {type: lidar, name: eye}
- {type: camera, name: eye}
- {type: lidar, period: 0.12}
"""
    told = {(f.line, f.path): f.message for f in failure(data=text).faults}
    message = told[3, "sensors[1] ('eye').name"]
    assert "already the name of sensors[0] ('eye'); change" in message
    assert "multiple of simulation.time_step" in told[4, "sensors[2].period"]


def test_sensors_are_a_part_of_what_a_diagram_is_made_from(noisy):
    with pytest.raises(ValueError, match="other sensors: make it by"):
        RunTrial(make_scenario(), diagram=noisy)


def test_a_sensor_of_ones_own_is_wired_by_its_ports(monkeypatch):
    from pydrake.systems.primitives import Gain

    from hunav_drake.systems.sensing import SensorConfig, register_sensor

    monkeypatch.setattr(SENSORS, "_choices", dict(SENSORS))

    @register_sensor("gps")
    @dataclass
    class Gps(SensorConfig):
        def MakeSystem(self, task):
            from pydrake.systems.framework import DiagramBuilder

            builder = DiagramBuilder()
            gain = builder.AddSystem(Gain(2.0, 7))
            builder.ExportInput(gain.get_input_port(), "robot_state")
            builder.ExportOutput(gain.get_output_port(), "twice")
            return builder.Build()

    diagram = MakeTrialDiagram(make_scenario("sensors=[{type: gps}]"))
    context = diagram.CreateDefaultContext()
    np.testing.assert_array_equal(
        diagram.GetOutputPort("twice").Eval(context),
        2 * diagram.GetOutputPort("robot_state").Eval(context),
    )


def test_the_scene_shows_the_truth_whatever_a_sensor_calls_its_port(
    monkeypatch,
):
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import Gain

    from hunav_drake.systems.sensing import SensorConfig, register_sensor

    monkeypatch.setattr(SENSORS, "_choices", dict(SENSORS))

    @register_sensor("odometry")
    @dataclass
    class Odometry(SensorConfig):
        def MakeSystem(self, task):
            builder = DiagramBuilder()
            gain = builder.AddSystem(Gain(2.0, 7))
            builder.ExportInput(gain.get_input_port(), "robot_state")
            builder.ExportOutput(gain.get_output_port(), "robot_state")
            return builder.Build()

    diagram = MakeTrialDiagram(make_scenario("sensors=[{type: odometry}]"))
    context = diagram.CreateDefaultContext()
    seen, true = (
        port.Eval(system.GetMyContextFromRoot(context))
        for name, kind in (("scene", "Input"), ("robot", "Output"))
        for system in [diagram.GetSubsystemByName(name)]
        for port in [getattr(system, f"Get{kind}Port")("robot_state")]
    )
    np.testing.assert_array_equal(seen, true)
    assert np.abs(true[:2]).max() > 1


# What hides robots and people from each other.


def reaction(obstacles):
    """Tells whether a scared person reacts to a robot 2 m away."""
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import ConstantVectorSource

    builder = DiagramBuilder()
    people = AddHumans(
        builder,
        [HumanConfig(pose=(0, 0, 0), behavior="scared")],
        obstacles=obstacles,
    )
    robot = builder.AddSystem(
        ConstantVectorSource([2.0, 0, np.pi, -0.3, 0, 0, 0.3])
    )
    builder.Connect(robot.get_output_port(), people.robot_states)
    builder.ExportOutput(people.behavior_status, "status")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.0)
    return diagram.GetOutputPort("status").Eval(simulator.get_context())[0] > 0


def senses(wall):
    """Tells whether people, robot and lidar see through a wall, all three."""
    seen = VisiblePeople(obstacles=wall, num_humans=1)
    context = seen.CreateDefaultContext()
    for port in ("robot_state", "human_states"):
        row = np.zeros(7)
        row[[0, 6]] = 2.0 * (port == "robot_state"), 0.3
        seen.GetInputPort(port).FixValue(context, row)
    scans = []
    for config in (LidarConfig(people="discs"), LidarConfig()):
        lidar = Lidar(config, obstacles=wall, num_humans=1)
        own = lidar.CreateDefaultContext()
        for port in ("robot_state", "human_states"):
            value = seen.GetInputPort(port).Eval(context)
            lidar.GetInputPort(port).FixValue(own, value)
        alone = Lidar(config, obstacles=wall)
        empty = alone.CreateDefaultContext()
        robot = lidar.GetInputPort("robot_state").Eval(own)
        alone.GetInputPort("robot_state").FixValue(empty, robot)
        scans += [
            lidar.get_scan_output_port().Eval(own),
            alone.get_scan_output_port().Eval(empty),
        ]
    return (
        reaction(wall),
        bool(seen.get_visible_output_port().Eval(context)[0]),
        (scans[0] != scans[1]).any(),
        (scans[2] != scans[3]).any(),
    )


def test_nobody_sees_through_a_wall():
    between = Obstacles.from_shapes([[(1, -2), (1, 2)]], solid=[False])
    nothing = Obstacles.from_shapes([], solid=[])
    assert senses(nothing) == (True, True, True, True)
    assert senses(between) == (False, False, False, False)


def test_a_planner_alone_needs_to_know_its_lidar():
    class Asking(Careful):
        scan_size = None

    def planner(**options):
        return LocalPlanner(
            Asking(),
            PlanningTask(
                limits=RobotLimits(),
                robot_radius=0.3,
                goal_tolerance=0.2,
                goal_yaw_tolerance=0.2,
                obstacles=Obstacles.from_shapes([], solid=[]),
                num_humans=0,
                **options,
            ),
        )

    port = planner(lidar=LidarConfig(num_rays=7)).GetInputPort("scan")
    assert port.size() == 7
    with pytest.raises(ValueError, match="Asking needs a lidar: give its Pl"):
        planner()
