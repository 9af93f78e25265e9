"""What every registered choice must do, whoever wrote it."""

import dataclasses
from typing import Any, NamedTuple

import jsonschema
import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer
import pytest
import yaml

from hunav_drake import (
    CheckScenario,
    HumanConfig,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    RunTrial,
    SaveContext,
    SaveScenario,
    Scenario,
    ScenarioError,
)
from hunav_drake.scenario import CrowdConfig, SimulationConfig, World
from hunav_drake.scenario.json_schema import scenario_json_schema
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.planning import (
    PERCEPTIONS,
    PLANNERS,
    LocalPlanner,
    Plan,
    Planner,
    PlannerConfig,
    PlannerStatus,
    PursuitPlanner,
    register_planner,
)
from hunav_drake.systems.robot import (
    DRIVES,
    ROBOTS,
    RobotConfig,
    RobotTask,
    register_robot,
)
from hunav_drake.systems.sensing import LOCALIZATIONS, SENSORS
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS
from tests.choices import NEEDED


class Kind(NamedTuple):
    registry: Registry
    # Where a choice is in a scenario.
    path: tuple[str | int, ...]


KINDS = {
    "planner": Kind(PLANNERS, ("planner",)),
    "motion model": Kind(MOTION_MODELS, ("crowd", "model")),
    "robot": Kind(ROBOTS, ("robot",)),
    "sensor": Kind(SENSORS, ("sensors", 0)),
    "wall": Kind(WALLS, ("world", "walls", 0)),
    "furniture": Kind(FURNITURE, ("world", "furniture", 0)),
    "drive": Kind(DRIVES, ("robot", "drive")),
    "perception": Kind(PERCEPTIONS, ("planner", "sees")),
    "localization": Kind(LOCALIZATIONS, ("planner", "localization")),
}
CHOICES = [
    pytest.param(kind, name, id=f"{kind} {name}")
    for kind, (registry, _) in KINDS.items()
    for name in sorted(registry)
]


def in_scenario(kind, name, /, **parameters) -> dict[str, Any]:
    """Returns a scenario as data, with that choice in it."""
    path = KINDS[kind].path
    data: Any = {"type": name, **NEEDED.get(name, {}), **parameters}
    for step in reversed(path):
        data = [data] if isinstance(step, int) else {step: data}
    if kind == "drive":
        data["robot"] = {"type": "urdf", **NEEDED["urdf"], **data["robot"]}
    return data


def load(data):
    return LoadScenario(data=yaml.safe_dump(data))


def choice_in(kind, scenario):
    for step in KINDS[kind].path:
        scenario = (
            scenario[step] if isinstance(step, int) else getattr(scenario, step)
        )
    return scenario


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), CHOICES)
def test_it_is_chosen_by_its_tag_and_survives_a_file(kind, name):
    scenario = load(in_scenario(kind, name))
    choice = choice_in(kind, scenario)
    assert type(choice) is KINDS[kind].registry[name]
    assert name_of(choice) == name
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    # And with all that differs from the defaults, as with nothing.
    assert load(plain(scenario)) == scenario
    assert CheckScenario(scenario) == scenario


@pytest.fixture(scope="module")
def validator():
    return jsonschema.Draft202012Validator(scenario_json_schema())


@pytest.mark.parametrize(("kind", "name"), CHOICES)
def test_the_json_schema_has_it(validator, kind, name):
    assert validator.is_valid(in_scenario(kind, name))
    assert not validator.is_valid(in_scenario(kind, f"{name}_"))
    assert not validator.is_valid(in_scenario(kind, name, nonsense=1))


def test_the_json_schema_leaves_room_for_classes_by_their_place(validator):
    name = "my_module:MyPlanner"
    assert validator.is_valid({"planner": name})
    assert validator.is_valid(in_scenario("planner", name, speed=0.5))
    assert not validator.is_valid({"planner": "my_module:"})


