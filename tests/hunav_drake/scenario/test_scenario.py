"""Loading, overriding, naming and saving scenarios."""

import dataclasses as dc
import itertools
import math
from pathlib import Path
import stat

import numpy as np
import pytest

from hunav_drake.scenario import (
    CheckScenario,
    HumanConfig,
    ListScenarios,
    LoadScenario,
    SaveScenario,
    Scenario,
)
from tests.hunav_drake.scenario.loading_failure import failure

TWO = """\
one:
  robot: {radius: 0.2}
two:
  robot: {radius: 0.3}
  planner: {type: nobody}
"""


def test_an_empty_mapping_is_a_scenario_of_defaults():
    assert LoadScenario(data="{}") == Scenario()


def test_a_file_and_its_text_say_the_same(tmp_path):
    text = "name: x\ndescription: a b\nhumans:\n- pose: [1, 2, 3]\n"
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    scenario = LoadScenario(filename=file)
    assert scenario == LoadScenario(filename=str(file))
    assert scenario == LoadScenario(data=text)
    assert scenario.description == "a b"
    assert scenario.humans[0].pose == (1.0, 2.0, 3.0)


def test_is_called_as_its_file_unless_it_has_a_name(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("{}")
    assert LoadScenario(filename=file).name == "mine"
    file.write_text("name: yours")
    assert LoadScenario(filename=file).name == "yours"
    file.write_text("theirs: {}")
    scenario = LoadScenario(filename=file, scenario_name="theirs")
    assert scenario.name == "theirs"


@pytest.mark.parametrize("kwargs", [{}, {"filename": "a", "data": "b"}])
def test_takes_either_a_file_or_text(kwargs):
    with pytest.raises(ValueError, match="either filename or data"):
        LoadScenario(**kwargs)


def test_a_missing_file_names_the_shipped_scenarios_and_the_nearest():
    text = str(failure(filename="pasing.yaml"))
    assert "No such file" in text
    assert f"shipped scenarios: {', '.join(ListScenarios())}" in text
    assert "did you mean passing?" in text


def test_a_directory_is_no_scenario_unless_it_hides_a_shipped_one(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "passing").mkdir()
    (tmp_path / "mine").mkdir()
    assert LoadScenario(filename="passing").humans
    text = str(failure(filename="mine"))
    assert "is a directory, not a file; shipped scenarios: " in text


@pytest.mark.slow
def test_a_file_comes_before_a_shipped_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "passing").write_text("description: mine")
    assert LoadScenario(filename="passing").description == "mine"
    assert ListScenarios()["passing"] != "mine"


def test_one_of_several_scenarios_is_taken_by_name():
    assert LoadScenario(data=TWO, scenario_name="one").robot.radius == 0.2


def test_one_of_several_scenarios_may_be_named_like_a_key():
    two = TWO.replace("one:", "crowd:", 1).replace("nobody", "sfm")
    for name, radius in (("crowd", 0.2), ("two", 0.3)):
        loaded = LoadScenario(data=two, scenario_name=name)
        assert loaded.robot.radius == radius
    assert "leave scenario_name" in str(
        failure(data="robot: {radius: 0.2}", scenario_name="robot")
    )


def test_a_wrong_scenario_name_lists_the_nearest():
    text = str(failure(data=TWO, scenario_name="on"))
    assert "there is no scenario 'on' in it; did you mean 'one'?" in text
    text = str(failure(data=TWO, scenario_name="zzz"))
    assert "valid: one, two" in text
    assert "there are none" in str(failure(data="[]", scenario_name="a"))


def test_faults_of_a_named_scenario_have_their_lines():
    text = str(failure(data=TWO, scenario_name="two"))
    assert "data:5: planner.type: there is no planner 'nobody'" in text


