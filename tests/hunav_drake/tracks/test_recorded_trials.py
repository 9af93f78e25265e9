"""Trials with recorded people."""

import os
from pathlib import Path

import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    ReadTracks,
    RunTrial,
    SaveContext,
    SaveScenario,
    ScenarioError,
    SetTrialSeed,
    TransferContext,
)
from hunav_drake.scenario.named_files import files_sha256
from hunav_drake.scenario.population import draw_people, people_who_never_come
from hunav_drake.systems.crowd import MOTION_MODELS
from hunav_drake.systems.people.track_config import TracksConfig
from hunav_drake.systems.people.track_groups import walking_groups
from hunav_drake.systems.people.tracks import motion_at
from hunav_drake.systems.planning import PLANNERS
from hunav_drake.tracks.recorded import people_of
from tests.choices import shipped

FILE = Path(__file__).parents[2] / "data" / "recorded_corridor.csv"
SCENARIO = f"""\
name: recorded
world:
  walls:
    - {{type: box, center: [0, 5], size: [24, 0.2]}}
    - {{type: box, center: [0, -8], size: [24, 0.2]}}
population:
  tracks: {{file: {FILE}, mode: hand_over}}
robot: {{start: [-5, -1.0, 0], goal: [6, 0, 0]}}
evaluator: {{period: 0.05}}
simulation: {{duration: 14.0}}
"""
ONE = f"""\
humans:
  - track: {{file: {FILE}, id: 4}}
  - pose: [0, 3, 0]
"""


def load(*overrides, data=SCENARIO):
    return LoadScenario(data=data, overrides=overrides)


def result_at(scenario, diagram, context):
    simulator = MakeTrialSimulator(diagram, context)
    simulator.AdvanceTo(scenario.simulation.duration)
    return GetTrialResult(scenario, diagram, simulator.get_context())


@pytest.fixture(scope="module")
def trial():
    """The scenario, its diagram, and how its trial ends."""
    scenario = load()
    diagram = MakeTrialDiagram(scenario)
    context = MakeTrialSimulator(diagram).get_context().Clone()
    return scenario, diagram, result_at(scenario, diagram, context)


def test_blind_people_are_those_of_the_file():
    result = RunTrial(load("population.tracks.mode=blind"))
    recording = result.recording
    for i, track in enumerate(ReadTracks(FILE).people):
        here = np.isfinite(recording.humans[:, i, 0])
        times = recording.times
        first, last = track.times[[0, -1]]
        within = (times >= first - 1e-9) & (times <= last + 1e-9)
        assert (here == within).all()
        motion = motion_at(track, times[here])
        away = abs(recording.humans[here, i, :2] - motion.positions)
        assert away.max() < 1e-12
    assert recording.human_names[3] == "recorded_4"
    assert result.metrics["replay_ade"] < 1e-12
    assert result.metrics["hand_overs"] == result.metrics["reactive_share"] == 0


def test_people_are_handed_over_and_their_errors_told(trial):
    scenario, _, result = trial
    metrics, recording = result.metrics, result.recording
    assert metrics["hand_overs"] >= 2
    assert 0 < metrics["reactive_share"] < 1
    assert 0 < metrics["replay_ade_at_phase"] < metrics["replay_ade"] < 1
    mode = recording.replay[..., 0]
    switches = (np.diff(mode, axis=0) != 0) & (mode[1:] > 0) & (mode[:-1] > 0)
    change = np.hypot(*np.diff(recording.humans[..., 3:5], axis=0).T).T
    assert switches.sum() > metrics["hand_overs"]
    assert change[switches & (mode[1:] == 1)].max() < 0.15
    # The motion model takes over with forces of its own, up to its limit.
    limit = scenario.crowd.max_acceleration * 0.05
    assert change[switches].max() < limit + 1e-9
    steps = result.steps
    assert steps["hand_overs"].iloc[-1] == metrics["hand_overs"]


def test_errors_by_hand(trial):
    _, _, result = trial
    recording = result.recording
    errors, lasts = [], []
    for i, track in enumerate(ReadTracks(FILE).people):
        times = recording.times
        known = np.isfinite(recording.humans[:, i, 0])
        known &= (times >= track.times[0] - 1e-9) & (
            times <= track.times[-1] + 1e-9
        )
        places = motion_at(track, times[known]).positions
        away = np.hypot(*(recording.humans[known, i, :2] - places).T)
        errors.append(away)
        lasts.append(away[-1])
    ade = np.concatenate(errors).mean()
    assert result.metrics["replay_ade"] == pytest.approx(ade, abs=1e-12)
    fde = np.mean(lasts)
    assert result.metrics["replay_fde"] == pytest.approx(fde, abs=1e-12)


