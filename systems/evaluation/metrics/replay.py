"""What the robot made of recorded people."""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import REACTIVE, REPLAYED
from hunav_drake.systems.evaluation.metric import REPLAY_FAMILY, register_metric
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family=REPLAY_FAMILY, source="hunav_drake")


def _rows(recording: Recording) -> Array:
    """Returns the rows of recorded people, none if there are none."""
    if recording.replay is None:
        return np.zeros((len(recording), 0, 3))
    return recording.replay


def _reacts(recording: Recording) -> tuple[Mask, Mask]:
    """Returns whether people are recorded ones here, and reactive, (N, n)."""
    mode = _rows(recording)[..., 0]
    return np.isin(mode, (REPLAYED, REACTIVE)), mode == REACTIVE


def replay_errors(recording: Recording, *, at_phase: bool) -> Array:
    """Returns the distances of people from the recording, (samples, people).

    They are NaN where somebody is not here, or not in the recording.
    """
    away = _rows(recording)[..., 2 if at_phase else 1]
    here, _ = _reacts(recording)
    return np.where(here & (away >= 0), away, np.nan)


def reacting(recording: Recording) -> Array:
    """Returns 1 where recorded people react, else 0, shape (samples, people).

    It is NaN where somebody is not here.
    """
    here, reacts = _reacts(recording)
    return np.where(here, reacts, np.nan)


def _errors(recording: Recording, *, at_phase: bool) -> tuple[float, Array]:
    """Returns the mean of distances, and the mean at each sample."""
    away = replay_errors(recording, at_phase=at_phase)
    known = np.isfinite(away)
    away[~known] = 0.0
    count = known.sum(axis=1)
    series = np.full(len(recording), np.nan)
    np.divide(away.sum(axis=1), count, out=series, where=count > 0)
    total = int(count.sum())
    return float(away.sum() / total) if total else np.nan, series


def _last(recording: Recording, column: int) -> float:
    """Returns the mean of the last distance of each person."""
    away = _rows(recording)[..., column]
    here, _ = _reacts(recording)
    known = here & (away >= 0)
    people = np.flatnonzero(known.any(axis=0))
    last = len(recording) - 1 - np.argmax(known[::-1], axis=0)
    ends = away[last[people], people]
    return float(ends.mean()) if len(ends) else np.nan


@_metric(unit="m", direction="lower")
def replay_ade(recording: Recording) -> tuple[float, Array]:
    """The mean distance of recorded people from their recording then (ADE).

    It is the mean over all samples and people who are here and in the recording
    at that time; 0 where nobody was handed over. NaN without recorded people.
    Series: the mean over people.
    """
    return _errors(recording, at_phase=False)


@_metric(unit="m", direction="lower")
def replay_fde(recording: Recording) -> float:
    """The mean over people of their last distance from the recording (FDE).

    The last sample of a person is that at which it is last here and in the
    recording. NaN without recorded people.
    """
    return _last(recording, 1)


@_metric(unit="m", direction="lower")
def replay_ade_at_phase(recording: Recording) -> tuple[float, Array]:
    """The mean distance of recorded people from their path, late or not.

    As `replay_ade`, with the distance from the place of the recording where the
    person has got to. Series: the mean over people.
    """
    return _errors(recording, at_phase=True)


@_metric(unit="m", direction="lower")
def replay_fde_at_phase(recording: Recording) -> float:
    """The mean over people of their last distance from their path.

    As `replay_fde`, with the distances of `replay_ade_at_phase`.
    """
    return _last(recording, 2)


@_metric(unit="-", direction="lower")
def hand_overs(recording: Recording) -> tuple[float, Array]:
    """The number of times that the motion model took over a recorded person.

    NaN without recorded people. Series: the number by each sample.
    """
    if recording.replay is None:
        return np.nan, np.full(len(recording), np.nan)
    _, reacts = _reacts(recording)
    begins = np.diff(reacts.astype(int), axis=0, prepend=0) > 0
    series = begins.sum(axis=1).cumsum().astype(float)
    return float(series[-1]), series


@_metric(unit="-", direction="lower")
def reactive_share(recording: Recording) -> tuple[float, Array]:
    """The share of the time of recorded people in which they react.

    That is, in which the motion model moves them. NaN without recorded people.
    Series: the share of the people who are here.
    """
    here, reacts = _reacts(recording)
    count = here.sum(axis=1)
    series = np.full(len(recording), np.nan)
    np.divide(reacts.sum(axis=1), count, out=series, where=count > 0)
    total = int(here.sum())
    return float(reacts.sum() / total) if total else np.nan, series
