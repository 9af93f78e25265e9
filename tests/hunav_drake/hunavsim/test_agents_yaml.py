"""HuNavSim's own files."""

import dataclasses as dc

import numpy as np
import pytest
from scipy import stats

from hunav_drake import RunTrial
from hunav_drake.hunavsim.agents_yaml import BEHAVIOR_NAMES, ImportAgents
from hunav_drake.hunavsim.reactions import SETTINGS, reaction_ports
from hunav_drake.scenario import (
    DifferentialDriveConfig,
    LoadScenario,
    SaveScenario,
    ScenarioError,
)
from hunav_drake.systems.behavior import LoadBehavior
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people.profile import own_forces
from hunav_drake.systems.world.obstacles import inside
from tests.maps import write_map

AGENTS = """\
hunav_loader:
  ros__parameters:
    map: cafe
    publish_people: true
    agents:
      - ana
      - luis
    ana:
      id: 7
      skin: 2
      behavior: 1
      group_id: 3
      max_vel: 1.5
      radius: 0.4
      init_pose:
        x: 3
        y: -2.5
        z: 1.25
        h: 0.5
      goal_radius: 0.2
      cyclic_goals: true
      goals:
        - g1
        - g0
        - g1
      g0: {x: 5.0, y: 6.0, h: 1.25}
      g1: {x: 7.0, y: 8.0, h: 1.25}
    luis:
      behavior: 2
      init_pose: {x: 9, y: 9}
"""
METRICS = """\
hunav_evaluator_node:
  ros__parameters:
    frequency: 2.0
    metrics:
      path_length: true
      completed: false
      time_to_reach_goal: true
"""


@pytest.fixture
def write(tmp_path):
    def write(text, name="agents.yaml"):
        file = tmp_path / name
        file.write_text(text)
        return file

    return write


def faults(file, **kwargs):
    with pytest.raises(ScenarioError) as info:
        ImportAgents(file, **kwargs)
    return [
        f"{fault.line}: {fault.path}: {fault.message}"
        for fault in info.value.faults
    ]


def test_an_agent_becomes_a_person(write):
    ana, luis = ImportAgents(write(AGENTS)).humans
    assert ana.name == "ana"
    assert ana.id == 7
    assert ana.group_id == 3
    assert ana.behavior == "regular"
    assert ana.desired_speed == ana.speed_limit == 1.5
    assert ana.radius == 0.4
    assert ana.pose == (3.0, -2.5, 0.5)
    assert ana.goal_radius == 0.2
    assert ana.cyclic
    assert ana.goals == [(7.0, 8.0), (5.0, 6.0), (7.0, 8.0)]
    assert luis.behavior == "impassive"
    assert luis.pose == (9.0, 9.0, 0.0)
    assert luis.goals == []
    # What is missing is what HuNavSim takes for it.
    assert luis.cyclic
    assert luis.desired_speed == 1.0
    assert luis.radius == 0.35
    assert luis.goal_radius == 0.001


def test_what_is_not_carried_over_is_told_line_by_line(write):
    told = []
    text = METRICS + "    experiment_tag: night\n    result_file: a.txt\n"
    scenario = ImportAgents(
        write(AGENTS), metrics_filename=write(text, "m.yaml"), left_out=told
    )
    assert scenario.name == "agents_night"
    lines = [f"{it.line}: {it.path}: {it.message}" for it in told]
    for expected in (
        "3: map: there is no cafe.yaml beside",
        "4: publish_people: has no meaning",
        "10: ana.skin: the appearance of people depends",
        "18: ana.init_pose.z: people stand on the floor",
        "26: ana.g0.h: a goal is a point",
        "28: luis.max_vel: is missing; as in HuNavSim, 1.0",
        "28: luis.cyclic_goals: is missing; as in HuNavSim, true",
        "9: result_file: `hunav run",
    ):
        assert any(line.startswith(expected) for line in lines), expected


