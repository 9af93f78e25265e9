"""Weights of forces fitted to people whose weights are known."""

import math
import os
from pathlib import Path

import numpy as np
import pytest
import yaml

from hunav_drake import ReadTracks, Tracks, WriteTracks
from hunav_drake.commands.cli import main
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people.tracks import Track
from hunav_drake.systems.world.shapes import Polyline, World
from hunav_drake.validation.fitting import FitForces, fit_text
from hunav_drake.validation.recorded import (
    FUTURE,
    PAST,
    STEP,
    CrowdPrediction,
    windows_of,
)

SCENES = (
    Path(os.environ.get("HUNAV_REFERENCE", "../shared/reference")).resolve()
    / "tracks"
)


# People of HuNavSim's weights are fitted from those on.
CONFIG = CrowdConfig(profile="hunav_drake_0.1")


def crossing_people(weights, count=6, people=5, noise=0.0, seed=0):
    """Windows of people who cross each other, as a crowd with weights walks.

    They walk straight on before, and the model is told nothing of their goals.
    """
    rng = np.random.default_rng(seed)
    model = CrowdPrediction(CONFIG, weights)
    windows = []
    for _ in range(count):
        now = rng.uniform(-2.5, 2.5, (people, 2))
        way = rng.uniform(-np.pi, np.pi, people)
        speed = rng.uniform(0.8, 1.3, people)
        velocity = speed[:, None] * np.column_stack([np.cos(way), np.sin(way)])
        past = np.arange(1 - PAST, 1)[:, None] * STEP
        before = now[:, None] + velocity[:, None] * past
        window = np.concatenate([before, np.zeros((people, FUTURE, 2))], axis=1)
        window[:, PAST:] = model(window, "ahead")
        window[:, PAST:] += rng.normal(0, noise, (people, FUTURE, 2))
        windows.append(window)
    return windows


@pytest.mark.slow
@pytest.mark.parametrize(
    "truth",
    [{"social_factor": 2.5}, {"social_factor": 8.0, "relaxation_time": 0.7}],
    ids=lambda it: "+".join(it),
)
def test_weights_are_found_again(truth):
    fit = FitForces(
        crossing_people(truth), list(truth), goal="ahead", config=CONFIG
    )
    assert fit.after < 0.1 * fit.before
    for name, value in truth.items():
        assert fit.values[name] == pytest.approx(value, rel=0.05)


@pytest.mark.slow
def test_noise_is_in_the_errors():
    truth = {"social_factor": 2.5}
    windows = crossing_people(truth, count=12, noise=0.02)
    fit = FitForces(windows, goal="ahead", config=CONFIG)
    (value,), (error,) = fit.values.values(), fit.errors.values()
    assert 0 < error < 0.5
    assert abs(value - 2.5) < 4 * error
    # Twice 2 cm, as of x and y.
    assert fit.after == pytest.approx(0.028, abs=0.006)
    assert "social_factor" in fit_text(fit)


@pytest.mark.slow
def test_fits_end_at_the_least():
    truth = {"social_factor": 2.5, "gamma": 0.3}
    windows = crossing_people(truth, count=20, noise=0.03, seed=2)
    fit = FitForces(windows, list(truth), goal="ahead", config=CONFIG)
    known = CrowdPrediction(CONFIG, truth)
    offsets = [known(it, "ahead") - it[:, PAST:] for it in windows]
    square = np.mean([np.square(it).sum(axis=2).mean() for it in offsets])
    assert fit.after < np.sqrt(square)
    # Where somebody passes on the other side, distances jump.
    for name, value in truth.items():
        assert fit.errors[name] > 0.005 * value
        assert abs(fit.values[name] - value) < 4 * fit.errors[name]
    assert not fit.warnings


def test_intervals_of_few_windows_are_wider():
    windows = crossing_people({"social_factor": 2.5}, count=3, noise=0.02)
    fit = FitForces(windows, goal="ahead", config=CONFIG)
    (value,), (error,) = fit.values.values(), fit.errors.values()
    # Student's t of two degrees of freedom.
    low, high = value - 4.3027 * error, value + 4.3027 * error
    assert f"{low:.3f} to {high:.3f}" in fit_text(fit)
    many = fit._replace(windows=10**9)
    assert f"to {value + 1.95996 * error:.3f}" in fit_text(many)