def test_metrics_of_recorded_people_are_those_of_such_trials_only():
    result = RunTrial(load("simulation.duration=0.5"))
    assert "replay_ade" in result.metrics
    assert result.recording.replay.shape[1:] == (5, 3)
    other = RunTrial(
        LoadScenario("passing", overrides=["simulation.duration=0.5"])
    )
    assert "replay_ade" not in other.metrics
    assert other.recording.replay is None


@pytest.mark.slow
def test_a_trial_repeats(trial):
    scenario, diagram, result = trial
    assert RunTrial(scenario).recording == result.recording
    context = diagram.CreateDefaultContext()
    simulator = MakeTrialSimulator(diagram, context)
    simulator.AdvanceTo(3.0)
    SetTrialSeed(diagram, context, 5)
    again = result_at(scenario, diagram, context)
    assert again.recording == result.recording


# In the middle of a hand-over, of a return, and of both.
@pytest.mark.slow
@pytest.mark.parametrize("time", [2.0, 3.05, 4.5, 6.0])
def test_forks_and_saved_contexts_have_the_same_future(trial, time, tmp_path):
    scenario, diagram, result = trial
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    context = simulator.get_context()
    k = int(np.searchsorted(result.recording.times, time))
    modes = set(result.recording.replay[k, :, 0])
    assert modes >= {1.0, 2.0}
    file = SaveContext(diagram, context, tmp_path / "saved.npz")
    other = MakeTrialDiagram(scenario)
    for one, fork in (
        (diagram, context.Clone()),
        (other, LoadContext(other, file)),
        (other, TransferContext(diagram, context, other)),
    ):
        found = result_at(scenario, one, fork)
        assert found.recording == result.recording
        assert found.metrics.equals(result.metrics)


def test_a_context_of_another_recording_is_refused(trial, tmp_path):
    _, diagram, _ = trial
    file = SaveContext(
        diagram, diagram.CreateDefaultContext(), tmp_path / "saved.npz"
    )
    moved = tmp_path / FILE.name
    moved.write_text(FILE.read_text().replace("0.4,1,", "0.41,1,"))
    other = load(f"population.tracks.file={moved}")
    with pytest.raises(ValueError, match="memory recordings"):
        LoadContext(MakeTrialDiagram(other), file)


def test_the_content_of_the_file_counts_for_a_result(tmp_path):
    moved = tmp_path / FILE.name
    moved.write_bytes(FILE.read_bytes())
    scenario = load(f"population.tracks.file={moved}")
    first = files_sha256(scenario)
    assert first == files_sha256(load())
    moved.write_text(FILE.read_text().replace("0.4,1,", "0.41,1,"))
    assert files_sha256(scenario) != first
    own = load(data=ONE)
    assert files_sha256(own)


def test_a_changed_file_is_read_anew(tmp_path):
    moved = tmp_path / FILE.name
    moved.write_bytes(FILE.read_bytes())
    scenario = load(f"population.tracks.file={moved}")
    assert len(draw_people(scenario)) == 5
    lines = FILE.read_text().splitlines()
    kept = [line for line in lines if ",5," not in line]
    moved.write_text("\n".join(kept) + "\n")
    assert len(draw_people(scenario)) < 5


def test_paths_are_relative_to_the_scenario(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "people.csv").write_bytes(FILE.read_bytes())
    file = tmp_path / "own.yaml"
    file.write_text(
        "humans: [{track: {file: data/people.csv, id: 4, end: 9, start: 1}}]\n"
        "population: {tracks: {file: data/people.csv, on: 1.5, off: 2.5}}\n"
        "robot: {start: [-5, -1, 0]}\n"
    )
    scenario = LoadScenario(file)
    assert scenario.humans[0].track.file == str(tmp_path / "data/people.csv")
    assert len(draw_people(scenario)) == 6
    text = SaveScenario(scenario, tmp_path / "again.yaml")
    assert "file: data/people.csv" in text
    assert "pose" not in text
    again = LoadScenario(tmp_path / "again.yaml")
    assert again.population.tracks == scenario.population.tracks
    assert again.population.tracks.off == 2.5


