"""Whatever is wrong with a scenario file is told, with its place."""

import contextlib
import functools
import pickle
import time

import pytest
import yaml

from hunav_drake.scenario import (
    CheckScenario,
    DifferentialDriveConfig,
    Fault,
    HumanConfig,
    Scenario,
    ScenarioError,
)
from tests.hunav_drake.scenario.loading_failure import failure

HUMAN = "humans:\n  - name: ana\n    pose: [5, 5, 0]\n"
WALLS = "world:\n  walls:\n"
BOX = WALLS + "    - {type: box, name: bar, center: [5, 5], size: [2, 2]}\n"
ROOM = BOX + "robot: {start: [0, 0, 0]}\n"

# What the file says; the line that is named (0 for the whole file); the path;
# and words of the message.
CASES = {
    # YAML
    "empty": ("", 0, "", "is empty"),
    "only comments": ("# a\n# b\n", 0, "", "is empty"),
    "unclosed list": ("robot:\n  start: [1, 2\nplanner: {}", 3, "", "not YAML"),
    "unclosed text": ('description: "abc\n', 2, "", "quoted scalar"),
    "tab": ("robot:\n\tradius: 0.3\n", 2, "", "indent with spaces"),
    "bad indent": ("robot:\n  radius: 1\n start: 2\n", 3, "", "not YAML"),
    "colon in text": ("description: a: b\n", 1, "", "mapping values"),
    "binary": (b"\x7fELF\x02\x01\x00\x00", 1, "", "U+007F"),
    "zeros": (b"robot:\n\x00\x00\x00", 2, "", "U+0000 at offset 7"),
    "png": (b"\x89PNG\r\n\x1a\n", 1, "", "not UTF-8 text: byte 0x89"),
    "latin 1": ("a: 1\nb: señal".encode("latin-1"), 2, "", "byte 0xf1"),
    "utf 16": ("robot: {}".encode("utf-16"), 1, "", "not UTF-8"),
    "brackets": ("[" * 100_000, 1, "", "deeper than 50"),
    "braces": ("robot: " + "{a: " * 100_000, 1, "", "deeper than 50"),
    "dashes": ("humans:\n" + "- " * 100_000, 2, "", "deeper than 50"),
    "anchors bomb": (
        "a: &a [x, x, x, x, x, x, x, x, x]\n"
        + "".join(
            f"{b}: &{b} [{', '.join(['*' + a] * 9)}]\n"
            for a, b in zip("abcdefghijk", "bcdefghijkl", strict=True)
        ),
        6,
        "",
        "unfolds to more than 200000",
    ),
    "merge bomb": (
        "a0: &a0 {x: 1}\n"
        + "".join(
            f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}], k{i}: *a{i - 1}}}\n"
            for i in range(1, 60)
        ),
        17,
        "",
        "unfolds to more than 200000",
    ),
    "anchor in itself": ("&a [*a]", 1, "[0]", "contains itself"),
    "anchor not given": ("robot: *r\n", 1, "robot", "no anchor 'r'"),
    "two documents": ("{}\n---\n{}\n", 2, "", "second document"),
    "key twice": ("robot: {}\ncrowd: {}\nrobot: {}\n", 3, "robot", "twice"),
    "key twice below": (
        HUMAN + "    name: eva\n",
        4,
        "humans[0] ('ana').name",
        "first in line 2",
    ),
    "number as key": ("1: robot\n", 1, "", "a key must be text, got 1"),
    "list as key": ("? [robot]\n: {}\n", 1, "", "a key must be text"),
    "unknown tag": (
        HUMAN + "    radius: !Uniform {min: 0.3, max: 0.4}\n",
        4,
        "humans[0] ('ana').radius",
        "unknown tag '!Uniform'",
    ),
    "python tag": (
        "a: !!python/object/apply:os.system [ls]",
        1,
        "a",
        "unknown tag",
    ),
    # The form of the whole
    "a list": ("- robot\n- humans\n", 1, "", "must be a mapping, got a list"),
    "a number": ("5", 1, "", "must be a mapping, got 5"),
    "nothing": ("null", 1, "", "must be a mapping, got nothing"),
    "a sentence": ("Once upon a time", 1, "", "must be a mapping, got 'Once"),
    "unknown key": ("robt: {}\n", 1, "robt", "did you mean 'robot'?"),
    "strange key": ("zzz: {}\n", 1, "zzz", "unknown key; valid: crowd, des"),
    "section as list": ("robot: []\n", 1, "robot", "must be a mapping"),
    "section as nothing": ("robot:\n", 1, "robot", "got nothing"),
    "people as mapping": ("humans: {}\n", 1, "humans", "must be a list"),
    "person as number": ("humans:\n  - 5\n", 2, "humans[0]", "a mapping"),
    "description": ("description: 5\n", 1, "description", "must be text"),
    # People
    "no pose": ("humans:\n  - name: ana\n", 2, "('ana').pose", "is missing"),
    "short pose": ("humans:\n- pose: [1, 2]\n", 2, "pose", "3 numbers, got 2"),
    "long pose": ("humans:\n- pose: [1,2,3,4]\n", 2, "pose", "numbers, got 4"),
    "pose as text": ("humans:\n- pose: 1 2 3\n", 2, "pose", "list of numbers"),
    "pose of words": (
        "humans:\n- pose: [1, b, 3]\n",
        2,
        "humans[0].pose[1]",
        "must be a number, got 'b'",
    ),
    "far away": ("humans:\n- pose: [1e9, 0, 0]\n", 2, "pose[0]", "[-100000"),
    "nan": ("humans:\n- pose: [.nan, 0, 0]\n", 2, "pose[0]", "finite number"),
    "infinite": (HUMAN + "    radius: .inf\n", 4, "radius", "finite number"),
    "overflow": (HUMAN + "    radius: 1e999\n", 4, "radius", "finite number"),
    "400 digits": (
        HUMAN + "    radius: 1" + "0" * 400,
        4,
        "radius",
        "finite number",
    ),
    "10000 digits": (HUMAN + "    id: " + "1" * 10_000, 4, "id", "whole"),
    "negative": (
        HUMAN + "    max_speed: -1.0\n",
        4,
        "humans[0] ('ana').max_speed",
        "must be in (0, 10] m/s, got -1.0",
    ),
    "zero radius": (
        HUMAN + "    radius: 0\n",
        4,
        "radius",
        "[0.001, 5] m, got 0",
    ),
    "a million velocities": (
        "planner:\n  type: dwb\n  vx_samples: 1000\n  vtheta_samples: 1000\n",
        4,
        "planner.vtheta_samples",
        "must be at most 40 with vx_samples 1000",
    ),
    "number in quotes": (HUMAN + "    radius: '0.3'", 4, "radius", "a number"),
    "flag for number": (HUMAN + "    radius: true\n", 4, "radius", "got true"),
    "word for flag": (HUMAN + "    cyclic: yes\n", 4, "cyclic", "got 'yes'"),
    "number for flag": (HUMAN + "    cyclic: 1\n", 4, "cyclic", "got 1"),
    "number for name": ("humans:\n- {name: 5, pose: [1, 1, 0]}", 2, "name", ""),
    "half a number": (HUMAN + "    id: 1.5\n", 4, "id", "whole number"),
    "negative id": (HUMAN + "    id: -1\n", 4, "id", "at least 0, got -1"),
    "huge id": (HUMAN + "    id: 3000000000\n", 4, "id", "at most 2147483647"),
    "long name": (
        f"humans:\n- name: {'x' * 80}\n  pose: [1, 1, 0]\n",
        2,
        "name",
        "at most 64 characters",
    ),
    "goals as point": (HUMAN + "    goals: [1, 2]\n", 4, "goals[0]", "a list"),
    "goal of three": (HUMAN + "    goals: [[1, 2, 3]]\n", 4, "goals[0]", "2"),
    "key of a person": (
        HUMAN + "    speed: 1\n",
        4,
        "humans[0] ('ana').speed",
        "unknown key; did you mean 'max_speed'?",
    ),
    "key of forces": (
        HUMAN + "    forces:\n      gama: 1\n",
        5,
        "humans[0] ('ana').forces.gama",
        "did you mean 'gamma'?",
    ),
    "same name": (
        HUMAN + "  - name: ana\n    pose: [9, 9, 0]\n",
        4,
        "humans[1] ('ana').name",
        "'ana' is already the name of humans[0] ('ana')",
    ),
    "same id": (
        "humans:\n- {id: 1, pose: [5, 5, 0]}\n- {id: 1, pose: [6, 6, 0]}\n",
        3,
        "humans[1].id",
        "1 is already the id of humans[0]",
    ),
    "same start": (
        HUMAN + "  - pose: [5, 5, 1]\n",
        4,
        "humans[1].pose",
        "starts on the same point as humans[0] ('ana'); move it by 0.7 m",
    ),
    "jitter out of the world": (
        "humans:\n- pose: [0, -99999.9, 0]\nsimulation: {start_jitter: 0.5}\n",
        2,
        "humans[0].pose[1]",
        "must be in [-99999.5, 99999.5] m, got -99999.9: simulation.start_jit"
        "ter (0.5 m) may take the person beyond 100000 m; move it, or set the",
    ),
    "slow limit": (
        HUMAN + "    max_speed: 0.8\n",
        4,
        "max_speed",
        "at least desired_speed (1.2 m/s), got 0.8",
    ),
    "unknown behavior": (
        HUMAN + "    behavior: reguler\n",
        4,
        "behavior",
        "there is no behavior 'reguler'; did you mean 'regular'?",
    ),
    # Walls
    "no shape": (WALLS + "    - {size: [1, 1]}\n", 3, "walls[0]", "missing"),
    "unknown shape": (
        WALLS + "    - {type: boxx}\n",
        3,
        "world.walls[0]",
        "there is no wall shape 'boxx'; did you mean 'box'?",
    ),
    "wall as list": (WALLS + "    - []\n", 3, "world.walls[0]", "a mapping"),
    "key of a wall": (
        BOX + "    - type: box\n      center: [1, 1]\n      sise: [1, 1]\n",
        6,
        "world.walls[1].sise",
        "did you mean 'size'?",
    ),
    "flat box": (
        WALLS + "    - {type: box, center: [1, 1], size: [1, 0]}\n",
        3,
        "world.walls[0].size[1]",
        "must be in (0, 100000] m, got 0",
    ),
    "two corners": (
        WALLS + "    - {type: polygon, points: [[1, 1], [2, 2]]}\n",
        3,
        "points",
        "a list of at least 3",
    ),
    "one point": (
        WALLS + "    - {type: polyline, points: [[1, 1]]}\n",
        3,
        "points",
        "a list of at least 2",
    ),
    "no length": (
        WALLS + "    - {type: polyline, points: [[9, 9], [9, 9]]}\n",
        3,
        "world.walls[0].points[1]",
        "repeats points[0]",
    ),
    "repeated corner": (
        WALLS + "    - type: polygon\n      points:\n        - [5, 5]\n"
        "        - [6, 5]\n        - [6, 5]\n        - [6, 6]\n",
        7,
        "world.walls[0].points[2]",
        "repeats points[1]",
    ),
    "closed twice": (
        WALLS + "    - {type: polygon, points: [[5,5],[6,5],[6,6],[5,5]]}\n",
        3,
        "points[3]",
        "the last corner joins the first by itself",
    ),
    "no area": (
        WALLS + "    - {type: polygon, points: [[5, 5], [6, 6], [8, 8]]}\n",
        3,
        "points",
        "must enclose an area",
    ),
    "bow tie": (
        WALLS + "    - {type: polygon, points: [[5,5],[7,7],[7,5],[5,7]]}\n",
        3,
        "points",
        "must not cross itself; the side from points[0] meets",
    ),
    "spike": (
        WALLS + "    - {type: polygon, points: [[5,5],[9,5],[7,5],[7,8]]}\n",
        3,
        "points",
        "must not cross itself",
    ),
    # Who stands where
    "inside a wall": (
        BOX + "humans:\n  - {pose: [4.4, 5, 0]}\n",
        5,
        "humans[0].pose",
        "is inside world.walls[0] ('bar'); move it 0.75 m along (-1.00, 0.00)",
    ),
    "at a wall": (
        BOX + "humans:\n  - {name: ana, pose: [5, 6.3, 0]}\n",
        5,
        "humans[0] ('ana').pose",
        "overlaps world.walls[0] ('bar'); move it 0.05 m along (0.00, 1.00)",
    ),
    "across a thin wall": (
        WALLS + "    - {type: polyline, points: [[5, 0], [5, 9]]}\n"
        "humans:\n  - {pose: [5.0, 4, 0]}\n",
        5,
        "humans[0].pose",
        "overlaps world.walls[0]; move it 0.35 m",
    ),
    "goal in a wall": (
        BOX + "humans:\n  - pose: [0, 5, 0]\n    goals:\n      - [3, 5]\n"
        "      - [4.2, 5]\n",
        8,
        "humans[0].goals[1]",
        "is inside world.walls[0] ('bar'); move it 0.20 m along (-1.00, 0.00)",
    ),
    "robot in a wall": (
        BOX + "robot:\n  start: [5, 4.5, 0]\n",
        5,
        "robot.start",
        "is inside world.walls[0] ('bar')",
    ),
    "robot's goal": (
        BOX + "robot:\n  goal: [5, 3.8, 0]\n",
        5,
        "robot.goal",
        "overlaps world.walls[0] ('bar'); move it 0.15 m along (0.00, -1.00)",
    ),
    "robot on a person": (
        HUMAN + "robot:\n  start: [5.5, 5, 0]\n",
        5,
        "robot.start",
        "overlaps humans[0] ('ana') by 0.20 m",
    ),
    # How people move
    "motion model": (
        "crowd:\n  model: orka\n",
        2,
        "crowd.model",
        "there is no motion model 'orka'; did you mean 'orca'?",
    ),
    "motion model's parameter": (
        "crowd:\n  model:\n    type: orca\n    time_horizn: 1.0\n",
        4,
        "crowd.model.time_horizn",
        "did you mean 'time_horizon'?",
    ),
    "motion model's value": (
        "crowd:\n  model:\n    {type: orca, time_horizon: 0}\n",
        3,
        "crowd.model.time_horizon",
        "must be in (0, 1000] s, got 0",
    ),
    "another motion model's parameter": (
        "crowd:\n  model:\n    time_horizon: 1.0\n",
        3,
        "crowd.model.time_horizon",
        "unknown key",
    ),
    # The robot, its planner, the evaluator, the simulation
    "robot's model": (
        "robot:\n  type: tank\n",
        2,
        "robot.type",
        "there is no robot 'tank'; valid: differential_drive",
    ),
    "robot's limits": (
        "robot:\n  limits:\n    max_sped: 1\n",
        3,
        "robot.limits.max_sped",
        "did you mean 'max_speed'?",
    ),
    "tolerance": ("robot: {goal_tolerance: 0}", 1, "goal_tolerance", "(0, 10]"),
    "planner": (
        "planner:\n  type: persuit\n",
        2,
        "planner.type",
        "there is no planner 'persuit'; did you mean 'pursuit'?",
    ),
    "planner's parameter": (
        "planner:\n  type: pursuit\n  cruise_sped: 1.0\n",
        3,
        "planner.cruise_sped",
        "did you mean 'cruise_speed'?",
    ),
    "planner's value": (
        "planner:\n  type: pursuit\n  cruise_speed: fast\n",
        3,
        "planner.cruise_speed",
        "must be a number, got 'fast'",
    ),
    "bare name of a planner": (
        "planner: persuit\n",
        1,
        "planner.type",
        "there is no planner 'persuit'; did you mean 'pursuit'?",
    ),
    "planner that is a number": (
        "planner: 5\n",
        1,
        "planner",
        "must be a mapping, or the name of a planner, got 5",
    ),
    "planner's name that is a number": (
        "planner: {type: 5}\n",
        1,
        "planner.type",
        "must be the name of a planner, got 5",
    ),
    "planner's parameters as before": (
        "planner:\n  type: pursuit\n  parameters: {cruise_speed: 0.3}\n",
        3,
        "planner.parameters",
        "parameters stand beside the type now, as in planner: {type: pursuit,"
        " cruise_speed: 0.8}",
    ),
    "motion model's parameters as before": (
        "crowd:\n  model: orca\n  parameters: {time_horizon: 0.3}\n",
        3,
        "crowd.parameters",
        "crowd: {model: {type: orca, time_horizon: 2.0}}",
    ),
    "planner's period": (
        "planner: {period: 0.12}\n",
        1,
        "planner.period",
        "a multiple of simulation.time_step (0.05 s), got 0.12; nearest: 0.1"
        " or 0.15",
    ),
    "short period": (
        "evaluator:\n  period: 0.01\n",
        2,
        "evaluator.period",
        "got 0.01; nearest: 0.05",
    ),
    "metric": (
        "evaluator:\n  metrics: [path_length, path_lenth]\n",
        2,
        "evaluator.metrics[1]",
        "path_lenth",
    ),
    "metrics as text": ("evaluator: {metrics: all}", 1, "metrics", "a list"),
    "seed": ("simulation: {seed: -1}\n", 1, "simulation.seed", "at least 0"),
    "huge seed": (
        "simulation: {seed: 99999999999999999999}",
        1,
        "simulation.seed",
        "at most 9223372036854775807, got 99999999999999999999",
    ),
    "step": (
        "simulation: {time_step: 0}",
        1,
        "time_step",
        "[0.0001, 0.5] s, got",
    ),
    "a name with an escape": (
        'humans:\n  - {name: "\\e[31mred", pose: [0, 0, 0]}\n',
        2,
        "humans[0]",
        "must be one line without control characters",
    ),
    "several scenarios": (
        "a: {humans: []}\nb: {robot: {}}\n",
        0,
        "",
        "holds several scenarios: choose one by scenario_name, or --name: 'a'",
    ),
    "duration": (
        "simulation: {duration: 0.01}\n",
        1,
        "simulation.duration",
        "multiple of simulation.time_step (0.05 s), got 0.01; nearest: 0.05",
    ),
    "duration between steps": (
        "simulation: {duration: 0.501}\n",
        1,
        "simulation.duration",
        "got 0.501; nearest: 0.5 or 0.55",
    ),
    "no goal to wait for": (
        "evaluator: {start: at_goal_command}\n",
        1,
        "evaluator.start",
        "'at_goal_command' where the robot has no goal: nothing would be",
    ),
    "sexagesimal": ("simulation: {duration: 1:30}", 1, "duration", "'1:30'"),
    "date": ("simulation: {seed: 2026-01-31}", 1, "seed", "'2026-01-31'"),
    # HuNavSim's form
    "hunav": ("hunav_loader: {}", 0, "hunav_loader.ros__par", "is missing"),
    "hunav agents": (
        "hunav_loader:\n  ros__parameters:\n    agents: 5\n",
        3,
        "agents",
        "must be a list of agents' names",
    ),
}


