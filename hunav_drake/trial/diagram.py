"""The diagram of a trial."""

from collections.abc import Sequence
import dataclasses
from typing import TYPE_CHECKING, Any

from pydrake.common import RandomGenerator
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    OutputPort,
)

from hunav_drake.scenario import CheckScenario
from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.population import people_seed, with_drawn_people
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.ports import JoinPorts
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.sensing.delay import AddDelay
from hunav_drake.trial.blocks import (
    AddEvaluators,
    AddGoal,
    AddLocalization,
    AddMonitor,
    AddPeople,
    AddPerception,
    AddPlanner,
    AddRobots,
    AddSensors,
    AddTrialScene,
    ConnectByName,
    Ports,
    with_planner_lidar,
    with_prefix,
)
from hunav_drake.trial.fleet_blocks import (
    AddFleet,
    AddSurroundings,
    RefuseClash,
    SplitPort,
)
from hunav_drake.trial.seeds import CheckPeopleSeed, DrawSeed, SetTrialSeed

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


class TrialDiagram(Diagram):
    """The diagram of a trial, made by `MakeTrialDiagram`.

    Attributes:
        scenario: Its scenario. Changes of it have no effect.
        humans: All people, those of the population last.
    """

    def __init__(
        self, scenario: Scenario, humans: Sequence[HumanConfig]
    ) -> None:
        """Constructs an empty diagram."""
        super().__init__()
        self.scenario = scenario
        self.humans = humans

    @property
    def prefixes(self) -> dict[str, str]:
        """The prefixes of systems and ports, by the names of the robots."""
        return {it.name: it.prefix for it in robot_parts(self.scenario)}

    def DescribeMemory(self) -> list[str]:
        """Returns the trial's seed if it drew the people."""
        seed = people_seed(self.scenario)
        return [] if seed is None else [f"people drawn by seed {seed}"]

    def SetRandomContext(
        self, context: Context, generator: RandomGenerator
    ) -> None:
        """Draws a seed, and sets it as `SetTrialSeed` does.

        Drake's `MonteCarloSimulation` does not call this method: it resets a
        Context to the seed of the diagram. Use `MakeRandomSimulator` there.

        Args:
            context: A Context of this diagram, changed.
            generator: The source of the seed: see `DrawSeed`.

        Raises:
            ValueError: If the people of the trial are drawn by its seed.
        """
        SetTrialSeed(self, context, DrawSeed(generator))