@pytest.mark.parametrize(("kind", "name"), CHOICES)
def test_bad_parameters_are_told_with_their_place(kind, name):
    registry, path = KINDS[kind]
    place = ".".join(map(str, path)).replace(".0", "[0]")
    keys = [field.name for field in dataclasses.fields(registry[name])]
    # Nothing takes such a value.
    bad = {key: {"no": ["value"]} for key in keys} | {"nonsense": 1}
    with pytest.raises(ScenarioError) as info:
        load(in_scenario(kind, name, **bad))
    told = {fault.path for fault in info.value.faults}
    for key in bad:
        assert any(path.startswith(f"{place}.{key}") for path in told), key


@pytest.mark.parametrize("name", sorted(WALLS))
def test_a_wall_has_finite_vertices(name):
    wall = WALLS.make({"type": name, **NEEDED.get(name, {})})
    vertices = wall.vertices()
    assert vertices.ndim == 2
    assert vertices.shape[1] == 2
    assert len(vertices) >= 2 + wall.solid
    assert np.isfinite(vertices).all()
    assert isinstance(wall.solid, bool)


# What moves: in a trial with a wall and people on the way.
# (Robots stand for their drives.)
MOVING = [
    param
    for param in CHOICES
    if param.values[0] not in ("wall", "furniture", "drive")
]


def make_trial(kind, name):
    scenario = Scenario(
        world=World(walls=[{"type": "box", **NEEDED["box"]}]),
        humans=[
            HumanConfig(pose=(6, 0.3, 3), goals=[(0, -6)], group_id=1),
            HumanConfig(pose=(6, 1.3, 3), goals=[(0, -5)], group_id=1),
            HumanConfig(pose=(4, -3, 1), goals=[(4, 5)]),
        ],
        robot={"goal": (10, 0, 0)},
        simulation=SimulationConfig(duration=6.0, stuck_time=60.0),
    )
    if kind == "motion model":
        part = {"crowd": CrowdConfig(model=name)}
    elif kind == "robot":
        parameters = {"goal": (10, 0, 0), **NEEDED.get(name, {})}
        part = {"robot": {"type": name, **parameters}}
    elif kind == "sensor":
        part = {"sensors": [{"type": name}]}
    elif kind == "perception":
        part = {"planner": {"type": "sfm", "sees": name}}
    elif kind == "localization":
        part = {"planner": {"type": "sfm", "localization": name}}
    else:
        part = {kind: {"type": name, **NEEDED.get(name, {})}}
    return dataclasses.replace(scenario, **part)


OUTPUTS = (
    "robot_state",
    "human_states",
    "contacts",
    "velocity_command",
    "planner_status",
)


def seen(diagram, context):
    """Returns all numbers that tell how a trial stands."""
    path = diagram.GetOutputPort("planner_path").Eval(context)
    ports = [diagram.GetOutputPort(n).Eval(context) for n in OUTPUTS]
    result = np.concatenate([*ports, path.ravel()])
    assert np.isfinite(result).all()
    return result


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), MOVING)
def test_contexts_do_not_disturb_each_other(kind, name):
    """A clone goes on like the original, whatever others do meanwhile."""
    scenario = make_trial(kind, name)
    diagram = MakeTrialDiagram(scenario)
    straight = Simulator(diagram)
    straight.AdvanceTo(4.0)
    expected = seen(diagram, straight.get_context())

    forked = Simulator(diagram)
    forked.AdvanceTo(1.97)
    other = Simulator(diagram)
    clone = Simulator(diagram, forked.get_context().Clone())
    for time in (1.0, 2.0, 3.0, 4.0):
        other.AdvanceTo(time)
        clone.AdvanceTo(max(time, 1.97))
    forked.AdvanceTo(4.0)
    # Another diagram of the same scenario does the same, bit for bit.
    again = MakeTrialDiagram(scenario)
    fresh = Simulator(again)
    fresh.AdvanceTo(4.0)
    for which, simulator in (
        (diagram, forked),
        (diagram, clone),
        (diagram, other),
        (again, fresh),
    ):
        np.testing.assert_array_equal(
            seen(which, simulator.get_context()), expected
        )


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name"), MOVING)
def test_a_context_goes_through_a_file(kind, name, tmp_path):
    diagram = MakeTrialDiagram(make_trial(kind, name))
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.97)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "a.npz")
    loaded = Simulator(diagram, LoadContext(diagram, file))
    for it in (simulator, loaded):
        it.AdvanceTo(3.0)
    np.testing.assert_array_equal(
        seen(diagram, simulator.get_context()),
        seen(diagram, loaded.get_context()),
    )


