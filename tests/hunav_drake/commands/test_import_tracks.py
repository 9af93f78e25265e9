"""`hunav import --tracks`."""

from pathlib import Path

import numpy as np
import pytest

from hunav_drake import LoadScenario, ReadTracks, RunTrial, Tracks, WriteTracks
from hunav_drake.commands.cli import main
from hunav_drake.scenario.recorded_scenario import import_tracks
from hunav_drake.systems.people.track_config import TracksConfig
from hunav_drake.systems.people.tracks import Track

FILE = Path(__file__).parents[2] / "data" / "recorded_corridor.csv"


def test_writes_a_scenario_that_runs(tmp_path, capsys):
    output = tmp_path / "own.yaml"
    main(["import", "--tracks", str(FILE), "--on", "1.5", "-o", str(output)])
    assert "Wrote 5 recorded people" in capsys.readouterr().out
    scenario = LoadScenario(output)
    assert scenario.population.tracks.file == str(FILE)
    assert scenario.population.tracks.on == 1.5
    assert scenario.simulation.duration == 12.0
    # Along the longer side.
    start, goal = scenario.robot.start, scenario.robot.goal
    assert goal[0] - start[0] > 8
    assert start[1:] == goal[1:]
    main(["check", str(output)])
    assert "ok (5 people" in capsys.readouterr().out
    scenario.simulation.duration = 0.5
    assert RunTrial(scenario).recording.num_humans == 5


def test_a_recording_that_begins_late_begins_at_once(tmp_path):
    times = np.arange(100.0, 105.0, 0.4)
    up = np.column_stack([np.zeros_like(times), 1.2 * (times - 100)])
    file = tmp_path / "late.csv"
    WriteTracks(Tracks((Track(1, times, up),)), file)
    scenario = import_tracks(TracksConfig(file=str(file)))
    assert scenario.population.tracks.start == 100.0
    assert scenario.simulation.duration == pytest.approx(4.8)
    assert scenario.robot.start[2] == pytest.approx(np.pi / 2, abs=1e-3)
    given = import_tracks(
        TracksConfig(file=str(file), start=101.0), start=(1, 2, 3)
    )
    assert given.population.tracks.start == 101.0
    assert given.robot.start == (1, 2, 3)


def test_the_robot_starts_beside_whoever_is_in_its_way(tmp_path):
    times = np.arange(0.0, 20.0, 0.4)
    x = np.linspace(0, 10, len(times))
    rows = [np.column_stack([x, np.full_like(x, y)]) for y in (-2, 2)]
    # One stands where the robot would start, the other comes later.
    spot = import_tracks(
        TracksConfig(file=written(tmp_path / "a.csv", times, rows))
    ).robot.start
    stands = np.tile(spot[:2], (len(times), 1))
    file = written(tmp_path / "b.csv", times, [*rows, stands])
    start = import_tracks(TracksConfig(file=file)).robot.start
    assert start[0] == pytest.approx(spot[0], abs=0.3)
    assert abs(start[1]) == pytest.approx(1.0, abs=0.3)
    assert np.hypot(*np.subtract(start[:2], spot[:2])) >= 0.99
    # The trial begins at 3.3 s, and the first one comes at 3.38 s.
    file = written(tmp_path / "c.csv", times + 3.38, [*rows, stands])
    assert import_tracks(TracksConfig(file=file)).robot.start == start


def written(path, times, rows):
    tracks = [Track(i, times, row) for i, row in enumerate(rows)]
    WriteTracks(Tracks(tuple(tracks)), path)
    return str(path)


def test_outlines_become_walls(monkeypatch):
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    tracks = Tracks(ReadTracks(FILE).people, (square,))
    monkeypatch.setattr(
        "hunav_drake.scenario.recorded_scenario.load_tracks", lambda _: tracks
    )
    (wall,) = import_tracks(TracksConfig(file=str(FILE))).world.walls
    assert wall.points[0] == wall.points[-1] == (0.0, 0.0)
    assert len(wall.points) == 4


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give either the agents.yaml of HuNavSim, or --tracks"),
        (["a.yaml", "--tracks", "b.csv"], "give either"),
        (["--tracks", "none.csv"], "none.csv: No such file"),
        (["--tracks", str(FILE), "--profile", "hunavsim"], "leave them out"),
        (["--tracks", str(FILE), "--on", "9"], "off must be at least on"),
        (["--tracks", str(FILE), "--from", "99"], "from 0 to 12 s"),
    ],
)
def test_faults_are_told_in_a_line(arguments, words, capsys):
    assert main(["import", *arguments]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert len(told.splitlines()) == 1