def test_the_profile_can_be_chosen(write):
    scenario = ImportAgents(write(AGENTS), profile="hunavsim")
    assert scenario.crowd == CrowdConfig(profile="hunavsim")
    assert LoadScenario(data=SaveScenario(scenario)).crowd == scenario.crowd


@pytest.mark.parametrize("frequency", [30, 7, 10, 60, 0.3])
def test_any_frequency_is_one_of_whole_steps(write, frequency):
    """Of the usual time step where it can be, else of a shorter one."""
    told = []
    scenario = ImportAgents(
        write(AGENTS),
        metrics_filename=write(
            METRICS.replace("2.0", str(frequency)), "m.yaml"
        ),
        left_out=told,
    )
    period, step = scenario.evaluator.period, scenario.simulation.time_step
    assert period == 1 / frequency
    assert 0.025 < step <= 0.05 or step == period
    assert any("number of steps" in it.message for it in told) == (step != 0.05)
    # It is a scenario that runs, with a sample for each period.
    short = dc.replace(
        scenario,
        robot=DifferentialDriveConfig(start=[-5, -5, 0], goal=[9, -5, 0]),
        simulation=dc.replace(scenario.simulation, duration=3 * period),
    )
    times = RunTrial(LoadScenario(data=SaveScenario(short))).recording.times
    np.testing.assert_allclose(times, np.arange(4) * period, atol=1e-9)


def test_the_map_beside_the_file_is_that_of_the_world(write, tmp_path):
    write_map(tmp_path, ["....", "###?", "#..#"], name="cafe")
    file = write(AGENTS)
    scenario = ImportAgents(file)
    assert scenario.world.map == str(tmp_path / "cafe.yaml")
    assert inside(scenario.world.obstacles(), [1.15, 2.15]).any()
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    other = write_map(tmp_path, ["#"], name="other")
    assert ImportAgents(file, map_filename=other).world.map == str(other)


def test_a_faulty_map_is_told(write, tmp_path):
    write_map(tmp_path, ["#"], name="cafe", image="none.pgm")
    with pytest.raises(ScenarioError, match=r"3: map: .*none\.pgm: No such"):
        ImportAgents(write(AGENTS))


def test_the_rest_is_as_by_default(write):
    scenario = ImportAgents(write(AGENTS))
    assert scenario.robot == DifferentialDriveConfig()
    assert scenario.world.walls == []


def test_it_loads_wherever_a_scenario_is_expected(write):
    file = write(AGENTS)
    scenario = LoadScenario(filename=file, overrides=["humans[1].radius=0.2"])
    assert [human.name for human in scenario.humans] == ["ana", "luis"]
    assert [human.id for human in scenario.humans] == [7, 1]
    assert scenario.humans[1].radius == 0.2
    assert LoadScenario(data=SaveScenario(scenario)) == scenario


def test_the_original_agents(reference):
    file = reference / "hunav/agents.yaml"
    scenario = ImportAgents(file)
    assert [(human.name, human.behavior) for human in scenario.humans] == [
        ("agent1", "scared"),
        ("agent2", "threatening"),
        ("agent7", "curious"),
        ("agent4", "impassive"),
        ("agent5", "curious"),
    ]
    assert [human.id for human in scenario.humans] == [1, 2, 3, 4, 5]
    assert scenario.humans[3].goals[1] == (1.838239, -3.501402)


def test_the_original_metrics(reference):
    folder = reference / "hunav"
    evaluator = ImportAgents(
        folder / "agents.yaml", metrics_filename=folder / "metrics.yaml"
    ).evaluator
    assert evaluator.period == 1.0
    assert len(evaluator.metrics) == 28
    assert evaluator.metrics[0] == "time_to_reach_goal"
    assert evaluator.metrics[-1] == "obstacle_force_on_agents"


def test_only_chosen_metrics_are_taken(write):
    evaluator = ImportAgents(
        write(AGENTS), metrics_filename=write(METRICS, "m.yaml")
    ).evaluator
    assert evaluator.period == 0.5
    assert evaluator.metrics == ["path_length", "time_to_reach_goal"]