@pytest.mark.parametrize("name", sorted(ROBOTS))
def test_a_robot_stands_alone_too(name):
    """Its system, by itself, has all ports, and drives when it is told."""
    config = ROBOTS.make({"type": name, **NEEDED.get(name, {})})
    humans = [HumanConfig(pose=(3, 3, 0))]
    task = RobotTask(humans=humans)
    builder = DiagramBuilder()
    robot = builder.AddSystem(config.MakeSystem(task))
    v = min(0.4, 0.8 * config.limits.max_speed)
    command = builder.AddSystem(ConstantVectorSource([v, 0.2]))
    builder.Connect(
        command.get_output_port(), robot.GetInputPort("velocity_command")
    )
    if robot.HasInputPort("human_states"):
        people = builder.AddSystem(
            ConstantVectorSource([3.0, 3, 0, 0, 0, 0, 0.35])
        )
        builder.Connect(
            people.get_output_port(), robot.GetInputPort("human_states")
        )
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.0)
    port = robot.GetOutputPort("robot_state")
    x, y, yaw, vx, vy, omega, radius = port.Eval(
        robot.GetMyContextFromRoot(simulator.get_context())
    )
    assert np.hypot(vx, vy) == pytest.approx(v, rel=0.05)
    assert omega == pytest.approx(0.2, rel=0.05)
    # (Wheels of a skid steer slip sideways.)
    slip = 0.06 if name == "jackal" else 0.02
    assert np.arctan2(vy, vx) == pytest.approx(yaw, abs=slip)
    assert x > v
    assert y > 0.02
    assert radius == config.radius


# Choices that are systems of users' own.


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    for registry, _ in KINDS.values():
        monkeypatch.setattr(registry, "_choices", dict(registry))


def steady_planner(task, *, without=(), goal_size=3):
    """Makes a Diagram that is a planner: it always drives at 0.5 m/s."""
    builder = DiagramBuilder()
    for name, size in (
        ("robot_state", 7),
        ("human_states", 7 * task.num_humans),
        ("goal", goal_size),
    ):
        sink = builder.AddSystem(Multiplexer([size]))
        if name not in without:
            builder.ExportInput(sink.get_input_port(0), name)
    driving = float(PlannerStatus.DRIVING)
    for name, value in (
        ("velocity_command", [0.5, 0.0]),
        ("status", [driving]),
    ):
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.ExportOutput(source.get_output_port(), name)
    inner = builder.AddSystem(LocalPlanner(PursuitPlanner(), task))
    builder.ExportOutput(inner.get_path_output_port(), "path")
    return builder.Build()


def test_a_diagram_can_be_a_planner():
    @register_planner("steady")
    @dataclass
    class Steady(PlannerConfig):
        def MakeSystem(self, task):
            return steady_planner(task)

    result = RunTrial(
        Scenario(
            planner="steady",
            robot={"goal": (3, 0, 0)},
            simulation=SimulationConfig(duration=20),
        )
    )
    assert result.end_reason == "goal"
    assert result.provenance["planner"] == "steady"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (
            {"without": ("goal", "robot_state")},
            "robot_state .a vector of size 7. is missing.*goal .* is missing",
        ),
        ({"goal_size": 2}, "goal must be a vector of size 3, is .* size 2"),
    ],
)
def test_a_system_that_lacks_ports_is_no_planner(options, words):
    @register_planner("lacking")
    @dataclass
    class Lacking(PlannerConfig):
        def MakeSystem(self, task):
            return steady_planner(task, **options)

    with pytest.raises(TypeError, match=rf"planner Lacking lacks .*{words}"):
        MakeTrialDiagram(Scenario(planner="lacking"))