@functools.cache
def second() -> float:
    """Processor time for what takes a second on the machine of the bounds."""
    start = time.process_time()
    yaml.safe_load("- {pose: [1, 2, 3]}\n" * 2000)
    return 4 * (time.process_time() - start)


@contextlib.contextmanager
def at_most(seconds):
    """A bound that a slow or busy machine does not break."""
    limit = seconds * second()
    start = time.process_time()
    yield
    assert time.process_time() - start < limit


def test_there_are_many_cases():
    assert len(CASES) >= 60


@pytest.mark.parametrize("name", CASES)
def test_fault_has_place_path_and_rule(name, tmp_path):
    text, line, path, words = CASES[name]
    file = tmp_path / "bad.yaml"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with at_most(4.0):
        error = failure(filename=file)
    place = f"{file}:{line}: " if line else f"{file}: "
    first, *lines = str(error).splitlines()
    assert first.startswith(f"{file}: ")
    assert len(lines) == len(error.faults)
    assert any(
        text.startswith(place) and path in text and words in text
        for text in lines
    ), str(error)
    assert all(len(fault.message) < 400 for fault in error.faults)
    assert "pydantic" not in str(error)


def test_each_fault_is_told_once():
    for name in ("no pose", "same start", "inside a wall", "unknown tag"):
        assert len(failure(data=CASES[name][0]).faults) == 1