def MakeTrialDiagram(
    scenario: Scenario,
    meshcat: "Meshcat | None" = None,
    *,
    may_leave: bool = False,
    drawn: bool = True,
) -> TrialDiagram:
    """Makes the diagram of a trial, whose whole state is one Context.

    Args:
        scenario: The scenario. Its seed applies to the default Context; see
            `SetTrialSeed` for others. The people of its population are drawn
            here, by `population.seed` or, if there is none, by the seed of the
            trial: then the diagram is valid for this seed only.
        meshcat: The Meshcat that shows the trial; by default, none.
        may_leave: Whether `LeaveOut` can take people out. While all are here,
            results are the same.
        drawn: Whether the scene has geometry also where neither `meshcat` nor
            sensors see it, as for what reads the output "query". Without it
            the diagram is made faster; states and results are the same.

    Returns:
        A diagram of the systems "humans" (`AddHumans`), "robot" and "planner"
        (see `RobotConfig` and `PlannerConfig`), "goal" (if there is one),
        "evaluator" (`Evaluator`; with `EvaluatorConfig.encounters` mostly
        "encounters", another one), "monitor" (`TrialMonitor`), "scene"
        (`AddScene`), the sensors (see `AddSensors`) and, unless the planner
        sees everything, "perception" (see `AddPerception`); of "localization"
        and "perception_delay" (see `AddLocalization`) and of "command_delay",
        if the planner's pose is not exact, or if these are delayed; of "plant"
        and "scene_graph" for a robot that is a body of a plant, else of
        "contacts" (`DiscContacts`). Its only input is "trigger", if that starts
        the recording (`EvaluatorConfig.start`). Its outputs are "robot_state",
        "human_states", "behavior_status", "forces", "contacts",
        "velocity_command", "planner_status", "planner_path", "metrics",
        "recording", "trial_status", "query", "estimated_robot_state" if it is
        not exact, the outputs of the sensors, such as "scan", "local_costmap"
        and "global_costmap" (see `NavigationSystem`) of a planner with maps,
        "traffic" (see `OpenCrowd`) if people come and
        go, "replay" (see `RecordedPeople`) if some are recorded, and
        "social_signals" if behavior trees have social leaves. For its scenario
        see `TrialDiagram`.

        Of several robots, each has these systems, but for "humans", "scene",
        "plant" and "scene_graph", and the outputs from or about it, with its
        name and "_" before their names. Then "monitor" is a `FleetMonitor`,
        whose outputs are "trial_status" and "robot_ends", and "robot_states"
        has the rows of all robots.

    Raises:
        ScenarioError: If the scenario cannot be simulated.
    """
    scenario = CheckScenario(scenario, ways=False)
    full, traffic = with_drawn_people(with_planner_lidar(scenario))
    obstacles = full.world.obstacles()

    # At an instant, Drake updates the blocks in the order of these lines.
    builder = DiagramBuilder()
    parts = robot_parts(full)
    humans = AddPeople(builder, full, traffic, may_leave=may_leave)
    robots = AddRobots(builder, parts, obstacles)
    planners = [
        AddPlanner(builder, part, obstacles, len(parts) - 1) for part in parts
    ]
    evaluators = [
        AddEvaluators(builder, part, obstacles, robot.feels_forces)
        for part, robot in zip(parts, robots, strict=True)
    ]
    monitors = [AddMonitor(builder, part) for part in parts]
    is_social = humans.social_signals is not None
    scene = AddTrialScene(
        builder, full, meshcat, is_social=is_social, drawn=drawn
    )
    states = [robot.robot_state for robot in robots]
    robot_states = JoinPorts(builder, "robot_states", states)
    builder.Connect(robot_states, humans.robot_states)
    touches = SplitPort(builder, "touches", humans.robot_touches, len(parts))
    truth: Ports = {
        "human_states": humans.human_states,
        "behavior_status": humans.behavior_status,
        "forces": humans.forces,
        "query": scene.query_object,
    }
    outputs: dict[str, OutputPort | None] = {**truth}
    for part, robot, planner, recorders, monitor, touch, around in zip(
        *(parts, robots, planners, evaluators, monitors, touches),
        AddSurroundings(builder, parts, robots, humans.human_states),
        strict=True,
    ):
        given: Ports = {
            "robot_state": robot.robot_state,
            "human_states": humans.human_states,
            "behavior_status": humans.behavior_status,
            "contacts": robot.contacts,
            "robot_touches": touch,
            "wall_contact": robot.wall_contact,
            "replay": humans.replay,
            "social_signals": humans.social_signals,
            "goal": AddGoal(builder, part),
        }
        given = {**given, **around.others}
        sensed = AddSensors(builder, part, scene, given)
        given = {**given, **sensed}
        seen = AddPerception(builder, part, given, around.seen)
        seen = AddLocalization(builder, part, given, seen)
        own: Ports = {
            "robot_state": robot.robot_state,
            "estimated_robot_state": seen.get("estimated_robot_state"),
            "contacts": robot.contacts,
            "velocity_command": planner.velocity_command,
            "planner_status": planner.status,
            "planner_path": planner.path,
            "metrics": recorders[0].GetOutputPort("metrics"),
            "recording": recorders[0].GetOutputPort("recording"),
            "trial_status": monitor.GetOutputPort("trial_status"),
        }
        command = AddDelay(
            builder,
            f"{part.prefix}command_delay",
            planner.velocity_command,
            part.scenario.robot.command_delay,
            full.simulation.time_step,
            from_zero=True,
        )
        builder.Connect(command, robot.velocity_command)
        ConnectByName(builder, {**given, **around.bodies}, robot.systems[0])
        takers = [*robot.systems[1:], *recorders, monitor]
        ConnectByName(builder, given, *takers)
        ConnectByName(builder, seen, planner.system)
        ports = with_prefix({**own, **sensed, **planner.costmaps}, part)
        if part.name:
            RefuseClash(outputs, ports)
        outputs |= ports
        truth = {**truth, **with_prefix(own, part)}
    some: Ports = {
        "traffic": humans.traffic,
        "replay": humans.replay,
        "social_signals": humans.social_signals,
    }
    outputs |= some
    if len(parts) > 1:
        outputs |= {"robot_states": robot_states}
        ports = AddFleet(
            *(builder, full, parts, monitors, planners, scene),
            *(humans.human_states, robot_states),
        )
        RefuseClash(outputs, ports)
        outputs |= ports
    # The scene shows the truth, whatever the ports of sensors are called.
    ConnectByName(builder, {**outputs, **truth}, scene.system)

    if full.evaluator.start == "by_trigger":
        first, *more = (it[0].GetInputPort("trigger") for it in evaluators)
        builder.ExportInput(first, "trigger")
        for port in more:
            builder.ConnectInput("trigger", port)
    for name, port in outputs.items():
        if port is not None:
            builder.ExportOutput(port, name)
    diagram = TrialDiagram(scenario, full.humans)
    builder.BuildInto(diagram)
    diagram.set_name("trial")
    return diagram


def CheckTrialDiagram(scenario: Scenario, diagram: Diagram) -> None:
    """Checks that a diagram was made from a scenario, and serves its seed.

    Raises:
        ValueError: If the scenario of the diagram differs in more than name,
            description and duration, or if its people were drawn by another
            seed: see `SetTrialSeed`.
    """
    CheckPeopleSeed(diagram, scenario.simulation.seed)
    made_from = _fixed_parts(diagram.scenario)
    # (A copy, so that people added to its list get names, too.)
    parts = _fixed_parts(dataclasses.replace(scenario))
    for part, value in parts.items():
        if value != made_from[part]:
            raise ValueError(
                f"the diagram was made from a scenario with other {part}: make"
                " it by MakeTrialDiagram from this one"
            )


def _fixed_parts(scenario: Scenario) -> dict[str, Any]:
    """Returns the parts of a scenario that a diagram depends on."""
    parts: dict[str, Any] = plain(scenario)
    for free in (parts, parts["simulation"]):
        for key in ("name", "description", "seed", "duration"):
            free.pop(key, None)
    return parts
