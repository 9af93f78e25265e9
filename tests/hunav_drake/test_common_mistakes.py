"""What a newcomer gets wrong is told in one line, with what to do.

Each line has the place, the rule, what was found, and a remedy, and there is
no traceback, but with `--debug`.
"""

import re

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import (
    AddBodyState,
    AddHumans,
    CheckScenario,
    HumanConfig,
    LoadResults,
    LoadScenario,
    LoadSuite,
    MakeTrialDiagram,
    PlannerError,
    ReadRecording,
    RunTrial,
    SaveScenario,
    WriteReport,
)
from hunav_drake.scenario import Scenario, ScenarioError, SimulationConfig
from hunav_drake.systems.crowd.motion_model import (
    MotionModel,
    register_motion_model,
)
from hunav_drake.systems.evaluation import register_metric
from hunav_drake.systems.planning import (
    PLANNERS,
    Plan,
    Planner,
    register_planner,
)
from tests.agents import AGENTS

# A room of 10 m x 10 m with a wall in it, a robot and a person.
ROOM = """
name: room
world:
  walls:
    - {type: box, name: south, center: [5, -0.1], size: [10.4, 0.2]}
    - {type: box, name: north, center: [5, 10.1], size: [10.4, 0.2]}
    - {type: box, name: west, center: [-0.1, 5], size: [0.2, 10.4]}
    - {type: box, name: east, center: [10.1, 5], size: [0.2, 10.4]}
    - {type: box, name: shelf, center: [5, 4.8], size: [0.5, 9.6]}
humans:
  - {name: ana, pose: [2, 7, 0], goals: [[8, 8]], radius: 0.14}
robot: {radius: 0.15, start: [2, 2, 0], goal: [8, 2, 0]}
"""

