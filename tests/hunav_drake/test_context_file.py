"""A Context survives in a file, bit for bit."""

import dataclasses
from dataclasses import dataclass
import subprocess
import sys
from typing import ClassVar

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, Integrator
import pytest

from hunav_drake import (
    AddHumans,
    GetTrialResult,
    HumanConfig,
    LoadContext,
    LoadScenario,
    MakeHumans,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
)
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.planning import (
    PLANNERS,
    Plan,
    Planner,
    PlannerStatus,
    PursuitPlanner,
    register_planner,
)
from hunav_drake.systems.robot import AddBodyState
from hunav_drake.trial.context_file import ContextDigest
from hunav_drake.trial.context_layout import layout


def saved(scenario, time, path):
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    return SaveContext(diagram, simulator.get_context(), path)


def num_geometries(diagram):
    scene = diagram.GetSubsystemByName("scene")
    graph = scene.GetSubsystemByName("scene_graph")
    return graph.model_inspector().num_geometries()


@pytest.mark.parametrize(
    ("name", "robot"),
    [
        ("passing", {}),
        ("living_cafe", {}),
        ("three_robots", {}),
        ("crossing", {"type": "pmb2", "radius": 0.27}),
        ("crossing", {"type": "turtlebot3_burger", "radius": 0.123}),
    ],
)
def test_a_trial_that_is_not_drawn_has_the_same_state(name, robot, tmp_path):
    scenario = LoadScenario(
        filename=name,
        overrides=[f"robot.{key}={value}" for key, value in robot.items()],
    )
    digests, diagrams = [], []
    for drawn in (True, False):
        diagram = MakeTrialDiagram(scenario, drawn=drawn)
        simulator = MakeTrialSimulator(diagram)
        simulator.AdvanceTo(0.5)
        digests.append(ContextDigest(diagram, simulator.get_context()))
        diagrams.append(diagram)
    assert digests[0] == digests[1]
    assert num_geometries(diagrams[0]) > 0
    assert num_geometries(diagrams[1]) == 0
    # So one goes on where the other was.
    path = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    context = LoadContext(diagrams[0], path)
    assert ContextDigest(diagrams[0], context) == digests[0]


def test_what_a_camera_sees_is_drawn():
    scenario = LoadScenario(
        filename="passing", overrides=["sensors=[{type: camera}]"]
    )
    assert num_geometries(MakeTrialDiagram(scenario, drawn=False)) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cafe", "combined", "reaction_scared"])
def test_a_trial_goes_on_from_a_file(name, tmp_path):
    scenario = LoadScenario(filename=name)
    path = saved(scenario, 9.05, tmp_path / "context.npz")
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram, LoadContext(diagram, path))
    assert simulator.get_context().get_time() == pytest.approx(9.05)
    simulator.AdvanceTo(scenario.simulation.duration)
    result = GetTrialResult(scenario, diagram, simulator.get_context())
    assert result.recording == RunTrial(scenario).recording


@pytest.mark.slow
def test_another_process_goes_on(tmp_path):
    scenario = LoadScenario(filename="passing")
    path = saved(scenario, 9.0, tmp_path / "context.npz")
    code = f"""
from hunav_drake import *
scenario = LoadScenario(filename="passing")
diagram = MakeTrialDiagram(scenario)
simulator = MakeTrialSimulator(diagram, LoadContext(diagram, {str(path)!r}))
simulator.AdvanceTo(scenario.simulation.duration)
result = GetTrialResult(scenario, diagram, simulator.get_context())
result.recording.save({str(tmp_path / "recording.npz")!r})
"""
    subprocess.run([sys.executable, "-c", code], check=True)
    whole = RunTrial(scenario).recording
    assert type(whole).load(tmp_path / "recording.npz") == whole


def test_a_start_survives_too(tmp_path):
    scenario = LoadScenario(filename="passing")
    diagram = MakeTrialDiagram(scenario)
    path = tmp_path / "context.npz"
    SaveContext(diagram, diagram.CreateDefaultContext(), path)
    simulator = MakeTrialSimulator(diagram, LoadContext(diagram, path))
    simulator.AdvanceTo(scenario.simulation.duration)
    result = GetTrialResult(scenario, diagram, simulator.get_context())
    assert result.recording == RunTrial(scenario).recording