def test_a_huge_file_is_not_read(tmp_path):
    file = tmp_path / "huge.yaml"
    with open(file, "wb") as stream:
        stream.truncate(100 * 10**6)
    with at_most(1.0):
        error = failure(filename=file)
    assert str(error) == (
        f"{file}: 1 fault\n"
        f"{file}: is too large: at most 16777216 bytes, got 100000000"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "".join(f"key{i}: 1\n" for i in range(50_000)),
        "key: 1\n" * 50_000,
        "humans: [" + "1, " * 100_000 + "]",
        "humans:\n" + "- {pose: [a, b, c], spee: 3}\n" * 10_000,
        "humans:\n" + "- {pose: [1, 2, 3]}\n" * 10_000,
        "evaluator: {metrics: [" + ", ".join(map("m{}".format, range(10**5))),
        "description: " + "a" * 10**7 + "\nfoo: 1",
        "planner: {"
        + ", ".join(f"cruise_spee{i}: 1" for i in range(50_000))
        + "}",
        WALLS
        + "    - {type: polyline, points: [[0, 0], [9, 9]]}\n" * 9_000
        + "humans:\n"
        + "- {pose: [1, 2, 3]}\n" * 5_000,
    ],
    ids=lambda text: text[:20],
)
def test_large_nonsense_takes_little_time(text):
    with at_most(8.0):
        error = failure(data=text)
    assert len(str(error)) < 20_000


