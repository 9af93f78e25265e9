"""One diagram serves all seeds: they are in its Contexts."""

import dataclasses

import numpy as np
import pandas as pd
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Integrator
import pytest

from hunav_drake import (
    AddHumans,
    GetTrialResult,
    GetTrialSeed,
    LeaveOut,
    LoadContext,
    LoadScenario,
    MakeHumans,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    SetDecisionSeed,
    SetHumansSeed,
    SetRobotCommand,
    SetTrialSeed,
    TakeRobotAway,
    TransferContext,
)
from tests.walkers import make_walkers

DURATION = 2.5


def make_scenario(name="crossing", *, seed=0):
    """A short trial that differs by seed in all that can be drawn."""
    scenario = LoadScenario(
        filename=name,
        overrides=[
            f"simulation.duration={DURATION}",
            "simulation.start_jitter=0.3",
            f"simulation.seed={seed}",
        ],
    )
    modes = ("random_normal", "random_uniform", "default")
    humans = [
        dataclasses.replace(human, forces_mode=modes[i % 3])
        for i, human in enumerate(scenario.humans)
    ]
    return dataclasses.replace(scenario, humans=humans)


@pytest.fixture(scope="module")
def scenario():
    return make_scenario()


@pytest.fixture(scope="module")
def diagram(scenario):
    return MakeTrialDiagram(scenario)


@pytest.fixture(scope="module")
def results(scenario):
    """The results of some seeds, each of a diagram of its own."""
    return {seed: RunTrial(scenario, seed) for seed in (0, 1, 2**63 - 1)}


def saved_arrays(diagram, context, path):
    """All that a Context holds, as it is saved in a file."""
    with np.load(SaveContext(diagram, context, path)) as file:
        return dict(file)


def assert_same_arrays(one, other):
    assert one.keys() == other.keys()
    for name, array in one.items():
        np.testing.assert_array_equal(array, other[name], err_msg=name)


def assert_same_result(result, expected):
    assert result.recording == expected.recording
    pd.testing.assert_series_equal(
        result.metrics, expected.metrics, check_exact=True
    )
    assert result.provenance == expected.provenance
    assert result.end_reason == expected.end_reason


def test_seeds_differ(results):
    starts = [result.recording.humans[0, :, :2] for result in results.values()]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert (starts[one] != starts[other]).all()


def test_a_reused_diagram_gives_what_a_fresh_one_does(
    scenario, diagram, results
):
    for seed in (2**63 - 1, 1, 0, 1):
        result = RunTrial(scenario, seed, diagram=diagram)
        assert_same_result(result, results[seed])


@pytest.mark.parametrize("name", ["cafe", "combined", "reaction_curious"])
def test_so_it_does_in_other_scenarios(name):
    diagram = MakeTrialDiagram(make_scenario(name, seed=4))
    RunTrial(make_scenario(name), 8, diagram=diagram)
    assert_same_result(
        RunTrial(make_scenario(name), 5, diagram=diagram),
        RunTrial(make_scenario(name, seed=5)),
    )


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ("humans[0].radius=0.31", "humans"),
        ("robot.start=[0, 0.1, 0]", "robot"),
        ("planner.cruise_speed=0.4", "planner"),
        ("simulation.stuck_time=5.0", "simulation"),
    ],
)
def test_a_diagram_of_another_scenario_is_refused(change, part):
    diagram = MakeTrialDiagram(LoadScenario(filename="passing"))
    other = LoadScenario(filename="passing", overrides=[change])
    with pytest.raises(ValueError, match=f"other {part}: make it by"):
        RunTrial(other, diagram=diagram)
    with pytest.raises(ValueError, match=f"other {part}: make it by"):
        GetTrialResult(other, diagram, diagram.CreateDefaultContext())


def test_a_reused_simulator_does_so_too(scenario, diagram, results):
    simulator = MakeTrialSimulator(diagram)
    for seed in (1, 0, 1):
        SetTrialSeed(diagram, simulator.get_mutable_context(), seed)
        simulator.Initialize()
        simulator.AdvanceTo(DURATION)
        result = GetTrialResult(scenario, diagram, simulator.get_context())
        assert_same_result(result, results[seed])


def test_contexts_of_several_seeds_do_not_disturb_each_other(
    scenario, diagram, results
):
    simulators = {}
    for seed in results:
        context = diagram.CreateDefaultContext()
        SetTrialSeed(diagram, context, seed)
        simulators[seed] = MakeTrialSimulator(diagram, context)
    # The last step is a whole one, as without stops.
    for time in [*np.arange(1, 10) * 0.25, DURATION]:
        for simulator in simulators.values():
            simulator.AdvanceTo(time)
    for seed, simulator in simulators.items():
        result = GetTrialResult(scenario, diagram, simulator.get_context())
        assert_same_result(result, results[seed])


def test_nothing_of_the_past_is_kept(diagram, tmp_path):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(DURATION)
    context = simulator.get_mutable_context()
    goal = diagram.GetSubsystemByName("goal")
    goal.get_mutable_source_value(
        goal.GetMyMutableContextFromRoot(context)
    ).SetFromVector([1.0, 2.0, 3.0])
    SetTrialSeed(diagram, context, 6)
    fresh = MakeTrialDiagram(make_scenario(seed=6))
    assert_same_arrays(
        saved_arrays(diagram, context, tmp_path / "reset.npz"),
        saved_arrays(
            fresh, fresh.CreateDefaultContext(), tmp_path / "fresh.npz"
        ),
    )


