"""Searches for failures: their results, files, and how they go on."""

import dataclasses as dc
import json
import math
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from hunav_drake import (
    Failures,
    Falsify,
    LoadContext,
    LoadScenario,
    LoadSearchSpace,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    ScenarioError,
)
from hunav_drake.runs.failures.found import kind_of_failure, write_failures
from hunav_drake.runs.failures.minimal import Shrinking, shrink
from hunav_drake.runs.failures.scene_runs import (
    SceneCell,
    recording_sha256,
    scene_cell,
)
from hunav_drake.runs.failures.search import (
    _SEARCHES,
    _descend,
    _run_search,
    _with_values,
)
from hunav_drake.runs.failures.space import SearchSpace
from hunav_drake.systems.evaluation.robustness import Failing, robustness_of
from tests.hunav_drake.runs.failures.scenes import SCENE, SPACE, write_space
from tests.processes import dask_client


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Returns a search, and the folder that it has written."""
    folder = tmp_path_factory.mktemp("search")
    space = write_space(folder)
    return Falsify(space, budget=20, out=folder / "out"), folder / "out"


def values_of(failures):
    return [(v, tuple(map(str, f))) for v, f in failures.runs]


def scenes_of(failures):
    return [(str(it.scenario), it.failing, it.run) for it in failures.scenes]


@pytest.mark.slow
def test_a_search_finds_failures(found):
    failures, _ = found
    assert isinstance(failures, Failures)
    assert len(failures.runs) == 20
    assert failures.num_failures > 0
    assert failures.first_failure < 20
    rhos = [it.failing.robustness for it in failures.scenes]
    assert rhos
    assert max(rhos) < 0
    assert rhos == sorted(rhos)
    kinds = [it.kind for it in failures.scenes]
    assert len(set(kinds)) == len(kinds)


def test_scenes_are_minimal(found):
    """The one who does not matter is left out, and digits and time are few."""
    failures, folder = found
    for i, scene in enumerate(failures.scenes):
        assert [it.name for it in scene.scenario.humans] == ["ana"]
        for number in scene.scenario.humans[0].pose[:2]:
            assert number == round(number, 3)
        assert scene.scenario.simulation.duration <= scene.failing.time + 2.06
        assert (folder / f"{i + 1:03d}.yaml").stat().st_size < 500


@pytest.mark.slow
def test_failures_repeat_from_their_file_in_a_new_process(found):
    failures, folder = found
    rank = pd.read_csv(folder / "rank.csv", dtype={"scene": str})
    assert len(rank) == len(failures.scenes)
    code = (
        "import sys; from hunav_drake import LoadScenario, RunTrial;"
        "from hunav_drake.runs.failures.scene_runs import recording_sha256;"
        "print(*(recording_sha256(RunTrial(LoadScenario(it)).recording)"
        " for it in sys.argv[1:]))"
    )
    files = [str(folder / f"{name}.yaml") for name in rank["scene"]]
    told = subprocess.run(
        [sys.executable, "-c", code, *files],
        check=True,
        capture_output=True,
        text=True,
    )
    assert told.stdout.split() == rank["sha256"].tolist()


def test_a_context_before_the_failure_is_kept(found):
    failures, folder = found
    scenario = LoadScenario(folder / "001.yaml")
    assert "the robot runs into ana after" in scenario.description
    diagram = MakeTrialDiagram(scenario)
    context = LoadContext(diagram, folder / "001.npz")
    time = max(0.0, failures.scenes[0].failing.time - 3.0)
    assert context.get_time() == pytest.approx(time, abs=0.026)
    simulator = MakeTrialSimulator(diagram, context)
    simulator.AdvanceTo(scenario.simulation.duration)
    last = diagram.GetOutputPort("human_states").Eval(simulator.get_context())
    through = RunTrial(scenario).recording.humans[-1].ravel()
    np.testing.assert_array_equal(last, through)


@pytest.mark.slow
def test_a_second_call_goes_on_where_one_was_killed(found, tmp_path):
    failures, _ = found
    space = write_space(tmp_path)

    class KilledError(Exception):
        pass

    def kill(done, total):
        if done == 13:
            raise KilledError

    out = tmp_path / "out"
    with pytest.raises(KilledError):
        Falsify(space, budget=20, out=out, progress=kill)
    kept = (out / "runs.jsonl").read_text().splitlines()
    assert 11 <= len(kept) < 20
    again = Falsify(space, budget=20, out=out)
    lines = (out / "runs.jsonl").read_text().splitlines()
    assert lines[: len(kept)] == kept
    keys = [(it["sha256"], it["seed"]) for it in map(json.loads, lines)]
    assert len(set(keys)) == len(keys)
    assert scenes_of(again) == scenes_of(failures)
    assert values_of(again) == values_of(failures)
    with pytest.raises(ValueError, match="runs of another search"):
        Falsify(space, budget=20, out=out, seed=1)
    more = Falsify(space, budget=24, out=out)
    assert values_of(more)[:20] == values_of(failures)


@pytest.mark.slow
@pytest.mark.parametrize("where", ["workers", "dask"])
def test_where_scenes_are_run_does_not_matter(found, tmp_path, where):
    failures, folder = found
    space, out = write_space(tmp_path), tmp_path / "out"
    if where == "workers":
        other = Falsify(space, budget=20, workers=2, out=out)
    else:
        with dask_client(2) as client:
            executor = client.get_executor(pure=False)
            other = Falsify(
                space, budget=20, executor=executor, workers=2, out=out
            )
    assert values_of(other) == values_of(failures)
    assert scenes_of(other) == scenes_of(failures)
    rank = (folder / "rank.csv").read_text()
    assert (out / "rank.csv").read_text() == rank


@pytest.mark.slow
def test_random_scenes_are_drawn_by_seed_and_number(tmp_path):
    space = write_space(tmp_path)
    few = Falsify(space, method="random", budget=2)
    more = Falsify(space, method="random", budget=4)
    assert values_of(more)[:2] == values_of(few)
    other = Falsify(space, method="random", budget=2, seed=1)
    assert other.runs[0][0] != few.runs[0][0]


def test_a_descent_finds_the_lowest_point_of_a_bowl():
    """A coordinate that is no range of numbers stays."""
    low = np.array([0.3, 0.8, 0.0])

    def height(point):
        return float(((point[:2] - low[:2]) ** 2).sum())

    start = np.array([0.9, 0.1, 0.5])
    descent = _descend(start, height(start), [0, 1], 60)
    tried, _ = _run_search(descent, lambda asked: [*map(height, asked)])
    assert len(tried) <= 60
    best = min(tried, key=height)
    np.testing.assert_allclose(best[:2], low[:2], atol=0.03)
    assert {it[2] for it in tried} == {0.5}
    assert (np.array(tried) >= 0).all()
    assert (np.array(tried) <= 1).all()


def test_a_space_of_choices_is_not_polished():
    choices = {"robot.radius": {"choices": [0.2, 0.3]}}
    space = SearchSpace(scenario="crossing", space=choices)
    with pytest.raises(ValueError, match=r"polish=5 has no effect: .* here 0"):
        Falsify(space, budget=5, polish=5)


def test_a_descent_ends_where_it_is_level():
    descent = _descend(np.array([0.5, 0.5]), 1.0, [0, 1], 60)
    # (One of them is no valid scene.)
    tried, _ = _run_search(descent, lambda _: [1.0, math.inf])
    assert len(tried) == 2


@pytest.mark.slow
def test_scenes_that_cannot_be_run_are_never_the_nearest(tmp_path):
    """Also where all others are farther from a failure than their 9."""
    scene = SCENE.replace("duration: 12.0", "duration: 40.0")
    space = write_space(
        tmp_path,
        "scenario: scene.yaml\nrobustness: timeout\n"
        "space:\n  humans.luis.pose[0]: [-3, 4]\n"
        "  humans.luis.pose[1]: [0, 4]\n"
        "require: {start_gap: 3.0}\n",
        scene,
    )
    found = Falsify(space, method="random", budget=4, polish=5)
    valid = [it.robustness > 9.0 for _, it in found.runs]
    # Some of the first are no scenes, and yet a descent begins.
    assert not all(valid[:4])
    assert any(valid[:4])
    assert len(valid) > 4


def test_generations_keep_away_from_what_is_no_scene():
    """Also where all scenes are farther from a failure than their 9."""

    def values(asked):
        return [math.inf if it[0] > 0.5 else 20 + it[0] for it in asked]

    tried, _ = _run_search(_SEARCHES["cma"](2, 0, 140), values)
    assert len(tried) == 140
    assert np.mean([it[0] > 0.5 for it in tried[-50:]]) < 0.1


@pytest.mark.slow
def test_a_finished_search_is_polished(found, tmp_path):
    failures, folder = found
    shutil.copytree(folder, tmp_path / "out")
    space = folder.parent / "space.yaml"
    again = Falsify(space, budget=20, polish=8, out=tmp_path / "out")
    values = values_of(again)
    assert values[:20] == values_of(failures)
    assert 20 < len(values) <= 28
    worst = min(it.robustness for _, it in failures.runs)
    assert min(it.robustness for _, it in again.runs) <= worst


def test_scenes_that_begin_too_near_are_not_run(tmp_path):
    text = SPACE.replace("start_gap: 0.5", "start_gap: 50.0")
    out = tmp_path / "out"
    failures = Falsify(write_space(tmp_path, text), budget=5, out=out)
    assert failures.refused == 5
    assert not failures.scenes
    assert failures.first_failure is None
    assert {it.robustness for _, it in failures.runs} == {9.0}
    assert not (out / "runs.jsonl").read_text()


@pytest.mark.slow
def test_scenes_whose_run_has_an_error_have_no_result(tmp_path, monkeypatch):
    def broken(self, recording, seed):
        raise RuntimeError("no margin")

    monkeypatch.setattr(SceneCell, "numbers", broken)
    failures = Falsify(write_space(tmp_path), method="random", budget=1)
    assert failures.refused == 1
    assert "RuntimeError: no margin" in failures.fault


@pytest.mark.slow
def test_a_single_range_is_searched_too(tmp_path):
    text = SPACE.replace("  humans.ana.pose[1]: [1, 4]\n", "")
    text = text.replace("  humans.ana.desired_speed: [0.6, 1.6]\n", "")
    text = text.replace("  humans.luis.behavior:", "# ")
    failures = Falsify(write_space(tmp_path, text), budget=3)
    assert [[*values] for values, _ in failures.runs] == [
        ["humans.ana.pose[0]"]
    ] * 3


def test_another_planner_is_tried(tmp_path):
    failures = Falsify(
        write_space(tmp_path), {"type": "pursuit"}, method="random", budget=3
    )
    # It sees people, and waits.
    assert failures.num_failures == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("humans.ana.pose[0]", "humans.eva.pose[0]"), "no member named"),
        (("[0.6, 1.6]", "[-2.0, 1.6]"), r"desired_speed.*must be"),
        (("desired_speed: [", "desired_sped: ["), "unknown key"),
        (("[regular, curious]", "[regular, curios]"), "curious"),
        (("scene.yaml", "nowhere.yaml"), "[Nn]o such file"),
        (
            ("humans.ana.pose[1]", "humans[0].pose[0]"),
            r"replaces what humans\.ana\.pose\[0\] sets",
        ),
        (
            ("humans.ana.pose[1]: [1, 4]", "humans.ana: {choices: [{}]}"),
            r"replaces what humans\.ana\.pose\[0\] sets",
        ),
    ],
)
def test_faults_of_the_space_are_told_before_anything_runs(
    tmp_path, change, words
):
    out = tmp_path / "out"
    with pytest.raises(ScenarioError, match=words) as caught:
        Falsify(write_space(tmp_path, SPACE.replace(*change)), out=out)
    assert not out.exists()
    if "nowhere" not in str(change):
        assert all(
            it.source.endswith("space.yaml") for it in caught.value.faults
        )
        assert all(it.line > 4 for it in caught.value.faults)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[0.6, 1.6]", "[1.6, 0.6]"), "must be a range"),
        (("[0.6, 1.6]", "{integers: [1.5, 2]}"), "must be a range"),
        (("[0.6, 1.6]", "{choices: []}"), r" \{choices: \[...\]\}, got"),
        (("[0.6, 1.6]", "[0.6, .inf]"), "must be a range"),
        (("robustness: collision", "robustness: colision"), "collision"),
        (("require:", "requires:"), "unknown key"),
    ],
)
def test_faults_of_the_file_have_their_line(tmp_path, change, words):
    path = write_space(tmp_path, SPACE.replace(*change))
    with pytest.raises(ScenarioError, match=rf"space\.yaml:\d+: .*{words}"):
        LoadSearchSpace(filename=path)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"method": "cmaes"}, "method: there is no 'cmaes'; did you mean"),
        ({"budget": 0}, "budget must be"),
        ({"polish": -1}, "polish must be"),
        ({"polish": 2}, r"polish=2 has no effect: .* here 3"),
        ({"seed": -1}, "seed must be"),
    ],
)
def test_bad_arguments_are_refused(tmp_path, arguments, words):
    with pytest.raises(ValueError, match=words):
        Falsify(write_space(tmp_path), **arguments)


def test_counts_may_be_those_of_numpy(tmp_path):
    space = write_space(tmp_path)
    out = tmp_path / "numpy"
    one = Falsify(
        space, method="random", budget=np.int64(2), seed=np.int64(3), out=out
    )
    assert len(one.runs) == 2
    with pytest.raises(
        TypeError, match=r"budget must be a whole number, got 2\.5"
    ):
        Falsify(space, budget=2.5)


def test_without_cma_it_tells_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)
    with pytest.raises(ImportError, match=r"hunav_drake\[falsify\].*random"):
        Falsify(write_space(tmp_path))


def test_of_several_robots_the_worst_counts():
    scenario = LoadScenario("three_robots")
    recording = RunTrial(
        dc.replace(
            scenario, simulation=dc.replace(scenario.simulation, duration=1.0)
        )
    ).recording
    found = scene_cell(scenario, "timeout").numbers(recording, 0)
    assert found["robustness"] == min(
        robustness_of("timeout").failing(it, 1.0).robustness
        for it in recording.robots
    )


def test_values_of_a_point():
    space = LoadSearchSpace(
        data="scenario: passing\nspace: {a: [1, 3], b: {integers: [0, 2]},"
        " c: {choices: [x, y]}}"
    )
    assert space.values(np.array([0.5, 0.4, 0.6])) == {"a": 2, "b": 1, "c": "y"}
    assert space.values(np.ones(3)) == {"a": 3.0, "b": 2, "c": "y"}
    assert space.values(np.zeros(3)) == {"a": 1.0, "b": 0, "c": "x"}


def test_values_of_narrow_ranges_differ_and_keep_within():
    space = LoadSearchSpace(
        data="scenario: passing\nspace: {a: [1.0000001, 1.0000004],"
        " b: [1.0e-8, 3.0e-8], c: [0.12345612, 0.5]}"
    )
    low, middle, high = (space.values(np.full(3, u)) for u in (0, 0.5, 1))
    assert low == {"a": 1.0000001, "b": 1.0e-8, "c": 0.12345612}
    assert middle == pytest.approx({"a": 1.00000025, "b": 2e-8, "c": 0.311728})
    assert high == {"a": 1.0000004, "b": 3.0e-8, "c": 0.5}


def test_a_chain_keeps_only_what_still_fails():
    """By a rule: who is called eva must be there, and her x above 1.2."""
    person = {"name": "eva", "pose": [1.23456, 2.0, 0.0], "behavior": "scared"}
    other = {"name": "bob", "pose": [5.0, 5.0, 0.0]}
    data = {"humans": [other, person], "simulation": {"duration": 60.0}}
    places = [("humans", 1, "pose", 0), ("humans", 0, "pose", 1)]
    ranges = {place: [0.0, 9.0] for place in places}
    failing = Failing(-0.1, 4.0, 1, 0.0, 1.0)
    chain = shrink(Shrinking(data, ranges, failing))
    trial = next(chain)
    while True:
        names = [it["name"] for it in trial["humans"]]
        eva = "eva" in names and trial["humans"][names.index("eva")]
        fails = bool(eva) and eva["pose"][0] > 1.2
        try:
            trial = chain.send(failing if fails else Failing(1, 0, 0, 0, 0))
        except StopIteration as stop:
            end = stop.value
            break
    (left,) = end.data["humans"]
    assert left == {"name": "eva", "pose": [1.23, 2.0, 0.0]}
    assert end.data["simulation"]["duration"] == 6.0
    assert [*end.ranges] == [("humans", 0, "pose", 0)]


def test_minimal_scenes_stay_in_the_space():
    space = SearchSpace(
        scenario="crossing",
        space={
            "robot.radius": [0.16, 0.34],
            "robot.max_speed": [0.84, 2],
            "crowd.decisions.sigma_heading": {"choices": [0.05, 0.15]},
        },
    )
    values = {
        "robot.radius": 0.256789,
        "robot.max_speed": 0.844321,
        "crowd.decisions.sigma_heading": 0.15,
    }
    failing = Failing(-0.1, 4.0, -1, math.nan, math.nan)
    chain = shrink(Shrinking(*_with_values(space, {}, values), failing))
    scene = next(chain)
    assert scene["robot"] == {"radius": 0.3, "max_speed": 0.84}
    assert scene["crowd"]["decisions"]["sigma_heading"] == 0.15


@pytest.mark.parametrize(
    ("bearing", "speed", "kind"),
    [
        (0.1, 1.0, "ahead, at walking pace"),
        (-0.3, 0.1, "ahead, slowly"),
        (1.6, 2.0, "on the left, fast"),
        (-0.8, -0.1, "ahead on the right, moving apart"),
        (math.pi, 1.0, "behind, at walking pace"),
    ],
)
def test_kinds_are_directions_and_speeds(bearing, speed, kind):
    assert kind_of_failure(Failing(-1.0, 1.0, 0, bearing, speed)) == kind


def test_scenes_of_an_earlier_search_are_removed(found, tmp_path):
    failures, _ = found
    for name in ("001.html", "017.yaml", "017.npz", "017.html", "mine.yaml"):
        (tmp_path / name).touch()
    (tmp_path / "rank.csv").write_text("scene,rho\n001,-0.2\n017,-0.1\n")
    # These are not of a search.
    for name in ("100.npz", "404.html", "512.yaml"):
        (tmp_path / name).touch()
    write_failures(dc.replace(failures, scenes=failures.scenes[:1]), tmp_path)
    assert sorted(it.name for it in tmp_path.iterdir()) == [
        *("001.npz", "001.yaml", "100.npz", "404.html", "512.yaml"),
        *("mine.yaml", "rank.csv", "tried.csv"),
    ]


def test_scenes_of_a_search_that_was_interrupted_are_removed(found, tmp_path):
    failures, _ = found
    scene = failures.scenes[0]
    odd = scene._replace(failing=scene.failing._replace(robustness=-9.0))
    with pytest.raises(RuntimeError, match="does not repeat itself"):
        write_failures(dc.replace(failures, scenes=[odd]), tmp_path)
    (tmp_path / "1000.yaml").touch()
    with (tmp_path / "rank.csv").open("a") as file:
        file.write("1000,-0.1\n")
    write_failures(dc.replace(failures, scenes=[]), tmp_path)
    names = sorted(it.name for it in tmp_path.iterdir())
    assert names == ["rank.csv", "tried.csv"]


def test_a_kind_without_a_person():
    nobody = Failing(-1.0, 1.0, -1, math.nan, math.nan)
    assert kind_of_failure(nobody) == "nobody"


def test_the_scene_file_says_the_robustness(found):
    failures, folder = found
    scenario = LoadScenario(folder / "001.yaml")
    recording = RunTrial(scenario).recording
    again = robustness_of("collision").failing(
        recording, scenario.simulation.duration
    )
    assert again == failures.scenes[0].failing
    assert len(recording_sha256(recording)) == 64


def test_people_are_named_in_overrides():
    scenario = LoadScenario(data=SCENE, overrides=["humans.luis.radius=0.2"])
    assert scenario.humans[1].radius == 0.2