@pytest.mark.parametrize(
    ("override", "part", "value"),
    [
        ("robot.radius=0.3", lambda s: s.robot.radius, 0.3),
        ("robot.limits.max_speed = 2", lambda s: s.robot.limits.max_speed, 2),
        ("humans[1].radius=0.4", lambda s: s.humans[1].radius, 0.4),
        ("humans[0].goals[0]=[1, 2]", lambda s: s.humans[0].goals, [(1, 2)]),
        ("humans[0].goals[0][1]=3", lambda s: s.humans[0].goals, [(9, 3)]),
        ("robot.goal=[1, 2, 3]", lambda s: s.robot.goal, (1, 2, 3)),
        ("robot.goal=null", lambda s: s.robot.goal, None),
        ("description=a = b", lambda s: s.description, "a = b"),
        ("simulation={seed: 4}", lambda s: s.simulation.seed, 4),
    ],
)
def test_overrides_replace_what_the_file_says(override, part, value):
    text = (
        "humans:\n- {pose: [5, 5, 0], goals: [[9, 9]]}\n- {pose: [7, 7, 0]}\n"
    )
    assert part(LoadScenario(data=text, overrides=[override])) == value


def test_overrides_come_as_text_sequence_or_mapping():
    for overrides in (
        "robot.radius=0.3",
        ["robot.radius=0.2", "robot.radius=0.3"],
        {"robot.radius": "0.3"},
    ):
        scenario = LoadScenario(data="{}", overrides=overrides)
        assert scenario.robot.radius == 0.3


def test_members_of_lists_of_each_robot_go_by_name_too():
    scenario = LoadScenario(
        "three_robots",
        overrides=[
            "sensors=[{type: lidar, name: back}, {type: lidar, name: front}]",
            "robots[1].sensors=[{type: lidar, name: front}]",
            "sensors.front.noise=0.1",
        ],
    )
    found = [[it.noise for it in robot.sensors] for robot in scenario.robots]
    assert found == [[0.0, 0.1], [0.1], [0.0, 0.1]]


@pytest.mark.parametrize("name", ["zoé", "愛", "été_2", "zoe\u0301", "अनिता"])
def test_people_with_any_letters_go_by_name(name):
    scenario = LoadScenario(
        data="humans: [{pose: [5, 5, 0]},"
        f" {{name: {name}, pose: [7, 7, 0]}}]",
        overrides=[f"humans.{name}.radius=0.4"],
    )
    assert [it.radius for it in scenario.humans] == [0.35, 0.4]


def test_an_override_can_mend_a_fault_of_the_file():
    data = "robot: {radius: -1}"
    assert LoadScenario(data=data, overrides="robot.radius=1").robot.radius == 1


def test_an_override_reaches_one_of_two_people_who_share_an_anchor():
    data = (
        "humans:\n- {pose: [5, 5, 0], forces: &f {n: 1}}\n"
        "- {pose: [7, 7, 0], forces: *f}\n"
    )
    scenario = LoadScenario(data=data, overrides="humans[1].forces.n=3")
    assert [human.forces.n for human in scenario.humans] == [1, 3]


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("robot.radius", "must be a path and a value"),
        ("=1", "must be a path and a value"),
        ("robot..radius=1", "must be a path and a value"),
        ("humans[-1].radius=1", "must be a path and a value"),
        ("humans[x]=1", "must be a path and a value"),
        ("a" + ".a" * 100_000 + "=1", "must be a path and a value"),
        ("robot.radius=", "the value is empty"),
        ("robot.radius=[1", "the value is not YAML"),
        ("robot.radius=" + "[" * 10_000, "nests deeper"),
        ("robot.radius=*a", "there is no anchor 'a'"),
        ("robot.radius=big", "robot.radius: must be a number, got 'big'"),
        ("robot.radius=-1", "robot.radius: must be in [0.001, 5] m, got -1"),
        ("robot.radios=1", "robot.radios: unknown key; did you mean 'radius'?"),
        ("humans[7].radius=1", "humans has 1 members, counted from 0"),
        ("humans.radius=1", "humans has no member named 'radius'"),
        ("humans.eva.radius=1", "by number, as in humans[0]"),
        ("robot[0]=1", "robot is not given"),
        ("humans[0][1]=1", "humans[0] is a mapping, not a list"),
        ("robot.goal[0]=1", "robot.goal is not given"),
        ("humans[0].name.x=1", "humans[0].name is 'ana', not a mapping"),
        ("simulation.time_step=0.03", "planner.period: must be a multiple"),
        ("robot.start=[5, 5, 0]", "robot.start: overlaps humans[0] ('ana')"),
    ],
    ids=lambda text: text[:20],
)
def test_faults_of_an_override_are_placed_there(override, words):
    data = "humans:\n- {name: ana, pose: [5, 5, 0]}\n"
    text = str(failure(data=data, overrides=[override]))
    lines = text.splitlines()[1:]
    assert lines
    assert all(line.startswith(f"--set {override[:57]}") for line in lines)
    assert words in text


