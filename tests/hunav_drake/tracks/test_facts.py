"""What a recording of known people is told to hold."""

import numpy as np
import pytest

from hunav_drake import Tracks
from hunav_drake.systems.people.tracks import Track
from hunav_drake.tracks.facts import describe_tracks


def line(number, period):
    """Returns one who walks along x for 20 s, 2 m beside the one before."""
    times = np.arange(0.0, 20.01, period)
    return Track(
        number, times, np.column_stack([1.2 * times, 0 * times + 2.0 * number])
    )


@pytest.mark.parametrize("periods", [[0.4] * 6, [0.4] * 5 + [0.1], [0.1, 0.4]])
def test_people_are_counted_whatever_the_rates_of_their_rows(periods):
    tracks = Tracks(tuple(line(i, it) for i, it in enumerate(periods)))
    facts = describe_tracks(tracks)
    assert facts.present == facts.most == len(periods)
    assert facts.nearest == pytest.approx(2.0, abs=1e-6)


def test_times_without_people_count_in_the_mean():
    late = line(1, 0.4)
    late = Track(2, late.times + 80.0, late.positions)
    facts = describe_tracks(Tracks((line(1, 0.4), line(3, 0.1), late)))
    # Two for 20 s, nobody for 60 s, one for 20 s.
    assert facts.present == pytest.approx(60.0 / 100.0)
    assert facts.most == 2
    instant = Tracks((Track(1, np.zeros(1), np.zeros((1, 2))),))
    assert describe_tracks(instant).present == 1.0


def test_who_goes_and_comes_back_is_not_there_in_between():
    times = np.concatenate(
        [np.arange(0, 10.1, 0.5), np.arange(100, 110.1, 0.5)]
    )
    track = Track(1, times, np.column_stack([times, 0 * times]))
    assert describe_tracks(Tracks((track,))).present == pytest.approx(20 / 110)


@pytest.mark.parametrize("period", [1.0, 2.0, 4.0])
def test_who_is_seen_seldom_is_there_in_between(period):
    facts = describe_tracks(Tracks(tuple(line(i, period) for i in (1, 2))))
    assert facts.present == 2.0
