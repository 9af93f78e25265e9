"""The profile "hunavsim": one switch for all that HuNavSim does otherwise."""

import dataclasses as dc
import json
import lzma

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadContext,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
)
from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES
from hunav_drake.hunavsim.services import AgentServices
from hunav_drake.scenario import (
    CheckScenario,
    LoadScenario,
    SaveScenario,
    Scenario,
    ScenarioError,
)
from hunav_drake.systems.behavior import BEHAVIORS, CheckBehavior, LoadBehavior
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.crowd.social_force.model import SocialForceModel
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.people.profile import PROFILES
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.trial.humans import MakeHumans
from tests.recorded import COMPACT, read_recorded, recorded_names, single

TRACES = recorded_names("crowd")

# The columns of the recorded agents.
YAW, OMEGA, STATUS, GOAL = 2, 6, 7, 8
MOTION = [0, 1, 3, 4]

# The recorded forces, in pairs, and ours.
FORCES = {"desired": 0, "obstacle": 1, "social": 2}


def make_people(scenario, *, reverse=False):
    """Returns the diagram of the people of a trace, from the start on."""
    agents = scenario["agents"][:: -1 if reverse else 1]
    humans = [
        HumanConfig(
            id=agent["id"],
            pose=[agent["x"], agent["y"], agent["yaw"]],
            behavior=BEHAVIOR_NAMES[agent["behavior"]],
            desired_speed=agent["desired_velocity"],
            radius=agent["radius"],
            goals=agent["goals"],
            goal_radius=agent["goal_radius"],
            group_id=agent["group_id"],
        )
        for agent in agents
    ]
    walls = scenario.get("obstacles")
    given = {}
    if walls:
        given = {
            "obstacle_range": walls["max_dist"],
            "max_obstacles": walls["count"],
        }
    return MakeHumans(
        humans,
        obstacles=Obstacles.from_points(walls["points"] if walls else []),
        config=CrowdConfig(profile="hunavsim", **given),
        time_step=scenario["dt"],
        separate_trees=False,
    )