@pytest.mark.parametrize("seed", [0, 2**32 - 1, 2**32, 2**63 - 1])
def test_a_seed_survives_clones_and_files(diagram, tmp_path, seed):
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, np.int64(seed))
    clone = context.Clone()
    path = SaveContext(diagram, context, tmp_path / "context.npz")
    SetTrialSeed(diagram, context, 17)
    loaded = LoadContext(diagram, path)
    assert GetTrialSeed(diagram, context) == 17
    assert GetTrialSeed(diagram, clone) == GetTrialSeed(diagram, loaded) == seed
    assert_same_arrays(
        saved_arrays(diagram, clone, tmp_path / "clone.npz"),
        saved_arrays(diagram, loaded, tmp_path / "loaded.npz"),
    )


def test_a_result_tells_the_seed_of_its_context(scenario, diagram, results):
    assert GetTrialSeed(diagram, diagram.CreateDefaultContext()) == 0
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, 1)
    MakeTrialSimulator(diagram, context).AdvanceTo(DURATION)
    for named in (scenario, make_scenario(seed=8)):
        result = GetTrialResult(named, diagram, context)
        assert result.provenance == results[1].provenance
        assert result.provenance["seed"] == 1


@pytest.mark.parametrize("seed", [-1, 2**63, 0.5, True, "1", None])
def test_a_refused_seed_leaves_a_context_as_it_is(diagram, tmp_path, seed):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(0.5)
    context = simulator.get_mutable_context()
    before = saved_arrays(diagram, context, tmp_path / "before.npz")
    with pytest.raises(ValueError, match="seed must be a whole number in"):
        SetTrialSeed(diagram, context, seed)
    assert_same_arrays(
        before, saved_arrays(diagram, context, tmp_path / "after.npz")
    )


def test_a_context_of_another_diagram_is_refused(scenario, diagram):
    other = MakeTrialDiagram(scenario).CreateDefaultContext()
    with pytest.raises(RuntimeError, match="Context"):
        SetTrialSeed(diagram, other, 1)


def make_random_people():
    return make_walkers(
        2, xs=(1.0, 6.0), cyclic=False, forces_mode="random_uniform"
    )


@pytest.mark.parametrize("separate_trees", [True, False])
def test_people_in_a_diagram_of_ones_own_start_again(separate_trees, tmp_path):
    """And the rest of it, here a robot that drives on, stays as it is."""

    def make(seed):
        builder = DiagramBuilder()
        people = AddHumans(
            builder,
            make_random_people(),
            start_jitter=0.2,
            seed=seed,
            separate_trees=separate_trees,
        )
        speed = builder.AddNamedSystem(
            "speed", ConstantVectorSource([0.1] + 6 * [0.0])
        )
        robot = builder.AddNamedSystem("robot", Integrator(7))
        builder.Connect(speed.get_output_port(), robot.get_input_port())
        builder.Connect(robot.get_output_port(), people.robot_states)
        builder.ExportOutput(people.human_states, "human_states")
        return builder.Build()

    diagram = make(0)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(3.0)
    context = simulator.get_mutable_context()
    walked = diagram.GetOutputPort("human_states").Eval(context)[0]
    assert walked > 1.5
    humans = diagram.GetSubsystemByName("humans")
    SetHumansSeed(humans, humans.GetMyMutableContextFromRoot(context), 7)
    assert context.get_time() == 3.0
    assert context.get_continuous_state_vector()[0] == pytest.approx(0.3)
    fresh = make(7)
    expected = fresh.CreateDefaultContext()
    expected.SetTime(3.0)
    expected.SetContinuousState(
        context.get_continuous_state_vector().CopyToVector()
    )
    assert_same_arrays(
        saved_arrays(diagram, context, tmp_path / "reset.npz"),
        saved_arrays(fresh, expected, tmp_path / "fresh.npz"),
    )


def test_people_alone_are_a_diagram_too():
    diagram = MakeHumans(make_random_people(), num_robots=0)
    context = diagram.CreateDefaultContext()
    forces = diagram.GetOutputPort("forces")
    drawn = []
    for seed in (0, 1, 0):
        SetHumansSeed(diagram, context, seed)
        drawn.append(forces.Eval(context).copy())
    assert (drawn[0] != drawn[1]).any()
    np.testing.assert_array_equal(drawn[0], drawn[2])
    with pytest.raises(ValueError, match="seed must be a whole number in"):
        SetHumansSeed(diagram, context, 2**63)


@pytest.mark.parametrize(
    "call",
    [
        lambda own, context: SetTrialSeed(own, context, 1),
        lambda own, context: SetDecisionSeed(own, context, 1),
        GetTrialSeed,
        lambda own, context: LeaveOut(own, context, "ana"),
        lambda own, context: SetRobotCommand(own, context, [0.5, 0]),
        lambda own, context: TakeRobotAway(own, context),
        lambda own, context: TransferContext(own, context, own),
        lambda own, context: MakeTrialSimulator(own, context),
        lambda own, _: RunTrial(make_scenario(), diagram=own),
    ],
)
def test_what_is_for_trials_tells_so_of_a_diagram_of_ones_own(call):
    own = MakeHumans(make_walkers(1), may_leave=True)
    with pytest.raises(TypeError, match=r"must be from MakeTrialDiagram, got"):
        call(own, own.CreateDefaultContext())


def test_only_people_are_reset_with_their_seed():
    builder = DiagramBuilder()
    AddHumans(builder, make_walkers(1), num_robots=0)
    diagram = builder.Build()
    with pytest.raises(ValueError, match="is not a diagram of people; take"):
        SetHumansSeed(diagram, diagram.CreateDefaultContext(), 1)
    builder = DiagramBuilder()
    builder.AddNamedSystem("crowd", ConstantVectorSource([0.0]))
    for other in (builder.Build(), ConstantVectorSource([0.0])):
        with pytest.raises(ValueError, match="is not a diagram of people"):
            SetHumansSeed(other, other.CreateDefaultContext(), 1)