# In the room: what is written instead of what, and what is said about it.
YAML = {
    "misspelt key": (
        "name: ana, pose",
        "name: ana, radios: 0.3, pose",
        r"11: humans\[0\] \('ana'\).radios: unknown key; did you mean 'radius'",
    ),
    "misspelt section": (
        "humans:",
        "humen:",
        r"10: humen: unknown key; did you mean 'humans'",
    ),
    "a text for a number": (
        "radius: 0.15",
        "radius: small",
        r"12: robot.radius: must be a number, got 'small'",
    ),
    "a negative radius": (
        "radius: 0.15",
        "radius: -0.15",
        r"12: robot.radius: must be in \[0.001, \d+\] m, got -0.15",
    ),
    "a pose of two numbers": (
        "pose: [2, 7, 0]",
        "pose: [2, 7]",
        r"11: humans\[0\] \('ana'\).pose: must be 3 numbers, got 2",
    ),
    "a goal that is no list of places": (
        "goals: [[8, 8]]",
        "goals: [8, 8]",
        r"11: .*goals\[0\]: must be a list of numbers, got 8",
    ),
    "a missing pose": (
        "pose: [2, 7, 0], ",
        "",
        r"11: humans\[0\] \('ana'\).pose: is missing",
    ),
    "a least speed above the largest": (
        "humans:",
        "planner: {type: dwb, min_vel_x: 0.5, max_vel_x: 0.3}\nhumans:",
        r"10: planner: max_vel_x must be at least min_vel_x \(0.5\), got 0.3",
    ),
    "a least turn rate above the largest": (
        "humans:",
        "planner: {type: dwb, recoveries: {max_spin: 0.3}}\nhumans:",
        r"10: planner.recoveries: max_spin must be at least min_spin \(0.4\)",
    ),
    "a goal in a wall": (
        "goal: [8, 2, 0]",
        "goal: [10.1, 2, 0]",
        r"12: robot.goal: is inside .*'east'.*; move it 0.25 m along \(-1.00",
    ),
    "a start in a shelf": (
        "start: [2, 2, 0]",
        "start: [4.8, 2, 0]",
        r"12: robot.start: is inside .*'shelf'.*; move it 0\.\d+ m along",
    ),
    "a goal outside of the building": (
        "goal: [8, 2, 0]",
        "goal: [14, 2, 0]",
        r"12: robot.goal: .*outside of the building; the nearest place inside",
    ),
    "a door that is too narrow": (
        "radius: 0.15",
        "radius: 0.45",
        r"12: robot.goal: .*a door of 0.40 m between .*'north'.*'shelf'.*widen",
    ),
    "a wall across the way": (
        "size: [0.5, 9.6]",
        "size: [0.5, 10.6]",
        r"12: robot.goal: .*'shelf'\) stands between, .*; leave a gap of more",
    ),
    "a person who cannot arrive": (
        "size: [0.5, 9.6]",
        "size: [0.5, 10.6]",
        r"11: humans\[0\] \('ana'\).goals\[0\]: cannot be reached",
    ),
    "two people on one place": (
        "humans:",
        "humans:\n  - {name: luis, pose: [2, 7, 0]}",
        r"starts on the same point as .*; move it by",
    ),
    "two people of one name": (
        "humans:",
        "humans:\n  - {name: ana, pose: [2, 4, 0]}",
        r"name: must be unique, but 'ana' is already the name of humans\[0\]",
    ),
    "a person in the robot": (
        "pose: [2, 7, 0]",
        "pose: [2.1, 2, 0]",
        r"12: robot.start: overlaps humans\[0\] \('ana'\) by .*; move one",
    ),
    "an unknown shape of wall": (
        "type: box, name: shelf",
        "type: bocks, name: shelf",
        r"9: .*walls\[4\].*type: there is no .*'bocks'; valid: box",
    ),
    "a wall without its size": (
        "center: [5, 4.8], size: [0.5, 9.6]",
        "center: [5, 4.8]",
        r"9: .*walls\[4\] \('shelf'\).size: is missing",
    ),
    "an unknown behavior": (
        "name: ana, pose",
        "name: ana, behavior: regulr, pose",
        r"behavior: there is no behavior 'regulr'; did you mean 'regular'",
    ),
    "an unknown planner": (
        "name: room",
        "planner: {type: dwbb}",
        r"planner.type: there is no planner 'dwbb'; did you mean 'dwb'",
    ),
    "a parameter of another planner": (
        "name: room",
        "planner: {type: pursuit, crus_speed: 1}",
        r"planner.crus_speed: unknown key; did you mean 'cruise_speed'",
    ),
    "an unknown motion model": (
        "name: room",
        "crowd: {model: {type: orcha}}",
        r"model.type: there is no motion model 'orcha'; did you mean 'orca'",
    ),
    "an unknown metric": (
        "name: room",
        "evaluator: {metrics: [path_lenght]}",
        r"there is no metric .*'path_lenght'; did you mean 'path_length'",
    ),
    "a negative duration": (
        "name: room",
        "simulation: {duration: -5}",
        r"2: simulation.duration: must be in \(0, 86400\] s, got -5",
    ),
    "a period that is no whole number of steps": (
        "name: room",
        "planner: {type: pursuit, period: 0.07}",
        r"period: must be a multiple of .*0.05 s.*got 0.07; nearest: 0.05 or",
    ),
    "a seed that is no number": (
        "name: room",
        "simulation: {seed: first}",
        r"2: simulation.seed: must be a whole number, got 'first'",
    ),
    "a map that is not there": (
        "world:",
        "world:\n  map: nowhere.yaml",
        r"4: world.map: .*nowhere.yaml.*(No such file|there is no)",
    ),
    "a planner without its lidar": (
        "name: room",
        "sensors: [{type: lidr}]",
        r"2: sensors\[0\].type: there is no sensor 'lidr'; did you mean 'lidar",
    ),
    "a key twice": (
        "name: room",
        "name: room\nname: hall",
        r"3: name: .*(twice|already|line 2)",
    ),
    "a tab": ("humans:", "\thumans:", r"10: .*(tab|\\t)"),
    "a bracket that stays open": (
        "goals: [[8, 8]]",
        "goals: [[8, 8]",
        r"1[12]: ",
    ),
    "a tree that is not there": (
        "name: ana, pose",
        "name: ana, behavior: ./no.xml, pose",
        r"behavior: .*no.xml.*(No such file|there is no)",
    ),
}