def make_own():
    """Returns a diagram with continuous state, a parameter and an input."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source", ConstantVectorSource([1.0]))
    first = builder.AddNamedSystem("first", Integrator(1))
    second = builder.AddNamedSystem("second", Integrator(2))
    builder.Connect(source.get_output_port(), first.get_input_port())
    builder.ExportInput(second.get_input_port(), "rate")
    free = builder.AddNamedSystem("free", Integrator(1))
    builder.ExportOutput(free.get_output_port(), "integral")
    return builder.Build()


def test_any_diagram_has_its_state_parameters_and_inputs_kept(tmp_path):
    diagram = make_own()
    context = diagram.CreateDefaultContext()
    context.SetTime(3.0)
    context.SetContinuousState([1.0, 2.0, 1 / 3, 0.5])
    diagram.get_input_port().FixValue(context, [5.0, 6.0])
    source = diagram.GetSubsystemByName("source")
    own = source.GetMyMutableContextFromRoot(context)
    source.get_mutable_source_value(own).SetFromVector([7.0])
    free = diagram.GetSubsystemByName("free")
    free.get_input_port().FixValue(
        free.GetMyMutableContextFromRoot(context), [8.0]
    )
    SaveContext(diagram, context, tmp_path / "own.npz")

    other = make_own()
    loaded = LoadContext(other, tmp_path / "own.npz")
    assert loaded.get_time() == 3.0
    np.testing.assert_array_equal(
        loaded.get_continuous_state_vector().CopyToVector(), [1, 2, 1 / 3, 0.5]
    )
    np.testing.assert_array_equal(other.get_input_port().Eval(loaded), [5, 6])
    free = other.GetSubsystemByName("free")
    own = free.GetMyContextFromRoot(loaded)
    assert free.get_input_port().Eval(own) == 8.0
    first = other.GetSubsystemByName("first")
    assert first.get_input_port().Eval(
        first.GetMyContextFromRoot(loaded)
    ) == pytest.approx(7.0)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ([np.nan], "first: continuous: must be finite, but number 0 is nan"),
        ([-np.inf], "first: continuous: must be finite, but number 0 is -inf"),
        ([1.0, 2.0], r"must be float64 of shape \(1,\), got"),
        ([1], r"must be float64 of shape \(1,\), got int64"),
        ([2.0], "its content is not what SaveContext wrote"),
    ],
)
def test_a_damaged_integrator_is_refused(tmp_path, value, words):
    diagram = make_own()
    path = tmp_path / "own.npz"
    SaveContext(diagram, diagram.CreateDefaultContext(), path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **arrays | {"1/continuous": np.array(value)})
    with pytest.raises(ValueError, match=rf"own\.npz: is damaged: .*{words}"):
        LoadContext(diagram, path)


def test_people_whose_robot_is_fixed(tmp_path):
    """A port of a diagram within the diagram has its value kept, too."""
    builder = DiagramBuilder()
    people = AddHumans(builder, [HumanConfig(pose=[0, 0, 0], goals=[[9, 0]])])
    builder.ExportOutput(people.human_states, "human_states")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    humans = people.robot_states.get_system()
    people.robot_states.FixValue(
        humans.GetMyMutableContextFromRoot(simulator.get_mutable_context()),
        [3.0, 0.1, 0, 0, 0, 0, 0.35],
    )
    simulator.AdvanceTo(2.0)
    SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    other = Simulator(diagram, LoadContext(diagram, tmp_path / "c.npz"))
    states = []
    for one in (simulator, other):
        one.AdvanceTo(5.0)
        states.append(diagram.get_output_port().Eval(one.get_context()))
    np.testing.assert_array_equal(*states)


def test_a_robot_of_a_plant_goes_on(tmp_path):
    """Of a discrete plant, which keeps more than numbers."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.01)
    body = plant.AddRigidBody(
        "cart", SpatialInertia.SolidCubeWithDensity(80.0, 0.4)
    )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    people = AddHumans(builder, [HumanConfig(pose=[4, 0, 3], goals=[[-9, 0]])])
    robot = AddBodyState(builder, plant, body, radius=0.3)
    builder.Connect(robot, people.robot_states)
    builder.ExportOutput(people.human_states, "human_states")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodySpatialVelocity(
        own, body, SpatialVelocity([0, 0, 0.1], [0.5, 0, 0])
    )
    simulator.AdvanceTo(2.0)
    SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    other = Simulator(diagram, LoadContext(diagram, tmp_path / "c.npz"))
    states = []
    for one in (simulator, other):
        one.AdvanceTo(5.0)
        states.append(diagram.get_output_port().Eval(one.get_context()))
    np.testing.assert_array_equal(*states)