def test_listed_and_recorded_people_go_together():
    scenario = load("simulation.duration=6", data=ONE)
    result = RunTrial(scenario)
    rows = result.recording.humans
    first = ReadTracks(FILE).people[3].times[0]
    assert np.isnan(rows[0, 0]).all()
    after = result.recording.times >= first
    assert np.isfinite(rows[after, 0]).all()
    assert np.isfinite(rows[:, 1]).all()
    assert (result.recording.replay[:, 1] == [0, -1, -1]).all()


def test_a_recorded_person_needs_no_pose_and_others_do():
    person = load(data=ONE).humans[0]
    assert person.pose == (0, 0, 0)
    assert draw_people(load(data=ONE))[0].pose[:2] == pytest.approx((2.0, 4.0))
    with pytest.raises(ScenarioError, match=r"humans\[0\]\.pose: is missing"):
        load(data="humans: [{radius: 0.3}]")


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["population.tracks.file=none.csv"], "none.csv: No such file"),
        (
            ["population.tracks.mode=dead"],
            "mode: unknown value 'dead'; valid: blind",
        ),
        (["population.tracks.off=1.0"], "off must be at least on"),
        (["population.tracks.end=0.0"], "end must be after start"),
        (["population.tracks.start=99.0"], "nobody is there from 99 s on"),
        (["population.tracks.fps=10"], "fps has no part in csv"),
        (["population.tracks.fsp=3"], "did you mean 'fps'"),
        (["population.tracks.format=svg"], "format: there is no 'svg'"),
        (["robot.type=pmb2"], "a physical robot needs recorded people with"),
        (
            ["humans=[{name: recorded_2, pose: [0, 3, 0]}]"],
            "must not give a name that somebody has",
        ),
        (
            [f"humans=[{{track: {{file: {FILE}, id: 2}}}}]"],
            r"person 2 again, whom humans\[0\] .*track has",
        ),
    ],
)
def test_faults_have_a_place_and_a_remedy(overrides, words):
    with pytest.raises(ScenarioError, match=words) as caught:
        load(*overrides)
    assert len(str(caught.value).splitlines()) <= 2


@pytest.mark.parametrize(
    ("person", "words"),
    [
        ("track: {file: FILE, id: 9}", "no person 9; there are 1, 2, 3"),
        ("track: {file: FILE, id: -1}", r"track\.id: must be"),
        ("track: {file: FILE}", r"track\.id: is missing"),
        ("track: {file: FILE, id: 1}, goals: [[1, 2]]", "goals: must not be"),
        ("track: {file: FILE, id: 1}, pose: [1, 2, 0]", "pose: must not be"),
        ("track: {file: FILE, id: 1}, desired_speed: 0", "speed: must not be"),
        (
            "track: {file: FILE, id: 1, mode: blind}, behavior: scared",
            "must be regular for a person who follows",
        ),
    ],
)
def test_faults_of_a_persons_track(person, words):
    data = f"humans: [{{{person.replace('FILE', str(FILE))}}}]\n"
    with pytest.raises(ScenarioError, match=words):
        load(data=data + "robot: {start: [-9, 4, 0]}\n")


@pytest.mark.parametrize("row", ["0,-1,2,2", "0,1,2e5,2"])
def test_people_who_cannot_be_replayed_are_told_by_the_check(row, tmp_path):
    file = tmp_path / "people.csv"
    file.write_text(f"time,id,x,y\n{row}\n")
    with pytest.raises(ScenarioError, match=r"tracks: .* cannot be replayed"):
        load(f"population.tracks.file={file}")


def test_people_who_never_come_are_told():
    assert people_who_never_come(load()) == ""
    # Person 4 comes at 1.2 s.
    assert "1 of 5" in people_who_never_come(load("simulation.duration=1"))
    note = people_who_never_come(load("simulation.duration=1", data=ONE))
    assert "1 of 1 recorded people are not there" in note


def test_a_group_may_have_the_largest_number():
    most = "humans=[{pose: [0, 3, 0], group_id: 2147483647}]"
    assert draw_people(load(most))[2].group_id == 0


def test_a_configuration_in_python_tells_its_fault():
    with pytest.raises(ValueError, match=r"^TracksConfig\(\): off must be"):
        TracksConfig(file="people.csv", on=4.0)


@pytest.mark.slow
def test_a_physical_robot_meets_people_who_stay():
    scenario = load(
        "humans[0].track.id=1",
        "humans[0].track.mode=blind",
        "robot={type: pmb2, start: [-2, 2, 0], goal: [3, 2, 0]}",
        "simulation.duration=3",
        data=ONE,
    )
    result = RunTrial(scenario)
    track = ReadTracks(FILE).people[0]
    places = motion_at(track, result.recording.times).positions
    # The body in the plant follows within a step.
    away = np.hypot(*(result.recording.humans[:, 0, :2] - places).T)
    assert away.max() < 1e-12


