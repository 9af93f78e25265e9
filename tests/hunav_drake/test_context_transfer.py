"""The state of one trial is taken over into the diagram of another."""

from importlib.resources import files
import re

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.common.value import Value
from pydrake.systems.framework import LeafSystem
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    TransferContext,
)
from hunav_drake.systems import robot
from hunav_drake.systems.common.sampling import Sampling
from hunav_drake.systems.planning import PlannerConfig, register_planner
from hunav_drake.systems.robot.drives import DifferentialWheels
from hunav_drake.systems.robot.robots import UrdfRobot
from hunav_drake.trial.context_layout import leaves


def scenario(name, *overrides):
    return LoadScenario(filename=name, overrides=list(overrides))


def at(diagram, time):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    return simulator


def ports(diagram, context):
    return [
        diagram.GetOutputPort(name).Eval(context)
        for name in ("human_states", "robot_state")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("passing", ()),
        ("cafe", ("planner=dwb",)),
        ("combined", ("planner={name: mppi, batch_size: 100}",)),
        ("station", ()),
        ("crossing", ("robot.type=pmb2",)),
    ],
)
def test_another_diagram_of_the_scenario_goes_on_alike(name, overrides):
    mine = scenario(name, *overrides)
    diagram, other = MakeTrialDiagram(mine), MakeTrialDiagram(mine)
    simulator = at(diagram, 3.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    fork = MakeTrialSimulator(other, taken)
    for each in (simulator, fork):
        each.AdvanceTo(6.0)
    np.testing.assert_equal(
        ports(diagram, simulator.get_context()),
        ports(other, fork.get_context()),
    )


@pytest.mark.slow
def test_another_planner_begins_at_the_same_instant():
    mine = scenario("cafe", "planner=dwb")
    diagram = MakeTrialDiagram(mine)
    simulator = at(diagram, 4.0)
    before = ports(diagram, simulator.get_context())
    changed = scenario("cafe", "planner=sfw")
    other = MakeTrialDiagram(changed)
    taken = TransferContext(diagram, simulator.get_context(), other)
    assert taken.get_time() == 4.0
    np.testing.assert_equal(ports(other, taken), before)
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(8.0)
    simulator.AdvanceTo(8.0)
    robots = [
        diagram_.GetOutputPort("robot_state").Eval(it.get_context())
        for diagram_, it in ((diagram, simulator), (other, fork))
    ]
    assert not np.array_equal(*robots)
    # The recording is of the whole trial.
    result = GetTrialResult(changed, other, fork.get_context())
    assert result.recording.times[0] == 0.0


def test_the_command_is_taken_over_and_the_memory_is_not():
    diagram = MakeTrialDiagram(scenario("passing", "planner=dwb"))
    simulator = at(diagram, 5.0)
    other = MakeTrialDiagram(scenario("passing", "planner=pursuit"))
    taken = TransferContext(diagram, simulator.get_context(), other)
    commands = [
        it.GetSubsystemByName("planner")
        .GetOutputPort("velocity_command")
        .Eval(it.GetSubsystemByName("planner").GetMyContextFromRoot(context))
        for it, context in ((diagram, simulator.get_context()), (other, taken))
    ]
    assert commands[0][0] > 0.3
    np.testing.assert_array_equal(*commands)


def test_the_first_context_is_not_changed():
    diagram = MakeTrialDiagram(scenario("passing"))
    simulator = at(diagram, 3.0)
    run_through = at(diagram, 6.0)
    other = MakeTrialDiagram(scenario("passing", "planner=orca"))
    taken = TransferContext(diagram, simulator.get_context(), other)
    MakeTrialSimulator(other, taken).AdvanceTo(6.0)
    simulator.AdvanceTo(6.0)
    np.testing.assert_equal(
        ports(diagram, simulator.get_context()),
        ports(diagram, run_through.get_context()),
    )


OTHERS = {
    "humans": ("humans=[]", "there were 2, and are 0"),
    "humans[0].name": ("humans[0].name=bob", "it was 'ana', and is 'bob'"),
    "humans[0].id": ("humans[0].id=77", "it was 1, and is 77"),
    "humans[0].behavior": ("humans[0].behavior=curious", "and is 'curious'"),
    "humans[0].radius": ("humans[0].radius=0.2", "it was 0.4, and is 0.2"),
    "humans[0].desired_speed": ("humans[0].desired_speed=0.5", "is 0.5"),
    "humans[0].goals[0][0]": ("humans[0].goals=[[1, 1]]", "and is 1.0"),
    "humans[0].forces.social_factor": (
        "humans[0].forces.social_factor=5.0",
        "and is 5.0",
    ),
    "population.cohorts": (
        "population.cohorts=[{number: 1, start: [{rectangle: [2, 1, 4, 2]}]}]",
        "there were 0, and are 1",
    ),
    "robot.type": ("robot.type=pmb2", "and is 'pmb2'"),
    "robot.radius": ("robot.radius=0.2", "it was 0.35, and is 0.2"),
    "robot.limits.max_speed": ("robot.limits.max_speed=0.5", "and is 0.5"),
    "robot.goal": ("robot.goal=null", "and is nothing"),
    "robot.goal[0]": ("robot.goal=[1, 1, 0]", "it was -7.7, and is 1.0"),
    "robot.goal_tolerance": ("robot.goal_tolerance=0.1", "and is 0.1"),
    "evaluator.timeout": ("evaluator.timeout=5.0", "nothing, and is 5.0"),
    "evaluator.start": ("evaluator.start=by_trigger", "and is 'by_trigger'"),
    "time_step": ("simulation.time_step=0.025", "it was 0.05, and is 0.025"),
}


@pytest.fixture(scope="module")
def passing():
    return MakeTrialDiagram(scenario("passing"))


@pytest.mark.parametrize("part", OTHERS)
def test_other_people_robots_and_evaluators_are_refused(passing, part):
    """They would be mixed: the state of one, the parameters of the other."""
    change, words = OTHERS[part]
    other = MakeTrialDiagram(scenario("passing", change))
    context = passing.CreateDefaultContext()
    match = rf"^{re.escape(part)}: .*{words}; the state cannot be taken over"
    with pytest.raises(ValueError, match=match):
        TransferContext(passing, context, other)
    with pytest.raises(ValueError, match=rf"^{re.escape(part)}: "):
        TransferContext(other, other.CreateDefaultContext(), passing)


def test_people_whom_other_walls_draw_elsewhere_are_refused():
    people = "population.cohorts=[{number: 6, start: [{rectangle: [1, 0, 5,"
    people += " 2]}]}]"
    wall = "world.walls=[{type: box, center: [3, 1], size: [3, 1]}]"
    alone, same, beside = (
        MakeTrialDiagram(scenario("passing", people, *changes))
        for changes in ((), ("crowd.model=orca",), (wall,))
    )
    context = alone.CreateDefaultContext()
    TransferContext(alone, context, same)
    with pytest.raises(ValueError, match=r"drawn\[.*list the people under hum"):
        TransferContext(alone, context, beside)


def test_people_with_the_weights_of_another_profile_are_refused():
    """Their weights are in the Context, and would stay the old ones."""
    mine = MakeTrialDiagram(scenario("doorway", "crowd={}"))
    other = scenario("doorway", "crowd={profile: hunav_drake_0.1}")
    match = r"^people by crowd\.profile\[0\]\.forces\.social_factor: it was 90"
    with pytest.raises(ValueError, match=match):
        TransferContext(
            mine, mine.CreateDefaultContext(), MakeTrialDiagram(other)
        )


@pytest.mark.parametrize(
    "change",
    [
        "crowd.model=orca",
        "crowd.robot_gap=0.1",
        "world.walls=[{type: box, center: [0, 3], size: [5, 1]}]",
        "simulation.stuck_time=1000.0",
        "scene.overlays=[]",
    ],
)
def test_world_motion_model_and_scene_may_be_others(passing, change):
    changed = scenario("passing", change)
    simulator, other = at(passing, 2.0), MakeTrialDiagram(changed)
    taken = TransferContext(passing, simulator.get_context(), other)
    np.testing.assert_equal(
        ports(other, taken), ports(passing, simulator.get_context())
    )
    MakeTrialSimulator(other, taken).AdvanceTo(2.5)


@pytest.mark.slow
def test_a_robot_of_which_the_file_has_changed_is_refused(tmp_path):
    """Even where it has as many joints."""
    text = (files(robot) / "models" / "pmb2.sdf").read_text()
    file = tmp_path / "robot.sdf"
    diagrams = []
    for name in ("pmb2", "renamed"):
        file.write_text(
            text.replace('model name="pmb2"', f'model name="{name}"')
        )
        changed = scenario("passing")
        changed.robot = UrdfRobot(
            file=str(file),
            base="base",
            drive=DifferentialWheels(
                left_wheel="left_wheel_joint",
                right_wheel="right_wheel_joint",
                wheel_separation=0.4044,
                wheel_radius=0.0985,
                max_torque=6.0,
            ),
        )
        diagrams.append(MakeTrialDiagram(changed))
    context = diagrams[0].CreateDefaultContext()
    with pytest.raises(ValueError, match=r"plant cannot .* by other joints"):
        TransferContext(diagrams[0], context, diagrams[1])


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (("planner.sees=visible",), ("planner.sees=lidar",)),
        ((), ("planner.sees=visible",)),
        (("planner.sees=lidar",), ()),
        (
            ("sensors=[{type: lidar, num_rays: 9}]",),
            ("sensors=[{type: lidar, num_rays: 11}]",),
        ),
    ],
)
def test_a_planner_may_see_by_other_means(before, after):
    diagram, other = (
        MakeTrialDiagram(scenario("passing", "planner=dwb", *changes))
        for changes in (before, after)
    )
    simulator = at(diagram, 3.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    np.testing.assert_equal(
        ports(other, taken), ports(diagram, simulator.get_context())
    )
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(4.0)
    ahead = ports(other, fork.get_context())[1]
    assert ahead[0] != ports(diagram, simulator.get_context())[1][0]


def test_fixed_inputs_are_taken_over():
    mine = scenario("passing", "evaluator.start=by_trigger")
    diagram = MakeTrialDiagram(mine)
    changed = scenario("passing", "evaluator.start=by_trigger", "planner=orca")
    other = MakeTrialDiagram(changed)
    simulator = MakeTrialSimulator(diagram)
    trigger = diagram.GetInputPort("trigger")
    trigger.FixValue(simulator.get_mutable_context(), 1.0)
    simulator.AdvanceTo(1.0)
    taken = TransferContext(diagram, simulator.get_context(), other)
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(2.0)
    result = GetTrialResult(changed, other, fork.get_context())
    assert result.recording.times[[0, -1]].tolist() == [0.0, 2.0]
    # (Drake numbers the sources of a SceneGraph on, through all diagrams.)
    scene = diagram.GetSubsystemByName("scene")
    graph = scene.GetSubsystemByName("scene_graph")
    port = graph.get_input_port(graph.num_input_ports() - 1)
    context = simulator.get_mutable_context()
    port.FixValue(
        graph.GetMyMutableContextFromRoot(context),
        graph.AllocateInputAbstract(port),
    )
    with pytest.raises(ValueError, match=r"the input scene/.* a fixed value"):
        TransferContext(diagram, context, other)


@pytest.mark.parametrize(
    ("overrides", "change", "due"),
    [
        # The lidar's period is that of the planner.
        ("planner={type: orca, sees: lidar}", "planner.period=0.2", 3.2),
        ("sensors=[{type: lidar, period: 0.1}]", "sensors[0].period=0.4", 3.2),
        ("crowd.decisions={period: 0.5}", "crowd.decisions.period=2.0", 4.0),
    ],
)
def test_samples_go_on_with_another_period(overrides, change, due):
    """They do not wait until the number of samples is that of before."""
    diagram = MakeTrialDiagram(scenario("crossing", overrides))
    simulator = at(diagram, 3.0)
    other = MakeTrialDiagram(scenario("crossing", overrides, change))
    taken = TransferContext(diagram, simulator.get_context(), other)
    (system,) = (
        it
        for _, it in leaves(other)
        if isinstance(it, Sampling) and it.get_name() != "localization"
    )
    fork = MakeTrialSimulator(other, taken)
    fork.AdvanceTo(3.05)
    port = system.get_output_port(0)
    own = system.GetMyContextFromRoot(fork.get_context())
    held = port.Eval(own)
    while np.array_equal(port.Eval(own), held):
        assert own.get_time() < due + 0.01
        fork.AdvanceTo(own.get_time() + 0.05)
    assert own.get_time() == pytest.approx(due)


class Counter(LeafSystem):
    """A planner of users, with a state that they may not be able to save."""

    def __init__(self, speed, stored, num_humans):
        super().__init__()
        self.DeclareVectorInputPort("robot_state", 7)
        self.DeclareVectorInputPort("human_states", 7 * num_humans)
        self.DeclareVectorInputPort("goal", 3)
        if stored:
            self.DeclareDiscreteState([speed])
        else:
            self.DeclareAbstractState(Value((speed,)))

        def command(context, output):
            if stored:
                (now,) = context.get_discrete_state(0).value()
            else:
                (now,) = context.get_abstract_state(0).get_value()
            output.SetFromVector([now, 0.0])

        self.DeclareVectorOutputPort("velocity_command", 2, command)
        self.DeclareVectorOutputPort("status", 1, lambda *_: None)
        self.DeclareAbstractOutputPort(
            "path", lambda: Value(np.zeros((0, 2))), lambda *_: None
        )


@pytest.mark.parametrize("stored", [True, False])
def test_states_of_own_planners_are_copied_or_begin_anew(stored):
    name = f"counter_{stored}"

    @register_planner(name)
    @dataclass
    class CounterPlanner(PlannerConfig):
        speed: float = 0.5

        def MakeSystem(self, task):
            return Counter(self.speed, stored, task.num_humans)

    diagram = MakeTrialDiagram(
        scenario("passing", f"planner={{type: {name}, speed: 0.3}}")
    )
    simulator = at(diagram, 1.0)
    planner = diagram.GetSubsystemByName("planner")
    own = planner.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    if stored:
        own.SetDiscreteState([0.4])
    else:
        own.SetAbstractState(0, (0.4,))
    for speed, command in ((0.3, 0.4), (0.6, 0.6)):
        other = MakeTrialDiagram(
            scenario("passing", f"planner={{type: {name}, speed: {speed}}}")
        )
        taken = TransferContext(diagram, simulator.get_context(), other)
        port = other.GetOutputPort("velocity_command")
        assert port.Eval(taken)[0] == command