def test_frequency_zero_means_every_step(write):
    text = METRICS.replace("2.0", "0.0")
    evaluator = ImportAgents(
        write(AGENTS), metrics_filename=write(text, "m.yaml")
    ).evaluator
    assert evaluator.period == 0.05


def test_a_behavior_that_is_not_available_is_told_when_it_is_loaded(
    write, monkeypatch
):
    import hunav_drake.systems.behavior as behavior

    monkeypatch.setattr(behavior, "BEHAVIORS", {"regular": None})
    monkeypatch.setattr(behavior, "ACTIVITIES", {})
    file = write(AGENTS)
    assert ImportAgents(file).humans[1].behavior == "impassive"
    with pytest.raises(ScenarioError) as info:
        LoadScenario(filename=file)
    assert str(info.value) == (
        f"{file}: 1 fault\n{file}:29: luis.behavior: there is no behavior"
        " 'impassive'; valid: regular"
    )


def test_custom_forces_of_a_behavior(write):
    custom = (
        "behavior:\n        type: 2\n        configuration: 1\n"
        "        social_force_factor: 4.0\n        goal_force_factor: 3.0\n"
        "        obstacle_force_factor: 9.0\n        duration: 40.0\n"
    )
    human = ImportAgents(write(AGENTS.replace("behavior: 1\n", custom))).humans[
        0
    ]
    assert human.behavior == "impassive"
    assert human.forces.social_factor == 4.0
    assert human.forces.goal_factor == 3.0
    assert human.forces.obstacle_factor == 9.0
    default = custom.replace("configuration: 1", "configuration: 0")
    human = ImportAgents(
        write(AGENTS.replace("behavior: 1\n", default))
    ).humans[0]
    assert own_forces(human, "default").social_factor == 5.0


def import_behavior(write, settings, told=None):
    """The first person of the file, with settings of HuNavSim 2.0."""
    block = f"behavior: {settings}\n"
    file = write(AGENTS.replace("behavior: 1\n", block))
    return ImportAgents(file, left_out=told).humans[0]


def test_custom_factors_are_kept_and_unusual_ones_told(write):
    """HuNavSim limits those that are not custom: to what, is said."""
    told = []
    human = import_behavior(
        write,
        "{type: 1, configuration: 1, goal_force_factor: 1.0,"
        " obstacle_force_factor: 80.0, social_force_factor: 20.0}",
        told,
    )
    forces = human.forces
    factors = forces.goal_factor, forces.obstacle_factor, forces.social_factor
    assert factors == (1.0, 80.0, 20.0)
    lines = [f"{it.line}: {it.path}: {it.message}" for it in told]
    lines = [line for line in lines if "factor" in line]
    assert len(lines) == 2
    rule = "is kept, but beyond"
    start = "11: ana.behavior"
    assert lines[0].startswith(f"{start}.goal_force_factor: {rule} [2, 5]")
    assert lines[1].startswith(f"{start}.obstacle_force_factor: {rule} [2, 50]")


def test_custom_settings_of_a_reaction_are_ports(write):
    told = []
    human = import_behavior(
        write,
        "{type: 4, configuration: 1, duration: 12.0, once: false, vel: 2.5,"
        " dist: 5.0}",
        told,
    )
    assert human.behavior.tree == "scared"
    assert human.behavior.ports == {
        "duration": 12.0,
        "only_once": False,
        "speed": 1.8,
        "distance": 5.0,
        "push": 20.0,
    }
    told = [f"{it.path}: {it.message}" for it in told]
    assert "ana.behavior.vel: is limited to 1.8 m/s, as in HuNavSim" in told
    assert (
        "ana.behavior.other_force_factor: is missing; as in HuNavSim, 20.0"
        in told
    )
    with pytest.raises(ScenarioError, match=r":11: ana\.behavior\.dist: "):
        LoadScenario(
            filename=write(
                AGENTS.replace(
                    "behavior: 1\n",
                    "behavior: {type: 4, configuration: 1, dist: -1.0}\n",
                )
            )
        )