@pytest.mark.slow
def test_errors_that_nobody_can_tell_are_infinite():
    windows = crossing_people({}, count=2)
    fit = FitForces(windows, ["social_factor", "gamma"], config=CONFIG)
    assert "2 windows of 8 s cannot tell the errors of 2" in fit.warnings[0]
    assert np.isinf(list(fit.errors.values())).all()
    # (Unknown, not 0.)
    assert np.array_equal(np.isnan(fit.correlation), ~np.eye(2, dtype=bool))
    assert "nan" not in fit_text(fit)


def test_an_effect_that_is_fitted_away_stays_away():
    """Near the fit it changes nothing; from the start, it does."""
    now = np.arange(PAST + FUTURE) * STEP
    walk = np.stack([np.column_stack([1.2 * now, 0 * now + 0.35])])
    wall = World(walls=[Polyline(points=[(-5, 0), (20, 0)])]).obstacles()
    options = {"config": CONFIG, "obstacles": wall}
    fit = FitForces([walk, walk], ["obstacle_sigma"], **options)
    assert fit.before > 0.1
    assert fit.after < 1e-6


def test_weights_that_change_nothing_stay_and_have_no_error():
    apart = [window[:1] for window in crossing_people({}, count=4)]
    free = ["relaxation_time", "social_factor"]
    fit = FitForces(apart, free, config=CONFIG)
    assert fit.values["social_factor"] == 5.0
    assert math.isinf(fit.errors["social_factor"])
    assert math.isnan(fit.correlation[0, 1])
    assert "social_factor changes nothing" in fit.warnings[0]


@pytest.mark.slow
def test_the_order_of_people_does_not_matter():
    truth = {"social_factor": 2.5}
    windows = crossing_people(truth, noise=0.01)
    one = FitForces(windows, goal="ahead", config=CONFIG).values[
        "social_factor"
    ]
    turned = [window[::-1].copy() for window in windows]
    other = FitForces(turned, goal="ahead", config=CONFIG).values[
        "social_factor"
    ]
    assert one == pytest.approx(other, rel=0.02)


def test_what_a_recording_cannot_tell_is_refused_or_said():
    windows = crossing_people({})
    for name, words in (
        ("obstacle_factor", "acts at walls only"),
        ("group_gaze_factor", "acts in groups only"),
        ("sociable", "there is no weight 'sociable'"),
    ):
        with pytest.raises(ValueError, match=words):
            FitForces(windows, [name])
    with pytest.raises(ValueError, match="each once"):
        FitForces(windows, ["gamma", "gamma"])
    with pytest.raises(ValueError, match="there are none"):
        FitForces([])
    alone = crossing_people({}, count=3, people=1)
    fit = FitForces(alone, ["social_factor"], goal="ahead", config=CONFIG)
    assert "changes nothing" in fit.warnings[0]
    assert np.isinf(fit.errors["social_factor"])


@pytest.mark.slow
def test_real_people_want_less_force():
    path = SCENES / "zara01.txt"
    if not path.exists():
        pytest.skip("the recorded people are not here")
    fit = FitForces(list(windows_of(ReadTracks(path))), config=CONFIG)
    assert fit.people == 196
    assert fit.values["social_factor"] < 1.5
    assert fit.after < 0.9 * fit.before


def test_the_command_fits_and_writes(tmp_path, capsys):
    windows = crossing_people({"social_factor": 2.5}, count=1)
    times = np.arange(PAST + FUTURE) * STEP
    people = tuple(Track(i, times, row) for i, row in enumerate(windows[0]))
    file, out = tmp_path / "a.csv", tmp_path / "people.yaml"
    other = tmp_path / "b.csv"
    for path in (file, other):
        WriteTracks(Tracks(people), path)
    words = ["fit", str(file), "--goal", "ahead", "--holdout", str(other)]
    words += ["--profile", "hunav_drake_0.1"]
    assert main([*words, "-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert "5 paths" in told
    assert "fitted" in told
    forces = yaml.safe_load(out.read_text())["forces"]
    assert forces["social_factor"] == pytest.approx(2.5, rel=0.1)
    assert forces["gamma"] == 0.35
    assert main([*words, "--free", "gama"]) == 2
    assert "did you mean 'gamma'" in capsys.readouterr().err
    assert main([*words, "-o", str(out)]) == 2