def test_all_faults_come_at_once_in_order_of_lines():
    error = failure(
        data=WALLS
        + "    - {type: box, name: bar, center: [5, 5], size: [2, 2]}\n"
        "humans:\n"
        "  - name: ana\n"
        "    pose: [5, 5, 0]\n"
        "    max_sped: 1\n"
        "  - name: ana\n"
        "    pose: [9, 9]\n"
        "  - name: eva\n"
        "    pose: [9, 9, 0]\n"
        "    name: eva\n"
        "robot:\n"
        "  radius: -1\n"
        "  start: [5, 5, 0]\n"
        "simulation: {time_step: 0.04}\n"
    )
    assert [(fault.line, fault.path) for fault in error.faults] == [
        (6, "humans[0] ('ana').pose"),
        (7, "humans[0] ('ana').max_sped"),
        (8, "humans[1] ('ana').name"),
        (9, "humans[1] ('ana').pose"),
        (12, "humans[2] ('eva').name"),
        (14, "robot.radius"),
        # Its default, 0.05 s, is written nowhere; the step is what matters.
        (16, "planner.period"),
        (16, "evaluator.period"),
    ]
    assert str(error).startswith("data: 8 faults\ndata:6: humans[0] ('ana')")


def test_nothing_is_concluded_from_what_is_wrong_itself():
    error = failure(data="simulation: {time_step: -1}\nplanner: {period: 0.07}")
    assert [fault.path for fault in error.faults] == ["simulation.time_step"]