@pytest.mark.parametrize("mistake", YAML)
def test_a_mistake_in_a_file(mistake, hunav, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    old, new, words = YAML[mistake]
    assert ROOM.count(old) == 1
    (tmp_path / "room.yaml").write_text(ROOM.replace(old, new))
    code, out, err = hunav("check", "room.yaml")
    assert code == 2
    assert "Traceback" not in out + err
    lines = [line for line in err.splitlines() if re.search(words, line)]
    assert len(lines) == 1, err
    assert lines[0].startswith("room.yaml:")


def test_the_room_itself_is_sound(hunav, tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    assert hunav("check", tmp_path / "room.yaml")[0] == 0


def test_degrees_are_a_warning(hunav, tmp_path):
    text = ROOM.replace("pose: [2, 7, 0]", "pose: [2, 7, 90]")
    (tmp_path / "room.yaml").write_text(text)
    code, _, err = hunav("check", tmp_path / "room.yaml")
    assert code == 0
    line, *notes = err.splitlines()
    assert all(it.startswith("hunav: note: ") for it in notes)
    assert "room.yaml:11: humans[0] ('ana').pose[2]: is 90 rad" in line
    assert "if it is in degrees, write 1.5708" in line


COMMANDS = {
    "unknown command": ("rum passing", r"no command 'rum'; did you mean 'run'"),
    "no scenario": ("run", r"hunav run: .*required: scenario; see `hunav run"),
    "unknown option": ("run passing --sed 1", r"unrecognized .*--sed"),
    "unknown scenario": ("run pasing", r"pasing: .*did you mean passing"),
    "a seed below 0": ("run passing --seed=-1", r"--seed: .*\[0, 2\^63\), got"),
    "unknown planner": (
        "run passing --planner persuit",
        r"planner.type: there is no planner 'persuit'; did you mean 'pursuit'",
    ),
    "a planner's module that is not there": (
        "run passing --planner nowhere:Mine",
        r"planner.type: cannot get 'nowhere:Mine'.*No module named 'nowhere'",
    ),
    "a setting without a value": (
        "run passing --set robot.radius",
        r"--set robot.radius: must be a path and a value, as in robot.radius=",
    ),
    "a setting of nobody": (
        "run passing --set humans[9].radius=0.3",
        r"--set humans\[9\].radius=0.3: humans has 2 members, counted from 0",
    ),
    "a setting out of range": (
        "run passing --set robot.radius=-1",
        r"--set robot.radius=-1: robot.radius: must be in .* got -1",
    ),
    "a folder that cannot be written": (
        "run passing --out /proc/here",
        r"--out /proc/here: cannot write there: .*\. Name a folder",
    ),
    "code of one's own that is not there": (
        "run passing --import nowhere.py",
        r"--import nowhere.py: No such file",
    ),
    "an overlay that is none": (
        "run passing --overlays halo",
        r"--overlays: there is no overlay 'halo'; valid: goals",
    ),
    "a recording that is not there": (
        "evaluate nowhere.npz",
        r"nowhere.npz: No such file",
    ),
    "a file that is no recording": (
        "evaluate /dev/null",
        r"/dev/null: is not a recording: its name must end in .npz",
    ),
    "a report of nothing": (
        "report .",
        r"No results .*`hunav run SCENARIO --o",
    ),
    "an unknown metric": (
        "metrics show path_lenght",
        r"'path_lenght'; did you mean 'path_length'",
    ),
    "an unknown tree": (
        "tree show shy",
        r"no behavior or file 'shy'; there is",
    ),
    "a film of nothing": (
        "render nowhere -o a.mp4",
        r"nowhere: there is no such file or folder; `hunav run",
    ),
    "an unknown suite": ("bench papr", r"papr: .*did you mean 'paper'"),
    "agents that are not there": (
        "import agents.yaml",
        r"agents.yaml: cannot be read: No such file",
    ),
    "an unknown case": ("validate --case coridor", r"there is no case 'corid"),
}


@pytest.mark.parametrize("mistake", COMMANDS)
def test_a_mistake_in_a_command(mistake, hunav, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    line, words = COMMANDS[mistake]
    try:
        code, out, err = hunav(*line.split())
    except SystemExit as error:
        code = error.code
        out, err = capsys.readouterr()
    assert code == 2
    assert "Traceback" not in out + err
    assert sum(bool(re.search(words, it)) for it in err.splitlines()) == 1, err
    # The heading of a list of faults, and a hint, may stand beside it.
    assert len(err.splitlines()) <= 3


TREES = {
    "an unknown leaf": ("<GoHome/>", r"1: .*GoHome.*"),
    "a missing port": ("<Wait/>", r"1: .*(Wait|node)"),
    "a tag that stays open": ("<Sequence>", r"1: .*"),
}


@pytest.mark.parametrize("mistake", TREES)
def test_a_mistake_in_a_tree(mistake, hunav, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body, words = TREES[mistake]
    (tmp_path / "my.xml").write_text(
        '<root BTCPP_format="4" main_tree_to_execute="T">'
        f'<BehaviorTree ID="T">{body}</BehaviorTree></root>'
    )
    code, out, err = hunav("tree", "check", "my.xml")
    assert code == 2
    assert re.search(f"my.xml:{words}", err.splitlines()[0]), err
    assert "Traceback" not in out + err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("goals: [g0, g1]", "goals: [g7]", "g7"),
        ("type: 1", "type: 99", "99"),
        ("radius: 0.4", "radius: big", "big"),
    ],
)
def test_a_mistake_in_agents_yaml(hunav, tmp_path, old, new, words):
    good = tmp_path / "good.yaml"
    good.write_text(AGENTS)
    assert hunav("import", good)[0] == 0
    bad = tmp_path / "agents.yaml"
    bad.write_text(AGENTS.replace(old, new))
    code, out, err = hunav("import", bad)
    assert code == 2
    # (The name of the folder may have the words, too.)
    lines = re.findall(r"agents\.yaml:\d+: (agent1.*)", err)
    assert any(words in line for line in lines)
    assert "Traceback" not in out + err


def _forget_the_robot():
    builder = DiagramBuilder()
    AddHumans(builder, [HumanConfig(pose=(0, 0, 0), goals=[(5, 0)])])
    # (Without a name, it would be gone before the exception: then pydrake may
    # end the process.)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.2)


def _unreachable():
    text = ROOM.replace("size: [0.5, 9.6]", "size: [0.5, 10.6]")
    CheckScenario(LoadScenario(data=text))


@dataclass
class _Tuple(Planner):
    def plan(self, task, view, memory):
        return 0.1, 0.0


@dataclass
class _Nan(Planner):
    def plan(self, task, view, memory):
        return Plan(float("nan"), 0.0, 1)


def _run_with(planner):
    choices = {"a_tuple_for_a_plan": _Tuple, "nan_for_a_speed": _Nan}
    register_planner(planner)(choices[planner])
    scenario = LoadScenario("passing", overrides=[f"planner={planner}"])
    RunTrial(scenario, on_planner_error="raise")


@pytest.fixture(autouse=True)
def _choices_as_before(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


def _planner_of_wrong_arity():
    @register_planner("too_few_parameters")
    @dataclass
    class Few(Planner):
        def plan(self, task, view):
            return Plan(0.0, 0.0, 1)


def _model_of_wrong_arity():
    @register_motion_model("too_few_for_a_model")
    @dataclass
    class Few(MotionModel):
        def forces(self, snapshot):
            return np.zeros((1, 16))

        def advance(self, snapshot):
            return snapshot.states


def _metric_of_wrong_arity():
    @register_metric(unit="m", family="mine", source="me")
    def two_recordings(first, second):
        """Of two."""
        return 0.0


PYTHON = {
    "a goal, not goals": (
        lambda: HumanConfig(pose=(0, 0, 0), goal=(1, 2)),
        r"HumanConfig\(\): goal: unknown argument; did you mean 'goals'\?",
    ),
    "no pose": (
        lambda: HumanConfig(),
        r"HumanConfig\(\): pose: is missing; give pose=",
    ),
    "a pose of two numbers": (
        lambda: HumanConfig(pose=(1, 2)),
        r"pose: must be 3 numbers",
    ),
    "a text for a speed": (
        lambda: HumanConfig(pose=(0, 0, 0), desired_speed="fast"),
        r"desired_speed: must be a number, got 'fast'",
    ),
    "a speed out of range": (
        lambda: HumanConfig(pose=(0, 0, 0), desired_speed=-1),
        r"desired_speed: must be in \[0, 10\] m/s, got -1",
    ),
    "a misspelt part of a scenario": (
        lambda: Scenario(human=[]),
        r"Scenario\(\): human: unknown argument; did you mean 'humans'\?",
    ),
    "a duration of nothing": (
        lambda: SimulationConfig(duration=0),
        r"SimulationConfig\(\): duration: must be in \(0, 86400\] s, got 0",
    ),
    "a mapping for a file": (
        lambda: LoadScenario({"robot": {}}),
        r"LoadScenario\(\) takes the name of a file.*got a mapping",
    ),
    "a misspelt scenario": (
        lambda: LoadScenario("pasing"),
        r"did you mean passing",
    ),
    "a name for a scenario": (
        lambda: RunTrial("passing"),
        r"a Scenario is needed, got str; LoadScenario\(",
    ),
    "a name for a scenario of a diagram": (
        lambda: MakeTrialDiagram("passing"),
        r"a Scenario is needed, got str; LoadScenario\(",
    ),
    "a seed that is a text": (
        lambda: RunTrial(LoadScenario("passing"), "one"),
        r"RunTrial: seed: must be a whole number in .* got 'one'",
    ),
    "a mapping for a person": (
        lambda: AddHumans(DiagramBuilder(), [{"pose": (0, 0, 0)}]),
        r"humans\[0\] must be a HumanConfig, got dict",
    ),
    "a forgotten robot": (
        _forget_the_robot,
        r"nothing is connected to its port robot_states; connect the state",
    ),
    "a way that is blocked": (
        _unreachable,
        r"robot.goal: cannot be reached from robot.start: .* leave a gap",
    ),
    "a recording that is not there": (
        lambda: ReadRecording("nowhere.npz"),
        r"No such file or directory: 'nowhere.npz'",
    ),
    "results that are not there": (
        lambda: LoadResults("nowhere"),
        r"No results are there. `hunav run SCENARIO --out nowhere` writes some",
    ),
    "a report on nothing": (
        lambda: WriteReport([], "a.html"),
        r"a report needs at least one result, got none",
    ),
    "a file in no folder": (
        lambda: SaveScenario(LoadScenario("passing"), "no/where.yaml"),
        r"No such file or directory: 'no",
    ),
    "an unknown suite": (
        lambda: LoadSuite(filename="papr"),
        r"papr: there is no such file; did you mean 'paper'",
    ),
    "a planner of wrong arity": (
        _planner_of_wrong_arity,
        r"Few.plan\(\) must take \(self, task, view, memory\), got",
    ),
    "a planner that gives a tuple": (
        lambda: _run_with("a_tuple_for_a_plan"),
        r"planner 'a_tuple_for_a_plan' failed at t = 0.000 s: .* must give a P",
    ),
    "a planner that gives NaN": (
        lambda: _run_with("nan_for_a_speed"),
        r"planner 'nan_for_a_speed' failed at t = 0.000 s: .*finite",
    ),
    "a model of wrong arity": (
        _model_of_wrong_arity,
        r"Few.advance\(\) must take \(self, snapshot, forces\), got \(self, sn",
    ),
    "a metric of wrong arity": (
        _metric_of_wrong_arity,
        r"metric 'two_recordings': the function must take \(recording\), got",
    ),
}


@pytest.mark.parametrize("mistake", PYTHON)
def test_a_mistake_in_python(mistake, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make, words = PYTHON[mistake]
    kinds = (ValueError, TypeError, OSError, PlannerError, RuntimeError)
    with pytest.raises(kinds) as caught:
        make()
    text = str(caught.value)
    assert sum(bool(re.search(words, it)) for it in text.splitlines()) == 1, (
        text
    )
    # What lists faults has a heading.
    assert len(text.splitlines()) <= 1 + 2 * isinstance(
        caught.value, ScenarioError
    )


LEAF = """
from hunav_drake.systems.behavior import register_action

@register_action("Hop")
def hop(context):
    return {value}
"""


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ('"yes"', r"action Hop must return NodeStatus.*got 'yes'.*t = 0.000 s"),
        ("1 / 0", r"leaf.py:6: ZeroDivisionError.*t = 0.000 s"),
    ],
)
def test_a_leaf_that_is_wrong(hunav, tmp_path, monkeypatch, value, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leaf.py").write_text(
        LEAF.replace("Hop", f"Hop{len(value)}").format(value=value)
    )
    (tmp_path / "hop.xml").write_text(
        '<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree ID="T">'
        f"<Hop{len(value)}/></BehaviorTree></root>"
    )
    arguments = [
        *("run", "passing", "--import", "leaf.py"),
        *("--set", "humans[0].behavior=./hop.xml"),
    ]
    code, out, err = hunav(*arguments)
    assert code == 2
    (line,) = err.splitlines()
    assert re.search(words.replace("Hop", f"Hop{len(value)}"), line), line
    assert "Traceback" not in out


def test_debug_shows_where_it_comes_from(hunav):
    plain = hunav("run", "passing", "--planner", "persuit")[2]
    for arguments in (
        ["run", "passing", "--planner", "persuit", "--debug"],
        ["--debug", "run", "passing", "--planner", "persuit"],
    ):
        code, _, err = hunav(*arguments)
        assert code == 2
        assert "Traceback" in err
        assert err.endswith(plain)


def test_a_fault_of_the_package_is_told_so(hunav, monkeypatch):
    import hunav_drake.scenario

    def fail():
        raise LookupError("nothing there")

    monkeypatch.setattr(hunav_drake.scenario, "ListScenarios", fail)
    code, _, err = hunav("list")
    assert code == 1
    assert err.splitlines()[0] == "hunav: LookupError: nothing there"
    assert "--debug shows where" in err
    assert "Traceback" in hunav("--debug", "list")[2]


def test_there_are_more_than_forty():
    assert len(YAML) + len(COMMANDS) + len(TREES) + len(PYTHON) > 75
    assert callable(AddBodyState)
