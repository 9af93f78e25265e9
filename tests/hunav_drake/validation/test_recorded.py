"""Motion models against recorded people."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from hunav_drake import ReadTracks, Tracks, WriteTracks
from hunav_drake.commands.cli import main
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people.tracks import Track
from hunav_drake.validation.recorded import (
    FUTURE,
    PAST,
    STEP,
    CrowdPrediction,
    Sample,
    _difference,
    _off_by_density,
    _times_to_collision,
    constant_velocity,
    judge_recorded,
    recorded_overlap,
    sample_of,
    speeds_by_density,
    windows_of,
)

SCENES = (
    Path(os.environ.get("HUNAV_REFERENCE", "../shared/reference")).resolve()
    / "tracks"
)


def walkers(count=3, rows=40, apart=2.0, speed=1.2):
    """People who walk side by side, straight on."""
    times = np.arange(rows) * STEP
    return Tracks(
        tuple(
            Track(
                i + 1,
                times,
                np.column_stack([speed * times, np.full(rows, apart * i)]),
            )
            for i in range(count)
        )
    )


def test_windows_have_those_who_are_there_throughout():
    tracks = walkers(2, 44)
    late = Track(9, np.arange(10, 60) * STEP, np.zeros((50, 2)))
    windows = list(windows_of(Tracks((*tracks.people, late))))
    assert [len(it) for it in windows] == [2, 3, 3, 1]
    assert windows[0].shape == (2, PAST + FUTURE, 2)
    assert np.allclose(windows[1][0, 0], [1.2 * 12 * STEP, 0.0])
    assert not list(windows_of(walkers(2, 19)))


@pytest.mark.parametrize("goal", ["true", "ahead"])
def test_straight_walkers_are_predicted_by_all(goal):
    windows = list(windows_of(walkers(apart=10.0)))
    models = {
        "constant": constant_velocity,
        "crowd": CrowdPrediction(CrowdConfig()),
    }
    for score in judge_recorded("lane", windows, models, [goal]):
        assert score.people == 3 * len(windows)
        assert score.ade[0] < 0.03
        assert score.fde[0] < 0.05
        assert score.overlap == 0


def test_distances_are_those_of_the_recording():
    """Who turns by a right angle is 4.8 s x 1 m/s x sqrt 2 away at the end."""
    times = np.arange(PAST + FUTURE) * STEP
    ahead = np.minimum(times, (PAST - 1) * STEP)
    place = np.column_stack([ahead, times - ahead])
    windows = list(windows_of(Tracks((Track(1, times, place),))))
    models = {"constant": constant_velocity}
    (score,) = judge_recorded("turn", windows, models, ["ahead"])
    side = np.arange(1, FUTURE + 1) * STEP
    assert score.ade[0] == pytest.approx(np.mean(np.sqrt(2) * side), rel=1e-6)
    assert score.fde[0] == pytest.approx(np.sqrt(2) * FUTURE * STEP, rel=1e-6)


def test_overlaps_are_told():
    assert recorded_overlap(list(windows_of(walkers(2, apart=0.3)))) == 1.0
    assert recorded_overlap(list(windows_of(walkers(2, apart=0.5)))) == 0.0


def test_times_to_collision():
    offsets = np.array([[2.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.1, 0.0]])
    velocities = np.array([[-2.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [-1.0, 0.0]])
    times = _times_to_collision(offsets, velocities)
    # Bodies of 0.2 m meet 0.4 m apart; the third passes, the last overlap.
    assert times.tolist() == [pytest.approx(0.8), np.inf, np.inf, np.inf]


def test_differences_of_distributions():
    values = np.arange(10.0)
    assert _difference(values, values) == 0
    assert _difference(values, values + 100) == 1
    assert np.isnan(_difference(values, values[:0]))


def test_local_densities_are_those_of_others_within_2_m():
    sample = sample_of(list(windows_of(walkers(3, apart=1.5))))
    beside = sample.densities.reshape(-1, 3, FUTURE) * 4 * np.pi
    assert np.allclose(beside, np.array([1, 2, 1])[:, None])
    assert np.allclose(sample.speeds, 1.2)


def test_mean_speeds_by_density():
    none = np.zeros(0)

    def walking(*speeds):
        """30 people each at 0.1, 0.4 and 0.6 persons/m^2, and few at 2."""
        densities = np.append(np.repeat([0.1, 0.4, 0.6], 30), [2.0] * 5)
        speeds = np.append(np.repeat(speeds, 30), [9.0] * 5)
        return Sample(none, speeds, densities, none, none)

    free = walking(1.3, 1.0, 0.8)
    densities, means = speeds_by_density(free)
    assert densities.tolist() == [*np.arange(0.125, 2.2, 0.25)]
    assert means[:3] == pytest.approx([1.3, 1.0, 0.8])
    assert np.isnan(means[3:]).all()
    assert _off_by_density(free, free) == 0
    off = _off_by_density(free, walking(1.3, 0.7, 0.8))
    assert off == pytest.approx(0.1)
    assert np.isnan(_off_by_density(free, Sample(*[none] * 5)))


def test_bodies_are_as_large_as_told():
    """People who walk side by side stay where bodies have room."""
    windows = list(windows_of(walkers(2, apart=0.45)))
    config, none = CrowdConfig(), {"social_factor": 0.0}
    models = {
        "narrow": CrowdPrediction(config, none),
        "wide": CrowdPrediction(config, none, radius=0.25),
    }
    narrow, wide = judge_recorded("pair", windows, models, ["true"])
    assert narrow.ade[0] < 0.01
    assert wide.sample.nearest.min() > 0.499 > narrow.sample.nearest.min()


def test_without_a_social_force_people_do_not_avoid():
    windows = list(windows_of(walkers(2, apart=0.6)))
    config = CrowdConfig(profile="hunavsim")
    models = {
        "hunavsim": CrowdPrediction(config),
        "none": CrowdPrediction(config, {"social_factor": 0.0}),
    }
    default, none = judge_recorded("pair", windows, models, ["true"])
    assert none.ade[0] < 0.05 < default.ade[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "fps", "old", "free"),
    [
        # (The recording has 15 frames a second.)
        ("eth", 15, (0.242, 0.191), (0.207, 0.071)),
        ("zara01", None, (0.209, 0.215), (0.162, 0.065)),
        ("students003", None, (0.348, 0.420), (0.281, 0.256)),
    ],
)
def test_scores_of_recorded_streets(scene, fps, old, free):
    """Near what was measured by other means, in other windows.

    Bodies of 0.25 m, as there. The default is nearer to the recording than that
    of version 0.1, by 15 % on the whole way and by 25 % at its end; and little
    worse than people who avoid nobody. Of bodies of 0.2 m, which can come as
    near as people do, it is little worse than who goes straight on if no goal
    is known.
    """
    path = SCENES / f"{scene}.txt"
    if not path.exists():
        pytest.skip("the recorded people are not here")
    windows = list(windows_of(ReadTracks(path, fps=fps)))
    before = CrowdConfig(profile="hunav_drake_0.1")
    models = {
        "constant": constant_velocity,
        "old": CrowdPrediction(before, radius=0.25),
        "free": CrowdPrediction(before, {"social_factor": 0.0}, radius=0.25),
        "default": CrowdPrediction(CrowdConfig(), radius=0.25),
        "narrow": CrowdPrediction(CrowdConfig()),
    }
    scores = {
        (it.model, it.goal): it for it in judge_recorded(scene, windows, models)
    }
    for name, expected in (("old", old), ("free", free)):
        score = scores[name, "true"]
        mean, low, high = score.ade
        assert low < mean < high
        assert (mean, score.fde[0]) == pytest.approx(expected, abs=0.02)
    now, was, none = (
        scores[name, "true"] for name in ("default", "old", "free")
    )
    assert now.overlap == 0
    assert now.ade[0] < min(0.85 * was.ade[0], 1.1 * none.ade[0])
    assert now.fde[0] < min(0.75 * was.fde[0], 1.1 * none.fde[0])
    for name, limit in (("default", 1.03), ("narrow", 1.025)):
        now, straight = (scores[it, "ahead"] for it in (name, "constant"))
        assert now.ade[0] < limit * straight.ade[0]
        assert now.fde[0] < limit * straight.fde[0]
    now, was = scores["narrow", "true"], scores["old", "true"]
    assert now.ade[0] < 0.85 * was.ade[0]
    assert now.fde[0] < 0.75 * was.fde[0]


@pytest.mark.slow
def test_the_command_writes_tables(tmp_path, capsys):
    file = tmp_path / "lane.csv"
    WriteTracks(walkers(), file)
    page = tmp_path / "page.md"
    words = ["validate", "--tracks", str(file), "--model", "orca"]
    assert main([*words, "--markdown", str(page), "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "lane: 6 paths" in told
    assert "constant_velocity" in told
    assert "| orca |" in page.read_text()
    assert "](page_1.svg)" in page.read_text()
    assert "<svg" in (tmp_path / "page_1.svg").read_text()
    rows = (tmp_path / "recorded.csv").read_text().splitlines()
    assert len(rows) == 1 + 4
    assert main([*words, "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)
    assert [it["model"] for it in scores[:2]] == ["constant_velocity", "orca"]
    assert main([*words, "--body-radius", "nan"]) == 2
    assert "radius" in capsys.readouterr().err
    assert main(["validate", "--body-radius", "0.2"]) == 2
    assert "--body-radius: needs --tracks" in capsys.readouterr().err
    assert main([*words, "--case", "lanes"]) == 2
    assert "--case: has no effect" in capsys.readouterr().err
    between = Tracks((Track(1, np.array([0.1, 0.2]), np.zeros((2, 2))),))
    for tracks in (walkers(rows=5), between):
        WriteTracks(tracks, file)
        assert main(words) == 2
        assert "nobody is there for 8 s" in capsys.readouterr().err


def test_who_is_alone_overlaps_nobody():
    pair, single = (walkers(n, 20, apart=0.3) for n in (2, 1))
    windows = [*windows_of(pair), *windows_of(single), *windows_of(single)]
    assert recorded_overlap(windows) == 0.5
