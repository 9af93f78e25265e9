"""People who walk, and who of them is on a seat."""

import numpy as np

from hunav_drake.systems.common.layout import Signal
from hunav_drake.systems.people.human_config import HumanConfig


def make_walkers(n, *, xs=(6.0, 0.0), spacing=2.0, cyclic=True, **kwargs):
    """Returns people who start at x = 0 and walk along the x-axis.

    Args:
        n: How many.
        xs: The x of each goal, in turn, in meters.
        spacing: How far they are from each other, in meters.
        cyclic: Whether the first goal follows the last.
        kwargs: Attributes of each HumanConfig.
    """
    return [
        HumanConfig(
            pose=[0, spacing * i, 0],
            goals=[[x, spacing * i] for x in xs],
            cyclic=cyclic,
            **kwargs,
        )
        for i in range(n)
    ]


def seated(recording):
    """Returns whether people are on a seat, or on their way down or up.

    The shape is (N + 1, n). In furniture, they sit.
    """
    humans, signals = recording.humans, recording.social_signals
    sits = np.zeros(humans.shape[:2], dtype=bool)
    if signals is None:
        return sits
    shown = signals[:, :, Signal.POSTURE] > 0
    # A second of samples.
    for k in range(1 + int(np.ceil(1.1 / np.diff(recording.times)[0]))):
        sits[k:] |= shown[: len(shown) - k]
        sits[: len(shown) - k] |= shown[k:]
    return sits