def test_what_makes_no_system_is_told():
    @register_robot("nothing")
    @dataclass
    class Nothing(RobotConfig):
        def MakeSystem(self, task):
            return None

    with pytest.raises(TypeError, match="Nothing must make a System, got None"):
        MakeTrialDiagram(Scenario(robot="nothing"))


def test_a_planner_that_needs_a_lidar_is_refused():
    @register_planner("looking")
    @dataclass
    class Looking(Planner):
        scan_size = 5

        def plan(self, task, view, memory): ...

    with pytest.raises(ScenarioError, match="planner: the planner 'looking'"):
        MakeTrialDiagram(Scenario(planner="looking"))


def test_an_unregistered_choice_is_never_taken_for_another():
    @dataclass
    class Nameless(PursuitPlanner):
        pass

    with pytest.raises(ValueError, match="Nameless is not registered"):
        Scenario(planner=Nameless())
    scenario = Scenario()
    scenario.planner = Nameless()
    with pytest.raises(ScenarioError, match="Nameless is not registered"):
        CheckScenario(scenario)


def test_the_bare_name_of_a_choice_may_be_refined():
    scenario = LoadScenario(
        data="planner: pursuit\ncrowd: {model: orca}\n",
        overrides=["planner.cruise_speed=0.3", "crowd.model.time_horizon=3"],
    )
    assert scenario.planner.cruise_speed == 0.3
    assert scenario.crowd.model == MOTION_MODELS.make(
        {"type": "orca", "time_horizon": 3}
    )


@dataclasses.dataclass(frozen=True)
class Leg:
    """A part of what a planner remembers."""

    name: str
    points: np.ndarray


class Memory(NamedTuple):
    """What a planner remembers."""

    count: int
    legs: tuple[Leg, ...]
    status: PlannerStatus
    last: float | None = None


class Unsaveable:
    """What arrays cannot hold."""


def remember(memory, view):
    points = np.array([[view.robot[0], 0.1]])
    points.setflags(write=False)
    leg = Leg(f"leg {memory.count}", points)
    return Memory(
        memory.count + 1,
        (*memory.legs, leg)[-3:],
        PlannerStatus.DRIVING,
        np.float64(view.robot[0]),
    )


def test_a_planners_memory_goes_through_a_file(tmp_path):
    @register_planner("remembering")
    @dataclass
    class Remembering(Planner):
        initial_memory = Memory(0, (), PlannerStatus.IDLE)

        def plan(self, task, view, memory):
            memory = remember(memory, view)
            v = 0.1 + 0.01 * memory.count + 0.001 * len(memory.legs[0].name)
            path = np.concatenate([leg.points for leg in memory.legs])
            return Plan(v, 0.0, memory.status, memory, path)

    scenario = Scenario(planner="remembering", robot={"goal": (9, 0, 0)})
    diagram = MakeTrialDiagram(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.47)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "a.npz")
    loaded = Simulator(diagram, LoadContext(diagram, file))
    for it in (simulator, loaded):
        it.AdvanceTo(1.0)
    np.testing.assert_array_equal(
        seen(diagram, simulator.get_context()),
        seen(diagram, loaded.get_context()),
    )


def test_a_memory_that_no_file_can_hold_is_refused(tmp_path):
    @register_planner("secretive")
    @dataclass
    class Secretive(Planner):
        initial_memory = ()

        def plan(self, task, view, memory):
            return Plan(0.0, 0.0, PlannerStatus.DRIVING, (1, Unsaveable()))

    diagram = MakeTrialDiagram(
        Scenario(planner="secretive", robot={"goal": (9, 0, 0)})
    )
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1)
    with pytest.raises(
        ValueError, match=r"planner's memory holds .*Unsaveable.* cannot be"
    ):
        SaveContext(diagram, simulator.get_context(), tmp_path / "a.npz")
    assert list(tmp_path.iterdir()) == []
