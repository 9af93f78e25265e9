"""Recordings and states that tests of metrics are made of."""

import numpy as np

from hunav_drake.systems.evaluation.recording import Recording

R = 0.35


def rows(samples, x=0.0, y=0.0, yaw=0.0, vx=0.0, vy=0.0, omega=0.0, r=R):
    """Returns states, shape (samples, 7), from numbers or series."""
    columns = np.broadcast_arrays(
        x, y, yaw, vx, vy, omega, r, np.zeros(samples)
    )
    return np.stack(columns[:7], axis=-1)


def make(times, robot, humans=(), **kwargs):
    """Returns a Recording of a robot and people, from states of each."""
    samples = len(times)
    people = np.zeros((samples, len(humans), 7))
    for i, states in enumerate(humans):
        people[:, i] = states
    return Recording(times=times, robot=robot, humans=people, **kwargs)