def test_people_who_walk_together_are_groups():
    tracks = ReadTracks(FILE)
    assert walking_groups(tracks) == [-1, 0, 0, -1, -1]
    people = draw_people(load("humans=[{pose: [0, 3, 0], group_id: 4}]"))
    assert [it.group_id for it in people] == [4, -1, 5, 5, -1, -1]
    config = load().population.tracks
    assert [it.group_id for it in people_of(config)] == [-1, 0, 0, -1, -1]


def test_drawn_people_keep_their_numbers_of_groups():
    scenario = load(
        "population.cohorts=[{number: 4, start: [{rectangle: [-4, -7, 4, -5]}],"
        " group_sizes: [0, 1]}]"
    )
    ids = [it.group_id for it in draw_people(scenario)]
    assert ids[1] == ids[2] == 0
    assert len(set(ids[5:])) == 2
    assert 0 not in ids[5:]


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting",
    [
        *(f"planner.type={name}" for name in sorted(shipped(PLANNERS))),
        *(f"crowd.model={{type: {name}}}" for name in shipped(MOTION_MODELS)),
        "crowd.profile=hunavsim",
        "crowd.separate_trees=true",
        "crowd.separate_trees=false",
        "crowd.keep_apart=false",
        "crowd.route_planning=false",
        "simulation.time_step=0.01",
        "simulation.time_step=0.025",
        "simulation.start_jitter=0.2",
        "planner.sees={type: visible}",
        "planner.sees={type: lidar}",
        "sensors=[{type: lidar}]",
        "population.tracks.smooth=0.0",
        "population.tracks.mode=reactive",
    ],
)
def test_recorded_people_go_with_every_other_choice(setting):
    overrides = [setting, "simulation.duration=1.5", "evaluator.period=0.1"]
    if setting == "planner.type=mppi":
        overrides.append("planner.batch_size=60")
    result = RunTrial(load(*overrides))
    recording = result.recording
    assert np.isfinite(recording.humans[:, 0]).all()
    assert np.isnan(recording.humans[0, 3]).all()
    if "reactive" not in setting and "smooth" not in setting:
        track = ReadTracks(FILE).people[4]
        away = recording.humans[:, 4, :2] - track.positions[0]
        assert abs(away).max() < 0.02


def test_people_come_at_sources_beside_recorded_ones():
    scenario = load(
        "population.seed=1",
        "population.sources=[{name: door, rate: 0.6, max_present: 5,"
        " start: [{rectangle: [-4, -7, 0, -5]}], sinks: {exit: 1}}]",
        "population.sinks=[{name: exit, area: {rectangle: [5, -7, 6, -5]}}]",
        "simulation.duration=8",
    )
    result = RunTrial(scenario)
    came = np.isfinite(result.recording.humans[..., 0]).any(axis=0)
    assert came[:5].all()
    assert came[5:].any()
    assert (result.recording.replay[:, 5:, 0] == 0).all()


ZARA = (
    Path(os.environ.get("HUNAV_REFERENCE", "../shared/reference")).resolve()
    / "tracks/zara01.txt"
)


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["blind", "hand_over", "reactive"])
def test_zara01_is_replayed(mode):
    if not ZARA.exists():
        pytest.skip(f"no recorded people at {ZARA}")
    scenario = load(
        f"population.tracks={{file: {ZARA}, mode: {mode}, end: 30.0}}",
        "world={}",
        "robot={start: [0, 4, 0], goal: [14, 6, 0]}",
        "simulation.duration=25",
    )
    result = RunTrial(scenario)
    mode_of = result.recording.replay[..., 0]
    change = np.hypot(*np.diff(result.recording.humans[..., 3:5], axis=0).T).T
    follows = (mode_of[1:] == 1) & (mode_of[:-1] == 1)
    if follows.any():
        assert change[follows].max() < 0.15
    switches = (mode_of[1:] != mode_of[:-1]) & (mode_of[1:] > 0)
    switches &= mode_of[:-1] > 0
    assert switches.any() == (mode != "blind")
    if mode == "hand_over":
        assert change[switches].max() < 0.15
    assert (result.metrics["replay_ade"] < 1e-12) == (mode == "blind")