def free_run(case, *, reverse=False):
    """Walks people from the start on, and never puts them back.

    Returns:
        By step and person, in the order of the trace: the states after it, the
        statuses and forces in it, and the goals after it.
    """
    scenario = case["scenario"]
    diagram = make_people(scenario, reverse=reverse)
    context = diagram.CreateDefaultContext()
    trees = diagram.GetSubsystemByName("behaviors")
    n = len(scenario["agents"])
    parts = [], [], [], []
    for step in case["trace"]["steps"][1:]:
        robot = [*step["robot"], single(scenario["robot"]["radius"])]
        diagram.GetInputPort("robot_states").FixValue(context, robot)
        status = diagram.GetOutputPort("behavior_status").Eval(context)
        forces = diagram.GetOutputPort("forces").Eval(context)
        context.SetDiscreteState(
            diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        states = diagram.GetOutputPort("human_states").Eval(context)
        own = trees.GetMyContextFromRoot(context)
        goals = [trees.GetMemory(own, i)[0] for i in range(n)]
        rows = states.reshape(n, 7), status, forces.reshape(n, 8, 2), goals
        for part, row in zip(parts, rows, strict=True):
            part.append(np.array(row)[:: -1 if reverse else 1])
    return [np.array(part) for part in parts]


@pytest.mark.parametrize("name", TRACES)
def test_a_free_run_is_that_of_the_original(name):
    """From the start on, for 40 s and more, without being put back.

    The bits of all states, all goals and all statuses.
    """
    case = json.loads(read_recorded(name))
    states, status, forces, goals = free_run(case)
    steps = case["trace"]["steps"][1:]
    recorded = np.array([step["agents"] for step in steps])
    np.testing.assert_array_equal(states[..., MOTION], recorded[..., MOTION])
    np.testing.assert_array_equal(status, recorded[..., STATUS])
    np.testing.assert_array_equal(goals, recorded[..., GOAL])
    np.testing.assert_array_equal(states[..., YAW], recorded[..., YAW])
    # (It is in single precision there.)
    np.testing.assert_allclose(
        states[..., 5], recorded[..., OMEGA], rtol=1e-6, atol=1e-9
    )
    if "forces" in steps[0]:
        columns = case["trace"]["force_fields"]
        expected = np.array([step["forces"] for step in steps])
        # Of who reacts, what the port tells is of the snapshot; and who drops
        # a goal has the next one then.
        walks = (status == 0) & (np.diff(goals, axis=0, prepend=goals[:1]) == 0)
        assert walks.mean() > 0.02
        for force, index in FORCES.items():
            first = columns.index(f"{force}_x")
            np.testing.assert_array_equal(
                forces[walks][:, index], expected[walks][:, first : first + 2]
            )


UNSEEN = json.loads(
    lzma.decompress((COMPACT.parent / "hunavsim_traces.json.xz").read_bytes())
)


@pytest.mark.parametrize("case", UNSEEN, ids=lambda case: case["name"])
def test_random_people_walk_as_in_the_original(case):
    """All behaviors, numbers, groups and steps, and points for obstacles.

    The other simulator passes back what it was told, as in the recording.
    """
    services = AgentServices(
        [
            HumanConfig(
                id=agent["id"],
                pose=[agent["x"], agent["y"], single(agent["yaw"])],
                behavior=BEHAVIOR_NAMES[agent["behavior"]],
                desired_speed=agent["v"],
                radius=agent["radius"],
                goals=agent["goals"],
                goal_radius=agent["goal_radius"],
                group_id=agent["group"],
                cyclic=agent["cyclic"],
            )
            for agent in case["agents"]
        ],
        config=CrowdConfig(profile="hunavsim"),
        time_step=case["dt"],
    )
    states = services.agents.states
    rows = iter(case["states"])
    every = case["every"]
    points = case.get("closest_obs")
    for k, robot in enumerate(case["robot"]):
        if k == 0:
            continue
        states, status = services.compute_agents(
            states,
            [*robot, single(case["robot_radius"])],
            closest_obs=points and points[k // 20],
        )
        if k % every == 0:
            expected = np.array(next(rows))
            np.testing.assert_allclose(
                states[:, MOTION], expected[:, MOTION], rtol=0, atol=1e-9
            )
            np.testing.assert_allclose(
                states[:, 2], expected[:, YAW], rtol=0, atol=1e-8
            )
            np.testing.assert_array_equal(status, expected[:, 6])
    assert next(rows, None) is None


@pytest.mark.parametrize(
    "name", [name for name in TRACES if "group" in name or "obstacles" in name]
)
def test_another_order_changes_the_last_digits_of_who_does_not_react(name):
    case = json.loads(read_recorded(name))
    states, status, _, goals = free_run(case, reverse=True)
    recorded = np.array([s["agents"] for s in case["trace"]["steps"][1:]])
    np.testing.assert_allclose(
        states[..., MOTION], recorded[..., MOTION], rtol=0, atol=1e-12
    )
    np.testing.assert_array_equal(status, recorded[..., STATUS])
    np.testing.assert_array_equal(goals, recorded[..., GOAL])


def test_a_key_beside_the_profile_wins():
    config = CrowdConfig(profile="hunavsim", obstacle_range=3.0, model="orca")
    assert config.obstacle_range == 3.0
    assert type(config.model).__name__ == "OrcaModel"
    assert config.max_obstacles == 1
    assert not config.route_planning


@pytest.mark.parametrize("row", PROFILES["hunavsim"].crowd)
def test_every_row_of_the_profile_is_of_a_field_and_changes_it(row):
    profile, default = CrowdConfig(profile="hunavsim"), CrowdConfig()
    assert getattr(profile, row) != getattr(default, row)
    again = CrowdConfig(profile="hunavsim", **{row: getattr(default, row)})
    assert getattr(again, row) == getattr(default, row)


def test_the_profile_has_a_row_for_every_field():
    """Whoever adds a field says what HuNavSim does."""
    table = PROFILES["hunavsim"].crowd
    fields = {field.name for field in dc.fields(CrowdConfig)}
    # (Whether robots stop at people hangs on the robot, and nothing on how
    # many systems tick the trees. Random decisions are of no profile.)
    others = {"profile", "robots_stop", "separate_trees", "decisions"}
    assert fields - others == set(table)
    # (The error bound is one of the fast kernel. What the programs around
    # HuNavSim tell it, instead of what is so, is not of HuNavSim.)
    others = {"error_bound", "measured_velocities", "robot_obstacle_radius"}
    fields = {field.name for field in dc.fields(SocialForceModel)}
    assert fields - others == set(table["model"]) - {"type"}


TEXT = """
crowd: {profile: hunavsim, max_obstacles: 3}
humans:
- {pose: [0, 4, 0], goals: [[5, 4]], behavior: scared}
- {pose: [0, 2, 0], goals: [[5, 2]], cyclic: false}
"""


def test_a_scenario_with_the_profile_is_saved_and_read_again():
    scenario = LoadScenario(data=TEXT)
    text = SaveScenario(scenario)
    assert LoadScenario(data=text) == scenario
    # Only what differs from the profile is written.
    assert "max_obstacles: 3" in text
    assert "obstacle_range" not in text
    assert "cyclic: false" in text
    assert CheckScenario(scenario) == scenario


def test_the_profile_can_be_set_on_the_command_line():
    scenario = LoadScenario(
        filename="cafe", overrides=["crowd.profile=hunavsim"]
    )
    assert scenario.crowd == CrowdConfig(profile="hunavsim")


def test_goals_are_cyclic_with_the_profile_unless_they_are_said_not_to_be():
    human = HumanConfig(pose=[0, 0, 0], goals=[[1, 0], [2, 0]])
    reached = {}
    for name in PROFILES:
        diagram = MakeHumans(
            [human],
            config=CrowdConfig(profile=name),
            num_robots=0,
            separate_trees=False,
        )
        trees = diagram.GetSubsystemByName("behaviors")
        context = diagram.CreateDefaultContext()
        seen = set()
        for _ in range(100):
            context.SetDiscreteState(
                diagram.EvalUniquePeriodicDiscreteUpdate(context)
            )
            own = trees.GetMyContextFromRoot(context)
            seen.add(int(trees.GetMemory(own, 0)[0]))
        reached[name] = seen
    onward = {0, 1, 2}
    assert reached == {
        "default": onward,
        "hunav_drake_0.1": onward,
        "hunavsim": {0, 1},
    }


def test_one_cyclic_goal_freezes_a_person_at_full_speed():
    """As in the original: the goal is dropped, and is the next one."""
    human = HumanConfig(pose=[0, 0, 0], goals=[[2, 0]])
    diagram = MakeHumans(
        [human], config=CrowdConfig(profile="hunavsim"), num_robots=0
    )
    context = diagram.CreateDefaultContext()
    for _ in range(200):
        context.SetDiscreteState(
            diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
    x, *_, vx, _, _, _ = diagram.GetOutputPort("human_states").Eval(context)
    assert 1.5 < x < 1.6 + 0.06
    assert vx == pytest.approx(1.2, rel=2e-3)


def test_who_rests_looks_along_x():
    human = HumanConfig(pose=[0, 0, 2.0])
    for name, yaw in (("default", 2.0), ("hunavsim", 0.0)):
        diagram = MakeHumans(
            [human], config=CrowdConfig(profile=name), num_robots=0
        )
        context = diagram.CreateDefaultContext()
        context.SetDiscreteState(
            diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        assert diagram.GetOutputPort("human_states").Eval(context)[2] == yaw


def test_a_goal_within_a_long_step_is_dropped_by_the_step_too():
    """`lightsfm` drops a goal that a step ends in, without a stop."""
    human = HumanConfig(
        pose=[0, 0, 0],
        goals=[[3, 0], [9, 0]],
        goal_radius=0.4,
        desired_speed=2.0,
    )
    diagram = MakeHumans(
        [human],
        config=CrowdConfig(profile="hunavsim"),
        num_robots=0,
        time_step=0.5,
        separate_trees=False,
    )
    context = diagram.CreateDefaultContext()
    trees = diagram.GetSubsystemByName("behaviors")
    xs, goals = [], []
    for _ in range(6):
        context.SetDiscreteState(
            diagram.EvalUniquePeriodicDiscreteUpdate(context)
        )
        xs.append(diagram.GetOutputPort("human_states").Eval(context)[0])
        own = trees.GetMyContextFromRoot(context)
        goals.append(trees.GetMemory(own, 0)[0])
    # One meter a step: from 2 m to 3 m, and on.
    np.testing.assert_allclose(xs, [1, 2, 3, 4, 5, 6])
    assert goals == [0, 0, 0, 1, 1, 1]


def test_who_could_react_walks_with_a_step_of_six_decimals():
    people = [
        HumanConfig(pose=[0, 40 * i, 0], goals=[[99, 40 * i]], behavior=name)
        for i, name in enumerate(("regular", "surprised"))
    ]
    diagram = MakeHumans(
        people,
        config=CrowdConfig(profile="hunavsim"),
        num_robots=0,
        time_step=1 / 30,
    )
    context = diagram.CreateDefaultContext()
    context.SetDiscreteState(diagram.EvalUniquePeriodicDiscreteUpdate(context))
    rows = diagram.GetOutputPort("human_states").Eval(context).reshape(2, 7)
    # From rest, the speed after one step is the force times its length.
    ratio = rows[1, 3] / rows[0, 3]
    np.testing.assert_allclose(ratio, 0.033333 * 30, rtol=1e-12)


def test_behaviors_are_the_ones_of_the_profile():
    ours = {"type": "scared", "track": True}
    scenario = Scenario(
        humans=[HumanConfig(pose=[0, 0, 0], behavior=ours)],
        crowd=CrowdConfig(profile="hunavsim"),
    )
    with pytest.raises(ScenarioError, match=r"behavior\.track"):
        CheckScenario(scenario)
    # All others can be named, too; those that HuNavSim has not are ours.
    for name in BEHAVIORS:
        assert not list(CheckBehavior(name, profile="hunavsim"))
    for name, same in (("distracted", True), ("scared", False)):
        tree = LoadBehavior(name, profile="hunavsim")
        assert (tree is LoadBehavior(name)) == same


OWN_TREE = """
<root main_tree_to_execute="Stop">
  <BehaviorTree ID="Stop">
    <Fallback>
      <Sequence>
        <IsRobotVisible agent_id="{id}" distance="4.0"/>
        <SurprisedNav agent_id="{id}" time_step="{dt}"/>
      </Sequence>
      <RegularNav agent_id="{id}" time_step="{dt}"/>
    </Fallback>
  </BehaviorTree>
</root>
"""


def test_leaves_of_a_tree_of_ones_own_are_those_of_the_profile():
    """Who stops keeps the velocity that others see, in HuNavSim alone."""
    human = HumanConfig(pose=[0, 0, 0], goals=[[9, 0]], behavior=OWN_TREE)
    speeds = {}
    for name in PROFILES:
        diagram = MakeHumans([human], config=CrowdConfig(profile=name))
        context = diagram.CreateDefaultContext()
        diagram.GetInputPort("robot_states").FixValue(
            context, [6, 0, 0, 0, 0, 0, 0.3]
        )
        for _ in range(160):
            before = diagram.GetOutputPort("human_states").Eval(context).copy()
            context.SetDiscreteState(
                diagram.EvalUniquePeriodicDiscreteUpdate(context)
            )
        after = diagram.GetOutputPort("human_states").Eval(context)
        assert after[0] == before[0]
        speeds[name] = after[3]
    assert speeds["default"] == 0
    assert speeds["hunavsim"] > 1


def test_people_on_one_point_at_one_velocity_lose_their_social_forces():
    """As in HuNavSim, which takes zero for all that is not a number."""
    people = [HumanConfig(pose=[x, 0, 0]) for x in (0.0, 0.0, 0.5)]
    diagram = MakeHumans(
        people, config=CrowdConfig(profile="hunavsim"), num_robots=0
    )
    context = diagram.CreateDefaultContext()
    forces = diagram.GetOutputPort("forces").Eval(context).reshape(3, 8, 2)
    assert not forces[:2, 2].any()
    assert forces[2, 2].any()
    assert np.isfinite(forces).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["combined", "reaction_distracted"])
def test_a_trial_with_the_profile_repeats_and_resumes(name, tmp_path):
    scenario = LoadScenario(
        filename=name,
        overrides=["crowd.profile=hunavsim", "simulation.duration=8"],
    )
    diagram = MakeTrialDiagram(scenario)
    whole = RunTrial(scenario, diagram=diagram)
    assert whole.recording == RunTrial(scenario).recording
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(5.0)
    file = tmp_path / "half.npz"
    SaveContext(diagram, simulator.get_context(), file)
    simulator = MakeTrialSimulator(diagram, LoadContext(diagram, file))
    simulator.AdvanceTo(whole.end_time)
    rest = GetTrialResult(scenario, diagram, simulator.get_context())
    np.testing.assert_array_equal(rest.recording.humans, whole.recording.humans)


def test_epsilon_has_no_part_in_it():
    human = HumanConfig(
        pose=[0, 0, 0], forces=SocialForceParameters(epsilon=0.1)
    )
    scenario = Scenario(humans=[human], crowd=CrowdConfig(profile="hunavsim"))
    with pytest.raises(ScenarioError, match="epsilon: has no part"):
        CheckScenario(scenario)


def test_its_kernel_has_no_derivatives():
    crowd = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0])],
        config=CrowdConfig(profile="hunavsim"),
        num_robots=0,
    )
    with pytest.raises(ValueError, match="other than 'hunavsim'"):
        crowd.CalcJacobian(crowd.CreateDefaultContext())