def test_faults_of_the_file_and_of_overrides_come_together():
    text = str(
        failure(
            data="robot: {radius: -1}", overrides=["x", "planner.type=none"]
        )
    )
    assert text.splitlines() == [
        "data: 3 faults",
        "data:1: robot.radius: must be in [0.001, 5] m, got -1.0",
        *text.splitlines()[2:],
    ]
    assert "--set x: must be a path" in text
    assert "--set planner.type=none: planner.type: there is no" in text


def test_everybody_has_a_name_and_a_number():
    data = "humans:\n" + "".join(
        f"- {{pose: [{3 + 2 * i}, 5, 0]{more}}}\n"
        for i, more in enumerate(
            ["", ", name: human_1", ", id: 1", ", name: eva, id: 2", ""]
        )
    )
    humans = LoadScenario(data=data).humans
    assert [human.name for human in humans] == [
        "human_2",
        "human_1",
        "human_3",
        "eva",
        "human_4",
    ]
    assert [human.id for human in humans] == [3, 4, 1, 2, 5]


def test_naming_leaves_the_given_people_alone():
    human = HumanConfig(pose=(5, 5, 0))
    named = CheckScenario(Scenario(humans=[human]))
    assert (named.humans[0].name, named.humans[0].id) == ("human_1", 1)
    assert (human.name, human.id) == ("", None)
    assert CheckScenario(named) == named


def test_saved_text_has_only_what_differs_from_the_defaults():
    scenario = LoadScenario(
        data="humans:\n- {pose: [5, 5, 0], radius: 0.35, goals: [[7, 8]]}\n"
        "world: {walls: [{type: box, center: [1, 2], size: [0.2, 0.2]}]}\n"
    )
    assert SaveScenario(scenario) == (
        "world:\n  walls:\n  - type: box\n    center: [1.0, 2.0]\n"
        "    size: [0.2, 0.2]\n"
        "humans:\n- name: human_1\n  id: 1\n  pose: [5.0, 5.0, 0.0]\n"
        "  goals:\n  - [7.0, 8.0]\n"
    )