@pytest.mark.parametrize(
    ("number", "ports"),
    [
        (3, {"duration": 30.0, "distance": 4.0}),
        (4, {"duration": 40, "distance": 3.0, "speed": 0.6, "push": 20.0}),
        (5, {"duration": 40.0, "speed": 1.5, "stop_distance": 1.5}),
        (6, {"duration": 40.0, "goal_distance": 1.4}),
    ],
)
def test_the_default_configuration_has_the_usual_reaction(write, number, ports):
    human = import_behavior(write, f"{{type: {number}, configuration: 0}}")
    assert human.behavior.ports == {"only_once": True, **ports}


@pytest.mark.parametrize("number", [3, 4, 5, 6])
@pytest.mark.parametrize("mode", ["random_normal", "random_uniform"])
def test_reactions_are_drawn_as_in_hunavsim(number, mode):
    """The distributions, and that a draw belongs to a person's number."""
    behavior = BEHAVIOR_NAMES[number]

    def draw(number):
        human = {"forces_mode": mode, "behavior": behavior, "id": number}
        ports = reaction_ports(human, {}, 1, lambda *_: None)
        return [ports[it.port][1] for it in SETTINGS[behavior].values()]

    assert draw(5) == draw(5)
    drawn = np.array([draw(number) for number in range(1000)])
    for values, it in zip(drawn.T, SETTINGS[behavior].values(), strict=True):
        if mode == "random_uniform":
            expected = stats.uniform(it.low, it.high - it.low)
        else:
            expected = stats.norm(it.mean, it.deviation)
            assert values.min() >= it.least
            values = values[values > it.least]
            expected = stats.truncnorm(
                *((it.least - it.mean) / it.deviation, np.inf),
                *(it.mean, it.deviation),
            )
        assert stats.kstest(values, expected.cdf).pvalue > 1e-3
    correlation = np.corrcoef(drawn.T) - np.eye(len(drawn.T))
    assert abs(correlation).max() < 0.12


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("behavior: 1", "behavior: 7", "11: ana.behavior: must be one of 1 re"),
        ("behavior: 1", "behavior: scared", "11: ana.behavior: must be one of"),
        ("behavior: 1", "behavior: true", "11: ana.behavior: must be one of"),
        ("behavior: 1", "behavior: {type: 9}", "11: ana.behavior.type: must"),
        ("id: 7", "id: -7", "9: ana.id: must be at least 0, got -7"),
        (
            "radius: 0.4",
            "radius: 40",
            "14: ana.radius: must be in [0.001, 5] m",
        ),
        ("max_vel: 1.5", "max_vel: fast", "13: ana.max_vel: must be a number"),
        (
            "max_vel: 1.5",
            "max_vell: 1.5",
            "13: ana.max_vell: unknown key; did you mean 'max_vel'?",
        ),
        ("x: 3", "x: .nan", "16: ana.init_pose.x: must be a finite number"),
        ("        x: 3\n", "", "15: ana.init_pose.x: is missing"),
        ("init_pose: {x: 9, y: 9}", "skin: 1", "28: luis.init_pose: must be a"),
        ("g0: {x: 5.0, y", "g0: {x: 5.0, yy", "26: ana.g0.y: is missing"),
        ("g0: {x: 5.0", "g0: {x: 1e7", "26: ana.g0.x: must be in"),
        ("- g0", "- g5", "24: ana.goals[1]: there is no goal 'g5'"),
        ("- g0", "- 5", "24: ana.goals[1]: there is no goal 5"),
        ("- luis", "- luís", "7: agents[1]: 'luís' is not described; did you"),
        ("- luis", "- ana", "7: agents[1]: 'ana' is listed twice"),
        ("- luis", "- 5", "7: agents[1]: must be a name, got 5"),
        ("{x: 9, y: 9}", "{x: 3, y: -2.5}", "30: luis.init_pose: starts on"),
        ("radius: 0.4", "radius: !x 1", "radius: unknown tag '!x'"),
        ("hunav_loader", "loader", "hunav_loader.ros__parameters: is missing"),
        ("skin: 2", "id: 2", "id: is given twice, first in line 9"),
    ],
    ids=lambda text: text[:20],
)
def test_faults_have_their_lines_and_the_names_of_the_file(
    write, old, new, fault
):
    assert old in AGENTS
    found = faults(write(AGENTS.replace(old, new, 1)))
    assert len(found) == 1
    assert fault in found[0]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("2.0", "fast", "3: frequency: must be a number of Hz"),
        ("2.0", "-1", "3: frequency: must be a number of Hz"),
        ("2.0", "1" + 400 * "0", "3: frequency: must be a number of Hz"),
        ("2.0", ".nan", "3: frequency: must be a number of Hz"),
        ("2.0", "true", "3: frequency: must be a number of Hz"),
        ("2.0", "0.001", "3: frequency: must be in (0, 60] s, got 1000"),
        ("false", "5", "6: metrics.completed: must be true or false, got 5"),
        ("metrics:", "metrics: 5\n    x:", "4: metrics: must be a mapping"),
        ("hunav_evaluator", "evaluator", "ros__parameters: is missing"),
        ("2.0", "[", "is not YAML"),
    ],
    ids=lambda text: text[:20],
)
def test_faults_of_the_metrics(write, old, new, fault):
    metrics = write(METRICS.replace(old, new, 1), "m.yaml")
    agents = write(AGENTS)
    with pytest.raises(ScenarioError) as info:
        ImportAgents(agents, metrics_filename=metrics)
    (found,) = info.value.faults
    assert found.source == str(metrics)
    assert fault in f"{found.line}: {found.path}: {found.message}"


