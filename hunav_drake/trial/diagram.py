"""The diagram of a trial."""

import dataclasses
from typing import TYPE_CHECKING, Any

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.scenario import CheckScenario
from hunav_drake.scenario.population import people_seed, with_drawn_people
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
from hunav_drake.systems.people.names import name_people
from hunav_drake.systems.people.starts import draw_starts
from hunav_drake.systems.robot import DiscContacts, RobotTask
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.scene.scene_config import COSTMAPS
from hunav_drake.systems.sensing.sensor_config import LidarConfig
from hunav_drake.trial.humans import AddHumans
from hunav_drake.trial.planner import (
    AddPerception,
    AddPlanner,
    with_planner_lidar,
)
from hunav_drake.trial.seeds import CheckPeopleSeed, TrialDiagram
from hunav_drake.trial.sensors import AddSensors

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


def MakeTrialDiagram(
    scenario: Scenario, meshcat: "Meshcat | None" = None
) -> Diagram:
    """Makes the diagram of a trial: its whole state is one Context.

    Args:
        scenario: What happens. Its seed is that of the default Context alone:
            see `SetTrialSeed`. The people of its population are drawn here,
            by `population.seed` or, if that is not given, by this seed: then
            the diagram is of this seed only.
        meshcat: Where to show the trial; without one nothing is published.

    Returns:
        A diagram of the systems "humans" (`AddHumans`), "robot" and "planner"
        (see `RobotConfig` and `PlannerConfig`), "goal" (if there is one),
        "evaluator" (`Evaluator`), "monitor" (`TrialMonitor`), "scene"
        (`AddScene`), the sensors (see `AddSensors`) and, unless the planner
        sees everything, "perception" (see `AddPerception`); of "plant" and
        "scene_graph" for a robot that is a body of a plant, else of "contacts"
        (`DiscContacts`). It has no inputs, but for "trigger" if that begins the
        recording (`EvaluatorConfig.start`); its outputs are "robot_state",
        "human_states", "behavior_status", "forces", "contacts",
        "velocity_command", "planner_status", "planner_path", "metrics",
        "recording", "trial_status", "query", what the sensors measure, as
        "scan", "local_costmap" and "global_costmap" (see `NavigationSystem`) of
        a planner with maps, and "traffic" (see `OpenCrowd`) if people come and
        go. It is a `TrialDiagram`.

    Raises:
        ScenarioError: If the scenario cannot be simulated.
    """
    scenario = CheckScenario(scenario, ways=False)
    made_for = _fixed_parts(scenario)
    scenario, traffic = with_drawn_people(with_planner_lidar(scenario))
    made_for["drawn"] = plain(scenario.humans[len(made_for["humans"]) :])
    robot_config = scenario.robot
    time_step = scenario.simulation.time_step
    obstacles = scenario.world.obstacles()

    builder = DiagramBuilder()
    humans = AddHumans(
        builder,
        scenario.humans,
        obstacles=scenario.world,
        config=_crowd(scenario),
        time_step=time_step,
        start_jitter=scenario.simulation.start_jitter,
        seed=scenario.simulation.seed,
        traffic=traffic,
    )
    task = RobotTask(
        time_step=time_step,
        obstacles=obstacles,
        humans=scenario.humans,
        human_starts=draw_starts(
            scenario.humans,
            scenario.simulation.seed,
            scenario.simulation.start_jitter,
        ),
    )
    robot = robot_config.AddToBuilder(builder, task)
    contacts = robot
    if not robot.HasOutputPort("contacts"):
        contacts = builder.AddNamedSystem(
            "contacts", DiscContacts(scenario.humans, time_step=time_step)
        )
    planner = AddPlanner(builder, scenario, obstacles)
    shared = {
        "goal_tolerance": robot_config.goal_tolerance,
        "goal_yaw_tolerance": robot_config.goal_yaw_tolerance,
        "time_step": time_step,
    }
    evaluator = builder.AddNamedSystem(
        "evaluator",
        Evaluator(
            scenario.humans,
            config=scenario.evaluator,
            robot_max_speed=robot_config.limits.max_speed,
            obstacles=obstacles,
            feels_forces=contacts is robot,
            **shared,
        ),
    )
    monitor = builder.AddNamedSystem(
        "monitor",
        TrialMonitor(
            stuck_time=scenario.simulation.stuck_time,
            stuck_distance=scenario.simulation.stuck_distance,
            **shared,
        ),
    )
    monitor.made_for = made_for
    scene = AddScene(
        builder,
        scenario.world,
        scenario.humans,
        robot_config,
        time_step=time_step,
        meshcat=meshcat,
        config=scenario.scene,
        scan_angles=_scan_angles(scenario),
    )

    robot_state = robot.GetOutputPort("robot_state")
    builder.Connect(
        planner.GetOutputPort("velocity_command"),
        robot.GetInputPort("velocity_command"),
    )
    builder.Connect(robot_state, humans.robot_states)
    builder.Connect(robot_state, scene.robot_state)
    builder.Connect(humans.human_states, scene.human_states)
    given = {
        "robot_state": robot_state,
        "human_states": humans.human_states,
        "behavior_status": humans.behavior_status,
        "contacts": contacts.GetOutputPort("contacts"),
        "robot_touches": humans.robot_touches,
    }
    if robot.HasOutputPort("wall_contact"):
        given["wall_contact"] = robot.GetOutputPort("wall_contact")
    if robot_config.goal is not None:
        goal = ConstantVectorSource(robot_config.goal)
        given["goal"] = builder.AddNamedSystem("goal", goal).get_output_port()
    sensed = AddSensors(builder, scenario, scene, given)
    given |= sensed
    systems = [robot, evaluator, monitor]
    if contacts is not robot:
        systems.append(contacts)
    wanted = [(system, given) for system in systems]
    wanted.append((planner, AddPerception(builder, scenario, given)))
    for system, ports in wanted:
        for name, port in ports.items():
            if system.HasInputPort(name):
                builder.Connect(port, system.GetInputPort(name))
    costmaps = {
        name: planner.GetOutputPort(name)
        for name in COSTMAPS
        if planner.HasOutputPort(name)
    }
    for name, port in (
        ("robot_state", robot_state),
        ("human_states", humans.human_states),
        ("behavior_status", humans.behavior_status),
        ("forces", humans.forces),
        ("contacts", given["contacts"]),
        ("velocity_command", planner.GetOutputPort("velocity_command")),
        ("planner_status", planner.GetOutputPort("status")),
        ("planner_path", planner.GetOutputPort("path")),
        ("metrics", evaluator.GetOutputPort("metrics")),
        ("recording", evaluator.GetOutputPort("recording")),
        ("trial_status", monitor.get_trial_status_output_port()),
        ("query", scene.query_object),
        *sensed.items(),
        *costmaps.items(),
    ):
        builder.ExportOutput(port, name)
    if humans.traffic is not None:
        builder.ExportOutput(humans.traffic, "traffic")
    # What is drawn besides, where anything is: see `SceneConfig`.
    for name, port in (
        ("behavior_status", humans.behavior_status),
        ("forces", humans.forces),
        ("planner_path", planner.GetOutputPort("path")),
        ("scan", sensed.get("scan")),
        *costmaps.items(),
    ):
        if port is not None and scene.system.HasInputPort(name):
            builder.Connect(port, scene.system.GetInputPort(name))
    if scenario.evaluator.start == "by_trigger":
        builder.ExportInput(evaluator.GetInputPort("trigger"), "trigger")
    diagram = TrialDiagram()
    builder.BuildInto(diagram)
    diagram.set_name("trial")
    return diagram