def test_saving_replaces_the_file_as_a_whole(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_text("x" * 10_000)
    text = SaveScenario(Scenario(description="é"), file)
    assert file.read_text(encoding="utf-8") == text == "description: é\n"
    assert list(tmp_path.iterdir()) == [file]
    # A program that serves it must be able to read it.
    plain = tmp_path / "plain"
    plain.touch()
    assert stat.S_IMODE(file.stat().st_mode) == stat.S_IMODE(
        plain.stat().st_mode
    )


def test_a_failed_save_leaves_nothing_behind(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError, match="taken"):
        SaveScenario(Scenario(), tmp_path / "taken")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_what_yaml_cannot_say_is_refused():
    scenario = Scenario()
    scenario.planner.cruise_speed = object()
    with pytest.raises(ValueError, match=r"parameters of choices.* got object"):
        SaveScenario(scenario)


@pytest.mark.slow
@pytest.mark.parametrize("name", ListScenarios())
def test_shipped_scenarios_load_and_survive_saving(name):
    scenario = LoadScenario(filename=name)
    assert ListScenarios()[name] == scenario.description != ""
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    assert all(human.goals for human in scenario.humans)
    assert len({human.name for human in scenario.humans}) == len(
        scenario.humans
    )


def test_scenarios_are_shipped():
    folder = Path(__file__).parents[3] / "scenarios"
    names = list(ListScenarios())
    assert names == sorted(path.stem for path in folder.glob("*.yaml"))
    for name in ("cafe", "combined", "crossing", "house", "office", "passing"):
        assert name in names


@pytest.mark.parametrize("name", ["passing", "crossing", "combined"])
def test_the_people_of_the_paper_are_those_of_hunavsim(name):
    crowd = LoadScenario(filename=name).crowd
    assert crowd.profile == "hunavsim"
    # In the original, one would stand in another, or in the robot.
    assert crowd.keep_apart
    assert crowd.model.kernel == "hunavsim"
    assert not crowd.route_planning


def free_box(scenario):
    """The inner faces of the four outer walls."""
    walls = {wall.name: wall.vertices() for wall in scenario.world.walls}
    return (
        walls["west"][:, 0].max(),
        walls["east"][:, 0].min(),
        walls["south"][:, 1].max(),
        walls["north"][:, 1].min(),
    )


@pytest.mark.parametrize(
    ("name", "box"),
    [
        ("passing", (-8.55, 9.65, -2.87, 2.83)),
        ("crossing", (-5.97, 5.33, -9.92, 9.28)),
        ("cafe", (-5.2, 3.9, -11.0, 7.5)),
    ],
)
def test_rooms_have_the_documented_size(name, box):
    assert free_box(LoadScenario(filename=name)) == pytest.approx(box)


@pytest.mark.parametrize("name", ["passing", "crossing"])
def test_people_first_look_where_they_walk(name):
    for human in LoadScenario(filename=name).humans:
        (x, y, yaw), (gx, gy) = human.pose, human.goals[0]
        assert yaw == pytest.approx(math.atan2(gy - y, gx - x), abs=1e-3)


def segment_distance(segment, point):
    """The distance of points, shape (n, 2), from one segment."""
    (ax, ay), (bx, by) = segment
    length2 = (bx - ax) ** 2 + (by - ay) ** 2
    t = ((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / length2
    t = min(max(t, 0.0), 1.0)
    return math.hypot(
        point[0] - ax - t * (bx - ax), point[1] - ay - t * (by - ay)
    )


def test_nobody_has_to_walk_through_the_furniture_of_the_cafe():
    scenario = LoadScenario(filename="cafe")
    furniture = scenario.world.furniture
    assert {type(it).__name__ for it in furniture} == {
        "Chair",
        "Counter",
        "Plant",
        "Table",
    }
    names = {it.name for it in furniture if it.name}
    assert names == {"counter", *(f"table_{i}" for i in range(1, 6))}
    ways = [(scenario.robot.start[:2], scenario.robot.goal[:2], 0.35)]
    for human in scenario.humans:
        ways.append((human.pose[:2], human.goals[0], human.radius))
        cycle = [*human.goals, human.goals[0]]
        ways += [(a, b, human.radius) for a, b in itertools.pairwise(cycle)]
    for piece in furniture:
        # Points along the outline, every 5 cm or so.
        (corners,) = piece.footprints()
        after = np.roll(corners, -1, axis=0)
        outline = [
            corners[i] + s / 20 * (after[i] - corners[i])
            for i in range(len(corners))
            for s in range(20)
        ]
        for a, b, radius in ways:
            gap = min(segment_distance((a, b), point) for point in outline)
            assert gap > radius, (piece, a, b)


def test_people_of_the_cafe_are_those_of_the_original(reference):
    from hunav_drake.hunavsim.agents_yaml import ImportAgents

    original = ImportAgents(reference / "hunav/agents.yaml")
    same = [dc.replace(human, name="") for human in original.humans]
    cafe = LoadScenario(filename="cafe").humans
    assert [dc.replace(human, name="") for human in cafe] == same
