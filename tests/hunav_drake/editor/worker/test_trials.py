import csv
import json
import math

import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.editor.worker.channel import Stopped
from hunav_drake.editor.worker.trials import Trials

TEXT = """
name: short
humans:
- {name: ana, pose: [2, 0.1, 3.14], goals: [[-3, 0]], behavior: curious}
- {name: bo, pose: [2, 1, 3.14], goals: [[-3, 1]]}
robot: {start: [-2, 0, 0], goal: [2.5, 0, 0]}
planner: pursuit
simulation: {duration: 12.0}
"""


class FakeChannel:
    """Keeps what is sent; stops the run after some looks."""

    def __init__(self, stop_after=math.inf):
        self.sent = []
        self.left = stop_after

    def send(self, message):
        self.sent.append(json.loads(json.dumps(message, allow_nan=False)))

    def look(self):
        self.left -= 1
        if self.left < 0:
            raise Stopped

    def of(self, kind):
        return [it for it in self.sent if it["kind"] == kind]


def _message(out, **changes):
    return {
        "do": "run",
        "run": 1,
        "seed": 3,
        "planner": None,
        "text": TEXT,
        "folder": None,
        "filename": None,
        "name": None,
        "speed": 0.0,
        "out": str(out),
        **changes,
    }


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A run, and where its files are."""
    out = tmp_path_factory.mktemp("out")
    channel = FakeChannel()
    Trials(channel).run(_message(out))
    return channel, out


def test_metrics_are_those_of_run_trial(done):
    channel, _ = done
    (result,) = channel.of("result")
    expected = RunTrial(LoadScenario(data=TEXT), 3)
    assert result["end_reason"] == expected.end_reason
    assert result["end_time"] == expected.end_time
    assert list(result["metrics"]) == list(expected.metrics.index)
    for name, value in expected.metrics.items():
        got = result["metrics"][name]
        assert (got is None) if math.isnan(value) else float(got) == value


def test_frames_show_everybody_and_how_far_it_is(done):
    channel, _ = done
    frames = channel.of("frame")
    assert len(frames) >= 2
    times = [it["time"] for it in frames]
    assert times == sorted(times)
    assert frames[0]["robots"] == [[-2.0, 0.0, 0.0]]
    assert all(len(it["people"]) == 2 for it in frames)
    assert 0 <= frames[0]["progress"] <= frames[-1]["progress"] <= 1
    assert frames[-1]["time"] == channel.of("result")[0]["end_time"]


def test_paths_lead_from_start_to_end(done):
    channel, _ = done
    (result,) = channel.of("result")
    paths = result["paths"]
    assert len(paths["times"]) == len(paths["robots"]) == len(paths["people"])
    assert paths["times"][-1] == pytest.approx(result["end_time"])
    assert paths["robots"][0] == [[-2.0, 0.0, 0.0]]


def test_several_robots_are_in_all_frames_and_take_a_planner(tmp_path):
    text = """
    robots:
      - {name: anna, robot: {start: [-2, 0, 0], goal: [2, 0, 0]}}
      - {name: bob, robot: {start: [-2, 2, 0], goal: [2, 2, 0]}}
    simulation: {duration: 1.0}
    """
    channel = FakeChannel()
    message = _message(tmp_path, text=text, planner="pursuit")
    Trials(channel).run(message)
    (result,) = channel.of("result")
    assert result["planner"] == "pursuit"
    for robots in (
        channel.of("frame")[0]["robots"],
        result["paths"]["robots"][0],
    ):
        assert robots == [[-2.0, 0.0, 0.0], [-2.0, 2.0, 0.0]]


@pytest.mark.slow
def test_the_planner_of_the_scenario_keeps_its_parameters(tmp_path):
    slow = "planner: {type: pursuit, cruise_speed: 0.2}"
    text = TEXT.replace("planner: pursuit", slow).replace("12.0", "2.0")
    channel = FakeChannel()
    trials = Trials(channel)
    for planner in (None, "pursuit", "sfm"):
        trials.run(_message(tmp_path, text=text, planner=planner))
    own, same, other = channel.of("result")
    assert own["metrics"] == same["metrics"] != other["metrics"]
    kept = [it["own_planner"] for it in (own, same, other)]
    assert kept == [True, True, False]


def test_files_of_the_run_are_written(done):
    channel, out = done
    (idle,) = channel.of("idle")
    folder = out / "runs" / "short_pursuit_3"
    assert idle["folder"] == str(folder)
    assert "replay.html" in (folder / "report.html").read_text()
    assert (folder / "replay.html").stat().st_size > 100_000
    with (folder / "steps.csv").open() as file:
        assert len(list(csv.reader(file))) > 10
    saved = LoadScenario(filename=folder / "scenario.yaml")
    assert saved.simulation.seed == 3


@pytest.mark.slow
def test_another_seed_or_planner_is_another_run(tmp_path):
    channel = FakeChannel()
    trials = Trials(channel)
    for changes in ({"seed": 1}, {"seed": 2}, {"planner": "sfm"}):
        trials.run(_message(tmp_path, **changes))
    ends = [(it["planner"], it["seed"]) for it in channel.of("result")]
    assert ends == [("pursuit", 1), ("pursuit", 2), ("sfm", 3)]
    for seed, planner, result in zip(
        *((1, 2, 3), ("pursuit", "pursuit", "sfm"), channel.of("result")),
        strict=True,
    ):
        scenario = LoadScenario(data=TEXT, overrides={"planner.type": planner})
        expected = RunTrial(scenario, seed).metrics["path_length"]
        assert result["metrics"]["path_length"] == expected


@pytest.mark.slow
def test_each_seed_draws_its_own_people(tmp_path):
    area = "{rectangle: [-1, 2, 3, 5]}"
    crowd = f"population: {{cohorts: [{{number: 2, start: [{area}]}}]}}\n"
    channel = FakeChannel()
    trials = Trials(channel)
    seeds = (1, 2, None, 1)
    for seed in seeds:
        message = _message(tmp_path, seed=seed, text=TEXT + crowd)
        trials.run(message)
    scenario = LoadScenario(data=TEXT + crowd)
    for seed, result in zip(seeds, channel.of("result"), strict=True):
        expected = RunTrial(scenario, seed)
        people = expected.recording.humans[0, :, :2].round(3)
        starts = [person[:2] for person in result["paths"]["people"][0]]
        assert starts == people.tolist()
        # Without a seed it is the scenario's, whatever was run before.
        assert result["seed"] == (seed or 0)


def test_a_stopped_run_has_no_result(tmp_path):
    channel = FakeChannel(stop_after=1)
    Trials(channel).run(_message(tmp_path))
    assert not channel.of("result")
    assert channel.of("idle") == [{"kind": "idle", "folder": None}]
    assert not [*tmp_path.iterdir()]


def test_a_run_that_is_not_possible_says_why(tmp_path):
    channel = FakeChannel()
    trials = Trials(channel)
    trials.run(_message(tmp_path, text=TEXT.replace("curious", "curios")))
    (result,) = channel.of("result")
    assert result["end_reason"] == "failed"
    assert "curious" in result["error"]
    assert "\n" not in result["error"]
    trials.run(_message(tmp_path))
    assert channel.of("result")[1]["end_reason"] != "failed"


@pytest.mark.slow
def test_it_is_called_as_its_file(tmp_path):
    channel = FakeChannel()
    text = TEXT.replace("name: short\n", "")
    message = _message(tmp_path, text=text, filename="/somewhere/lobby.yaml")
    Trials(channel).run(message)
    (idle,) = channel.of("idle")
    assert idle["folder"].endswith("lobby_pursuit_3")