def _scan_angles(scenario: Scenario) -> Array | None:
    """Returns the angles of the scan's rays to the robot's heading."""
    for sensor in scenario.sensors:
        if isinstance(sensor, LidarConfig) and sensor.mount == "robot":
            return sensor.pose[2] + sensor.angles()
    return None


def _crowd(scenario: Scenario) -> CrowdConfig:
    """Returns how people move, with what hangs on the robot."""
    crowd = scenario.crowd
    if crowd.robots_stop is not None:
        return crowd
    return dataclasses.replace(crowd, robots_stop=scenario.robot.physical)


def CheckTrialDiagram(scenario: Scenario, diagram: Diagram) -> None:
    """Checks that a trial's diagram was made from a scenario, for its seed.

    Raises:
        ValueError: If it was made from another one, whose name, description
            and duration alone may differ; or if its people were drawn by
            another seed: see `SetTrialSeed`.
    """
    CheckPeopleSeed(diagram, scenario.simulation.seed)
    made_for = diagram.GetSubsystemByName("monitor").made_for
    parts = _fixed_parts(scenario)
    del parts["people_seed"]
    for part, value in parts.items():
        if value != made_for[part]:
            raise ValueError(
                f"the diagram was made from a scenario with other {part}: make"
                " it by MakeTrialDiagram from this one"
            )


def _fixed_parts(scenario: Scenario) -> dict[str, Any]:
    """Returns what a diagram is made from, as plain data by section."""
    humans = name_people(scenario.humans)
    parts: dict[str, Any] = plain(dataclasses.replace(scenario, humans=humans))
    for free in (parts, parts["simulation"]):
        for key in ("name", "description", "seed", "duration"):
            free.pop(key, None)
    return {**parts, "people_seed": people_seed(scenario)}