def test_a_missing_file_is_a_scenario_error(tmp_path):
    assert "No such file" in faults(tmp_path / "none.yaml")[0]


def test_a_file_of_faults_is_not_looked_through_to_its_end(write):
    names = ", ".join(f"agent{i}" for i in range(20_000))
    found = faults(
        write(f"hunav_loader: {{ros__parameters: {{agents: [{names}]}}}}")
    )
    assert 100 <= len(found) <= 110


# As HuNavSim 2 writes them: numbered goals that agents share, and trees.
SECOND = """\
hunav_loader:
  ros__parameters:
    yaml_base_name: hall_agents
    map: hall
    global_goals:
      1: {x: 2.0, y: 0.0}
      2: {x: 8.0, y: 0.5, h: 1.5}
    agents: [ana, luis]
    ana:
      id: 1
      init_pose: {x: 0.0, y: 0.0, z: 1.25, h: 0.0}
      behavior: {type: Regular, configuration: 0}
      goals: [2, 1]
    luis:
      id: 2
      init_pose: {x: 0.0, y: 3.0, h: 0.0}
      behavior: {type: Regular, configuration: 0}
      goals: [1]
"""
TREE = """\
<root BTCPP_format="4"><BehaviorTree ID="DefaultTree"><Fallback>
  <Inverter><RunOnce><SetGoal agent_id="{id}" goal_id="2"/></RunOnce></Inverter>
  <Sequence><Inverter><IsGoalReached agent_id="{id}"/></Inverter>
    <RegularNav agent_id="{id}" time_step="{dt}"/></Sequence>
  <UpdateGoal agent_id="{id}"/>
</Fallback></BehaviorTree></root>
"""