def test_an_error_can_be_pickled():
    error = failure(data="robot: 5")
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)
    assert (
        copy.faults
        == error.faults
        == (
            Fault(
                "data",
                1,
                "robot",
                "must be a mapping, or the name of a robot, got 5",
            ),
        )
    )
    assert error.faults[0].place == "data:1"


def test_many_faults_are_counted_not_printed():
    text = str(failure(data="humans: [" + "1, " * 99 + "]"))
    assert text.endswith("... and 49 more")


def test_scenario_made_in_python_is_checked_alike():
    scenario = Scenario(
        humans=[
            HumanConfig(name="ana", pose=(5, 5, 0)),
            HumanConfig(name="ana", pose=(9, 5, 0), behavior="odd"),
        ],
        robot=DifferentialDriveConfig(start=(5, 5, 0)),
    )
    with pytest.raises(ScenarioError) as info:
        CheckScenario(scenario)
    text = str(info.value)
    assert text.startswith("scenario: 3 faults\n")
    assert "scenario: humans[1] ('ana').name: must be unique" in text
    assert "scenario: humans[1] ('ana').behavior: there is no" in text
    assert "scenario: robot.start: overlaps humans[0] ('ana')" in text


def test_what_was_assigned_later_is_checked_too():
    scenario = Scenario()
    CheckScenario(scenario)
    scenario.robot.radius = -1.0
    scenario.humans.append("ana")
    with pytest.raises(ScenarioError) as info:
        CheckScenario(scenario)
    assert [fault.path for fault in info.value.faults] == [
        "humans[0]",
        "robot.radius",
    ]
