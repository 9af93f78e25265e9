"""Tracks of recorded people: frames, gaps, noise, and motion in between."""

import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.people.tracks import Track, Tracks, motion_at


def curve(times):
    """A smooth walk, and its velocity."""
    t = np.asarray(times)
    place = np.column_stack(
        [1.2 * t + 0.3 * np.sin(t / 2), 0.5 * np.sin(t / 3)]
    )
    speed = np.column_stack(
        [1.2 + 0.15 * np.cos(t / 2), 0.5 / 3 * np.cos(t / 3)]
    )
    return place, speed


def test_rows_in_any_order_make_the_same_tracks():
    rng = np.random.default_rng(0)
    ids = np.repeat([7, 3], 5)
    times = np.tile(np.arange(5) * 0.4, 2)
    places = rng.normal(size=(10, 2))
    order = rng.permutation(10)
    dut = Tracks.from_rows(ids[order], times[order], places[order])
    assert [it.id for it in dut.people] == [3, 7]
    assert np.array_equal(dut.people[1].positions, places[:5])
    assert dut.period == 0.4
    with pytest.raises(ValueError, match=r"person 3 has two rows at 0 s"):
        Tracks.from_rows([3, 3], [0, 0], np.zeros((2, 2)))


@given(st.floats(-4, 4), st.booleans(), st.booleans())
def test_other_frames_keep_distances_and_headings(angle, swap, flip):
    times = np.arange(6) * 0.4
    place, speed = curve(times)
    yaws = np.arctan2(speed[:, 1], speed[:, 0])
    dut = Tracks((Track(1, times, place, yaws),), (place[:3],))
    moved = dut.moved(rotate=angle, shift=(3.0, -2.0), swap=swap, flip=flip)
    (it,) = moved.people
    steps = np.diff(it.positions, axis=0)
    assert np.allclose(np.hypot(*steps.T), np.hypot(*np.diff(place, axis=0).T))
    assert np.allclose(moved.walls[0], it.positions[:3])
    # Who looks where they go does so in any frame.
    after = motion_at(it._replace(yaws=None), times).yaws
    before = motion_at(Track(1, times, place), times).yaws
    off = np.angle(np.exp(1j * (after - it.yaws)))
    assert np.allclose(np.abs(off), np.abs(before - yaws), atol=1e-9)


def test_a_frame_turned_by_a_right_angle():
    dut = Tracks((Track(1, np.zeros(1), np.array([[2.0, 1.0]])),))

    def place(**options):
        return dut.moved(**options).people[0].positions[0].tolist()

    assert place(rotate=math.pi / 2) == pytest.approx([-1, 2])
    assert place(swap=True) == [1, 2]
    assert place(flip=True) == [2, -1]
    assert place(shift=(1.0, 1.0)) == [3, 2]


def test_a_gap_makes_another_person():
    times = np.array([0.0, 0.4, 0.8, 3.0, 3.4])
    dut = Tracks(
        (
            Track(4, times, curve(times)[0]),
            Track(9, times[:2], np.zeros((2, 2))),
        )
    ).split()
    assert [it.id for it in dut.people] == [4, 9, 10]
    assert dut.people[2].times.tolist() == [3.0, 3.4]
    whole = dut.split(5.0)
    assert [len(it.times) for it in whole.people] == [3, 2, 2]


def test_a_window_begins_at_zero():
    times = np.arange(10) * 0.4
    dut = Tracks((Track(1, times, curve(times)[0]),)).between(1.0, 3.0)
    assert dut.people[0].times[0] == pytest.approx(0.2)
    assert dut.people[0].times[-1] == pytest.approx(1.8)
    assert not dut.between(50.0).people


def test_sampled_tracks_stay_on_the_path():
    """Through rows every 0.4 s, a spline errs by millimeters."""
    times = np.arange(0.1, 20, 0.4)
    dut = Tracks((Track(1, times, curve(times)[0]),)).resampled(0.05)
    (it,) = dut.people
    assert np.allclose(it.times / 0.05, np.round(it.times / 0.05))
    assert np.abs(it.positions - curve(it.times)[0]).max() < 1e-3
    motion = motion_at(Track(1, times, curve(times)[0]), it.times)
    assert np.abs(motion.velocities - curve(it.times)[1]).max() < 0.01


def test_noise_is_estimated_and_taken_out():
    """Noise of 2 cm at 10 Hz makes velocities wrong by 0.28 m/s."""
    rng = np.random.default_rng(1)
    times = np.arange(0, 30, 0.1)
    place, speed = curve(times)
    noisy = place + rng.normal(0, 0.02, place.shape)
    dut = Tracks((Track(1, times, noisy),))
    assert dut.noise == pytest.approx(0.02, rel=0.15)

    def error(tracks):
        (it,) = tracks.people
        velocities = motion_at(it, times).velocities
        return np.sqrt(np.mean((velocities - speed) ** 2))

    assert error(dut) > 0.2
    assert error(dut.smoothed()) < 0.03
    assert error(dut.smoothed(0.02)) < 0.03
    smooth = Tracks((Track(1, times, place),))
    assert smooth.noise < 1e-4


def test_who_stands_looks_where_they_went():
    times = np.arange(12) * 0.4
    x = np.minimum(times, 2.0)
    it = Track(1, times, np.column_stack([np.zeros(12), -x]))
    motion = motion_at(it, np.arange(0, 4.4, 0.1))
    assert np.allclose(motion.yaws, -math.pi / 2, atol=0.05)


def test_before_and_after_a_track_the_person_stands():
    times = np.array([1.0, 1.4, 1.8, 2.2, 2.6])
    motion = motion_at(Track(1, times, curve(times)[0]), [0.0, 3.0])
    assert np.allclose(motion.positions, curve([1.0, 2.6])[0])
    assert not motion.velocities.any()


def test_rounding_of_the_last_time_does_not_stop_a_person():
    times = np.round(np.arange(4) * 0.4, 6)
    assert times[-1] < 3 * 0.4
    track = Track(1, times, np.column_stack([times, 0 * times]))
    motion = motion_at(track, np.arange(4) * 0.4)
    assert np.allclose(motion.velocities, [1.0, 0.0])


@pytest.mark.parametrize("rows", [1, 2, 3, 4])
def test_short_tracks_are_tracks(rows):
    times = np.arange(rows) * 0.4
    dut = Tracks((Track(1, times, curve(times)[0]),))
    assert np.isfinite(dut.smoothed().resampled(0.1).people[0].positions).all()
    assert dut.noise >= 0
    assert math.isnan(dut.period) == (rows == 1)