@pytest.mark.parametrize("place", [".", "behavior_trees", "../behavior_trees"])
def test_the_files_of_hunavsim_2_have_numbered_goals_and_trees(place, tmp_path):
    folder = tmp_path / "scenarios"
    (folder / place).mkdir(parents=True)
    file = folder / "people.yaml"
    file.write_text(SECOND)
    tree = (folder / place / "hall_agents__agent_2_bt.xml").resolve()
    tree.write_text(TREE)
    told = []
    scenario = ImportAgents(file, left_out=told)
    ana, luis = scenario.humans
    assert [(it.name, it.id, it.pose) for it in scenario.places] == [
        ("goal_1", 1, (2.0, 0.0, 0.0)),
        ("goal_2", 2, (8.0, 0.5, 1.5)),
    ]
    assert ana.behavior == "regular"
    assert ana.goals == [(8.0, 0.5), (2.0, 0.0)]
    # It sets its goals itself.
    assert luis.behavior == str(tree)
    assert luis.goals == []
    assert any(it.path == "luis.behavior" for it in told)
    run = RunTrial(
        dc.replace(
            scenario,
            robot=dc.replace(scenario.robot, start=(0.0, -9.0, 0.0)),
            simulation=dc.replace(scenario.simulation, duration=4.0),
        )
    ).recording
    # Both walk to the second place.
    for i, person in enumerate((ana, luis)):
        way = run.humans[-1, i, :2] - np.array(person.pose[:2])
        ahead = np.array([8.0, 0.5]) - np.array(person.pose[:2])
        assert way @ ahead / np.hypot(*ahead) > 2.0


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("goals: [1]", "goals: [3]", 18, "there is no goal 3"),
        ("1: {x: 2.0, y: 0.0}", "one: {x: 2.0, y: 0.0}", 6, "whole number"),
        ("1: {x: 2.0, y: 0.0}", "1: {x: 2.0}", 6, "is missing"),
        ("type: Regular", "type: Regulr", 12, "must be one of"),
    ],
)
def test_faults_of_the_files_of_hunavsim_2(old, new, line, words, tmp_path):
    file = tmp_path / "people.yaml"
    file.write_text(SECOND.replace(old, new))
    with pytest.raises(ScenarioError, match=words) as caught:
        ImportAgents(file)
    assert line in [it.line for it in caught.value.faults]


@pytest.mark.parametrize(
    ("node", "sets"),
    [
        ('<SetGoal agent_id="{id}" goal_id="2"/>', True),
        ('<Action ID="SetGoal" agent_id="{id}" goal_id="2"/>', True),
        ('<AlwaysSuccess/><!-- <SetGoal goal_id="2"/> -->', False),
        ('<SubTree ID="SetGoal"/>', False),
    ],
)
def test_listed_goals_are_left_out_if_the_tree_sets_goals(node, sets, tmp_path):
    file = tmp_path / "people.yaml"
    file.write_text(SECOND)
    xml = TREE.replace('<SetGoal agent_id="{id}" goal_id="2"/>', node)
    (tmp_path / "hall_agents__agent_2_bt.xml").write_text(xml)
    told = []
    luis = ImportAgents(file, left_out=told).humans[1]
    assert luis.goals == ([] if sets else [(2.0, 0.0)])
    assert ("luis.goals" in [it.path for it in told]) == sets


@pytest.mark.parametrize("key", ["yaml_base_name: hall_agents", "map: hall"])
def test_names_that_are_too_long_for_files_are_of_none(key, tmp_path):
    file = tmp_path / "people.yaml"
    file.write_text(SECOND.replace(key, key + 300 * "l"))
    assert len(ImportAgents(file).humans) == 2


@pytest.mark.parametrize("encoding", ["none", "utf-32"])
def test_a_tree_in_an_unknown_encoding_is_told_of_later(encoding, tmp_path):
    file = tmp_path / "people.yaml"
    file.write_text(SECOND)
    xml = f'<?xml version="1.0" encoding="{encoding}"?>{TREE}'
    (tmp_path / "hall_agents__agent_2_bt.xml").write_text(xml)
    luis = ImportAgents(file).humans[1]
    assert luis.goals == [(2.0, 0.0)]
    with pytest.raises(ValueError, match="this cannot be read as XML"):
        LoadBehavior(luis.behavior)
