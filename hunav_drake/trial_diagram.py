"""The diagram of a trial."""

from typing import TYPE_CHECKING

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake.humans import AddHumans
from hunav_drake.scenario import CheckScenario, name_humans
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.evaluation.trial_monitor import TrialMonitor
from hunav_drake.systems.planning import (
    LocalPlanner,
    PlanningTask,
    make_planner,
)
from hunav_drake.systems.robot import DifferentialDrive
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.world.obstacles import Obstacles

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


def MakeTrialDiagram(
    scenario: Scenario, meshcat: "Meshcat | None" = None
) -> Diagram:
    """Makes the diagram of a trial: its whole state is one Context.

    Args:
        scenario: What happens. Its seed is that of the default Context alone:
            see `SetTrialSeed`.
        meshcat: Where to show the trial; without one nothing is published.

    Returns:
        A diagram of the systems "humans" (`AddHumans`), "robot"
        (`DifferentialDrive`), "planner" (`LocalPlanner`), "goal" (if there is
        one), "evaluator" (`Evaluator`), "monitor" (`TrialMonitor`) and "scene"
        (`AddScene`). It has no inputs, but for "trigger" if that begins the
        recording (`EvaluatorConfig.start`); its outputs are "robot_state",
        "human_states", "behavior_status", "forces", "velocity_command",
        "planner_status", "metrics", "recording", "status" and "query".

    Raises:
        ScenarioError: If the scenario cannot be simulated.
    """
    CheckScenario(scenario)
    scenario = name_humans(scenario)
    robot_config = scenario.robot
    time_step = scenario.simulation.time_step
    obstacles = scenario.world.obstacles()

    builder = DiagramBuilder()
    humans = AddHumans(
        builder,
        scenario.humans,
        obstacles=obstacles,
        config=scenario.crowd,
        time_step=time_step,
        start_jitter=scenario.simulation.start_jitter,
        seed=scenario.simulation.seed,
    )
    robot = builder.AddNamedSystem(
        "robot", DifferentialDrive(robot_config, time_step=time_step)
    )
    planner = _AddPlanner(builder, scenario, obstacles)
    evaluator = _AddEvaluator(builder, scenario, obstacles)
    monitor = _AddMonitor(builder, scenario)
    scene = AddScene(
        builder,
        scenario.world,
        scenario.humans,
        robot_config,
        time_step=time_step,
        meshcat=meshcat,
    )

    robot_state = robot.get_robot_state_output_port()
    builder.Connect(
        planner.get_velocity_command_output_port(),
        robot.get_velocity_command_input_port(),
    )
    for port in (
        humans.robot_state,
        planner.get_robot_state_input_port(),
        evaluator.GetInputPort("robot_state"),
        monitor.get_robot_state_input_port(),
        scene.robot_state,
    ):
        builder.Connect(robot_state, port)
    for port in (
        planner.get_human_states_input_port(),
        evaluator.GetInputPort("human_states"),
        scene.human_states,
    ):
        builder.Connect(humans.human_states, port)
    builder.Connect(
        humans.behavior_status, evaluator.GetInputPort("behavior_status")
    )
    if robot_config.goal is not None:
        goal = builder.AddNamedSystem(
            "goal", ConstantVectorSource(robot_config.goal)
        )
        for system in (planner, evaluator, monitor):
            builder.Connect(goal.get_output_port(), system.GetInputPort("goal"))
    for name, port in (
        ("robot_state", robot_state),
        ("human_states", humans.human_states),
        ("behavior_status", humans.behavior_status),
        ("forces", humans.forces),
        ("velocity_command", planner.get_velocity_command_output_port()),
        ("planner_status", planner.get_status_output_port()),
        ("metrics", evaluator.GetOutputPort("metrics")),
        ("recording", evaluator.GetOutputPort("recording")),
        ("status", monitor.get_status_output_port()),
        ("query", scene.query_object),
    ):
        builder.ExportOutput(port, name)
    if scenario.evaluator.start == "by_trigger":
        builder.ExportInput(evaluator.GetInputPort("trigger"), "trigger")
    diagram = builder.Build()
    diagram.set_name("trial")
    return diagram


def _AddPlanner(
    builder: DiagramBuilder, scenario: Scenario, obstacles: Obstacles
) -> LocalPlanner:
    config = scenario.planner
    robot = scenario.robot
    task = PlanningTask(
        limits=robot.limits,
        robot_radius=robot.radius,
        goal_tolerance=robot.goal_tolerance,
        goal_yaw_tolerance=robot.goal_yaw_tolerance,
        obstacles=obstacles,
        period=config.period,
    )
    planner = LocalPlanner(
        make_planner(config.name, config.parameters),
        task,
        num_humans=len(scenario.humans),
        time_step=scenario.simulation.time_step,
    )
    builder.AddNamedSystem("planner", planner)
    return planner


def _AddEvaluator(
    builder: DiagramBuilder, scenario: Scenario, obstacles: Obstacles
) -> Evaluator:
    evaluator = Evaluator(
        scenario.humans,
        time_step=scenario.simulation.time_step,
        config=scenario.evaluator,
        goal_tolerance=scenario.robot.goal_tolerance,
        goal_yaw_tolerance=scenario.robot.goal_yaw_tolerance,
        obstacles=obstacles,
    )
    builder.AddNamedSystem("evaluator", evaluator)
    return evaluator


def _AddMonitor(builder: DiagramBuilder, scenario: Scenario) -> TrialMonitor:
    monitor = TrialMonitor(
        goal_tolerance=scenario.robot.goal_tolerance,
        goal_yaw_tolerance=scenario.robot.goal_yaw_tolerance,
        stuck_time=scenario.simulation.stuck_time,
        stuck_distance=scenario.simulation.stuck_distance,
        time_step=scenario.simulation.time_step,
    )
    builder.AddNamedSystem("monitor", monitor)
    return monitor