def test_an_abstract_input_cannot_be_kept(tmp_path):
    class Reader(LeafSystem):
        def __init__(self):
            super().__init__()
            self.DeclareAbstractInputPort("text", AbstractValue.Make("a"))

    builder = DiagramBuilder()
    reader = builder.AddNamedSystem("reader", Reader())
    builder.ExportInput(reader.get_input_port(), "text")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    diagram.get_input_port().FixValue(context, AbstractValue.Make("b"))
    with pytest.raises(ValueError, match=r"text.* has a fixed value that is"):
        SaveContext(diagram, context, tmp_path / "c.npz")


def test_a_context_of_another_diagram_is_refused(tmp_path):
    path = saved(LoadScenario(filename="passing"), 1.0, tmp_path / "c.npz")
    diagram = MakeTrialDiagram(LoadScenario(filename="cafe"))
    with pytest.raises(ValueError, match=r"c.npz: does not fit the diagram at"):
        LoadContext(diagram, path)
    with pytest.raises(ValueError, match="Make the diagram as it was made"):
        LoadContext(make_own(), path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"humans: []"])
def test_another_file_is_refused(tmp_path, content):
    path = tmp_path / "context.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="is not a Context written by"):
        LoadContext(make_own(), path)


def test_another_archive_is_refused(tmp_path):
    np.savez(tmp_path / "context.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match="is not a Context written by"):
        LoadContext(make_own(), tmp_path / "context.npz")


def test_a_state_that_cannot_be_kept_is_named(tmp_path):
    class Secretive(LeafSystem):
        def __init__(self):
            super().__init__()
            self.DeclareAbstractState(AbstractValue.Make({"a": 1}))

    builder = DiagramBuilder()
    builder.AddNamedSystem("secretive", Secretive())
    diagram = builder.Build()
    with pytest.raises(ValueError, match=r"secretive has an abstract state"):
        SaveContext(diagram, diagram.CreateDefaultContext(), tmp_path / "c.npz")
    assert not list(tmp_path.iterdir())


def test_other_trees_are_refused(tmp_path):
    """Also where they have as much memory."""
    path = saved(
        LoadScenario(filename="reaction_scared"), 1.0, tmp_path / "c.npz"
    )
    diagram = MakeTrialDiagram(LoadScenario(filename="reaction_curious"))
    with pytest.raises(ValueError, match=r"c.npz: does not fit the diagram at"):
        LoadContext(diagram, path)


@dataclass
class Counter(Planner):
    """A planner that remembers how often it was asked."""

    initial_memory: ClassVar[float] = 0.0

    step: float = 1.0

    def plan(self, task, view, memory):
        return Plan(0, 0, PlannerStatus.DRIVING, memory + self.step)


@dataclass
class Twin(Counter):
    """One that remembers as many numbers, of another kind."""


@pytest.mark.parametrize(
    ("planner", "parameters", "found"),
    [
        ("stored_twin", {}, r"_counter\(.*step=1.0\) .*_twin\(.*step=1.0\)"),
        ("stored_counter", {"step": 2.0}, r"\(.*step=1.0\) .*\(.*step=2.0\)"),
        ("pursuit", {}, r"pursuit\(.*cruise_speed=0.6, .* in the diagram"),
    ],
)
def test_the_memory_of_another_planner_is_refused(
    tmp_path, monkeypatch, planner, parameters, found
):
    # A register of this test's own.
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))
    register_planner("stored_counter")(Counter)
    register_planner("stored_twin")(Twin)

    def make(name, parameters):
        chosen = {"name": name, **parameters}
        return dataclasses.replace(
            LoadScenario(filename="passing"), planner=chosen
        )

    path = saved(make("stored_counter", {}), 1.0, tmp_path / "c.npz")
    LoadContext(MakeTrialDiagram(make("stored_counter", {"step": 1.0})), path)
    with pytest.raises(ValueError, match=rf"c\.npz: does not fit .*{found}"):
        LoadContext(MakeTrialDiagram(make(planner, parameters)), path)


def test_parameters_of_a_planner_are_named(tmp_path):
    scenario = LoadScenario(filename="passing")
    path = saved(scenario, 1.0, tmp_path / "c.npz")
    fast = dataclasses.replace(
        scenario, planner=PursuitPlanner(cruise_speed=0.7)
    )
    words = r"of planner pursuit\(.*=0.6.* of planner pursuit\(.*speed=0.7"
    with pytest.raises(ValueError, match=words):
        LoadContext(MakeTrialDiagram(fast), path)


ANA = HumanConfig(pose=[0, 0, 0], goals=[[9, 0], [0, 0]], behavior="scared")


@pytest.mark.parametrize(
    ("human", "options", "words"),
    [
        ({"goals": [[9, 0]]}, {}, "with 2 goals.* with 1 goals"),
        ({"id": 5}, {}, "person 1 .* person 5 "),
        ({}, {"num_robots": 2}, " 1 robots .* 2 robots "),
        ({}, {"time_step": 0.1}, "step of 0.05 s in the file.* of 0.1 s"),
        (
            {"behavior": "curious"},
            {},
            "tree ScaredNavTree .* tree CuriousNavTree ",
        ),
    ],
)
def test_trees_of_others_are_refused(tmp_path, human, options, words):
    diagram = MakeHumans([ANA])
    path = SaveContext(
        diagram, diagram.CreateDefaultContext(), tmp_path / "c.npz"
    )
    other = MakeHumans([dataclasses.replace(ANA, **human)], **options)
    with pytest.raises(ValueError, match=rf"c\.npz: does not fit .*{words}"):
        LoadContext(other, path)


def test_trees_of_one_system_are_not_those_of_many(tmp_path):
    people = [ANA, dataclasses.replace(ANA, pose=(0, 5, 0))]
    diagram = MakeHumans(people)
    path = SaveContext(
        diagram, diagram.CreateDefaultContext(), tmp_path / "c.npz"
    )
    other = MakeHumans(people, separate_trees=False)
    with pytest.raises(ValueError, match=r"c\.npz: does not fit"):
        LoadContext(other, path)


def test_people_in_another_order_are_refused(tmp_path):
    """Each would go on where another one was."""
    scenario = LoadScenario("crossing")
    path = tmp_path / "context.npz"
    diagram = MakeTrialDiagram(scenario)
    SaveContext(diagram, diagram.CreateDefaultContext(), path)
    turned = dataclasses.replace(scenario, humans=scenario.humans[::-1])
    first, last = (scenario.humans[i].name for i in (0, -1))
    words = f"memory person {first} in the file, person {last} in the diagram"
    with pytest.raises(ValueError, match=words):
        LoadContext(MakeTrialDiagram(turned), path)
    # Also in one's own diagram.
    people = [HumanConfig(name=it, pose=[0, 0, 0]) for it in ("ana", "ben")]
    own = MakeHumans(people)
    SaveContext(own, own.CreateDefaultContext(), path)
    words = "at ::humans::crowd: memory person ana in the file, person ben in"
    with pytest.raises(ValueError, match=words):
        LoadContext(MakeHumans(people[::-1]), path)


def test_what_may_differ_is_as_it_is_in_the_diagram(tmp_path):
    diagram = MakeHumans([ANA])
    context = diagram.CreateDefaultContext()
    path = SaveContext(diagram, context, tmp_path / "c.npz")
    moved = dataclasses.replace(ANA, goals=[[9, 1], [1, 0]])
    LoadContext(MakeHumans([moved], config=CrowdConfig(model="orca")), path)


def test_a_state_that_is_not_finite_is_not_saved(tmp_path):
    diagram = make_own()
    context = diagram.CreateDefaultContext()
    context.SetContinuousState([1.0, np.nan, 0, 0])
    with pytest.raises(ValueError, match="second: continuous: must be finite"):
        SaveContext(diagram, context, tmp_path / "c.npz")
    assert not list(tmp_path.iterdir())


class Anonymous(LeafSystem):
    """A system that gets no name of its own."""


def test_a_system_without_a_name_is_known_in_another_process():
    """Its name tells its module, which may be `__main__`, and an address."""
    builder = DiagramBuilder()
    builder.AddSystem(Anonymous())
    builder.AddNamedSystem("named", Anonymous())
    diagram = builder.Build()
    told = layout(diagram, diagram.CreateDefaultContext())
    assert [it["path"] for it in told] == ["::_", "::_::", "::_::named"]


def test_the_context_of_a_system_that_is_no_diagram_is_refused(tmp_path):
    crowd = HumanCrowd([HumanConfig(pose=[0, 0, 0])], num_robots=0)
    context = crowd.CreateDefaultContext()
    with pytest.raises(TypeError, match="of a Diagram, got a HumanCrowd; put"):
        SaveContext(crowd, context, tmp_path / "context.npz")
